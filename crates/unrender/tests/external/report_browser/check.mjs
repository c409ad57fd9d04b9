// Checks the pages in a browser: node check.mjs FOLDER, which browser.rs has filled.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import axe from "axe-core";
import { open } from "./browser.mjs";

const NO_BROWSER = 77;
const folder = process.argv[2];
const read = (path) => JSON.parse(readFileSync(join(folder, path), "utf8"));
let browser;
try {
  browser = await open();
} catch (error) {
  console.error(`no browser could be opened: ${error.message}`);
  process.exit(NO_BROWSER);
}

/** Opens a page; `told` collects errors and requests to the network. */
async function visit(path, { width = 1280, scheme = "light" } = {}) {
  const tab = await browser.newPage();
  const url = pathToFileURL(join(folder, path)).href;
  const told = [];
  tab.on("console", (message) => told.push(`console: ${message.text()}`));
  tab.on("pageerror", (error) => told.push(`error: ${error.message}`));
  tab.on("request", (request) => {
    if (request.url() !== url && !request.url().startsWith("data:")) {
      told.push(`request: ${request.url()}`);
    }
  });
  await tab.setViewport({ width, height: 800 });
  await tab.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await tab.goto(url, { waitUntil: "load" });
  // The map is ready when its canvas has the picture's size.
  await tab.waitForFunction(() => {
    const map = document.querySelector(".map");
    const image = map?.querySelector(".groups");
    return !map || map.querySelector("canvas").width === image.naturalWidth;
  });
  await tab.waitForFunction(() => !document.querySelector("main.play") || document.body.dataset.ready);
  return { tab, told };
}

/** Waits until the map shows the group `name`, and checks that only its row is lit. */
async function tells(tab, name) {
  const said = () => tab.$eval(".readout", (readout) => readout.textContent);
  await tab
    .waitForFunction(
      (n) => document.querySelector(".readout strong")?.textContent === n, { timeout: 20_000 }, name)
    .catch(async () => assert.fail(`the map shows ${await said()} instead of ${name}`));
  assert.deepEqual(await tab.$$eval("tr.lit", (rows) => rows.map((r) => r.dataset.group)), [name]);
}

