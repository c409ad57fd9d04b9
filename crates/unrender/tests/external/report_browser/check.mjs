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
  await tab.click(".flicker");
  const first = await shown();
  assert.match(first, /photo|rendered/);
  await tab.waitForFunction(
    (before) => document.querySelector(".compare").className !== before, {}, first);
  await tab.click(".flicker");
  assert.equal(await shown(), "compare");
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
    all.filter((d) => !d.closest(".readout"))
      .map((d) => ({ ...d.dataset, value: d.value, text: d.textContent })));
  assert.ok(numbers.length > least, `${numbers.length} numbers`);
  for (const { key, scale, value, text } of numbers) {
    const parts = key.split("/").slice(1).map((p) => p.replaceAll("~1", "/").replaceAll("~0", "~"));
    const recorded = parts.reduce((at, part) => at?.[part], run);
    assert.equal(Number(value), recorded, key);
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
      if (!parent.closest("data, script, svg, code, .readout") && /\d/.test(text)) texts.push(text);
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
  await theDividerMoves(tab);
  await theFlickerToggles(tab);
  await hoveringNamesTheGroup(tab, read(`${name}/places.json`));
  const failed = await tab.$eval("tr.failed", (row) => row.textContent);
  assert.match(failed, /failed.*assumed.*too few pixels/s);
  assert.deepEqual(told, []);
  console.log(`${name}: complete, offline, and its numbers are the run's`);
}
{
  const run = read("real/run.json");
  const { tab, told } = await visit("real/report.html");
  await namesAreText(tab, run);
  await numbersAreTheRuns(tab, run, 50);
  await theDividerMoves(tab);
  // The middle of the picture's lower edge shows the floor.
  await hoveringNamesTheGroup(tab, [{ name: "floor", x: 0.5, y: 0.97 }]);
  assert.deepEqual(told, []);
  console.log("real: a recovery's page says what its run.json says");
}
for (const path of ["few/report.html", "many/report.html", "comparison.html", "gallery.html"]) {
  for (const [width, scheme] of [[1280, "light"], [360, "light"], [360, "dark"]]) {
    const { tab, told } = await visit(path, { width, scheme });
    await readsWell(tab, `${path}, ${width} pixels, ${scheme}`);
    assert.deepEqual(told, []);
    await tab.close();
  }
  console.log(`${path}: reads well at 1280 and 360 pixels, light and dark`);
}
await browser.close();
