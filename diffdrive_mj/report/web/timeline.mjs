// Two small plots of a belief's errors over time, position above heading, with a cursor; a click or a drag sets the time.

import {largest} from '#web/replay.mjs';
import {degrees, quantity, seconds} from '#web/quantities.mjs';

const LEFT = 8, RIGHT = 8, TOP = 18, GAP = 22, FOOT = 16;

export class Timeline {
  constructor(canvas, {onTime, palette}) {
    Object.assign(this, {canvas, onTime, palette});
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      this.pick(event);
    });
    canvas.addEventListener('pointermove', event => {
      if (event.buttons) this.pick(event);
    });
  }

  show(replay, belief, t) {
    Object.assign(this, {replay, belief, t});
    this.draw();
  }

  pick({offsetX}) {
    const {clientWidth} = this.canvas, [start, end] = [this.replay.t[0], this.replay.t.at(-1)];
    const share = Math.min(Math.max((offsetX - LEFT) / (clientWidth - LEFT - RIGHT), 0), 1);
    this.onTime(start + share * (end - start));
  }

  draw() {
    const {clientWidth: width, clientHeight: height} = this.canvas, fine = devicePixelRatio || 1;
    if (!this.replay || !width) return;
    Object.assign(this.canvas, {width: Math.round(width * fine), height: Math.round(height * fine)});
    const context = this.canvas.getContext('2d'), half = (height - GAP - FOOT) / 2;
    context.setTransform(fine, 0, 0, fine, 0, 0);
    context.font = this.palette().font;
    const heading = this.belief.heading_error.map(angle => angle * 180 / Math.PI);
    this.curve(context, this.belief.position_error, [TOP, half], width, 'position error', v => `at most ${quantity(v, 'm')}`);
    const said = v => v < 0.01 ? degrees(v * Math.PI / 180) : `at most ${v.toPrecision(3)}°`;
    this.curve(context, heading, [half + GAP + TOP - 6, height - FOOT - 4], width, 'heading error', said, 180);
    const times = this.replay.t, places = [['left', LEFT, '0 s'], ['right', width - RIGHT, seconds(times.at(-1) - times[0])]];
    for (const [align, x, text] of places) {
      context.textAlign = align;
      context.fillStyle = this.palette().muted;
      context.fillText(text, x, height - 3);
    }
  }

  // One curve between two heights, over its zero line, with its name and its largest value.
  curve(context, values, [top, bottom], width, name, said, jump = Infinity) {
    const {t} = this.replay, colours = this.palette(), most = largest(values) || 1, signed = values.some(v => v < 0);
    const x = time => LEFT + (time - t[0]) / (t.at(-1) - t[0]) * (width - LEFT - RIGHT);
    const y = value => bottom - (value / most + (signed ? 1 : 0)) / (signed ? 2 : 1) * (bottom - top);
    context.fillStyle = colours.muted;
    context.textAlign = 'left';
    context.fillText(name, LEFT, top - 6);
    context.textAlign = 'right';
    context.fillText(said(largest(values)), width - RIGHT, top - 6);
    rule(context, colours.line, [x(t[0]), y(0)], [x(t.at(-1)), y(0)]);
    context.strokeStyle = colours.ghost;
    context.lineWidth = 1.8;
    context.beginPath();
    // An angle that passes the far side of the circle goes on at the other end, and draws no line between.
    values.forEach((value, k) => {
      const jumps = k === 0 || (signed && Math.abs(value - values[k - 1]) > jump);
      context[jumps ? 'moveTo' : 'lineTo'](x(t[k]), y(value));
    });
    context.stroke();
    rule(context, colours.ink, [x(this.t), top], [x(this.t), bottom]);
  }
}

function rule(context, color, from, to) {
  Object.assign(context, {strokeStyle: color, lineWidth: 1});
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}
