import assert from 'node:assert/strict';
import test from 'node:test';
import {Camera} from '#web/camera.mjs';
import {drawScene} from '#web/scene.mjs';

const palette = {ink: 'ink', muted: 'muted', line: 'line', floor: 'floor', truth: 'truth', ghost: 'ghost', haze: 'haze', font: '', dark: false};
const robot = {left_radius: 0.1, right_radius: 0.1, track_width: 0.4, tyre_width: 0.04, caster_x: -0.2, caster_radius: 0.025};
const path = y => ({x: [0, 4], y: [0, y], theta: [0, 0]});
const belief = (name, y) => ({name, ...path(y), robot, position_error: [0, Math.abs(y)], heading_error: [0, 0]});
const replay = {t: [0, 2], truth: path(0), robot, beliefs: [belief('first', 2), belief('second', -2)]};

// What is stroked on a canvas: each line with its corners, its colour and its dashes.
function strokes(chosen, t) {
  const camera = Object.assign(new Camera(), {width: 800, height: 800}), drawn = [];
  camera.fit([[0, 4], [-2, 2]]);
  let corners = [], dash = [];
  const context = new Proxy({}, {get: (state, name) => ({
    beginPath: () => { corners = []; }, setLineDash: given => { dash = given; }, restore: () => { dash = []; },
    moveTo: (...at) => corners.push(camera.toFloor(...at)), lineTo: (...at) => corners.push(camera.toFloor(...at)),
    stroke: () => drawn.push({corners, dashed: dash.length > 0, color: state.strokeStyle}),
  })[name] ?? state[name] ?? (() => {})});
  drawScene(context, camera, palette, replay, chosen, t);
  return drawn;
}

const near = (found, wanted) => found.forEach((value, i) => assert.ok(Math.abs(value - wanted[i]) < 1e-9, `${found} is not ${wanted}`));
const middle = points => [0, 1].map(i => points.reduce((sum, point) => sum + point[i], 0) / points.length);
// Halfway between the wheels, which are the shapes of four corners.
const between = shapes => middle(shapes.filter(({corners}) => corners.length === 4).flatMap(({corners}) => corners));

test('the robot is where it is, and dashed where the chosen belief has it', () => {
  for (const [chosen, y] of [[0, 1], [1, -1]]) {
    const drawn = strokes(chosen, 1);
    near(between(drawn.filter(({color}) => color === 'ink')), [2, 0]);
    const ghost = drawn.filter(({color}) => color === 'ghost');
    near(between(ghost), [2, y]);
    assert.ok(ghost.length === 3 && ghost.every(({dashed}) => dashed));
  }
});

test('the paths are there: the true one, the believed one in colours, the other one dashed', () => {
  const drawn = strokes(0, 2), of = color => drawn.filter(each => each.color === color).map(({corners}) => corners.at(-1));
  near(of('truth')[0], [4, 0]);
  near(of('muted')[0], [4, -2]);
  const coloured = drawn.filter(({color}) => color.startsWith('rgb('));
  assert.equal(coloured.length, 1);
  near(coloured[0].corners.at(-1), [4, 2]);
});
