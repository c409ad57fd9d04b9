// Makes a picture of a page: node screenshot.mjs PAGE.html OUT.png WIDTH HEIGHT [dark|light] [SELECTOR]
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { open } from "./browser.mjs";

const [page, out, width, height, scheme = "light", selector] = process.argv.slice(2);
const browser = await open();
const tab = await browser.newPage();
await tab.setViewport({ width: Number(width), height: Number(height) });
await tab.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
await tab.goto(pathToFileURL(resolve(page)).href);
if (selector) await tab.evaluate((s) => document.querySelector(s).scrollIntoView(), selector);
await tab.screenshot({ path: out, fullPage: Number(height) === 0 });
await browser.close();
