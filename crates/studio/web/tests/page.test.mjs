// The page against the mock server: everything a user does, with the messages it must send.

import assert from "node:assert/strict";
import { contrastBelow, eventually, pageOf, time_s, untilTime } from "./browser.mjs";
import { pageTest } from "./harness.mjs";
import { startMock } from "./mock-server.mjs";

pageTest("the page loads with map, program and devices and without complaints", async ({ page }) => {
  assert.equal(await page.title(), "The doorbell – Cairn studio");
  await page.getByText("Connected").waitFor();
  assert.equal(await page.locator(".source [data-resource=Y2]").count(), 2);
  assert.equal(await page.locator(".device").count(), 6);
  const painted = await page.evaluate(() => {
    const canvas = document.getElementById("map-canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4004) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    return colours.size;
  });
  assert.ok(painted > 20, `${painted} colours on the map`);
});

pageTest("play runs the clock and pause stops it", async ({ page, sent }) => {
  await page.getByRole("button", { name: "Play" }).click();
  await untilTime(page, 0.5);
  await page.getByRole("button", { name: "Pause" }).click();
  await page.getByRole("button", { name: "Play" }).waitFor();
  const stopped = await time_s(page);
  await page.waitForTimeout(200);
  assert.equal(await time_s(page), stopped);
  assert.deepEqual([sent("play").length, sent("pause").length], [1, 1]);
});

pageTest("a step moves the run by one control period", async ({ page }) => {
  await page.getByRole("button", { name: "One step" }).click();
  await page.waitForFunction(() => window.cairn.state().step === 20);
  await page.keyboard.press(".");
  await page.waitForFunction(() => window.cairn.state().step === 40);
});

pageTest("brackets and slider change the speed, the slider logarithmically", async ({ page, sent }) => {
  await page.keyboard.press("]");
  await page.keyboard.press("]");
  await eventually("two requests", () => sent("speed").length === 2);
  assert.deepEqual(sent("speed").map(({ ratio }) => ratio), [2, 5]);
  await page.keyboard.press("[");
  await page.locator("#speed").fill("0");
  await eventually("0.1×", () => sent("speed").at(-1)?.ratio === 0.1);
  await page.waitForFunction(() => document.querySelector(".speed-value").textContent === "0.1×");
});

pageTest("a click with the box tool places a box, and the remove tool takes it away", async ({ page, mock, sent }) => {
  await page.getByRole("button", { name: "Place a box" }).click();
  await page.mouse.click(...(await pageOf(page, [3.6, -0.4])));
  await eventually("the request", () => sent("place").length === 1);
  const { at_m, size_m } = sent("place")[0];
  assert.ok(Math.hypot(at_m[0] - 3.6, at_m[1] + 0.4) < 0.03, String(at_m));
  assert.equal(size_m, 0.4);
  await page.waitForFunction(() => window.cairn.state().things.length === 2);
  await page.getByRole("button", { name: "Remove a box" }).click();
  await page.mouse.click(...(await pageOf(page, [3.6, -0.4])));
  await page.waitForFunction(() => window.cairn.state().things.length === 1);
  assert.deepEqual(sent("remove"), [{ type: "remove", id: 20 }]);
  assert.equal(mock.run.things.length, 1);
});

pageTest("what the program refuses appears as a message and can be dismissed", async ({ page }) => {
  await page.keyboard.press("b");
  await page.mouse.click(...(await pageOf(page, [-6, 2])));
  const toast = page.getByRole("alert").getByText(/would stand in a wall/);
  await toast.waitFor();
  await page.getByRole("button", { name: "Dismiss", exact: true }).click();
  await toast.waitFor({ state: "detached" });
});

pageTest("furniture of the house cannot be removed", async ({ page, sent }) => {
  await page.keyboard.press("x");
  await page.mouse.click(...(await pageOf(page, [-0.3, -3.8])));
  await page.getByText("The sofa belongs to the house and stays.").waitFor();
  assert.equal(sent("remove").length, 0);
});

pageTest("the goal tool sends place and heading of the drag", async ({ page, sent }) => {
  await page.keyboard.press("g");
  await page.mouse.move(...(await pageOf(page, [1.5, -0.5])));
  await page.mouse.down();
  await page.mouse.move(...(await pageOf(page, [1.5, 0.5])), { steps: 4 });
  await page.mouse.up();
  await eventually("the goal", () => sent("goal").length === 1);
  const [x, y, yaw] = sent("goal")[0].pose;
  assert.ok(Math.hypot(x - 1.5, y + 0.5) < 0.03 && Math.abs(yaw - Math.PI / 2) < 0.05, String([x, y, yaw]));
  await page.waitForFunction(() => window.cairn.state().robots[0].goal !== null);
});

pageTest("what the robot makes of its goal stands at the foot of the map, and its refusal in full", async ({ page, mock }) => {
  const foot = page.locator(".readout.task");
  await page.getByText("assistant: idle", { exact: true }).first().waitFor();
  await page.keyboard.press("g");
  await page.mouse.click(...(await pageOf(page, [1.5, -0.5])));
  await foot.getByText(/^assistant: looking for a trail to \(1\.5, -0\.5\)$/).waitFor();
  assert.ok(!(await foot.getAttribute("class")).includes("bad"));
  const why = "no trail leads to the goal; the nearest point of a trail is 1.7 m away from it (23 m of trails searched with 41 questions)";
  mock.run.robot.giveUp(why);
  await page.keyboard.press(".");
  await foot.getByText(`assistant: gave up (1.5, -0.5): ${why}`, { exact: true }).waitFor();
  assert.ok((await foot.getAttribute("class")).includes("bad"));
  // Ears hear it once; the toast beside the map says it as well.
  assert.equal(await page.locator(".visually-hidden[role=status]").getByText(`gives up: ${why}`).count(), 1);
  await page.locator(".toast").getByText(why).waitFor();
  for (const width of [1280, 820]) {
    await page.setViewportSize({ width, height: 900 });
    const [map, box, tools] = await Promise.all(["#map", ".readout.task", ".view-tools"].map((name) => page.locator(name).boundingBox()));
    assert.ok(box.x >= map.x && box.x + box.width <= map.x + map.width && box.y + box.height <= map.y + map.height, `at ${width}: ${JSON.stringify(box)}`);
    assert.ok(box.x + box.width <= tools.x || box.y + box.height <= tools.y || box.y >= tools.y + tools.height, `at ${width} it lies over the buttons`);
  }
});

pageTest("nothing that is said lies over the map: hint, task, place and devices stand beside it at every width", async ({ page }) => {
  for (const [width, height] of [[1280, 800], [1920, 1080], [820, 1180]]) {
    await page.setViewportSize({ width, height });
    await page.keyboard.press("g");
    await page.mouse.move(...(await pageOf(page, [1.5, -0.5])));
    const view = await page.locator("#map-canvas").boundingBox();
    for (const name of [".hint", ".readout.task", ".readout.at", ".view-tools", ".map-foot .scale"]) {
      await page.locator(name).waitFor();
      const box = await page.locator(name).boundingBox();
      assert.ok(box.width > 0 && box.y >= view.y + view.height - 0.5, `${name} at ${width}: ${JSON.stringify([box, view])}`);
    }
    const map = await page.locator("#map").boundingBox();
    for (const device of await page.locator(".devices > *").all()) {
      const box = await device.boundingBox();
      assert.ok(box.x >= map.x && box.x + box.width <= map.x + map.width && box.y + box.height <= view.y, `a device at ${width}: ${JSON.stringify(box)}`);
    }
    await page.keyboard.press("Escape");
  }
});

pageTest("the place under a resting pointer follows the picture", async ({ page }) => {
  await page.mouse.move(...(await pageOf(page, [1.5, -0.5])));
  const told = page.locator(".readout.at");
  await told.getByText("1.50, −0.50 m").waitFor();
  await page.setViewportSize({ width: 1000, height: 700 });
  await eventually("another place", async () => (await told.textContent()) !== "1.50, −0.50 m");
});

pageTest("dragging pans, the wheel zooms at the pointer, F fits again", async ({ page, sent }) => {
  const start = await pageOf(page, [0, 0]);
  await page.mouse.move(...start);
  await page.mouse.down();
  await page.mouse.move(start[0] + 60, start[1] + 30, { steps: 3 });
  await page.mouse.up();
  const panned = await pageOf(page, [0, 0]);
  assert.ok(Math.abs(panned[0] - start[0] - 60) < 1 && Math.abs(panned[1] - start[1] - 30) < 1);
  const width = async () => (await pageOf(page, [1, 0]))[0] - (await pageOf(page, [0, 0]))[0];
  const before_px = await width();
  await page.mouse.move(...panned);
  await page.mouse.wheel(0, -300);
  await eventually("a larger scale", async () => (await width()) > before_px * 1.3);
  const zoomed = await pageOf(page, [0, 0]);
  assert.ok(Math.hypot(zoomed[0] - panned[0], zoomed[1] - panned[1]) < 1, "the point under the pointer stays");
  await page.keyboard.press("f");
  assert.ok(Math.abs((await width()) - before_px) < 0.01);
  assert.deepEqual(sent("place").concat(sent("goal"), sent("press")), []);
});

pageTest("the bell lights its device, its input and the timer", async ({ page, sent }) => {
  await page.getByRole("button", { name: /Ring the doorbell/ }).click();
  assert.deepEqual(await eventually("the request", () => sent("press")[0]), { type: "press", device: "bell" });
  await page.keyboard.press(".");
  await page.locator("button.device.on").waitFor();
  await page.locator(".source .operand-high[data-resource=I0]").first().waitFor();
  await page.locator(".source .operand-high[data-resource=Y2]").first().waitFor();
  await page.locator(".timer.on[data-timer='16']").getByText(/14\.[5-9]|15\.0/).waitFor();
});

pageTest("an operand shows its eight samples on hover and on focus", async ({ page }) => {
  await page.locator(".source [data-resource=I0]").first().hover();
  const tip = page.locator(".tip");
  await tip.getByText("I0 is off").waitFor();
  await tip.getByText("from: Doorbell").waitFor();
  assert.equal(await tip.locator("svg .line").count(), 1);
  await page.mouse.move(20, 780);
  await tip.waitFor({ state: "hidden" });
  await page.locator(".source [data-resource=Y1]").first().focus();
  await tip.getByText("Y1 is off").waitFor();
});

pageTest("the doorbell mission reaches its verdict with MOVE, packets, plots and log", async ({ page, mock }) => {
  mock.run.things = [];
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("]");
  await page.keyboard.press(" ");
  await page.locator(".line-flash").first().waitFor();
  await page.keyboard.press("5");
  await page.locator(".wire-row .hex").nth(3).waitFor();
  await page.keyboard.press("3");
  await page.locator(".node.lit").waitFor();
  await page.keyboard.press("6");
  await page.getByRole("log").getByText(/MOVE to/).waitFor();
  const banner = page.locator(".verdict");
  await banner.getByText("Mission passed").waitFor({ timeout: 60_000 });
  assert.equal(await banner.locator("li").count(), 4);
  await page.keyboard.press("4");
  await page.locator(".plot canvas").nth(3).waitFor();
  await page.keyboard.press("5");
  await page.getByText("500 of the last 500 packets").waitFor();
  assert.ok((await page.locator(".wire-spacer .wire-row").count()) < 60, "only the rows in sight exist");
  await page.keyboard.press("Escape");
  await banner.waitFor({ state: "hidden" });
  await page.locator(".top .pill", { hasText: "Passed" }).click();
  await banner.getByRole("button", { name: "Run again" }).click();
  await banner.waitFor({ state: "hidden" });
  await page.waitForFunction(() => window.cairn.state().t_s === 0);
});

pageTest("restart sends the seed of the field, and the mission chooser restarts another mission", async ({ page, sent }) => {
  await page.getByLabel("Seed").fill("42");
  await page.getByLabel("Seed").press("Enter");
  assert.deepEqual(await eventually("restart", () => sent("restart")[0]), { type: "restart", seed: 42, mission: null });
  await page.getByLabel("Mission").selectOption("empty_flat");
  assert.deepEqual(await eventually("restart", () => sent("restart")[1]), { type: "restart", seed: null, mission: "empty_flat" });
  await page.getByRole("tab", { name: "Program" }).waitFor({ state: "detached" });
  assert.deepEqual(await page.getByRole("tab").allTextContents(), ["Avoider", "Plots", "Wire", "Figures & log"]);
  assert.equal(await page.locator("[data-layer=pheromones]").count(), 0, "there is no trail");
  assert.equal(await page.locator("[data-plot=smell]").count(), 0, "nor is there a smell");
  assert.equal(await page.locator(".legend").isVisible(), false);
});

pageTest("the stop button stops the robot, S does the same", async ({ page, sent }) => {
  await page.getByRole("button", { name: "Stop the robot" }).click();
  await page.keyboard.press("s");
  await eventually("two requests", () => sent("stop").length === 2);
  assert.deepEqual(sent("stop")[0], { type: "stop", robot: 0 });
});

pageTest("columns can be resized by pointer and keys, and stay so", async ({ page }) => {
  const width = () => page.evaluate(() => document.getElementById("dock").clientWidth);
  const before_px = await width();
  const split = await page.locator("#split-main").boundingBox();
  await page.mouse.move(split.x + 4, split.y + 300);
  await page.mouse.down();
  await page.mouse.move(split.x - 76, split.y + 300, { steps: 3 });
  await page.mouse.up();
  assert.ok(Math.abs((await width()) - before_px - 80) < 8, `${await width()} after ${before_px}`);
  await page.locator("#split-main").press("ArrowRight");
  const narrowed = await width();
  assert.ok(narrowed < before_px + 70);
  await page.reload();
  await page.waitForFunction(() => window.cairn?.state() !== null);
  assert.equal(await width(), narrowed);
});

pageTest("the wire can be filtered per link and held", async ({ page }) => {
  await page.keyboard.press("5");
  await page.keyboard.press(" ");
  await page.locator(".wire-row .hex").nth(8).waitFor();
  await page.getByRole("button", { name: "Hold" }).click();
  await page.getByRole("button", { name: "robot", exact: true }).click();
  await page.getByRole("button", { name: "ground", exact: true }).click();
  await eventually("only the pheromone link", () => page.evaluate(() => {
    const names = [...document.querySelectorAll(".wire-spacer .wire-row > span:nth-child(2)")].map((cell) => cell.title);
    return names.length > 0 && names.every((name) => name === "pheromones");
  }));
  const held = await page.locator(".wire .count").textContent();
  await page.waitForTimeout(300);
  assert.equal(await page.locator(".wire .count").textContent(), held);
  await page.locator(".wire-spacer .wire-row").nth(2).click();
  await page.locator(".wire-detail code").getByText(/^10 02/).waitFor();
});

pageTest("a lost connection is told, and the page comes back by itself with a fresh hello", async ({ page, mock }) => {
  const { port } = mock;
  await mock.close();
  await page.getByText(/Connection lost, trying again/).waitFor();
  await page.getByText("Disconnected").waitFor();
  assert.ok(await page.getByRole("button", { name: /Ring the doorbell/ }).isDisabled());
  const again = await startMock({ port, mission: "empty_flat" });
  try {
    await page.getByText("Connected", { exact: true }).waitFor();
    await page.getByText(/Connection lost/).waitFor({ state: "hidden" });
    await page.waitForFunction(() => document.title.startsWith("Empty flat"));
  } finally {
    await again.close();
  }
}, { mayComplain: true });

pageTest("a recording can be played but not changed", async ({ page, sent }) => {
  await page.getByText("Replay", { exact: true }).waitFor();
  assert.ok(await page.getByRole("button", { name: /Ring the doorbell/ }).isDisabled());
  await page.keyboard.press("b");
  await page.getByText("This is a recording: it can be watched, not changed.").waitFor();
  await page.keyboard.press(" ");
  await untilTime(page, 0.2);
  assert.equal(sent("place").length, 0);
}, { mock: { kind: "replay" } });

pageTest("a computer that cannot keep up is said so", async ({ page }) => {
  await page.keyboard.press(" ");
  await page.locator(".achieved.warn").getByText("only 0.5×").waitFor();
}, { mock: { lag: 0.5 } });

pageTest("the theme follows the system, the toggle wins and is remembered", async ({ page }) => {
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  assert.equal(await theme(), "dark");
  await page.emulateMedia({ colorScheme: "light" });
  await eventually("the light theme", async () => (await theme()) === "light");
  await page.getByRole("button", { name: "Dark theme" }).click();
  assert.equal(await theme(), "dark");
  await page.reload();
  assert.equal(await theme(), "dark");
}, { context: { colorScheme: "dark" } });

pageTest("everything can be done with the keyboard alone", async ({ page, sent }) => {
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.className), "skip");
  await page.keyboard.press("?");
  await page.getByRole("dialog").getByText("Play or pause").waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "hidden" });
  await page.keyboard.press("d");
  assert.ok(await eventually("the bell", () => sent("press").length === 1));
  await page.keyboard.press("b");
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("Enter");
  assert.ok(await eventually("the box", () => sent("place").length === 1));
  await page.waitForFunction(() => window.cairn.state().things.length === 2);
  await page.keyboard.press("x");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => window.cairn.state().things.length === 1);
  await page.keyboard.press("g");
  await page.keyboard.press("PageUp");
  await page.keyboard.press("Enter");
  assert.ok(await eventually("the goal", () => sent("goal").length === 1));
  await page.keyboard.press("Escape");
  assert.equal(await page.evaluate(() => window.cairn.tool()), "select");
  await page.keyboard.press("l");
  await page.keyboard.press(" ");
  assert.equal(await page.locator("[data-layer=pheromones]").isChecked(), false);
  await page.keyboard.press("Escape");
  await page.keyboard.press("2");
  await page.locator("#panel-signals canvas").waitFor();
});

