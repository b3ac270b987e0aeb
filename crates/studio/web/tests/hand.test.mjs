// The page against the mock server: driving by hand, what is said, downloads, and every width.

import assert from "node:assert/strict";
import { eventually, pageOf, untilTime } from "./browser.mjs";
import { pageTest } from "./harness.mjs";
import { OFFER } from "./mock/offer.mjs";

pageTest("three quick presses of a key are three", async ({ page, sent }) => {
  await page.evaluate(() => {
    for (let i = 0; i < 3; i += 1) window.dispatchEvent(new KeyboardEvent("keydown", { key: "]" }));
  });
  await eventually("three requests", () => sent("speed").length === 3);
  assert.deepEqual(sent("speed").map(({ ratio }) => ratio), [2, 5, 10]);
  for (let i = 0; i < 3; i += 1) await page.keyboard.press(".");
  await page.waitForFunction(() => window.cairn.state().step === 60);
});

pageTest("held keys drive the robot, and letting go stops it at once", async ({ page, sent }) => {
  await page.keyboard.press("m");
  await page.locator(".drive").waitFor();
  await page.keyboard.down("w");
  await eventually("it is said again and again", () => sent("drive").length >= 3);
  await page.keyboard.down("a");
  await eventually("an arc", () => sent("drive").at(-1).turn_rate_radps > 0);
  assert.deepEqual(sent("drive").at(-1), { type: "drive", robot: 0, speed_mps: 0.3, turn_rate_radps: 0.6 });
  await page.keyboard.up("w");
  await page.keyboard.up("a");
  await eventually("standing", () => sent("drive").at(-1).speed_mps === 0 && sent("drive").at(-1).turn_rate_radps === 0);
  const n = sent("drive").length;
  await page.waitForTimeout(300);
  assert.equal(sent("drive").length, n, "a hand that is off says nothing");
  assert.equal(sent("stop").length + sent("press").length, 0, "S and D drive now");
  await page.keyboard.down("s");
  await eventually("backwards", () => sent("drive").at(-1).speed_mps === -0.3);
  await page.evaluate(() => window.dispatchEvent(new Event("blur")));
  await eventually("a page that loses the focus lets go", () => sent("drive").at(-1).speed_mps === 0);
  await page.keyboard.up("s");
  await page.keyboard.press("Escape");
  await page.locator(".drive").waitFor({ state: "hidden" });
});

pageTest("the stick on the map and a gamepad drive as well", async ({ page, sent }) => {
  await page.getByRole("button", { name: "Drive by hand" }).click();
  const box = await page.locator(".drive .stick").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y);
  await eventually("full speed ahead", () => sent("drive").at(-1)?.speed_mps === 0.3);
  await page.mouse.up();
  await eventually("standing", () => sent("drive").at(-1).speed_mps === 0);
  await page.evaluate(() => {
    window.pad = { id: "Test pad (0000)", axes: [0.5, 0.02], buttons: [] };
    navigator.getGamepads = () => [null, window.pad];
  });
  await eventually("to the right", () => sent("drive").at(-1).turn_rate_radps === -0.3);
  await page.evaluate(() => (window.pad.axes = [0.05, 0.02]));
  await eventually("a stick in its middle stands", () => sent("drive").at(-1).turn_rate_radps === 0);
});

pageTest("what is said never covers the map", async ({ page }) => {
  await page.getByRole("button", { name: "Place a box" }).click();
  await page.mouse.click(...(await pageOf(page, [-6, 2])));
  const toast = await page.locator(".toast").first().boundingBox();
  const view = await page.locator(".map-view").boundingBox();
  assert.ok(toast.x >= view.x + view.width || toast.y >= view.y + view.height, JSON.stringify([toast, view]));
}, { context: { viewport: { width: 820, height: 1180 } } });

