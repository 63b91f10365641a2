// The camera: what it looks at follows the drive, from where it looks is the user's, by dragging, wheel and buttons.

import * as THREE from "/three/three.module.js";

const FIELD = 40;  // of view, top to bottom [deg]
const LOWEST = 0.12, HIGHEST = Math.PI / 2 - 0.001;

export class Camera {
  constructor(canvas) {
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.02, 500);
    this.camera.up.set(0, 0, 1);
    this.reset();
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) this.turn(-event.movementX / 150, event.pointerType === "mouse" ? event.movementY / 200 : 0);
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 600));
    }, { passive: false });
  }

  reset() {
    [this.azimuth, this.elevation, this.closer] = [-2.35, 0.5, 1];  // behind the start, to its right
    this.changed = true;
  }

  turn(azimuth, elevation = 0) {
    this.azimuth += azimuth;
    this.elevation = Math.min(Math.max(this.elevation + elevation, LOWEST), HIGHEST);
    this.changed = true;
  }

  zoom(factor) {
    this.closer = Math.min(Math.max(this.closer * factor, 0.2), 8);
    this.changed = true;
  }

  // Look at a place on the floor so that a circle about it fits in; from above where that is wanted. Returns how far
  // away the camera is.
  look([x, y], radius, above) {
    const tangent = Math.tan(FIELD / 2 * Math.PI / 180) * Math.min(1, this.camera.aspect);
    const distance = radius / tangent / this.closer;
    const elevation = above ? HIGHEST : this.elevation, azimuth = above ? -Math.PI / 2 : this.azimuth;
    const level = distance * Math.cos(elevation);
    this.camera.position.set(
      x + level * Math.cos(azimuth), y + level * Math.sin(azimuth), distance * Math.sin(elevation),
    );
    this.camera.lookAt(x, y, 0);
    this.camera.far = 20 * distance + 50;
    this.camera.near = distance / 200;
    this.camera.updateProjectionMatrix();
    return distance;
  }
}