async function theDividerMoves(tab) {
  const clip = () => tab.$eval(".compare .over", (over) => getComputedStyle(over).clipPath);
  const right = async () => Number((await clip()).match(/^inset\(0px ([\d.]+)%/)?.[1] ?? NaN);
  assert.equal(await right(), 50);
  await tab.focus(".divider");
  for (let i = 0; i < 10; i++) await tab.keyboard.press("ArrowRight");
  assert.equal(await right(), 45);
  const box = await (await tab.$(".compare .frame")).boundingBox();
  const y = box.y + box.height / 2;
  await tab.mouse.move(box.x + 0.55 * box.width, y);
  await tab.mouse.down();
  await tab.mouse.move(box.x + 0.25 * box.width, y, { steps: 5 });
  await tab.mouse.up();
  assert.ok(Math.abs((await right()) - 75) < 3, `dragged to ${await clip()}`);
}

async function theFlickerToggles(tab) {
  const shown = () => tab.$eval(".compare", (figure) => figure.className);
  const usual = await shown();
  await tab.click(".flicker");
  const first = await shown();
  assert.match(first, /photo|rendered/);
  await tab.waitForFunction(
    (before) => document.querySelector(".compare").className !== before, {}, first);
  await tab.click(".flicker");
  assert.equal(await shown(), usual);
}

/** One zoom for all pictures, by buttons, keys and the wheel, which scrolls the page before a click. */
async function theViewZooms(tab) {
  const scales = () => tab.$$eval(".viewer .layer img", (images) =>
    images.map((image) => new DOMMatrix(getComputedStyle(image).transform).a));
  const all = async (scale, how) => assert.deepEqual(
    (await scales()).map((s) => Math.round(100 * s) / 100), [scale, scale, scale], how);
  await all(1, "at first");
  await tab.click(".zoom-in");
  await all(1.5, "the button");
  assert.equal(await tab.$eval(".zoom", (output) => output.textContent), "150 %");
  await tab.focus(".frame.error");
  await tab.keyboard.press("+");
  await all(2.25, "the key");
  const left = () => tab.$eval(".viewer", (viewer) => parseFloat(viewer.style.getPropertyValue("--x")));
  const before = await left();
  await tab.keyboard.press("ArrowRight");
  assert.ok((await left()) < before, "the arrow key moves the view");
  await tab.click(".zoom-fit");
  await all(1, "fit");
  const box = await (await tab.$(".frame.error")).boundingBox();
  await tab.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await tab.mouse.wheel({ deltaY: -300 });
  await tab.waitForFunction(() => document.querySelector(".viewer").classList.contains("zoomed"));
  await tab.click(".zoom-fit");
  await tab.evaluate(() => document.activeElement.blur());
  await tab.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await tab.mouse.wheel({ deltaY: -30 });
  await all(1, "a wheel that passes by");
  if (await tab.$(".show")) {
    // The page may still be scrolling from the wheel, so that a click of the mouse would miss.
    await tab.$eval(".show", (button) => button.click());
    await all(4, "the button of a place");
    await tab.click(".zoom-fit");
  }
}

/** The values under the pointer: of the page's pictures, of the difference, and the group's name. */
async function thePointerReads(tab, { name, x, y }, difference) {
  const frame = await tab.$(".frame.error");
  await frame.scrollIntoView();
  const box = await frame.boundingBox();
  await tab.mouse.move(box.x + x * box.width, box.y + y * box.height);
  await tab.waitForFunction(() => document.querySelector(".probe-group"), { timeout: 20_000 });
  const value = (of) => tab.$eval(`.probe-${of}`, (bold) => bold.textContent);
  assert.equal(await value("group"), name);
  assert.equal(await value("difference"), difference);
  for (const of of ["photograph", "re-rendering"]) assert.match(await value(of), /^\d+ \d+ \d+$/);
  assert.equal(await tab.$$eval(".mark:not([hidden])", (marks) => marks.length), 2);
}

/** The exposure applies to photograph and re-rendering alike, as a factor of linear values. */
async function theExposureChanges(tab) {
  const state = () => tab.evaluate(() => ({
    filters: [...document.querySelectorAll(".viewer .compare .layer img")]
      .map((image) => getComputedStyle(image).filter.replaceAll('"', "")),
    slope: document.querySelector(".viewer feFuncG").getAttribute("slope"),
    stops: document.querySelector(".stops").textContent,
  }));
  assert.deepEqual(await state(), { filters: ["none", "none"], slope: "1", stops: "0 EV" });
  await tab.focus(".exposure");
  for (let i = 0; i < 4; i++) await tab.keyboard.press("ArrowRight");
  assert.deepEqual(await state(),
    { filters: ["url(#exposure-0)", "url(#exposure-0)"], slope: "2", stops: "+1 EV" });
  for (let i = 0; i < 4; i++) await tab.keyboard.press("ArrowLeft");
}

async function copyingCopies(tab) {
  const copied = await tab.evaluate(async () => {
    const texts = [];
    navigator.clipboard.writeText = async (text) => void texts.push(text);
    const button = document.querySelector(".copy");
    button.click();
    await new Promise((done) => setTimeout(done, 50));
    return { texts, wanted: [button.dataset.copy], says: button.textContent };
  });
  assert.deepEqual(copied.texts, copied.wanted);
  assert.match(copied.texts[0], /^#[0-9a-f]{6}$/);
  assert.equal(copied.says, "Copied");
}

async function theVerdictComesFirst(tab, run) {
  const said = await tab.$eval(".verdict", (verdict) => verdict.textContent);
  assert.ok(said.startsWith(`${run.verdict.recovered} group`), said);
  assert.match(said, /doubtful/);
  const links = await tab.$$eval("ol.first a", (all) =>
    all.map((a) => document.querySelector(a.getAttribute("href")) !== null));
  assert.ok(links.every((leads) => leads), "each thing to look at is on the page");
  const fold = await tab.$eval("header", (header) => header.textContent);
  assert.doesNotMatch(fold, /\b(rung|lobe|global re-rendering)/);
}

async function hoveringNamesTheGroup(tab, places) {
  for (const { name, x, y } of places) {
    const image = await tab.$(".map .groups");
    await image.scrollIntoView();
    const box = await image.boundingBox();
    await tab.mouse.move(box.x + x * box.width, box.y + y * box.height);
    await tells(tab, name);
  }
  for (const index of new Set([0, places.length - 1, Math.floor(places.length / 2)])) {
    await tab.$$eval(".pick", (picks, i) => picks[i].focus(), index);
    await tells(tab, places[index].name);
  }
}

async function namesAreText(tab, run) {
  const shown = await tab.$$eval(".group-name", (names) => names.map((n) => n.textContent));
  assert.deepEqual(shown, Object.keys(run.groups));
  const stray = await tab.evaluate(() => ({
    hacked: window.hacked,
    scripts: document.scripts.length,
    headings: document.querySelectorAll("h1").length,
    pictures: document.querySelectorAll('img:not([src^="data:image/"])').length,
  }));
  assert.deepEqual(stray, { scripts: 1, headings: 1, pictures: 0 });
}

/** Every number is a correctly rounded field of run.json, and no digit is outside of these. */
async function numbersAreTheRuns(tab, run, least = 200) {
  const numbers = await tab.$$eval("main data, header data", (all) =>
    all.filter((d) => !d.closest(".readout, .probe"))
      .map((d) => ({ ...d.dataset, value: d.value, text: d.textContent })));
  assert.ok(numbers.length > least, `${numbers.length} numbers`);
  for (const { key, scale, value, text } of numbers) {
    const parts = key.split("/").slice(1).map((p) => p.replaceAll("~1", "/").replaceAll("~0", "~"));
    const recorded = parts.reduce((at, part) => at?.[part], run);
    assert.equal(Number(value), recorded, key);
    // A share that rounds to nothing is said to be less than the last digit.
    if (text.startsWith("< ")) {
      assert.ok(recorded > 0 && recorded * Number(scale) < Number(text.slice(2)), `${key}: ${recorded} is shown as ${text}`);
      continue;
    }
    const [digits, power = "0"] = text.split("e");
    const unit = 10 ** (Number(power) - (digits.split(".")[1] ?? "").length);
    const off = Math.abs(Number(text) - recorded * Number(scale));
    assert.ok(off <= 0.5000001 * unit, `${key}: ${recorded} is shown as ${text}`);
  }
  const strings = [];
  const gather = (value, key = "") => {
    strings.push(key);
    if (typeof value === "string") strings.push(value);
    else if (value && typeof value === "object") {
      Object.entries(value).forEach(([k, v]) => gather(v, k));
    }
  };
  gather(run);
  const loose = await tab.evaluate(() => {
    const texts = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const parent = walker.currentNode.parentElement;
      const text = walker.currentNode.textContent.trim();
      if (!parent.closest("data, script, svg, code, .readout, .probe, .tools") && /\d/.test(text)) texts.push(text);
    }
    return texts;
  });
  const known = strings.filter((s) => /\d/.test(s)).sort((a, b) => b.length - a.length);
  for (const text of loose) {
    const rest = known.reduce((left, string) => left.replaceAll(string, ""), text);
    assert.doesNotMatch(rest, /\d/, `a number from nowhere: ${text}`);
  }
}

/** Nothing extends beyond the page, and axe reports no problem of accessibility. */
async function readsWell(tab, what) {
  const widths = await tab.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(widths[0] <= widths[1], `${what}: ${widths[0]} of ${widths[1]} pixels`);
  await tab.$$eval("details", (all) => all.forEach((d) => (d.open = true)));
  await tab.evaluate(axe.source);
  const { violations } = await tab.evaluate(() => window.axe.run());
  const said = violations.map((v) => `${v.id}: ${v.help}: ${v.nodes[0].html.slice(0, 200)}`);
  assert.deepEqual(said, [], what);
}

for (const name of ["few", "many"]) {
  const run = read(`${name}/run.json`);
  const { tab, told } = await visit(`${name}/report.html`);
  await namesAreText(tab, run);
  await numbersAreTheRuns(tab, run);
  const places = read(`${name}/places.json`);
  await theVerdictComesFirst(tab, run);
  await theDividerMoves(tab);
  await theFlickerToggles(tab);
  await theViewZooms(tab);
  await thePointerReads(tab, places.at(-1), "+24.6 %");
  await thePointerReads(tab, places[0], "not compared");
  await theExposureChanges(tab);
  await copyingCopies(tab);
  await hoveringNamesTheGroup(tab, places);
  const failed = await tab.$eval("tr.failed", (row) => row.textContent);
  assert.match(failed, /failed.*assumed.*rendering noise leaves that open/s);
  assert.deepEqual(told, []);
  console.log(`${name}: complete, offline, and its numbers are the run's`);
}
{
  const run = read("real/run.json");
  const { tab, told } = await visit("real/report.html");
  await namesAreText(tab, run);
  await numbersAreTheRuns(tab, run, 50);
  await theDividerMoves(tab);
  // The middle of the picture's lower part shows the floor.
  await hoveringNamesTheGroup(tab, [{ name: "floor", x: 0.5, y: 0.8 }]);
  assert.deepEqual(told, []);
  console.log("real: a recovery's page says what its run.json says");
}
{
  const exact = read("exact.json");
  const { tab, told } = await visit("real/view.html");
  const off = async (of) => {
    const shown = (await tab.evaluate(() => unrender.radiance())).flat();
    const truth = exact[of].flat();
    const mean = truth.reduce((sum, v) => sum + v, 0) / truth.length;
    const squares = truth.reduce((sum, v, at) => sum + (v - shown[at]) ** 2, 0) / truth.length;
    return Math.sqrt(squares) / mean;
  };
  // Noise of both pictures is below 2 %.
  const asItWas = await off("lamp");
  assert.ok(asItWas > 0.5, `${asItWas} without a change`);
  await tab.evaluate(() => unrender.lamp("lamp", [0.3, 0.2, 0.1]));
  const byLamp = await off("lamp");
  assert.ok(byLamp < 0.02, `${byLamp} by the lamp`);
  assert.match(await tab.$eval("#command", (code) => code.textContent), /--light 'lamp: scale = \[0.3, 0.2, 0.1\]'/);
  const before = await off("both");
  await tab.evaluate(() => unrender.colour("wall & co", [0.7, 0.2, 0.05]));
  const byBoth = await off("both");
  const { firstOrder, shares } = await tab.evaluate(() => unrender.errors());
  assert.ok(byBoth < firstOrder + shares + 0.02 && byBoth < before / 4, `${byBoth} of ${before}, said ${firstOrder} and ${shares}`);
  // The same by hand: the slider, the picker's row, and back.
  await tab.click("#as-it-was");
  await tab.focus('[data-lamp="0"] input[type="range"]');
  await tab.keyboard.press("Home");
  await tab.waitForFunction(() => unrender.radiance().every((pixel) => pixel.every((v) => Math.abs(v) < 1e-6)));
  assert.match(await tab.$eval("#command", (code) => code.textContent), /--light 'lamp: off'/);
  await tab.click("#as-it-was");
  await tab.waitForFunction(() => unrender.radiance().some((pixel) => pixel[0] > 1e-3));
  const box = await (await tab.$("#picture")).boundingBox();
  await tab.mouse.move(box.x + 0.5 * box.width, box.y + 0.8 * box.height);
  assert.match(await tab.$eval("#probe", (probe) => probe.textContent), /group floor.*lit by lamp 100 %/);
  await tab.mouse.click(box.x + 0.5 * box.width, box.y + 0.8 * box.height);
  assert.match(await tab.$eval("#chosen", (chosen) => chosen.textContent), /^floor/);
  assert.deepEqual(told, []);
  console.log(`view: the lamp within ${byLamp.toFixed(4)}, with a colour within ${byBoth.toFixed(4)} (${before.toFixed(3)} without it)`);
}
for (const path of ["real/view.html", "few/report.html", "many/report.html", "comparison.html", "gallery.html"]) {
  for (const [width, scheme] of [[1280, "light"], [1024, "dark"], [360, "light"], [360, "dark"]]) {
    const { tab, told } = await visit(path, { width, scheme });
    await readsWell(tab, `${path}, ${width} pixels, ${scheme}`);
    assert.deepEqual(told, []);
    await tab.close();
  }
  console.log(`${path}: reads well at 1280, 1024 and 360 pixels, light and dark`);
}
await browser.close();
