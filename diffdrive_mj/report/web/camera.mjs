// Which part of the floor a canvas shows: metres to pixels and back, x to the right and y up.

export class Camera {
  constructor() {
    Object.assign(this, {x: 0, y: 0, scale: 100, width: 1, height: 1, fitted: 100});
  }

  // Show a box [[x, x], [y, y]] as large as the canvas allows: with a margin, and to the right room for buttons.
  fit([[left, right], [bottom, top]], margin = 34, buttons = 44) {
    const wide = Math.max(right - left, 1e-9), high = Math.max(top - bottom, 1e-9);
    const room = [Math.max(this.width - 2 * margin - buttons, 20), Math.max(this.height - 2 * margin, 20)];
    this.scale = this.fitted = Math.min(room[0] / wide, room[1] / high, 1e6);
    this.x = (left + right + buttons / this.scale) / 2;
    this.y = (bottom + top) / 2;
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toFloor(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  // Zoom so that what lies under a pixel stays there.
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toFloor(px, py);
    this.scale = Math.min(Math.max(this.scale * factor, this.fitted / 8), this.fitted * 2000);
    this.x = x - (px - this.width / 2) / this.scale;
    this.y = y + (py - this.height / 2) / this.scale;
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }
}

// The distance between grid lines [m], 1, 2 or 5 times a power of ten, that are at least so many pixels apart.
export function gridStep(scale, pixels = 70) {
  const least = pixels / scale, power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map(n => n * power).find(step => step >= least * (1 - 1e-9));
}
