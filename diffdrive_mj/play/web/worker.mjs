// MuJoCo away from the page: it is given a drive, and posts its shapes, then the drive piece by piece. MuJoCo's bindings
// make functions of text, which the page itself does not allow.

import load from "/mujoco/mujoco.js";
import { Drive } from "./drive.mjs";
import { shapes } from "./shapes.mjs";

const PIECE = 50;  // [ms]
const ready = load();
let newest = 0;

onmessage = async ({ data: { id, planned } }) => {
  newest = id;
  let drive = null;
  try {
    const mujoco = await ready;
    if (newest !== id) return;
    drive = new Drive(mujoco, planned);
    postMessage({ id, shapes: shapes(drive.physics.model) });
    let spent = 0;
    do {
      const begin = performance.now();
      drive.advance(PIECE);
      spent += (performance.now() - begin) / 1000;
      postMessage({ id, ...drive.taken(), faster: drive.physics.time / spent });
      await new Promise((go) => setTimeout(go));  // a newer drive may have come
    } while (!drive.done && newest === id);
  } catch (error) {
    postMessage({ id, error: `the physics could not be run here: ${error.message}` });
  } finally {
    drive?.free();
  }
};
