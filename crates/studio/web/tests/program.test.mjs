// The page against the real program: `CAIRN_BIN=/path/to/cairn npm test`. Skipped without it.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { eventually, launch, open, untilTime } from "./browser.mjs";
import { noProgram as skip, program, start } from "./program.mjs";

const VERDICT_TIMEOUT_MS = 120_000;

let browser;
before(async () => {
  if (!skip) browser = await launch();
});
after(() => browser?.close());

function programTest(name, body, { args, context } = {}) {
  test(name, { skip, timeout: VERDICT_TIMEOUT_MS + 60_000 }, async () => {
    const studio = await start({ args });
    let opened = null;
    try {
      opened = await open(browser, studio.url, context);
      await body({ ...opened, studio });
    } finally {
      await opened?.close();
      await studio.stop();
    }
  });
}

async function ensure(page, playing) {
  if ((await page.evaluate(() => window.cairn.state().playing)) !== playing) await page.keyboard.press(" ");
  await page.waitForFunction((wanted) => window.cairn.state().playing === wanted, playing);
}

programTest("the program's page loads, plays, pauses and steps without complaints", async ({ page, complaints }) => {
  await page.getByText("Connected").waitFor();
  await page.locator(".source [data-resource=Y2]").first().waitFor();
  await ensure(page, true);
  await untilTime(page, 0.5);
  await ensure(page, false);
  const step = await page.evaluate(() => window.cairn.state().step);
  await page.keyboard.press(".");
  await page.waitForFunction((before) => window.cairn.state().step === before + 20, step);
  assert.deepEqual(complaints, []);
});

programTest("the bell of the program lights its input and its timer", async ({ page }) => {
  await ensure(page, false);
  await page.getByRole("button", { name: /^Ring / }).click();
  await ensure(page, true);
  await page.locator(".source .operand-high[data-resource=YTMR16]").first().waitFor();
  await page.locator(".timer.on").first().waitFor();
});

programTest("a box placed on the map appears in the program's world", async ({ page }) => {
  await ensure(page, false);
  const before_n = await page.evaluate(() => window.cairn.state().things.length);
  await page.keyboard.press("b");
  const places = [[0, 0], [1, -1], [-1, 1], [2, -2], [-2, -2], [3, 0], [-3, 0]];
  for (const at_m of places) {
    await page.mouse.click(...(await page.evaluate((at) => window.cairn.pageOf(at), at_m)));
    const grew = await page.waitForFunction((n) => window.cairn.state().things.length > n, before_n, { timeout: 1500 }).catch(() => null);
    if (grew) return;
  }
  assert.fail("no place in the house took a box");
});

programTest("the doorbell mission reaches its verdict at twenty times", async ({ page, complaints }) => {
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("]");
  await page.waitForFunction(() => window.cairn.state().speed_ratio === 20);
  await ensure(page, true);
  await page.locator(".verdict").waitFor({ timeout: VERDICT_TIMEOUT_MS });
  const verdict = await page.evaluate(() => window.cairn.state().verdict);
  assert.ok(verdict.passed, JSON.stringify(verdict));
  assert.deepEqual(complaints, []);
});

programTest("a page that is opened late shows the way driven and the curves", async ({ page, studio }) => {
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("]");
  await ensure(page, true);
  await page.waitForFunction(() => window.cairn.state().robots[0].goal !== null && window.cairn.signal("path_length_m") > 1, null, { timeout: VERDICT_TIMEOUT_MS });
  await ensure(page, false);
  const late = await open(browser, studio.url);
  try {
    const known = await late.page.evaluate(() => window.cairn.known());
    assert.ok(known.n_curve_points > 100 && known.first_s < 0.5, JSON.stringify(known));
    assert.ok(known.way_m > 0.9, JSON.stringify(known));
  } finally {
    await late.close();
  }
});

programTest("one page looks back while the run goes on and another sees nothing of it", async ({ page, studio, complaints }) => {
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("]");
  await ensure(page, true);
  await untilTime(page, 20);
  const other = await open(browser, studio.url);
  try {
    await page.getByLabel("Time", { exact: true }).fill("5");
    await page.waitForFunction(() => Math.abs(window.cairn.state().t_s - 5) < 0.11);
    const begin_s = await other.page.evaluate(() => window.cairn.state().t_s);
    await other.page.waitForFunction((t_s) => window.cairn.state().t_s > t_s + 5, begin_s);
    assert.ok(await page.evaluate(() => Math.abs(window.cairn.state().t_s - 5) < 0.11 && window.cairn.live().t_s > 20));
    await page.keyboard.press("n");
    await page.waitForFunction((t_s) => window.cairn.state().t_s > t_s + 5, begin_s);
    assert.deepEqual(complaints, []);
  } finally {
    await other.close();
  }
});

