// Takes docs/images/studio.png: the doorbell mission while the robot goes around the box.
//
// `CAIRN_BIN=/path/to/cairn node scripts/screenshot.mjs [OUT.png]`; build the page and the program
// first. With `pngquant` on the path the file is made small.

import { spawn, spawnSync } from "node:child_process";
import { mkdirSync, statSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { eventually, launch, open } from "../tests/browser.mjs";

const SIZE = { width: 1440, height: 900 };
const SPEED = 4;
/** Into the detour: the box is beside the robot, the preview still lies on the trail. */
const DETOUR_M = 0.9;
const TIMEOUT_MS = 120_000;

const root = resolve(dirname(fileURLToPath(import.meta.url)), "../../../..");
const out = resolve(process.argv[2] ?? join(root, "docs/images/studio.png"));
const program = process.env.CAIRN_BIN;
if (!program) throw new Error("set CAIRN_BIN to the program, for example target/release/cairn");

const child = spawn(program, ["run", "doorbell", "--port", "0", "--speed", "0.1"], { stdio: ["ignore", "pipe", "inherit"] });
let output = "";
child.stdout.on("data", (data) => (output += data));
const browser = await launch();
try {
  const url = await eventually("the address of the studio", () => /http:\/\/127\.0\.0\.1:\d+/.exec(output)?.[0], 30_000);
  const { page } = await open(browser, url, { viewport: SIZE, colorScheme: "light" });
  page.setDefaultTimeout(TIMEOUT_MS);
  await page.evaluate(restartAt, SPEED);
  await page.getByRole("tab", { name: "Avoider" }).click();
  await page.waitForFunction(() => window.cairn.state()?.robots[0]?.avoider.state >= 5);
  for (let i = 0; i < 2; i += 1) await page.keyboard.press("[");
  const length_m = await page.evaluate(() => window.cairn.state().figures.path_length_m);
  await page.waitForFunction((least) => window.cairn.state().figures.path_length_m >= least, length_m + DETOUR_M);
  await page.evaluate(() => document.activeElement?.blur());
  mkdirSync(dirname(out), { recursive: true });
  await page.screenshot({ path: out });
} finally {
  await browser.close();
  child.kill("SIGTERM");
}
spawnSync("pngquant", ["--force", "--quality", "80-100", "--strip", "--output", out, out]);
process.stdout.write(`${out}  ${(statSync(out).size / 1024).toFixed(0)} kB\n`);

/** Runs in the page: from the beginning, so that plots and driven path are whole. */
function restartAt(speed) {
  const socket = new WebSocket(`ws://${location.host}/ws`);
  socket.onopen = () => {
    socket.send(JSON.stringify({ type: "speed", ratio: speed }));
    socket.send(JSON.stringify({ type: "restart", seed: null, mission: null }));
  };
}
