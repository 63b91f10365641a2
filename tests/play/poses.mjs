// Steps drives in MuJoCo's WebAssembly build, as the page does: reads a JSON list of drives, and writes for each its
// samples, how it held on to the floor, and how many times faster than real time it was stepped.
import { readFileSync } from "node:fs";
import load from "@mujoco/mujoco";
import { Drive } from "../../diffdrive_mj/play/web/drive.mjs";

const mujoco = await load();
const answers = JSON.parse(readFileSync(0, "utf8")).map((planned) => {
  const drive = new Drive(mujoco, planned), faster = drive.run();
  const { samples, grip } = drive.kept, { time } = drive.physics;
  drive.free();
  return { samples: [...samples], grip, time, faster };
});
process.stdout.write(JSON.stringify(answers));
