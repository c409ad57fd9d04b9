// Finds a browser and opens it: an installed one, or else the one from npm.
import { existsSync } from "node:fs";
import { delimiter, join } from "node:path";
import puppeteer from "puppeteer-core";

const NAMES = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
const ARGUMENTS = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"];
const TIMEOUT_MS = 180_000;

function installed() {
  const folders = (process.env.PATH ?? "").split(delimiter);
  const paths = folders.flatMap((folder) => NAMES.map((name) => join(folder, name)));
  return process.env.CHROME ?? paths.find((path) => existsSync(path));
}

/** Opens a headless browser. */
export async function open() {
  const path = installed();
  if (path) {
    return puppeteer.launch({ executablePath: path, args: ARGUMENTS, timeout: TIMEOUT_MS, protocolTimeout: TIMEOUT_MS });
  }
  const { default: chromium } = await import("@sparticuz/chromium");
  const args = [...chromium.args, ...ARGUMENTS];
  const executablePath = await chromium.executablePath();
  return puppeteer.launch({ executablePath, args, headless: "shell", timeout: TIMEOUT_MS, protocolTimeout: TIMEOUT_MS });
}