programTest("a mission with a laser shows its scans where they were taken, echoes on the walls", async ({ page, complaints }) => {
  assert.equal(await page.locator("[data-layer=laser]").count(), 1);
  await ensure(page, true);
  await page.waitForFunction(() => window.cairn.state().robots.some(({ scans }) => (scans?.[0]?.[2].length ?? 0) > 300), null, { timeout: 60_000 });
  const [scanner, at, beams] = await page.evaluate(() => window.cairn.state().robots.find(({ scans }) => scans)?.scans[0]);
  const bytes = Buffer.from(beams, "base64");
  const echoes = Array.from({ length: bytes.length / 2 }, (_, i) => bytes.readUInt16LE(2 * i)).filter((beam) => beam > 0 && beam < 65535);
  assert.ok(scanner === 0 && at.every(Number.isFinite) && echoes.length > 20, `${echoes.length} echoes`);
  assert.deepEqual(complaints, []);
}, { args: ["run", "laser-ward"] });

programTest("keys drive the real robot, and a closed page stops it", async ({ page, studio }) => {
  await ensure(page, true);
  await untilTime(page, 1);
  const watcher = await open(browser, studio.url);
  try {
    const begin = await page.evaluate(() => window.cairn.state().robots[0].truth);
    await page.keyboard.press("m");
    await page.keyboard.down("s");
    await watcher.page.waitForFunction(([x, y]) => {
      const robot = window.cairn.state().robots[0];
      return robot.phase === "driven by hand" && Math.hypot(robot.truth[0] - x, robot.truth[1] - y) > 0.05;
    }, begin);
    await page.close();
    await watcher.page.waitForFunction(() => window.cairn.state().robots[0].phase !== "driven by hand" && window.cairn.state().robots[0].wheels_mps.every((v) => Math.abs(v) < 0.001));
  } finally {
    await watcher.close();
  }
}, { args: ["run", "one-obstacle"] });

programTest("a goal is answered at the click, with the name of the robot", async ({ page }) => {
  await ensure(page, true);
  await untilTime(page, 1);
  await page.keyboard.press("g");
  // In the bed: said at once, and nothing is searched for.
  await page.mouse.click(...(await page.evaluate(() => window.cairn.pageOf([-5, 3]))));
  await page.getByText(/no robot can stand at \(-5\.0\d?, 3\.0\d?\) m: bed is there/).waitFor({ timeout: 3000 });
  assert.equal(await page.evaluate(() => window.cairn.state().robots[0].goal), null);
  // Where no trail leads.
  await page.keyboard.press("g");
  await page.mouse.click(...(await page.evaluate(() => window.cairn.pageOf([-5, 1.6]))));
  const foot = page.locator(".readout.task");
  await foot.getByText(/^assistant: looking for a trail to \(-5\.0, 1\.6\)/).waitFor({ timeout: 3000 });
});

programTest("the decision node shows its clock, its events, a stop with fail-safe outputs and a restart by the watchdog", async ({ page, complaints }) => {
  const node = page.locator(".program-node");
  await node.getByText(/^2026-03-01 2[12]:\d\d:\d\d$/).waitFor();
  await ensure(page, true);
  await node.getByText("stopped; outputs at their fail-safe values", { exact: true }).waitFor();
  assert.ok(await page.evaluate(() => window.cairn.state().devices.find(({ name }) => name === "alarm").on), "the alarm burns without the program");
  await node.getByText(/^\d events?, 1 watchdog restart$/).waitFor();
  assert.ok(await page.getByRole("button", { name: "Stop the robot" }).isDisabled(), "there is no robot");
  assert.deepEqual(complaints, []);
}, { args: ["run", "night-watch"] });

