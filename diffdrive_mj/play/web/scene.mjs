// The scene: floor, robot, ghost and their trails, drawn for one moment of a drive.

import * as THREE from "/three/three.module.js";
import { Camera } from "./camera.mjs";
import { Robot } from "./robot.mjs";
import { Trail } from "./trail.mjs";

const SMALLEST = 0.05;  // a robot is drawn at least this part of the camera's distance wide

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
    this.floor = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.MeshBasicMaterial());
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
    this.floor.material.map?.dispose();
    this.floor.material.map = tiles(color("--tile"), color("--joint"));
    this.floor.material.needsUpdate = true;
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

  // The paths of a drive, as far as they are known.
  trails(record) {
    this.truthTrail?.free();
    this.ghostTrail?.free();
    const truth = record.frames.map((frame) => [frame[1], frame[2]]), belief = record.errors.map((row) => row.belief);
    const all = [...truth, ...belief];
    const [xs, ys] = [0, 1].map((axis) => all.map((point) => point[axis]));
    const [left, right, low, high] = [least(xs), most(xs), least(ys), most(ys)];
    this.middle = [(left + right) / 2, (low + high) / 2];
    this.reach = Math.max(Math.hypot(right - left, high - low) / 2, this.track);
    const width = Math.max(this.track / 14, this.reach / 160);
    this.truthTrail = new Trail(truth, this.colors.truth, this.track / 200, width);
    this.ghostTrail = new Trail(belief, this.colors.ghost, this.track / 100, 0.7 * width);
    this.scene.add(this.truthTrail.group, this.ghostTrail.group);
  }

  // Draw a moment [s] of a drive. Returns how many times larger than they are the robots are drawn.
  draw(record, time) {
    const now = record.at(time), [x, y, height] = now.position, [gx, gy] = now.believed;
    const apart = Math.hypot(gx - x, gy - y);
    const whole = this.mode !== "follow";
    const [center, radius] = whole
      ? [this.middle, 1.1 * this.reach]
      : [[(x + gx) / 2, (y + gy) / 2], Math.max(2.2 * this.track, 0.75 * apart + this.track)];
    const distance = this.camera.look(center, radius, this.mode === "above");
    const larger = Math.max(1, SMALLEST * distance / this.track);
    this.robot.place(now.position, now.quaternion, now.wheels);
    this.robot.enlarge(larger);
    this.ghost.placeFlat(now.believed, height, now.wheels);
    this.ghost.enlarge(larger);
    this.truthTrail.upTo(time * 100);
    this.ghostTrail.upTo(time * record.planned.rate);
    this.pave(center, distance);
    this.renderer.render(this.scene, this.camera.camera);
    return larger;
  }

  // The floor reaches as far as the eye, in tiles of a metre, or of ten where these would be too small.
  pave(center, distance) {
    const tile = 10 ** Math.round(Math.log10(Math.max(distance / 6, 0.1))), size = 400 * tile;
    const { map } = this.floor.material;
    this.tile = tile;
    this.floor.scale.set(size, size, 1);
    this.floor.position.set(2 * tile * Math.round(center[0] / (2 * tile)), 2 * tile * Math.round(center[1] / (2 * tile)), 0);
    map.repeat.set(size / (2 * tile), size / (2 * tile));
    this.scene.fog.near = 2 * distance;
    this.scene.fog.far = 8 * distance;
  }
}

const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
const most = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);

// Two by two tiles, as a pattern.
function tiles(tile, joint) {
  const canvas = document.createElement("canvas"), n = 256;
  canvas.width = canvas.height = n;
  const brush = canvas.getContext("2d");
  brush.fillStyle = tile;
  brush.fillRect(0, 0, n, n);
  brush.fillStyle = joint;
  brush.fillRect(0, 0, n / 2, n / 2);
  brush.fillRect(n / 2, n / 2, n / 2, n / 2);
  const map = new THREE.CanvasTexture(canvas);
  map.wrapS = map.wrapT = THREE.RepeatWrapping;
  map.colorSpace = THREE.SRGBColorSpace;
  map.anisotropy = 4;
  return map;
}