pageTest("every control has a name and readable contrast in both themes", async ({ page }) => {
  for (const scheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: scheme, reducedMotion: "reduce" });
    const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select, canvas, [role=separator]")]
      .filter((element) => element.checkVisibility() && !element.closest("[role=img]") && !(element.getAttribute("aria-label") ?? element.textContent.trim()) && !(element.labels?.length)).map((element) => element.outerHTML.slice(0, 80)));
    assert.deepEqual(unnamed, []);
    let poor = [];
    // Buttons fade to their new colours, on a busy computer slowly.
    for (let attempt = 0; attempt < 10; attempt += 1) {
      poor = await page.evaluate(contrastBelow, 4.5);
      if (poor.length === 0) break;
      await page.waitForTimeout(300);
    }
    assert.deepEqual(poor, [], `${scheme} theme`);
  }
});

pageTest("the page fits a tablet and two fingers zoom", async ({ page }) => {
  const overflow = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
  assert.deepEqual(overflow, [820, 1180]);
  const scale = async () => (await pageOf(page, [1, 0]))[0] - (await pageOf(page, [0, 0]))[0];
  const before_px = await scale();
  const [x, y] = await pageOf(page, [0, 0]);
  const client = await page.context().newCDPSession(page);
  const touch = (type, gap) => client.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x: x - gap, y, id: 0 }, { x: x + gap, y, id: 1 }] });
  await touch("touchStart", 40);
  for (const gap of [50, 60, 80]) await touch("touchMove", gap);
  await touch("touchEnd", 0);
  assert.ok((await scale()) > before_px * 1.7, `${await scale()} after ${before_px}`);
}, { context: { viewport: { width: 820, height: 1180 }, hasTouch: true } });

pageTest("the map is drawn at least 30 times a second while playing", async ({ page }) => {
  await page.keyboard.press(" ");
  await untilTime(page, 0.3);
  const frames = await page.evaluate(async () => {
    const before = window.cairn.frames();
    await new Promise((resolve) => setTimeout(resolve, 2000));
    return (window.cairn.frames() - before) / 2;
  });
  assert.ok(frames >= 30, `${frames} frames/s`);
});
