// Starts a headless browser and opens the page; shared by the browser tests.

import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const EXECUTABLE = process.env.CHROMIUM ?? "/usr/bin/chromium";
const FLAGS = [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync",
];

// Where everything must be checked, a missing browser is no excuse.
if (process.env.CI && !existsSync(EXECUTABLE)) throw new Error(`no browser at ${EXECUTABLE}`);

/** A reason to skip, or false. */
export const noBrowser = existsSync(EXECUTABLE) ? false : `skipped: no browser at ${EXECUTABLE} (set CHROMIUM)`;

export function launch() {
  return chromium.launch({ executablePath: EXECUTABLE, args: FLAGS });
}

/** Opens a page in a context of its own; what it complains about collects in `complaints`. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.setDefaultTimeout(20_000);
  await page.goto(url);
  await page.waitForFunction(() => window.cairn?.state() !== null);
  return { page, complaints, close: () => context.close() };
}

/** The simulated time that the page shows. */
export function time_s(page) {
  return page.evaluate(() => window.cairn.state().t_s);
}

export async function untilTime(page, t_s) {
  await page.waitForFunction((wanted) => window.cairn.state()?.t_s >= wanted, t_s);
}

/** Where a point of the house is on the page, for the mouse. */
export function pageOf(page, at_m) {
  return page.evaluate((at) => window.cairn.pageOf(at), at_m);
}

/** Waits until the function gives something true; says what it waited for otherwise. */
export async function eventually(what, probe, timeout_ms = 10_000) {
  const end = Date.now() + timeout_ms;
  for (;;) {
    const value = await probe();
    if (value) return value;
    if (Date.now() > end) throw new Error(`waited ${timeout_ms} ms for ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 25));
  }
}

/** Runs in the page: texts whose colour against the nearest opaque background is too weak. */
export function contrastBelow(least) {
  const probe = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgba = (colour) => {
    probe.clearRect(0, 0, 1, 1);
    probe.fillStyle = colour;
    probe.fillRect(0, 0, 1, 1);
    return [...probe.getImageData(0, 0, 1, 1).data];
  };
  const luminance = ([r, g, b]) => [r, g, b].map((c) => c / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)).reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour[3] > 200) return colour;
    }
    return [255, 255, 255, 255];
  };
  const found = [];
  for (const element of document.querySelectorAll("body *")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    if (!own || !element.checkVisibility() || element.closest(":disabled, svg, .visually-hidden, .skip, option")) continue;
    const [a, b] = [luminance(rgba(getComputedStyle(element).color)), luminance(behind(element))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < least) found.push(`${element.className}: ${element.textContent.slice(0, 30)} ${ratio.toFixed(2)}`);
  }
  return found;
}
