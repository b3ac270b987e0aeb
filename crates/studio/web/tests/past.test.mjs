// The page against the mock server: looking back while the run goes on, lasers, contacts, cut lines.

import assert from "node:assert/strict";
import { eventually, untilTime } from "./browser.mjs";
import { pageTest } from "./harness.mjs";

const shown_s = (page) => page.evaluate(() => window.cairn.state().t_s);
const live_s = (page) => page.evaluate(() => window.cairn.live().t_s);
const wayOf = (page) => page.evaluate(() => window.cairn.signal("path_length_m"));

pageTest("the bar looks back while the run goes on, and Now comes back", async ({ page, sent }) => {
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("]");
  await page.keyboard.press(" ");
  await untilTime(page, 30);
  await page.keyboard.press("4");
  const bar = page.getByLabel("Time", { exact: true });
  await bar.fill("3");
  await page.waitForFunction(() => Math.abs(window.cairn.state().t_s - 3) < 0.2);
  assert.ok(sent("seek").length === 0 && sent("pause").length === 0, "the run is left alone");
  const before_s = await live_s(page);
  await eventually("the run to go on", async () => (await live_s(page)) > before_s + 1);
  assert.ok(Math.abs((await shown_s(page)) - 3) < 0.2, "what is shown stays");
  assert.equal(await wayOf(page), 0, "the robot had not set off");
  await page.locator(".past-badge").getByText(/^0:0[23]\.\d: the past/).waitFor();
  assert.match(await page.getByRole("button", { name: "Now" }).getAttribute("title"), /Kept: \d+ pictures, one every 0\.1 s; \d/);
  await page.keyboard.press("6");
  const entries = await page.locator(".log li:not([hidden]) time").allTextContents();
  assert.ok(entries.length > 0 && entries.every((text) => Number(text.slice(2)) <= 3.2), String(entries));
  assert.ok((await page.locator(".log li[hidden]").count()) > 0, "what came later is hidden");
  await page.getByRole("button", { name: /Ring the doorbell/ }).isDisabled();
  await page.keyboard.press("b");
  await page.getByText(/This is the past/).waitFor();
  await page.keyboard.press("n");
  await page.locator(".past-badge").waitFor({ state: "hidden" });
  await eventually("the present", async () => (await shown_s(page)) > before_s);
  assert.equal(await page.locator(".log li[hidden]").count(), 0);
  assert.ok((await wayOf(page)) > 0);
});

pageTest("keys look back and forward, and a robot can be stopped from the past", async ({ page, sent }) => {
  await page.keyboard.press(" ");
  await untilTime(page, 4);
  await page.keyboard.press("<");
  await eventually("a second back", async () => (await live_s(page)) - (await shown_s(page)) > 0.8);
  const first_s = await shown_s(page);
  await page.keyboard.press("<");
  await eventually("one more", async () => (await shown_s(page)) < first_s - 0.8);
  await page.keyboard.press(">");
  await eventually("one forward", async () => Math.abs((await shown_s(page)) - first_s) < 0.35);
  await page.keyboard.press("s");
  await eventually("the stop", () => sent("stop").length === 1);
  await page.keyboard.press("r");
  await page.locator(".past-badge").waitFor({ state: "hidden" });
  await page.waitForFunction(() => window.cairn.state().t_s === 0);
});

pageTest("ten robots with 361 beams each are drawn at 30 frames a second", async ({ page }) => {
  const colours = () => page.evaluate(() => {
    const canvas = document.getElementById("map-canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let n = 0;
    // The laser's blue-green, in the light theme: #00798c.
    for (let i = 0; i < data.length; i += 4) n += Math.abs(data[i]) < 12 && Math.abs(data[i + 1] - 0x79) < 12 && Math.abs(data[i + 2] - 0x8c) < 12 ? 1 : 0;
    return n;
  });
  await page.waitForFunction(() => window.cairn.state().robots.length === 11);
  await eventually("points", async () => (await colours()) > 600);
  await page.keyboard.press("l");
  await page.getByLabel("Laser").uncheck();
  await eventually("no points", async () => (await colours()) < 60);
  await page.getByLabel("Laser").check();
  await page.keyboard.press("Escape");
  await page.getByRole("button", { name: "Play" }).click();
  await untilTime(page, 0.3);
  const rates = [];
  for (let i = 0; i < 5; i += 1) {
    rates.push(await page.evaluate(async () => {
      const before = window.cairn.frames();
      const begin_ms = performance.now();
      await new Promise((resolve) => setTimeout(resolve, 1000));
      return ((window.cairn.frames() - before) * 1000) / (performance.now() - begin_ms);
    }));
  }
  const median = rates.sort((a, b) => a - b)[2];
  process.stdout.write(`# 10 robots × 361 beams: ${median.toFixed(1)} frames/s (median of 5 s)\n`);
  assert.ok(median >= 30, `${rates.map((rate) => rate.toFixed(1)).join(", ")} frames/s`);
}, { mock: { lasers: 10 }, mayComplain: true });

pageTest("a mission without a laser has no layer for it", async ({ page }) => {
  assert.equal(await page.locator("[data-layer=laser]").count(), 0);
  assert.equal(await page.locator("[data-layer=sonar]").count(), 1);
});

pageTest("a line is cut and mended at its link", async ({ page, sent }) => {
  await page.keyboard.press("5");
  await page.getByRole("button", { name: "Cut the line pheromones, both ways" }).click();
  await eventually("the cut", () => sent("cut").length === 1);
  assert.deepEqual(sent("cut")[0], { type: "cut", robot: 0, line: "pheromones", cut: true });
  await page.getByRole("button", { name: "Mend the line pheromones, both ways" }).click();
  await eventually("mended", () => sent("cut")[1]?.cut === false);
  for (const width of [1280, 1920, 820]) {
    await page.setViewportSize({ width, height: 900 });
    const [dock, hold] = await Promise.all([page.locator("#dock"), page.getByRole("button", { name: "Hold" })].map((element) => element.boundingBox()));
    assert.ok(hold.x + hold.width <= dock.x + dock.width, `Hold is cut off at ${width}`);
  }
});
