// A path on the floor: a ribbon of even width, strong up to where the robot has come, faint beyond.

import * as THREE from "/three/three.module.js";

export class Trail {
  // Points [[x, y], ...], its color, and how far above the floor it lies [m].
  constructor(points, color, height, width) {
    this.points = thinned(points, width / 2);
    this.group = new THREE.Group();
    this.strong = ribbon(this.points, width, color, 0.95);
    this.faint = ribbon(this.points, width, color, 0.25);
    this.strong.position.z = height;
    this.faint.position.z = height / 2;
    this.group.add(this.faint, this.strong);
  }

  // Show it strong up to the point of this number in the list given.
  upTo(count) {
    let segments = 0;
    while (segments < this.points.length - 1 && this.points[segments + 1].k <= count) segments += 1;
    this.strong.geometry.setDrawRange(0, 6 * segments);
  }

  paint(color) {
    for (const part of this.group.children) part.material.color.set(color);
  }

  free() {
    for (const part of this.group.children) { part.geometry.dispose(); part.material.dispose(); }
    this.group.removeFromParent();
  }
}

// Points at least some distance apart, each with its number in the list.
function thinned(points, apart) {
  const kept = [];
  points.forEach(([x, y], k) => {
    const last = kept.at(-1);
    if (!last || Math.hypot(x - last.x, y - last.y) >= apart || k === points.length - 1) kept.push({ x, y, k });
  });
  return kept;
}

function ribbon(points, width, color, opacity) {
  const corners = new Float32Array(6 * points.length), faces = [];
  points.forEach(({ x, y }, k) => {
    const a = points[Math.max(k - 1, 0)], b = points[Math.min(k + 1, points.length - 1)];
    const length = Math.hypot(b.x - a.x, b.y - a.y) || 1;
    const [ox, oy] = [-(b.y - a.y) / length * width / 2, (b.x - a.x) / length * width / 2];
    corners.set([x + ox, y + oy, 0, x - ox, y - oy, 0], 6 * k);
    if (k) faces.push(2 * k - 2, 2 * k - 1, 2 * k, 2 * k, 2 * k - 1, 2 * k + 1);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
  geometry.setIndex(faces);
  const material = new THREE.MeshBasicMaterial({
    color, opacity, transparent: true, depthWrite: false, side: THREE.DoubleSide,
  });
  const made = new THREE.Mesh(geometry, material);
  made.frustumCulled = false;
  made.renderOrder = 1;
  return made;
}
