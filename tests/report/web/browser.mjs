// Opens a report page in Chromium, at two widths and in two themes, and says what it saw, as JSON.
//
// node browser.mjs PAGE FAULTY-PAGE
import {createHash} from 'node:crypto';
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {chromium} from 'playwright-core';

const [url, faulty] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const args = [
  '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

const browser = await chromium.launch({executablePath: '/usr/bin/chromium', args});
const seen = {};
// All of it in one theme at each width; in the other the colours.
for (const [width, theme, other] of [[1280, 'light', 'dark'], [390, 'dark', 'light']]) {
  seen[`${width} ${theme}`] = await look(width, theme);
  seen[`${width} ${other}`] = await open(url, width, other, async page => ({usable: await usable(page), ...await faults(page)}));
}
seen.faulty = await open(faulty, 390, 'dark', async page => ({...await faults(page), cards: await page.locator('article').count()}));
await browser.close();
process.stdout.write(JSON.stringify(seen));

// A page in a context of its own, with all that it complains of and all that it asks for.
async function open(address, width, colorScheme, visit) {
  const touch = width < 500;
  const context = await browser.newContext({viewport: {width, height: 800}, colorScheme, hasTouch: touch, isMobile: touch});
  const page = await context.newPage(), complaints = [], requests = [];
  page.on('console', message => ['error', 'warning'].includes(message.type()) && complaints.push(message.text()));
  page.on('pageerror', error => complaints.push(error.message));
  page.on('dialog', dialog => complaints.push(`a dialog: ${dialog.message()}`) && dialog.dismiss());
  page.on('request', request => request.url().startsWith('data:') || requests.push(request.url()));
  await page.goto(address);
  const found = await visit(page);
  await context.close();
  return {...found, complaints, requests};
}

async function look(width, colorScheme) {
  return open(url, width, colorScheme, async page => {
    const player = page.locator('.replay .player').first();
    await player.scrollIntoViewIfNeeded();
    await player.locator('[data-part=position]').waitFor();
    const found = {usable: await usable(page)};
    Object.assign(found, await times(page, player), await zooms(page, player), await plays(player), await choices(player));
    if (width < 500) Object.assign(found, await touches(page, player));
    found.hand = await byHand(page);
    found.paper = await onPaper(page);
    found.names = await page.locator('.bounds tbody tr').first().evaluate(row => row.cells[0].offsetWidth / row.offsetWidth);
    found.unreached = await unreached(page);
    return {...found, ...await faults(page)};
  });
}

// How long after the start of the navigation [ms] everything was there to be used.
async function usable(page) {
  return page.evaluate(() => Math.max(
    performance.getEntriesByType('navigation')[0].loadEventEnd, performance.getEntriesByName('usable')[0].startTime));
}

async function faults(page) {
  await page.evaluate(() => document.querySelectorAll('details').forEach(each => { each.open = true; }));
  await page.evaluate(axe);
  const {violations} = await page.evaluate(() => window.axe.run());
  return {
    axe: violations.map(({id, nodes}) => `${id}: ${nodes.map(node => node.html).join(' ').slice(0, 300)}`),
    overflow: await page.evaluate(() => document.documentElement.scrollWidth - innerWidth),
    hacked: await page.evaluate(() => window.hacked ?? null),
    scripts: await page.locator('script').count(),
    background: await page.evaluate(() => getComputedStyle(document.body).backgroundColor),
  };
}

// What a canvas shows, once it has been drawn.
async function picture(player) {
  const image = await player.locator('.view').evaluate(canvas => new Promise(done =>
    requestAnimationFrame(() => requestAnimationFrame(() => done(canvas.toDataURL())))));
  return createHash('sha1').update(image).digest('hex');
}

async function readout(player) {
  return Object.fromEntries(await Promise.all(['clock', 'position', 'heading'].map(
    async name => [name, await player.locator(`[data-part=${name}]`).textContent()])));
}

// The numbers at some times, set by keys and by the slider itself.
async function times(page, player) {
  const slider = player.locator('[data-part=time]'), result = {}, pictures = new Set([await picture(player)]);
  result.end = await readout(player);
  await slider.focus();
  await page.keyboard.press('Home');
  result.start = await readout(player);
  pictures.add(await picture(player));
  for (let k = 0; k < 5; k++) await page.keyboard.press('ArrowRight');
  result.step5 = await readout(player);
  await slider.fill('250');
  result.step250 = await readout(player);
  pictures.add(await picture(player));
  // A click in the middle of the error plot.
  const box = await player.locator('[data-part=errors]').boundingBox();
  await player.locator('[data-part=errors]').click({position: {x: box.width / 4, y: box.height / 2}});
  result.clicked = await readout(player);
  return {readouts: result, pictures: pictures.size, spoken: await slider.getAttribute('aria-valuetext')};
}

// Keys, buttons, mouse wheel and drag change the view; 0 brings it back.
async function zooms(page, player) {
  const view = player.locator('.view'), steps = {};
  const first = await picture(player);
  const changed = async name => { steps[name] = await picture(player) !== first; };
  const back = async name => {
    await view.press('0');
    steps[name] = await picture(player) === first;
  };
  const box = await view.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel(0, 10);
  steps['the wheel scrolls until the view is chosen'] = await picture(player) === first;
  for (const key of ['+', '-', 'ArrowLeft', 'ArrowUp']) {
    await view.press(key);
    await changed(`key ${key}`);
    await back(`0 after ${key}`);
  }
  for (const part of ['closer', 'wider']) {
    await player.locator(`[data-part=${part}]`).click();
    await changed(`button ${part}`);
    await player.locator('[data-part=reset]').click();
    steps[`reset after ${part}`] = await picture(player) === first;
  }
  await view.focus();
  await view.hover();
  await page.mouse.wheel(0, -200);
  await page.waitForTimeout(50);
  await changed('wheel');
  await back('0 after wheel');
  await view.hover({position: {x: 80, y: 100}});
  await page.mouse.down();
  await page.mouse.move(box.x + 150, box.y + 150, {steps: 3});
  await page.mouse.up();
  await changed('drag');
  await back('0 after drag');
  return {zooms: steps};
}

async function plays(player) {
  const play = player.locator('[data-part=play]');
  await player.locator('[data-part=time]').fill('500');
  await play.click();
  const label = await play.textContent();
  await player.page().waitForTimeout(250);
  await play.click();
  return {plays: {label, after: await play.textContent(), clock: (await readout(player)).clock}};
}

// Another belief, another drive.
async function choices(player) {
  await player.locator('[data-part=time]').fill('500');
  await player.getByLabel('nearly right').check();
  const belief = await readout(player);
  await player.getByLabel('The same backwards').check();
  return {chosen: {belief, drive: await readout(player)}, key: await player.locator('.key').innerText()};
}

// Two fingers that move apart, and a tap.
async function touches(page, player) {
  await player.locator('.view').scrollIntoViewIfNeeded();
  const first = await picture(player), box = await player.locator('.view').boundingBox();
  const client = await page.context().newCDPSession(page), x = box.x + box.width / 2, y = box.y + box.height / 2;
  const points = gap => [{x: x - gap, y, id: 0}, {x: x + gap, y, id: 1}];
  await client.send('Input.dispatchTouchEvent', {type: 'touchStart', touchPoints: points(20)});
  for (const gap of [30, 45, 60]) await client.send('Input.dispatchTouchEvent', {type: 'touchMove', touchPoints: points(gap)});
  await client.send('Input.dispatchTouchEvent', {type: 'touchEnd', touchPoints: []});
  const pinched = await picture(player) !== first;
  await player.locator('[data-part=reset]').tap();
  const back = await picture(player) === first;
  await player.getByLabel('A bend').tap();
  return {touch: {pinched, back, tapped: await readout(player), scrolled: await scrolls(page, player, client)}};
}

// One finger that moves down over the view: it scrolls the page, and leaves the view as it is.
async function scrolls(page, player, client) {
  await player.locator('.view').evaluate(view => view.scrollIntoView({block: 'center', behavior: 'instant'}));
  const first = await picture(player), from = await page.evaluate(() => scrollY), box = await player.locator('.view').boundingBox();
  const at = down => [{x: box.x + 100, y: box.y + 200 - down, id: 0}];
  await client.send('Input.dispatchTouchEvent', {type: 'touchStart', touchPoints: at(0)});
  for (const down of [10, 30, 60, 100]) await client.send('Input.dispatchTouchEvent', {type: 'touchMove', touchPoints: at(down)});
  await client.send('Input.dispatchTouchEvent', {type: 'touchEnd', touchPoints: []});
  const pageMoved = await page.waitForFunction(y => scrollY > y, from, {timeout: 5000}).then(() => true, () => false);
  return {pageMoved, same: await picture(player) === first};
}

// Which of its sliders can be moved with the whole drive in sight.
async function inSight(page, card) {
  const seen = [];
  for (const slider of await card.locator('input[type=range][name]').all()) {
    await slider.evaluate(each => { each.blur(); each.scrollIntoView({block: 'end', behavior: 'instant'}); });
    const [control, stage] = [await slider.boundingBox(), await card.locator('.stage').boundingBox()];
    if (control.y >= 0 && control.y + control.height <= stage.y && stage.y + stage.height <= 800) seen.push(await slider.getAttribute('name'));
  }
  return seen;
}

// A setting by keys, its words and its address; the address alone brings it back.
async function byHand(page) {
  const card = page.locator('#k-by-hand'), slider = card.locator('[name=k]');
  const words = () => card.locator('[data-part=words]').innerText();
  await card.scrollIntoViewIfNeeded();
  const first = {words: await words(), off: await readout(card)};
  await slider.focus();
  for (let k = 0; k < 3; k++) await page.keyboard.press('ArrowRight');
  await card.locator('[name=method]').selectOption('euler');
  await page.waitForTimeout(250);
  const second = {words: await words(), off: await readout(card), hash: await page.evaluate(() => location.hash)};
  const shared = await open(`${url}${second.hash}`, 390, 'light', async other => {
    const there = other.locator('#k-by-hand');
    await there.locator('[data-part=words] p').first().waitFor();
    return {words: await there.locator('[data-part=words]').innerText(), k: await there.locator('[name=k]').inputValue()};
  });
  await card.getByRole('button', {name: 'Compensated: r_r = k r_l'}).click();
  await page.waitForTimeout(250);
  const key = await card.locator('.key').innerText(), after = await words();
  await page.evaluate(() => { location.hash = '#k-by-hand?k=1.25'; });
  await page.waitForTimeout(250);
  const typed = await slider.inputValue();
  return {first, second, shared, key, typed, compensated: after, seen: await inSight(page, card)};
}

// What a print has of each kind, and in which colour; and what is closed again after it.
async function onPaper(page) {
  await page.emulateMedia({media: 'print'});
  const found = await page.evaluate(() => {
    const shown = {}, all = selector => [...document.querySelectorAll(selector)];
    dispatchEvent(new Event('beforeprint'));
    for (const kind of ['input', 'button', 'canvas', 'h3', '.bounds', '.picture']) shown[kind] = all(kind).filter(each => each.checkVisibility()).length;
    shown.ink = getComputedStyle(document.body).color;
    shown.closed = all('details:not([open])').length;
    dispatchEvent(new Event('afterprint'));
    return {...shown, closedAfter: all('details:not([open])').length};
  });
  await page.emulateMedia({media: null});
  return found;
}

// What can be used but is not reached with the tab key.
async function unreached(page) {
  await page.evaluate(() => {
    document.activeElement.blur();
    window.reached = new Set();
    addEventListener('focusin', event => window.reached.add(event.target));
  });
  const selector = 'a[href], button, input, select, summary, canvas[tabindex], [tabindex="0"]';
  const count = await page.locator(selector).count();
  for (let k = 0; k < count; k++) await page.keyboard.press('Tab');
  return page.evaluate(wanted => [...document.querySelectorAll(wanted)].filter(each => {
    const one = each.type === 'radio' ? document.querySelector(`[name="${each.name}"]:checked`) : each;
    return each.checkVisibility() && !window.reached.has(one);
  }).map(each => each.outerHTML.slice(0, 100)), selector);
}