programTest("a mission of one's own is opened from the page, stays in the list, and a wrong one is told with its line", async ({ page, complaints }) => {
  const own = (key) => Buffer.from(`[mission]\nname = "mine"\ntitle = "My empty floor"\n${key} = 9.0\n[world]\nbounds_m = [-2.0, -2.0, 2.0, 2.0]\n[[robots]]\nname = "robot"\n[robots.mind]\nhow.method = "straight"\n`);
  await page.locator("#mission-file").setInputFiles({ name: "mine.toml", mimeType: "text/plain", buffer: own("duration_max_s") });
  await page.getByText("An empty world").waitFor();
  const list = page.getByLabel("Mission");
  assert.equal(await list.inputValue(), "mine");
  await list.selectOption("doorbell");
  await page.getByText("An empty world").waitFor({ state: "hidden" });
  assert.equal(await list.locator("optgroup[label='Your own'] option").textContent(), "My empty floor");
  assert.deepEqual(complaints, []);
  await page.locator("#mission-file").setInputFiles({ name: "wrong.toml", mimeType: "text/plain", buffer: own("duration") });
  await page.locator(".refusal").getByText(/wrong\.toml[^]*line 4/).waitFor();
});

programTest("the page comes back by itself after the program restarts", async ({ page, studio }) => {
  await studio.stop();
  await page.getByText(/Connection lost, trying again/).waitFor();
  const again = await start({ port: studio.port });
  try {
    await page.getByText("Connected", { exact: true }).waitFor();
  } finally {
    await again.stop();
  }
});

for (const [width, height] of [[1280, 800], [1440, 900], [1600, 1000], [820, 1180]]) {
  programTest(`nothing of the real mission sticks out of a page of ${width} by ${height}`, async ({ page }) => {
    assert.ok((await page.locator(".about").textContent()).length > 250, "a long text is what this is about");
    const size = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
    assert.deepEqual(size, [width, height]);
    for (const id of ["top", "map", "dock", "transport"]) {
      const box = await page.locator(`#${id}`).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= width + 0.5 && box.y + box.height <= height + 0.5 && box.height > 40, `${id} ${JSON.stringify(box)}`);
    }
  }, { context: { viewport: { width, height } } });
}

programTest("a thousand robots are dots, counted, and drawn fluently", async ({ page, complaints }) => {
  await untilTime(page, 1);
  assert.equal(await page.evaluate(() => window.cairn.state().crowd.length), 999);
  await page.getByText(/^\d+ under way$/).waitFor();
  const frames = await page.evaluate(async () => {
    const before = window.cairn.frames();
    await new Promise((resolve) => setTimeout(resolve, 2000));
    return (window.cairn.frames() - before) / 2;
  });
  assert.ok(frames > 0, "the map stands still");
  assert.deepEqual(complaints, []);
}, { args: ["run", "swarm"] });

test("a replay plays and offers nothing that it would refuse", { skip, timeout: VERDICT_TIMEOUT_MS }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "cairn-studio-"));
  const file = join(folder, "rig.mcap");
  execFileSync(program, ["run", "decision-rig", "--headless", "--record", file], { stdio: "ignore" });
  const studio = await start({ args: ["replay", file, "--speed", "20"] });
  let opened = null;
  try {
    opened = await open(browser, studio.url);
    const { page, complaints } = opened;
    await page.getByText("Replay", { exact: true }).waitFor();
    await page.locator(".verdict").waitFor();
    assert.ok(await page.locator("button[data-device]").first().isDisabled());
    const length_s = await page.evaluate(() => window.cairn.state().t_s);
    assert.equal(Number(await page.locator(".seek input").getAttribute("max")), length_s);
    assert.ok((await page.locator(".seek .mark").count()) > 0, "the bell is marked");
    await page.locator(".seek input").fill("1");
    await page.waitForFunction(() => Math.abs(window.cairn.state()?.t_s - 1) < 0.015);
    await page.keyboard.press("Shift+ArrowRight");
    await page.waitForFunction(() => window.cairn.state()?.t_s > 10.9);
    await page.keyboard.press("Home");
    await page.waitForFunction(() => window.cairn.state()?.t_s < 0.015);
    await page.keyboard.press("End");
    await page.waitForFunction((end) => window.cairn.state()?.t_s === end, length_s);
    await page.locator(".verdict").waitFor();
    assert.deepEqual(complaints, []);
  } finally {
    await opened?.close();
    await studio.stop();
    rmSync(folder, { recursive: true });
  }
});