pageTest("figures and plots begin anew with a run", async ({ page }) => {
  await page.getByRole("tab", { name: "Figures & log" }).click();
  await page.keyboard.press(" ");
  await untilTime(page, 1);
  const time = page.locator("[data-figure=time_s] b");
  await time.getByText(/^[1-9]\.\d$/).waitFor();
  await page.getByLabel("Mission").selectOption("empty_flat");
  await time.getByText(/^0\.0$/).waitFor();
  const way = page.locator("[data-figure=path_length_m] b");
  await way.waitFor();
  assert.match(await way.textContent(), /^(0(\.00)?|–)$/);
});

pageTest("maps, curves and a whole sheet can be downloaded", async ({ page }) => {
  await page.keyboard.press(" ");
  await untilTime(page, 0.5);
  const get = async (name) => {
    await page.getByRole("button", { name: "Download" }).click();
    const coming = page.waitForEvent("download");
    await page.getByRole("button", { name, exact: true }).click();
    const file = await coming;
    const chunks = [];
    for await (const chunk of await file.createReadStream()) chunks.push(chunk);
    return [file.suggestedFilename(), Buffer.concat(chunks)];
  };
  const [name, map] = await get("Map PNG");
  assert.match(name, /^doorbell-seed1-map\.png$/);
  assert.equal(map.subarray(1, 4).toString(), "PNG");
  const [, drawing] = await get("Map SVG");
  assert.match(drawing.toString(), /^<svg xmlns[^]*<polyline[^]*<\/svg>/);
  const [, plots] = await get("Plots PNG");
  assert.ok(plots.length > 2000);
  const [, numbers] = await get("Plots CSV");
  assert.match(numbers.toString(), /^t_s,(\w+,)*cross_track_m[^]*\n0\.\d+,/);
  const [, way] = await get("Way driven CSV");
  assert.match(way.toString(), /^robot,t_s,x_m,y_m\n/);
  const [, sheet] = await get("Screenshot of map and plots PNG");
  assert.ok(sheet.length > map.length / 2);
});

for (const width of [560, 820, 1280, 1920]) {
  pageTest(`the description can be read at ${width} pixels`, async ({ page }) => {
    await page.getByRole("button", { name: "What this is about" }).click();
    const text = page.locator("dialog p").getByText(/The bell rings, nobody moves for 15 s/);
    await text.waitFor();
    assert.ok(await text.evaluate((element) => element.scrollHeight <= element.clientHeight + 1), "nothing is cut off");
    await page.getByRole("button", { name: "Close" }).last().click();
  }, { context: { viewport: { width, height: 900 } } });
}

for (const viewport of [{ width: 820, height: 1180 }, { width: 820, height: 600 }]) {
  pageTest(`plots have axes at ${viewport.width} by ${viewport.height}`, async ({ page }) => {
    await page.getByRole("tab", { name: "Plots" }).click();
    await page.keyboard.press(" ");
    await untilTime(page, 0.5);
    const plots = await page.locator(".plot .uplot canvas").evaluateAll((all) => all.map((canvas) => canvas.getBoundingClientRect()).map(({ width, height, bottom }) => [width, height, bottom]));
    assert.equal(plots.length, OFFER.plots.length);
    for (const [width, height] of plots) assert.ok(width >= 200 && height >= 80, `a plot of ${width} by ${height}`);
  }, { context: { viewport } });
}

pageTest("a log that was hidden opens at its newest entry, and stays where a reader scrolled", async ({ page, mock }) => {
  const log = page.locator(".log");
  const toEnd_px = () => log.evaluate((list) => list.scrollHeight - list.clientHeight - list.scrollTop);
  const say = async (text) => {
    for (let i = 0; i < 60; i += 1) mock.run.say("info", `${text} ${i}`);
    await page.keyboard.press(".");
    await log.getByText(`${text} 59`).waitFor({ state: "attached" });
  };
  await page.getByRole("tab", { name: "Plots" }).click();
  await say("hidden");
  await page.getByRole("tab", { name: "Figures & log" }).click();
  await eventually("the end of the log", async () => (await toEnd_px()) < 2);
  await log.evaluate((list) => (list.scrollTop = 100));
  await page.waitForTimeout(100);
  await say("read");
  assert.equal(await log.evaluate((list) => list.scrollTop), 100);
});
