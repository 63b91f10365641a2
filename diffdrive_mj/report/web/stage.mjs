// A canvas with a camera that mouse, touch and keys move. What is on it, `paint(context, camera)` draws.

import {Camera} from '#web/camera.mjs';

const PAN = {ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40]};

export class Stage {
  constructor(canvas, paint) {
    Object.assign(this, {canvas, paint, camera: new Camera(), box: [[-1, 1], [-1, 1]], pointers: new Map()});
    new ResizeObserver(() => this.resize()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
    canvas.addEventListener('wheel', event => this.wheel(event), {passive: false});
    canvas.addEventListener('pointerdown', event => this.down(event));
    canvas.addEventListener('pointermove', event => this.move(event));
    canvas.addEventListener('pointerup', event => this.pointers.delete(event.pointerId));
    canvas.addEventListener('pointercancel', event => this.cancel(event));
    canvas.addEventListener('keydown', event => this.key(event));
    this.resize();
  }

  // Show a box of the floor, and come back to it on reset.
  show(box) {
    this.box = box;
    this.reset();
  }

  reset() {
    this.moved = false;
    this.camera.fit(this.box);
    this.draw();
  }

  zoom(factor, px, py) {
    this.moved = true;
    this.camera.zoom(factor, px, py);
    this.draw();
  }

  pan(dx, dy) {
    this.moved = true;
    this.camera.pan(dx, dy);
    this.draw();
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas, fine = devicePixelRatio || 1;
    if (!width || !height) return;
    Object.assign(this.canvas, {width: Math.round(width * fine), height: Math.round(height * fine)});
    Object.assign(this.camera, {width, height});
    if (this.moved) this.draw(); else this.reset();
  }

  // At most once a frame.
  draw() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = undefined;
      const context = this.canvas.getContext('2d'), fine = devicePixelRatio || 1;
      context.setTransform(fine, 0, 0, fine, 0, 0);
      context.clearRect(0, 0, this.camera.width, this.camera.height);
      this.paint(context, this.camera);
    });
  }

  // The wheel scrolls the page until the canvas has been chosen, by a click or with the tab key, or with Ctrl.
  wheel(event) {
    if (document.activeElement !== this.canvas && !event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    this.zoom(2 ** (-event.deltaY * (event.deltaMode ? 20 : 1) / 300), event.offsetX, event.offsetY);
  }

  down(event) {
    if (!this.pointers.size) this.earlier = {moved: this.moved, camera: {...this.camera}};
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    this.canvas.setPointerCapture(event.pointerId);
  }

  // A finger that scrolls the page after all has moved nothing here.
  cancel(event) {
    this.pointers.delete(event.pointerId);
    if (!this.earlier) return;
    this.moved = this.earlier.moved;
    Object.assign(this.camera, this.earlier.camera);
    this.draw();
  }

  // One pointer drags the floor; two drag it by their middle, and zoom.
  move(event) {
    if (!this.pointers.has(event.pointerId)) return;
    const before = [...this.pointers.values()];
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    const after = [...this.pointers.values()];
    const [from, to] = [middle(before), middle(after)];
    this.pan(to[0] - from[0], to[1] - from[1]);
    if (after.length === 2) this.zoom(apart(after) / Math.max(apart(before), 1), ...to);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (PAN[event.key]) this.pan(...PAN[event.key]);
    else if (event.key === '+' || event.key === '=') this.zoom(1.25);
    else if (event.key === '-') this.zoom(0.8);
    else if (event.key === '0') this.reset();
    else return;
    event.preventDefault();
  }
}

const middle = points => [0, 1].map(i => points.reduce((sum, point) => sum + point[i], 0) / points.length);
const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
