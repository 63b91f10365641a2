// What of a model is to be seen: its shapes with their colors, body by body.

const KINDS = { 2: "sphere", 4: "ellipsoid", 5: "cylinder", 6: "box" };  // mjtGeom
const HIDDEN = 3;  // the group of the tyres of the physics, which look like lenses
const WHEELS = { 2: "left", 3: "right" };  // by the number of the body; 1 is the robot

export function shapes(model) {
  const found = [];
  for (let k = 0; k < model.ngeom; k++) {
    const kind = KINDS[model.geom_type[k]], material = model.geom_matid[k];
    if (!kind || model.geom_group[k] === HIDDEN) continue;
    const [colors, at] = material < 0 ? [model.geom_rgba, k] : [model.mat_rgba, material];
    found.push({
      kind,
      wheel: WHEELS[model.geom_bodyid[k]] ?? null,
      size: [...model.geom_size.subarray(3 * k, 3 * k + 3)],
      position: [...model.geom_pos.subarray(3 * k, 3 * k + 3)],
      quaternion: [...model.geom_quat.subarray(4 * k, 4 * k + 4)],
      color: [...colors.subarray(4 * at, 4 * at + 3)],
    });
  }
  const hub = (body) => [...model.body_pos.subarray(3 * body, 3 * body + 3)];
  return { shapes: found, hubs: { left: hub(2), right: hub(3) } };
}
