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

  // Look at a place on the floor so that a circle about it fits in, top to bottom. Returns how far away the camera is.
  look(place, radius) {
    return this.from(place, radius, this.elevation, this.azimuth);
  }

  // Look at a rectangle on the floor, by its middle and half of its sides, so that it fits in.
  survey(middle, [along, across], above) {
    const { aspect } = this.camera;
    if (above) return this.from(middle, 1.3 * Math.max(across, along / aspect), HIGHEST, -Math.PI / 2);
    const radius = 1.4 * Math.hypot(along, across);  // whichever way it is turned; what is near looks larger
    return this.from(middle, radius * Math.max(Math.sin(this.elevation), 1 / aspect), this.elevation, this.azimuth);
  }

  from([x, y], radius, elevation, azimuth) {
    const distance = radius / Math.tan(FIELD / 2 * Math.PI / 180) / this.closer;
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
