// A robot in the scene: its body and two turning wheels, in its own colors or as a ghost.

import * as THREE from "/three/three.module.js";

const GHOST = 0xf08a24;

export class Robot {
  // Shapes as shapes.mjs has them. A ghost has the believed wheels: `sizes` are { true, believed }.
  constructor({ shapes, hubs }, ghost = null) {
    this.group = new THREE.Group();
    this.wheels = {};
    this.lift = 0;
    for (const side of ["left", "right"]) {
      const wheel = new THREE.Group();
      wheel.position.set(...hubs[side]);
      if (ghost) {
        const larger = ghost.believed[`${side}_radius`] / ghost.true[`${side}_radius`];
        wheel.scale.set(larger, 1, larger);
        wheel.position.y *= ghost.believed.track_width / ghost.true.track_width;
      }
      this.wheels[side] = wheel;
      this.group.add(wheel);
    }
    if (ghost) {
      const mean = ({ left_radius, right_radius }) => (left_radius + right_radius) / 2;
      this.lift = mean(ghost.believed) - mean(ghost.true);
    }
    for (const shape of shapes) (shape.wheel ? this.wheels[shape.wheel] : this.group).add(mesh(shape, Boolean(ghost)));
  }

  // The robot's pose from the physics.
  place([x, y, z], [w, i, j, k], angles) {
    this.group.position.set(x, y, z);
    this.group.quaternion.set(i, j, k, w).normalize();
    this.turn(angles);
  }

  // A pose [x, y, theta] in the plane, at the height of the axle.
  placeFlat([x, y, theta], height, angles) {
    this.group.position.set(x, y, height + this.lift);
    this.group.quaternion.setFromAxisAngle(UP, theta);
    this.turn(angles);
  }

  turn({ left, right }) {
    this.wheels.left.rotation.y = left;
    this.wheels.right.rotation.y = right;
  }

  // Draw it larger than it is, about its contacts with the floor.
  enlarge(factor) {
    this.group.scale.setScalar(factor);
    this.group.position.z *= factor;
  }

  free() {
    this.group.traverse((part) => { part.geometry?.dispose(); part.material?.dispose(); });
    this.group.removeFromParent();
  }
}

const UP = new THREE.Vector3(0, 0, 1);

function mesh({ kind, size, position, quaternion: [w, x, y, z], color }, ghost) {
  const material = ghost
    ? new THREE.MeshLambertMaterial({ color: GHOST, transparent: true, opacity: 0.55 })
    : new THREE.MeshLambertMaterial({ color: new THREE.Color(...color) });
  const made = new THREE.Mesh(geometry(kind, size), material);
  made.position.set(...position);
  made.quaternion.set(x, y, z, w);
  if (ghost) made.renderOrder = 2;
  return made;
}

function geometry(kind, [a, b, c]) {
  if (kind === "box") return new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
  if (kind === "cylinder") return new THREE.CylinderGeometry(a, a, 2 * b, 32).rotateX(Math.PI / 2);  // along z
  const ball = new THREE.SphereGeometry(1, 24, 16);
  return kind === "sphere" ? ball.scale(a, a, a) : ball.scale(a, b, c);
}
