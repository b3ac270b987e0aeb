// The mapping page against the real program, as a person uses it: `CAIRN_BIN=/path/to/cairn npm test`.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { contrastBelow, launch } from "./browser.mjs";
import { roomLog } from "./mock/room.mjs";
import { noProgram, start } from "./program.mjs";

const N_SCANS = 150;
let browser;
let studio;
let folder;

before(async () => {
  if (noProgram) return;
  browser = await launch();
  studio = await start({ args: ["run", "decision-rig"] });
  folder = mkdtempSync(join(tmpdir(), "cairn-mapping-"));
  writeFileSync(join(folder, "room.log"), roomLog(N_SCANS, { bad: true }));
  writeFileSync(join(folder, "picture.png"), Buffer.from([0x89, 0x50, 0x4e, 0x47, 1, 2, 3, 4]));
});
after(async () => {
  await browser?.close();
  await studio?.stop();
  if (folder) rmSync(folder, { recursive: true });
});

function mappingTest(name, body, { viewport = { width: 1280, height: 800 }, mayComplain = false } = {}) {
  test(name, { skip: noProgram, timeout: 120_000 }, async () => {
    const context = await browser.newContext({ viewport });
    const page = await context.newPage();
    const complaints = [];
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type())) complaints.push(message.text());
    });
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.setDefaultTimeout(30_000);
    try {
      await page.goto(`${studio.url.replace(/\/$/, "")}/map`);
      await page.waitForFunction(() => window.mapping?.source() !== null && window.mapping.state() !== null);
      await body(page);
      if (!mayComplain) assert.deepEqual(complaints, []);
    } finally {
      await context.close();
    }
  });
}

const scan = (page, slot = 0) => page.evaluate((s) => window.mapping.state().runs[s].scan, slot);
const untilFinished = (page, slot = 0) => page.waitForFunction((s) => window.mapping.state().runs[s]?.phase === "finished", slot);

async function openLog(page, name = "room.log") {
  await page.getByRole("button", { name: "Open…", exact: true }).click();
  await page.getByLabel("Log", { exact: true }).setInputFiles(join(folder, name));
  await page.getByRole("button", { name: "Read" }).click();
}

mappingTest("without a recording the page says how to begin", async (page) => {
  await page.getByRole("heading", { name: "From a recording to a map" }).waitFor();
  assert.ok((await page.locator(".welcome .sample").count()) >= 2);
  await page.getByRole("button", { name: "Play" }).isDisabled();
  await page.getByRole("link", { name: "Mission" }).click();
  await page.getByRole("link", { name: "Mapping" }).click();
  await page.getByRole("heading", { name: "From a recording to a map" }).waitFor();
});

mappingTest("a file that is no log is refused in words", async (page) => {
  await openLog(page, "picture.png");
  const card = page.getByRole("alert").filter({ hasText: "cannot be mapped" });
  await card.getByText(/picture\.png: unknown format/).waitFor();
  await card.getByRole("button", { name: "Open another…" }).click();
  await page.getByRole("heading", { name: "Open a recording" }).waitFor();
}, { mayComplain: true });

mappingTest("a chosen log plays, pauses and steps; its complaints have line numbers", async (page) => {
  await openLog(page);
  await page.waitForFunction(() => window.mapping.state().runs[0]?.scan > 3);
  await page.keyboard.press(" ");
  await page.waitForFunction(() => !window.mapping.state().playing);
  const held = await scan(page);
  await page.waitForTimeout(200);
  assert.equal(await scan(page), held);
  await page.getByRole("button", { name: "One scan" }).click();
  await page.waitForFunction((n) => window.mapping.state().runs[0].scan === n, held + 1);
  await page.locator(".scan-count", { hasText: `${held + 1} of ${N_SCANS}` }).waitFor();
  await page.getByRole("tab", { name: "File" }).click();
  await page.getByText("2 things were wrong in the file").waitFor();
  await page.locator(".complaints li", { hasText: `line ${N_SCANS + 2}:` }).waitFor();
});

