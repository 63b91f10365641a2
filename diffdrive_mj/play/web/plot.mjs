// A small plot against time: the whole curve, beneath a veil that is drawn back as time goes on. The curve is drawn
// once; veil and dot move above it, which costs no painting.

import { fixed } from "./words.mjs";

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 46, RIGHT = 10, TOP = 8, BOTTOM = 22;  // [px]
const MOST_POINTS = 600;

export class Plot {
  // Of an error, by the function of a row of the record that gives it; `least` is the smallest range shown.
  constructor(svg, value, least) {
    Object.assign(this, { svg, value, least, record: null });
    const layer = (className) => Object.assign(document.createElement("div"), { className });
    [this.veil, this.dot] = ["veil", "dot"].map(layer);
    svg.after(this.veil, this.dot);
    new ResizeObserver(() => this.record && this.show(this.record)).observe(svg);
  }

  // A record from its start to its end, in `scale` times the unit of the function.
  show(record, scale = this.scale ?? 1) {
    if (record !== this.record) this.shown = null;
    Object.assign(this, { record, scale });
    const rows = thinned(record.errors), values = rows.map((row) => scale * this.value(row));
    this.width = this.svg.clientWidth;
    this.height = this.svg.clientHeight;
    const ends = [Math.min(0, ...values), Math.max(0, ...values)];
    const [low, high] = ends.map((end) => (Math.abs(end) < this.least / 100 ? 0 : end));  // rounding is no error
    const step = nice(Math.max(high - low, this.least) / 3);
    this.low = Math.floor(low / step + 1e-9) * step;
    this.high = Math.max(Math.ceil(high / step - 1e-9) * step, this.low + step);
    this.svg.replaceChildren();
    for (let at = this.low; at <= this.high + step / 2; at += step) this.gridline(at, step);
    const every = nice(record.duration / 5);
    for (let t = 0; t <= record.duration + 1e-9; t += every) {
      const last = t + every > record.duration;
      this.label(this.x(t), this.height - 6, `${round(t, every)}${last ? " s" : ""}`, "middle");
    }
    const line = rows.map((row, k) => `${k ? "L" : "M"}${this.x(row.t).toFixed(1)} ${this.y(values[k]).toFixed(1)}`);
    this.add("path", { d: line.join("") });
    Object.assign(this.veil.style, { left: `${LEFT}px`, right: `${RIGHT}px`, top: `${TOP}px`, bottom: `${BOTTOM}px` });
    if (this.shown) this.move(...this.shown);
  }

  // Move to a row of the record.
  move(time, row) {
    this.shown = [time, row];
    if (!this.width) return;
    this.veil.style.transform = `scaleX(${1 - time / this.record.duration})`;
    this.dot.style.transform = `translate(${this.x(row.t)}px, ${this.y(this.scale * this.value(row))}px)`;
  }

  gridline(at, step) {
    this.add("line", { x1: LEFT, x2: this.width - RIGHT, y1: this.y(at), y2: this.y(at), class: "grid" });
    this.label(LEFT - 6, this.y(at) + 4, round(at, step), "end");
  }

  label(x, y, text, anchor) {
    this.add("text", { x, y, "text-anchor": anchor }).textContent = text;
  }

  add(kind, attributes, parent = this.svg) {
    const made = document.createElementNS(SVG, kind);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return parent.appendChild(made);
  }

  x(time) { return LEFT + time / this.record.duration * (this.width - LEFT - RIGHT); }
  y(value) { return TOP + (this.high - value) / (this.high - this.low) * (this.height - TOP - BOTTOM); }
}

function thinned(rows) {
  const stride = Math.max(1, Math.floor(rows.length / MOST_POINTS));
  return rows.filter((_, k) => k % stride === 0 || k === rows.length - 1);
}

// 1, 2 or 5 times a power of ten, at least as large.
function nice(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  return [1, 2, 5, 10].find((digit) => digit * power >= size * (1 - 1e-9)) * power;
}

function round(value, step) {
  return fixed(value, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
}
