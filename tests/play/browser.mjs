// Opens the page as users do, and prints what it has seen as JSON. Arguments: the page's address, the browser's
// program.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const [address, executablePath] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const args = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader"];
const browser = await chromium.launch({ executablePath, args });
const LOOKS = [[1280, "light"], [1280, "dark"], [390, "light"], [390, "dark"]];

async function opened(width, colorScheme, hash = "") {
  const page = await browser.newPage({ viewport: { width, height: width > 800 ? 900 : 844 }, colorScheme });
  page.said = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && page.said.push(message.text()));
  page.on("pageerror", (error) => page.said.push(String(error)));
  page.on("request", (request) => request.url().startsWith(address) || request.url().startsWith("data:") ||
    page.said.push(`asks for ${request.url()}`));
  await page.goto(address + hash);
  await state(page, hash.includes("banana") ? "refused" : "ready");
  return page;
}

const state = (page, wanted) => page.waitForFunction((s) => document.body.dataset.state === s, wanted);
// Until the drive that is shown has some settings.
const driven = (page, wanted) => page.waitForFunction((w) => Object.entries(w)
  .every(([name, value]) => window.app.record?.planned.setting[name] === value), wanted);

// What the page shows at the end of its drive.
async function end(page) {
  await page.focus("#time");
  await page.keyboard.press("End");
  await page.waitForFunction(() => document.querySelector("#run").textContent === "Run");
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
  return page.evaluate(() => ({
    hash: location.hash.slice(1),
    pose: JSON.parse(document.querySelector("#pose-true").dataset.pose),
    belief: JSON.parse(document.querySelector("#pose-believed").dataset.pose),
    words: document.querySelector("#words").textContent,
    why: document.querySelector("#why").textContent,
    clock: document.querySelector("#clock").textContent,
    drawn: ["robot", "ghost"].map((who) => window.app.scene[who].group.position.toArray().slice(0, 2)),
  }));
}

const seen = { looks: [] };
for (const [width, theme] of LOOKS) {
  const page = await opened(width, theme);
  await page.click("#run");  // pause: axe looks at what stands still
  await page.evaluate(axe);
  const violations = await page.evaluate(async () => (await axe.run(document)).violations
    .map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).join(" ")}`));
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  if (width === 1280 && theme === "light") await play(page);
  else if (theme === "dark" && width === 390) await share();
  seen.looks.push({ width, theme, said: [...page.said], violations, wide });
  await page.close();
}

// Which elements are written while it runs for 0.7 s, and have no layer of their own.
async function repainted() {
  const found = new Set(), layered = (node) => node && (getComputedStyle(node).willChange === "transform" ||
    layered(node.parentElement));
  const observer = new MutationObserver((changes) => {
    for (const { target } of changes) if (!layered(target)) found.add(target.id || target.className);
  });
  observer.observe(document.querySelector("main"), { childList: true, characterData: true, subtree: true });
  await new Promise((go) => setTimeout(go, 700));
  observer.disconnect();
  return [...found];
}

// Move sliders by keyboard, run, fit the wheels.
async function play(page) {
  const clocks = () => page.evaluate(() => [window.app.time, performance.now() / 1000]);
  await page.click("#reset");
  await page.selectOption("#pace", "5");
  await page.click("#run");
  await page.waitForFunction(() => document.querySelector("#run").textContent === "Pause");
  const [begin, since] = await clocks();
  seen.repainted = await page.evaluate(repainted);
  const [later, now] = await clocks();
  seen.pace = (later - begin) / (now - since);
  await page.focus("#k-slider");
  for (let k = 0; k < 6; k++) await page.keyboard.press("ArrowLeft");
  await driven(page, { k: 0.88 });
  seen.slid = await end(page);
  await page.click("#compensate");
  await driven(page, { right_radius: 0.088 });
  await page.click("#enlighten");
  await driven(page, { believed_right_radius: 0.088 });
  seen.compensated = await end(page);
  await page.fill("#friction", "0.1");
  await page.keyboard.press("Tab");
  await page.selectOption("#maneuver", "square");
  await driven(page, { friction: 0.1, maneuver: "square" });
  seen.slippery = await end(page);
  await page.selectOption("#robot", "ct_bot");
  await driven(page, { robot: "ct_bot" });
  seen.other = await page.evaluate(() => window.app.record.planned.setting);
  const { length } = page.said;
  await page.fill("#left_radius", "-3");
  await page.keyboard.press("Tab");
  await state(page, "refused");
  seen.refused = await page.textContent("#alert");
  page.said = page.said.slice(0, length);  // the browser names every request that is refused
  // Every control can be reached with Tab, in the order in which they stand.
  seen.controls = await page.evaluate(() => [...document.querySelectorAll("button, select, input")]
    .filter((control) => control.offsetParent).map(({ id }) => id));
  await page.focus("#camera-mode");
  seen.reached = ["camera-mode"];
  for (let k = 1; k < seen.controls.length; k++) {
    await page.keyboard.press("Tab");
    seen.reached.push(await page.evaluate(() => document.activeElement.id));
  }
}

// Open the address of the setting that was made by hand, in another window; then one that is no setting.
async function share() {
  const other = await opened(390, "dark", `#${seen.slid.hash}`);
  seen.shared = { ...await end(other), said: other.said };
  await other.close();
  const bad = await opened(390, "dark", "#k=banana&maneuver=spin");
  seen.banana = { alert: await bad.textContent("#alert"), robot: await bad.inputValue("#maneuver") };
  // The server ends while the page is open.
  await bad.route("**/api/drive*", (route) => route.abort());
  await bad.selectOption("#maneuver", "circle");
  await bad.waitForFunction(() => document.querySelector("#alert").textContent.includes("server"));
  seen.ended = await bad.textContent("#alert");
  await bad.close();
  const flat = await browser.newPage();
  await flat.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
  await flat.goto(address);
  await flat.waitForSelector("#alert:not([hidden])");
  seen.flat = await flat.textContent("#alert");
  await flat.close();
}

await browser.close();
process.stdout.write(JSON.stringify(seen));
