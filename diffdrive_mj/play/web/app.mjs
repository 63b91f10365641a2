// The page: a setting is asked for, its drive is stepped in the worker, and shown at the pace of the clock.

import { Controls } from "./controls.mjs";
import { Plot } from "./plot.mjs";
import { Record, wrapped } from "./record.mjs";
import { Scene } from "./scene.mjs";
import { fromHash, toHash } from "./settings.mjs";
import { fixed, reasons, words } from "./words.mjs";

const element = (id) => document.getElementById(id);
const DEGREES = 180 / Math.PI;
// Of an element; what is already there is not written again, which would paint it again.
const text = (id, said, at = element(id)) => { if (at.textContent !== said) at.textContent = said; };

class App {
  constructor(start) {
    this.start = start;
    this.worker = new Worker("/play/web/worker.mjs", { type: "module" });
    this.worker.onmessage = ({ data }) => this.heard(data);
    this.worker.onerror = () => this.answered("the physics could not be loaded");
    this.scene = new Scene(element("scene"));
    this.position = new Plot(element("position"), (row) => row.position, 0.001);
    this.heading = new Plot(element("heading"), (row) => row.heading * DEGREES, 0.1);
    this.controls = new Controls(element("controls"), start, (setting) => this.set(setting));
    Object.assign(this, { record: null, time: 0, running: false, atEnd: false, asking: null, drawn: [] });
    this.listen();
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.running = !still;
    this.atEnd = still;
    this.set(fromHash(location.hash, start.settings));
    requestAnimationFrame((now) => this.tick(now));
  }

  listen() {
    const on = (id, event, act) => element(id).addEventListener(event, act);
    on("run", "click", () => this.run(!this.running));
    on("reset", "click", () => { this.run(false); this.go(0); });
    on("time", "input", () => { this.run(false); this.go(Number(element("time").value)); });
    on("camera-mode", "change", () => this.show(element("camera-mode").value));
    on("turn-left", "click", () => this.scene.camera.turn(-0.3));
    on("turn-right", "click", () => this.scene.camera.turn(0.3));
    on("zoom-in", "click", () => this.scene.camera.zoom(1.25));
    on("zoom-out", "click", () => this.scene.camera.zoom(0.8));
    addEventListener("hashchange", () => {
      if (location.hash.slice(1) !== toHash(this.setting)) this.set(fromHash(location.hash, this.start.settings));
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.scene.paint());
  }

  // Another setting: into the sliders, and to the server.
  set(setting) {
    this.setting = setting;
    this.controls.show(setting);
    if (!this.asking) this.ask();
  }

  // Into the address, and to the server. One drive at a time, so that there is always something to see while a slider
  // moves; then the newest setting.
  async ask() {
    this.asking = toHash(this.setting);
    history.replaceState(null, "", `#${this.asking}`);
    document.body.dataset.state = "asking";
    let answer;
    try {
      answer = await (await fetch(`/api/drive?${this.asking}`)).json();
    } catch {
      answer = { error: "the server has ended: start diffdrive play again" };
    }
    if (answer.error) return this.answered(answer.error);
    this.planned = answer;
    this.worker.postMessage(answer);
  }

  // There is a drive, or a reason why there is none; another setting may have come meanwhile.
  answered(refusal = "") {
    const current = this.asking === toHash(this.setting);
    this.asking = null;
    if (!current) return this.ask();
    this.alert(refusal);
    document.body.dataset.state = refusal ? "refused" : "ready";
  }

  // What the worker has to say of the drive that it was given.
  heard({ error, shapes, faster, ...kept }) {
    if (!error) this.take(new Record(this.planned, kept), shapes, faster);
    this.answered(error);
  }

  take(record, shapes, faster) {
    this.record = record;
    this.scene.robots(shapes, record.planned);
    element("time").max = record.duration;
    const largest = record.errors.reduce((most, row) => Math.max(most, row.position), 0);
    const scale = largest < 1 ? 1000 : 1;
    document.querySelector(".unit").textContent = scale === 1 ? "[m]" : "[mm]";
    this.position.least = 0.001 * scale;
    this.position.show(record, scale);
    this.heading.show(record);
    const why = reasons(record).map((reason) => Object.assign(document.createElement("li"), { textContent: reason }));
    element("why").replaceChildren(...why);
    text("speed", `MuJoCo in this page: ${faster.toFixed(0)} times as fast as real time.`);
    this.faster = faster;
    this.scene.trails(record);
    this.time = this.atEnd ? record.end : Math.min(this.time, record.end);
    this.changed = true;
  }

  show(mode) {
    this.scene.mode = mode;
    this.scene.camera.reset();
    if (this.record) this.scene.trails(this.record);
  }

  alert(said) {
    text("alert", said);
    element("alert").hidden = !said;
  }

  run(running) {
    if (running && this.atEnd) this.go(0);
    this.running = running;
    this.changed = true;
  }

  go(time) {
    this.time = time;
    this.atEnd = this.record !== null && time >= this.record.end - 1e-9;
    this.changed = true;
  }

  tick(now) {
    requestAnimationFrame((later) => this.tick(later));
    const passed = Math.min((now - (this.last ?? now)) / 1000, 0.5);  // a page that was hidden does not leap
    this.last = now;
    if (!this.record) return;
    if (this.running) {
      this.go(Math.min(this.time + passed * Number(element("pace").value), this.record.end));
      if (this.atEnd) this.running = false;
    }
    if (this.changed || this.scene.camera.changed) this.draw(now);
  }

  draw(now) {
    const { record, time } = this, row = record.known(time);
    this.changed = this.scene.camera.changed = false;
    const larger = this.scene.draw(record, time);
    this.position.move(time, row);
    this.heading.move(time, row);
    // Nobody reads sixty numbers a second, and writing them costs more than drawing the robots.
    if (!this.running || now - (this.written ?? 0) > 100) {
      this.write(row, larger);
      this.written = now;
    }
    this.drawn = [...this.drawn.filter((t) => t > now - 1000), now];
    document.body.dataset.frames = this.drawn.length;
  }

  write(row, larger) {
    const { setting } = this.record.planned;
    const k = setting.maneuver === "k" ? `k = ${setting.k}   ` : "";
    const drawn = larger > 1.05 ? `   robots enlarged ${larger.toFixed(1)} ×` : "";
    text("caption", `${k}${row.t.toFixed(1)} s   tiles of ${this.scene.tile} m${drawn}`);
    text("run", this.running ? "Pause" : "Run");
    text("clock", `${this.time.toFixed(1)} s`);
    element("time").value = this.time;
    for (const [id, pose] of [["pose-true", row.truth], ["pose-believed", row.belief]]) {
      const line = element(id), [x, y, theta] = pose;
      line.dataset.pose = JSON.stringify(pose);
      const shown = [fixed(x, 3), fixed(y, 3), fixed(wrapped(theta) * DEGREES, 1)];
      shown.forEach((said, column) => text("", said, line.cells[column + 1]));
    }
    // Read out when it stands still, not sixty times a second.
    text("words", this.running ? words(this.record.errors.at(-1)).replace(/^After/, "In the end, after") : words(row));
  }
}

try {
  const reply = await fetch("/api/start");
  // For whoever wants to look into it from the console, and for the tests.
  window.app = new App(await reply.json());
} catch (error) {
  element("alert").textContent = `this browser cannot show the page: ${error.message}`;
  element("alert").hidden = false;
}
