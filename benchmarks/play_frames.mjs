// Opens the page of diffdrive play in headless Chromium, and prints as JSON how many frames a second it draws while its
// first drive runs, and how much faster than real time the physics was. Argument: the page's address.
import { chromium } from "playwright-core";

const args = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader"];
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args });
const seen = {};
for (const [width, height] of [[1280, 900], [390, 844]]) {
  const page = await browser.newPage({ viewport: { width, height } });
  await page.goto(process.argv[2]);
  await page.waitForFunction(() => document.body.dataset.state === "ready");
  await page.waitForTimeout(2000);
  seen[width] = await page.evaluate(async () => {
    const { scene } = window.app, draw = scene.draw.bind(scene);
    let frames = 0;
    scene.draw = (...moment) => { frames += 1; return draw(...moment); };
    await new Promise((go) => setTimeout(go, 5000));
    return { frames: frames / 5, faster: window.app.faster };
  });
  await page.close();
}
await browser.close();
process.stdout.write(JSON.stringify(seen));