mappingTest("a page that comes later sees the same, and goes to the end with a closed loop", async (page) => {
  await page.waitForFunction(() => window.mapping.board(0)?.n_tiles > 0);
  await page.keyboard.press("End");
  await untilFinished(page);
  await page.waitForFunction(() => !window.mapping.state().playing);
  const { n_closures, n_vertices, corrected, odometry } = await page.evaluate(() => {
    const board = window.mapping.board(0);
    const n_closures = board.edges.filter((_, i) => i % 3 === 2 && board.edges[i] === 1).length;
    return { n_closures, n_vertices: board.vertices.length / 2, corrected: board.tracks[1].n, odometry: board.tracks[0].n };
  });
  assert.ok(n_closures > 0 && n_vertices > 10, `${n_closures} closures of ${n_vertices} keyframes`);
  assert.deepEqual([corrected, odometry], [N_SCANS, N_SCANS]);
  await page.getByRole("tab", { name: "Now" }).click();
  await page.locator("[data-counter=scans]", { hasText: `${N_SCANS} of ${N_SCANS}` }).waitFor();
  await page.locator(".stages tbody tr").first().waitFor();
  await page.getByRole("tab", { name: "Results" }).click();
  await page.locator("[data-figure='map.entropy_mean_bits'] td", { hasText: /\d/ }).waitFor();
});

mappingTest("the map is where the walls are", async (page) => {
  // The first pose of the room is the map's origin: 6.4, 3 in the room, looking up.
  const cells = await page.evaluate(() => {
    const board = window.mapping.board(0);
    const at = (x, y) => {
      const [dx, dy] = [x - 6.4, y - 3];
      return board.cellAt(dy, -dx);
    };
    const wall = Math.max(...[-0.05, 0, 0.05].map((d) => at(8 + d, 4)));
    return { wall, floor: at(6.4, 4.5), outside: at(9, 3) };
  });
  assert.ok(cells.wall > 200 && cells.floor > 0 && cells.floor < 60 && cells.outside === 0, JSON.stringify(cells));
});

mappingTest("another parameter makes a second run beside the first, with figures of both", async (page) => {
  await page.keyboard.press("3");
  await page.getByLabel("Find a parameter").fill("map.resolution");
  const field = page.locator("[data-key='map.resolution_m'] input");
  assert.equal(await field.inputValue(), "0.05");
  await field.fill("-1");
  await page.getByRole("button", { name: "Run again and compare" }).click();
  await page.getByRole("alert").getByText(/map\.resolution_m = -1/).waitFor();
  await field.fill("0.1");
  await field.press("Enter");
  await page.waitForFunction(() => window.mapping.state().runs.length === 2);
  await page.locator(".panes.pair").waitFor();
  await page.getByText("Run B · 1 parameter set").waitFor();
  await page.getByRole("button", { name: /To the end/ }).click();
  await untilFinished(page, 1);
  await page.keyboard.press("4");
  await page.locator("#figures-table [data-figure='map.occupied_cells'] td").nth(1).waitFor();
  await page.getByRole("rowheader", { name: "map.resolution_m" }).waitFor();
  const cells = await page.locator("#figures-table [data-figure='map.occupied_cells'] td").allTextContents();
  assert.ok(Number(cells[0]) > Number(cells[1]) && Number(cells[1]) > 0, String(cells));
  assert.deepEqual(await page.locator("tr[data-key='map.resolution_m'] td").allTextContents(), ["0.05", "0.1"]);
});

mappingTest("both panes show the same window", async (page) => {
  await page.locator(".panes.pair").waitFor();
  const offsets = () => page.evaluate(() => [0, 1].map((slot) => {
    const box = document.querySelectorAll(".pane canvas")[slot].getBoundingClientRect();
    const [x, y] = window.mapping.pageOf(slot, [1, 1]);
    return [Math.round(x - box.left), Math.round(y - box.top)];
  }));
  await page.keyboard.press("f");
  const [a, b] = await offsets();
  assert.deepEqual(a, b);
  const box = await page.locator("#map-canvas-b").boundingBox();
  await page.mouse.move(box.x + 200, box.y + 300);
  await page.mouse.down();
  await page.mouse.move(box.x + 260, box.y + 330, { steps: 3 });
  await page.mouse.up();
  const [moved_a, moved_b] = await offsets();
  assert.deepEqual(moved_a, moved_b);
  assert.ok(Math.abs(moved_a[0] - a[0] - 60) <= 1 && Math.abs(moved_a[1] - a[1] - 30) <= 1);
  await page.mouse.wheel(0, -300);
  await page.waitForTimeout(50);
  const [zoomed_a, zoomed_b] = await offsets();
  assert.deepEqual(zoomed_a, zoomed_b);
  await page.keyboard.press("f");
  assert.deepEqual((await offsets())[0], a);
  await page.keyboard.press("4");
  await page.getByRole("button", { name: "Keep B only" }).click();
  await page.waitForFunction(() => window.mapping.state().runs.length === 1);
  assert.equal(await page.evaluate(() => window.mapping.board(0).cell_m.toFixed(3)), "0.100", "B's picture has moved to A's place");
});

