// MuJoCo away from the page: it is given a drive, runs it, and posts what there is to see. MuJoCo's bindings make
// functions of text, which the page itself does not allow.

import load from "/mujoco/mujoco.js";
import { Drive } from "./drive.mjs";
import { shapes } from "./shapes.mjs";

const ready = load();

onmessage = async ({ data: planned }) => {
  let drive = null;
  try {
    drive = new Drive(await ready, planned);
    const faster = drive.run();
    postMessage({ shapes: shapes(drive.physics.model), faster, ...drive.kept });
  } catch (error) {
    postMessage({ error: `the physics could not be run here: ${error.message.trim().replaceAll("\n", "; ")}` });
  } finally {
    drive?.free();
  }
};
