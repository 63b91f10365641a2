// The scene: floor, robot, ghost and their trails, drawn for one moment of a drive.

import * as THREE from "/three/three.module.js";
import { Camera } from "./camera.mjs";
import { FRAMES_PER_SECOND } from "./drive.mjs";
import { Robot } from "./robot.mjs";
import { Trail } from "./trail.mjs";

const SMALLEST = 0.06;  // a robot is drawn at least this part of the camera's distance wide

export class Scene {
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.canvas = canvas;
    this.scene = new THREE.Scene();
    this.scene.fog = new THREE.Fog(0, 1, 2);
    this.camera = new Camera(canvas);
    const sun = new THREE.DirectionalLight(0xffffff, 2);
    sun.position.set(-2, -3, 6);
    this.scene.add(sun, new THREE.HemisphereLight(0xffffff, 0x99a0a8, 1.6));
    this.floor = tiles();
    this.scene.add(this.floor);
    this.parts = [];
    this.mode = "follow";
    new ResizeObserver(() => this.fit()).observe(canvas.parentElement);
    this.paint();
    this.fit();
  }

  // The colors of the page's theme.
  paint() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    this.colors = { truth: color("--truth"), ghost: color("--ghost-line") };
    this.scene.background = new THREE.Color(color("--horizon"));
    this.scene.fog.color.set(color("--horizon"));
    this.floor.material.color.set(color("--joint"));
    this.truthTrail?.paint(this.colors.truth);
    this.ghostTrail?.paint(this.colors.ghost);
    this.camera.changed = true;
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.camera.aspect = width / height;
    this.camera.changed = true;
  }

  // A new robot with its ghost.
  robots(shapes, sizes) {
    this.robot?.free();
    this.ghost?.free();
    this.robot = new Robot(shapes);
    this.ghost = new Robot(shapes, sizes);
    this.scene.add(this.robot.group, this.ghost.group);
    this.track = Math.max(sizes.true.track_width, 2 * Math.max(sizes.true.left_radius, sizes.true.right_radius));
  }

  // The paths of a drive.
  trails(record) {
    this.truthTrail?.free();
    this.ghostTrail?.free();
    const truth = record.frames.map((frame) => [frame[1], frame[2]]), belief = record.errors.map((row) => row.belief);
    const all = [...truth, ...belief];
    const [xs, ys] = [0, 1].map((axis) => all.map((point) => point[axis]));
    const [left, right, low, high] = [least(xs), most(xs), least(ys), most(ys)];
    this.middle = [(left + right) / 2, (low + high) / 2];
    this.halves = [(right - left) / 2 + this.track, (high - low) / 2 + this.track];
    const reach = Math.hypot(...this.halves);
    const width = Math.max(this.track / 12, reach / (this.mode === "follow" ? 150 : 70));
    this.truthTrail = new Trail(truth, this.colors.truth, this.track / 200, width);
    this.ghostTrail = new Trail(belief, this.colors.ghost, this.track / 100, 0.7 * width);
    this.scene.add(this.truthTrail.group, this.ghostTrail.group);
  }

  // Draw a moment [s] of a drive. Returns how many times larger than they are the robots are drawn.
  draw(record, time) {
    const now = record.at(time), [x, y, height] = now.position, [gx, gy] = now.believed;
    const apart = Math.hypot(gx - x, gy - y);
    const between = [(x + gx) / 2, (y + gy) / 2], around = Math.max(2.2 * this.track, 0.75 * apart + this.track);
    const distance = this.mode === "follow"
      ? this.camera.look(between, around)
      : this.camera.survey(this.middle, this.halves, this.mode === "above");
    const larger = Math.max(1, SMALLEST * distance / this.track);
    this.robot.place(now.position, now.quaternion, now.wheels);
    this.robot.enlarge(larger);
    this.ghost.placeFlat(now.believed, height, now.wheels);
    this.ghost.enlarge(larger);
    this.truthTrail.upTo(time * FRAMES_PER_SECOND);
    this.ghostTrail.upTo(time * record.planned.rate);
    this.pave(this.mode === "follow" ? between : this.middle, distance);
    this.renderer.render(this.scene, this.camera.camera);
    return larger;
  }

  // The floor's joints reach as far as the eye, a metre apart, or ten where these would be too close.
  pave([x, y], distance) {
    this.tile = 10 ** Math.round(Math.log10(Math.max(distance / 6, 0.1)));
    this.floor.scale.setScalar(this.tile);
    this.floor.position.set(this.tile * Math.round(x / this.tile), this.tile * Math.round(y / this.tile), 0);
    this.scene.fog.near = distance;
    this.scene.fog.far = distance + 25 * this.tile;
  }
}

const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
const most = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);

// The joints between tiles of length 1, as bands; a textured floor costs five times as much to draw without a GPU.
function tiles(reach = 30, half = 0.008) {
  const corners = [], faces = [];
  for (let k = -reach; k <= reach; k++) {
    for (const along of [(a, b) => [a, b, 0], (a, b) => [b, a, 0]]) {
      const first = corners.length / 3;
      for (const [a, b] of [[k - half, -reach], [k + half, -reach], [k + half, reach], [k - half, reach]]) {
        corners.push(...along(a, b));
      }
      faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  geometry.setIndex(faces);
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }));
}