mappingTest("layers are switched with the keyboard and hide what they name", async (page) => {
  const colours = () => page.evaluate(() => {
    const canvas = document.getElementById("map-canvas-a");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    return seen.size;
  });
  await page.waitForTimeout(100);
  const all = await colours();
  await page.keyboard.press("l");
  for (const label of ["Map", "Corrected way", "Odometry", "Pose graph", "Loop closures"]) {
    await page.getByRole("group", { name: "Layers" }).getByLabel(label, { exact: true }).focus();
    await page.keyboard.press(" ");
  }
  await page.waitForTimeout(100);
  assert.ok((await colours()) < all / 2, "less is drawn");
  await page.keyboard.press("Escape");
  assert.ok(await page.getByRole("group", { name: "Layers" }).isHidden());
  // The browser complains that this test reads the canvas.
}, { mayComplain: true });

mappingTest("a sample of sonars shows its candidates with their verdict", async (page) => {
  await page.getByRole("button", { name: "Open…", exact: true }).click();
  await page.getByRole("dialog").getByRole("button", { name: /A room with five sonars/ }).click();
  await page.getByText("Reading A room with five sonars…").waitFor();
  await page.waitForFunction(() => window.mapping.source().recording?.rig === "sonar", undefined, { timeout: 60_000 });
  await page.keyboard.press("2");
  await page.getByRole("button", { name: /To the end/ }).click();
  await page.waitForFunction(() => window.mapping.registrations(0).length > 0, undefined, { timeout: 60_000 });
  await page.locator(".verdict-line b").waitFor();
  assert.ok((await page.locator(".heat-cell").count()) > 8);
  await page.waitForFunction(() => !window.mapping.state().playing);
  const applied = await page.evaluate(() => window.mapping.registrations(0).filter(({ applied }) => applied).length);
  assert.ok(applied > 0, "some corrections are made");
  for (let i = 0; i < 50 && !(await page.locator(".verdict-line.applied").isVisible()); i += 1) await page.getByRole("button", { name: "Comparison before" }).click();
  assert.equal(await page.locator(".heat-cell.best").count(), 1);
  await page.getByRole("rowheader", { name: "best", exact: true }).waitFor();
});

for (const [width, height] of [[1440, 900], [900, 700], [820, 1180]]) {
  mappingTest(`every panel fits a page of ${width} by ${height}, is named, and reads well in both themes`, async (page) => {
    for (const key of ["1", "2", "3", "4", "5"]) {
      await page.keyboard.press(key);
      for (const scheme of ["light", "dark"]) {
        await page.emulateMedia({ colorScheme: scheme, reducedMotion: "reduce" });
        let poor = [];
        for (let attempt = 0; attempt < 10; attempt += 1) {
          poor = await page.evaluate(contrastBelow, 4.5);
          if (poor.length === 0) break;
          await page.waitForTimeout(200);
        }
        assert.deepEqual(poor, [], `panel ${key}, ${scheme}`);
      }
      const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select, canvas, [role=separator]")]
        .filter((element) => element.checkVisibility() && !(element.getAttribute("aria-label") ?? element.textContent.trim()) && !element.labels?.length).map((element) => element.outerHTML.slice(0, 80)));
      assert.deepEqual(unnamed, [], `panel ${key}`);
      const size = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
      assert.deepEqual(size, [width, height]);
      const wide = await page.evaluate(() => {
        const dock = document.getElementById("dock").getBoundingClientRect();
        return [...document.querySelectorAll("#dock *")].filter((element) => element.checkVisibility() && element.getBoundingClientRect().right > dock.right + 1).map((element) => element.outerHTML.slice(0, 80));
      });
      assert.deepEqual(wide, [], `panel ${key}`);
    }
    for (const id of ["top", "map", "dock", "transport"]) {
      const box = await page.locator(`#${id}`).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= width + 0.5 && box.y + box.height <= height + 0.5 && box.height > 40, `${id} ${JSON.stringify(box)}`);
    }
  }, { viewport: { width, height } });
}

mappingTest("the page says when the program has ended, and comes back with it", async (page) => {
  const { port } = studio;
  await studio.stop();
  await page.getByText(/Connection lost, trying again/).waitFor();
  assert.ok(await page.getByRole("button", { name: /^(Play|Pause|Again)$/ }).isDisabled());
  studio = await start({ args: ["run", "decision-rig"], port });
  await page.getByText("Connected", { exact: true }).waitFor();
  await page.getByRole("heading", { name: "From a recording to a map" }).waitFor();
}, { mayComplain: true });
