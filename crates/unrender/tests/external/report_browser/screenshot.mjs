// Makes a picture of a page: node screenshot.mjs PAGE.html OUT.png WIDTH HEIGHT [dark|light] [SELECTOR] [SCRIPT]
// A page of `unrender view` is waited for; the script, which may use its `unrender`, runs before the picture.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { open } from "./browser.mjs";

const [page, out, width, height, scheme = "light", selector, script] = process.argv.slice(2);
const browser = await open();
const tab = await browser.newPage();
await tab.setViewport({ width: Number(width), height: Number(height) });
await tab.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
await tab.goto(pathToFileURL(resolve(page)).href);
await tab.waitForFunction(() => !document.querySelector("main.play") || document.body.dataset.ready);
if (script) await tab.evaluate(script);
if (selector) await tab.evaluate((s) => document.querySelector(s).scrollIntoView(), selector);
await tab.screenshot({ path: out, fullPage: Number(height) === 0 });
await browser.close();
