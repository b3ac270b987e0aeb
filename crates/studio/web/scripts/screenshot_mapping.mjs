// Takes docs/images/mapping.png: a recording being mapped, three quarters through.
//
// `CAIRN_BIN=/path/to/cairn node scripts/screenshot_mapping.mjs LOG [OUT.png]`; build the page and the
// program first. With `pngquant` on the path the file is made small.

import { spawnSync } from "node:child_process";
import { mkdirSync, statSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { launch } from "../tests/browser.mjs";
import { program, start } from "../tests/program.mjs";

const SIZE = { width: 1440, height: 900 };
const SHARE = 0.75;
const TIMEOUT_MS = 180_000;

const root = resolve(dirname(fileURLToPath(import.meta.url)), "../../../..");
const [log, to] = process.argv.slice(2);
if (!program || !log) throw new Error("set CAIRN_BIN to the program, for example target/release/cairn, and name a log");
const out = resolve(to ?? join(root, "docs/images/mapping.png"));

const studio = await start({ args: ["map", log, "--show"] });
const browser = await launch();
try {
  const context = await browser.newContext({ viewport: SIZE, colorScheme: "light" });
  const page = await context.newPage();
  page.setDefaultTimeout(TIMEOUT_MS);
  await page.goto(`${studio.url.replace(/\/$/, "")}/map`);
  await page.waitForFunction(() => window.mapping?.state()?.runs[0]?.scan > 0);
  const scan = await page.evaluate((share) => Math.round(window.mapping.state().runs[0].n_scans * share), SHARE);
  await page.evaluate((wanted) => {
    const place = document.querySelector(".place");
    place.value = String(wanted);
    place.dispatchEvent(new Event("change"));
  }, scan);
  await page.waitForFunction((wanted) => window.mapping.state().runs[0].scan === wanted && !window.mapping.state().playing, scan);
  await page.keyboard.press("f");
  await page.evaluate(() => document.activeElement?.blur());
  await page.waitForTimeout(500);
  mkdirSync(dirname(out), { recursive: true });
  await page.screenshot({ path: out });
} finally {
  await browser.close();
  await studio.stop();
}
spawnSync("pngquant", ["--force", "--quality", "80-100", "--strip", "--output", out, out]);
process.stdout.write(`${out}  ${(statSync(out).size / 1024).toFixed(0)} kB\n`);
