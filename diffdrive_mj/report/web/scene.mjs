// Draws a drive on a canvas: the floor with its grid, the paths, the robot and the ghost of where it believes to be.

import {gridStep} from '#web/camera.mjs';
import {errorColour} from '#web/colours.mjs';
import {enlarged, outline, placed} from '#web/outline.mjs';
import {largest, locate, poseAt} from '#web/replay.mjs';

// The view of a drive at a time; returns how many times larger than they are the robots are drawn.
export function drawScene(context, camera, palette, replay, chosen, t) {
  const at = locate(replay.t, t), belief = replay.beliefs[chosen];
  drawGrid(context, camera, palette);
  stroke(context, camera, replay.truth, {color: palette.truth, width: 7});
  replay.beliefs.forEach((other, k) => {
    if (k !== chosen) stroke(context, camera, other, {color: palette.muted, width: 1.2, dash: [5, 4]});
  });
  drawErrors(context, camera, palette, belief);
  const size = Math.max(enlarged(replay.robot, camera.scale), enlarged(belief.robot, camera.scale));
  drawStart(context, camera, palette, replay.truth);
  drawRobot(context, camera, belief.robot, poseAt(belief, at), size, {line: palette.ghost, fill: palette.haze, dash: [4, 3]});
  drawRobot(context, camera, replay.robot, poseAt(replay.truth, at), size, {line: palette.ink, fill: palette.floor, solid: true});
  return size;
}

function drawGrid(context, camera, palette) {
  const step = gridStep(camera.scale), digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const [left, top] = camera.toFloor(0, 0), [right, bottom] = camera.toFloor(camera.width, camera.height);
  context.save();
  Object.assign(context, {strokeStyle: palette.line, fillStyle: palette.muted, font: palette.font, lineWidth: 1});
  for (let k = Math.ceil(left / step); k * step <= right; k++) {
    const [px] = camera.toScreen(k * step, 0);
    line(context, [px, 0], [px, camera.height]);
    if (px > 44 && px < camera.width - 30) context.fillText((k * step).toFixed(digits), px + 4, camera.height - 6);
  }
  for (let k = Math.ceil(bottom / step); k * step <= top; k++) {
    const [, py] = camera.toScreen(0, k * step);
    line(context, [0, py], [camera.width, py]);
    if (py < camera.height - 28) context.fillText((k * step).toFixed(digits), 6, py - 4);
  }
  context.fillText('m', 6, camera.height - 6);
  context.restore();
}

function line(context, from, to) {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}

function stroke(context, camera, path, {color, width, dash = []}) {
  context.save();
  Object.assign(context, {strokeStyle: color, lineWidth: width, lineJoin: 'round', lineCap: dash.length ? 'butt' : 'round'});
  context.setLineDash(dash);
  context.beginPath();
  path.x.forEach((x, k) => context.lineTo(...camera.toScreen(x, path.y[k])));
  context.stroke();
  context.restore();
}

// The believed path, each stretch in the colour of its error.
function drawErrors(context, camera, palette, belief) {
  const most = largest(belief.position_error) || 1;
  context.save();
  Object.assign(context, {lineWidth: 3, lineCap: 'round'});
  for (let k = 1; k < belief.x.length; k++) {
    context.strokeStyle = errorColour((belief.position_error[k - 1] + belief.position_error[k]) / 2 / most, palette.dark);
    line(context, camera.toScreen(belief.x[k - 1], belief.y[k - 1]), camera.toScreen(belief.x[k], belief.y[k]));
  }
  context.restore();
}

function drawStart(context, camera, palette, truth) {
  context.save();
  Object.assign(context, {fillStyle: palette.floor, strokeStyle: palette.ink, lineWidth: 1.5});
  context.beginPath();
  context.arc(...camera.toScreen(truth.x[0], truth.y[0]), 4, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
  context.restore();
}

function drawRobot(context, camera, robot, pose, size, {line: color, fill, solid, dash = []}) {
  const {body, wheels} = outline(robot);
  context.save();
  Object.assign(context, {strokeStyle: color, lineWidth: 1.7, lineJoin: 'round'});
  context.setLineDash(dash);
  polygon(context, camera, placed(body, pose, size), fill);
  for (const wheel of wheels) polygon(context, camera, placed(wheel, pose, size), solid ? color : fill);
  context.restore();
}

function polygon(context, camera, corners, fill) {
  context.beginPath();
  corners.forEach(([x, y]) => context.lineTo(...camera.toScreen(x, y)));
  context.closePath();
  context.fillStyle = fill;
  context.fill();
  context.stroke();
}
