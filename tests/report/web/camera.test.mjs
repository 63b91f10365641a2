import assert from 'node:assert/strict';
import test from 'node:test';
import {Camera} from '#web/camera.mjs';

const camera = Object.assign(new Camera(), {width: 800, height: 400});
const near = (found, wanted) => found.forEach((value, i) => assert.ok(Math.abs(value - wanted[i]) < 1e-9, `${found}`));

test('a box is shown whole, beside the buttons', () => {
  for (const box of [[[0, 10], [0, 1]], [[-3, -2], [5, 50]], [[0, 0], [0, 0]]]) {
    camera.fit(box, 30, 40);
    const [left, bottom] = camera.toScreen(box[0][0], box[1][0]), [right, top] = camera.toScreen(box[0][1], box[1][1]);
    assert.ok(left >= 30 - 1e-9 && right <= 730 + 1e-9 && top >= 30 - 1e-9 && bottom <= 370 + 1e-9);
    near([(left + right) / 2, (top + bottom) / 2], [380, 200]);
  }
});

test('y is up and x to the right, to one scale', () => {
  camera.fit([[0, 2], [0, 1]]);
  const [[x, y], [a, b]] = [camera.toScreen(0, 0), camera.toScreen(1, 1)];
  assert.ok(a > x && b < y);
  near([a - x], [y - b]);
  near(camera.toFloor(...camera.toScreen(0.3, -7)), [0.3, -7]);
});

test('what lies under a pixel stays there', () => {
  camera.fit([[0, 2], [0, 1]]);
  const floor = camera.toFloor(123, 45), scale = camera.scale;
  camera.zoom(3, 123, 45);
  near(camera.toFloor(123, 45), floor);
  near([camera.scale], [3 * scale]);
  camera.pan(10, -20);
  near(camera.toFloor(133, 25), floor);
});

test('nobody gets lost', () => {
  camera.fit([[0, 2], [0, 1]]);
  const fitted = camera.scale;
  camera.zoom(1e-9);
  near([camera.scale], [fitted / 8]);
  camera.zoom(1e12);
  near([camera.scale], [fitted * 2000]);
});
