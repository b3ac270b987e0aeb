// Pure parts of the page, bundled on the fly: history bytes, camera, speeds, formats, signals, trails.

import assert from "node:assert/strict";
import { dirname } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const web = dirname(dirname(fileURLToPath(import.meta.url)));

async function load(path) {
  const { outputFiles } = await build({ absWorkingDir: web, entryPoints: [path], bundle: true, write: false, format: "esm", platform: "node", logLevel: "error" });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

test("the two youngest samples of a history byte tell level and edge", async () => {
  const { signalState, samples, isBoolean, isConstant } = await load("src/history.ts");
  assert.equal(signalState(0b0000_0000), "low");
  assert.equal(signalState(0b0000_0001), "rising");
  assert.equal(signalState(0b1111_1110), "falling");
  assert.equal(signalState(0b0000_0011), "high");
  assert.deepEqual(samples(0b1000_0001), [true, false, false, false, false, false, false, true]);
  for (const name of ["I0", "NI3", "O1", "Y95", "YTMR16", "S7", "1L"]) assert.ok(isBoolean(name), name);
  for (const name of ["M0", "A3", "STATUS", "5000"]) assert.ok(!isBoolean(name), name);
  assert.ok(isConstant("0L") && !isConstant("Y0"));
});

test("the waveform of a byte starts with its oldest sample", async () => {
  const { waveformPath } = await load("src/history.ts");
  assert.ok(waveformPath(0b1000_0000, 80, 20).startsWith("M0 1H10V19H20"));
  assert.ok(waveformPath(0b0000_0001, 80, 20).endsWith("V1H80"));
});

test("the camera is its own inverse and zooms about the pointer", async () => {
  const { Camera, scaleBar } = await load("src/map/camera.ts");
  const camera = new Camera();
  [camera.width_px, camera.height_px] = [800, 600];
  camera.fit([-6, -4.5, 6, 4.5], { x: 20, top: 20, bottom: 60 });
  const [x, y] = camera.toWorld(...camera.toScreen(1.25, -3.5));
  assert.ok(Math.abs(x - 1.25) < 1e-9 && Math.abs(y + 3.5) < 1e-9);
  for (const corner of [[-6, -4.5], [6, 4.5]]) {
    const [x_px, y_px] = camera.toScreen(...corner);
    assert.ok(x_px >= 19.9 && x_px <= 780.1 && y_px >= 19.9 && y_px <= 540.1, `${x_px} ${y_px}`);
  }
  assert.ok(camera.toScreen(0, 1)[1] < camera.toScreen(0, 0)[1], "y is up");
  const before = camera.toWorld(100, 90);
  camera.zoomAt(100, 90, 2.5);
  camera.toWorld(100, 90).forEach((value, i) => assert.ok(Math.abs(value - before[i]) < 1e-9));
  assert.deepEqual(scaleBar(60, 110), { length_m: 1, length_px: 60, label: "1 m" });
  assert.equal(scaleBar(400, 110).label, "20 cm");
});

test("the speed slider is logarithmic, ends at its limits, and sticks to 1", async () => {
  const { speedOfSlider, sliderOfSpeed } = await load("src/transport.ts");
  for (const last of [20, 200]) {
    const speeds = [0.1, 1, 10, last];
    assert.equal(speedOfSlider(0, speeds), 0.1);
    assert.equal(speedOfSlider(1000, speeds), last);
    assert.equal(speedOfSlider(sliderOfSpeed(1, speeds), speeds), 1);
    assert.equal(sliderOfSpeed(500, speeds), 1000);
    for (let position = 1; position <= 1000; position += 1) assert.ok(speedOfSlider(position, speeds) >= speedOfSlider(position - 1, speeds));
  }
});

test("figures take label and unit from their name", async () => {
  const { figure, clock, ratio, coordinate } = await load("src/format.ts");
  assert.deepEqual(figure("cross_track_rms_m", 0.0123), { label: "Cross track rms", value: "12", unit: "mm" });
  assert.deepEqual(figure("clearance_min_m", 0.45), { label: "Clearance min", value: "0.45", unit: "m" });
  assert.deepEqual(figure("collisions", 0), { label: "Collisions", value: "0", unit: "" });
  assert.equal(figure("time_s", null).value, "–");
  assert.equal(clock(72.34), "1:12.3");
  assert.equal(ratio(0.25), "0.25×");
  assert.equal(ratio(20), "20×");
  assert.equal(coordinate(-0.001), "0.00");
  assert.equal(coordinate(-1.5), "−1.50");
});

test("poses blend the short way round and never beyond the latest state", async () => {
  const { blendPose, blendFactor } = await load("src/map/interpolate.ts");
  const yaw = blendPose([0, 0, 3.1], [1, 0, -3.1], 0.5)[2];
  assert.ok(Math.abs(Math.abs(yaw) - Math.PI) < 0.01);
  const sample = (arrived_ms, playing = true) => ({ arrived_ms, state: { playing } });
  assert.equal(blendFactor(null, sample(10), 20), 1);
  assert.equal(blendFactor(sample(0), sample(33), 33), 0);
  assert.equal(blendFactor(sample(0), sample(33), 500), 1);
  assert.equal(blendFactor(sample(0), sample(33, false), 33), 1, "a paused run shows its state at once");
  assert.equal(blendFactor(sample(0), sample(900), 900), 1, "after a stall the latest is drawn at once");
});

test("a pulse between two pictures still leaves its mark in the signals", async () => {
  const { Signals } = await load("src/signals.ts");
  const signals = new Signals();
  const push = (t_s, byte) => signals.push({ t_s, decision: { resources: { Y3: byte, M0: 5, "1L": 255 } } });
  push(0, 0);
  push(1, 0b0001_0000);
  push(2, 0);
  assert.deepEqual([...signals.edges.keys()], ["Y3"]);
  assert.deepEqual(signals.edges.get("Y3").map(({ high }) => high), [false, true, false]);
});

test("edges told by the program are drawn exactly, and once", async () => {
  const { Signals } = await load("src/signals.ts");
  const signals = new Signals();
  signals.push({ t_s: 0, decision: { resources: { Y3: 0 }, edges: [] } });
  signals.push({ t_s: 17.4, decision: { resources: { Y3: 0 }, edges: [[17.01, "Y3", true], [17.11, "Y3", false]] } });
  assert.deepEqual(signals.edges.get("Y3"), [{ t_s: 0, high: false }, { t_s: 17.01, high: true }, { t_s: 17.11, high: false }]);
});

test("a long trail is thinned but keeps its ends", async () => {
  const { Trail } = await load("src/trail.ts");
  const trail = new Trail();
  for (let i = 0; i <= 20000; i += 1) trail.push([i * 0.05, 0], i);
  assert.ok(trail.points.length <= 6001, String(trail.points.length));
  assert.equal(trail.points[0].x_m, 0);
  assert.equal(trail.points.at(-1).t_s, 20000);
});

test("the painted field is a cone of radius sigma around a single source", async () => {
  const { intensities } = await load("src/map/field.ts");
  const field = { cell_m: 0.2, width: 21, height: 21, origin_m: [0, 0], values: [[10, 10, 100], [2, 2, 200]], sigma_m: 0.6, antenna_spacing_m: 0.38 };
  const { values, width } = intensities(field, 5);
  const at = (x, y) => values[y * width + x];
  assert.ok(Math.abs(at(52, 52) - 100) < 1e-4);
  assert.ok(Math.abs(at(52 + 6, 52) - 100 * (1 - 0.24 / 0.6)) < 1e-4);
  assert.equal(at(52 + 15, 52), 0);
  assert.equal(at(12, 12), 0, "values from 0x80 on are reserved");
});

test("operands are found by column, and by text where the column does not fit", async () => {
  const { placesOf } = await load("src/panels/operands.ts");
  const { EditorState } = await import("@codemirror/state");
  const doc = EditorState.create({ doc: "; bell\nFF   Y2,I0,Y1,0" }).doc;
  const operand = (text, column, resource = text) => ({ text, resource, column, length: text.length });
  const program = { source: "", mode: "corrected", functions: [{ line: 2, mnemonic: "FF", operands: [operand("Y2", 6), operand("I0", 99), operand("Y1", 12), operand("0", 15, null)] }] };
  const places = placesOf(doc, program).map(({ from, to }) => doc.sliceString(from, to));
  assert.deepEqual(places, ["Y2", "I0", "Y1"]);
});

test("a change that several states tell is one edge", async () => {
  const { Signals } = await load("src/signals.ts");
  const signals = new Signals();
  const state = (t_s, edges) => ({ t_s, decision: { resources: { I0: 0 }, edges } });
  const pulse = [[1.5, "I0", true], [1.51, "I0", false]];
  signals.push(state(1, []));
  for (const t_s of [2, 2.03, 2.06]) signals.push(state(t_s, pulse));
  signals.push(state(2.09, [[2.08, "I0", true], [2.085, "I0", false]]));
  assert.deepEqual(signals.edges.get("I0").slice(1).map(({ t_s, high }) => [t_s, high]), [[1.5, true], [1.51, false], [2.08, true], [2.085, false]]);
});

test("a crowd is counted by what needs attention first", async () => {
  const { countCrowd } = await load("src/map/crowd.ts");
  const crowd = [[0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 2], [0, 0, 0, 3], [0, 0, 0, 2]];
  assert.deepEqual(countCrowd(crowd), { under_way: 1, arrived: 2, touching: 2 });
});

test("another run is another story, the same run after a reconnection is not", async () => {
  const { Store } = await load("src/state.ts");
  const store = new Store();
  const hello = (run) => ({ type: "hello", run, mission: { name: "x", seed: 1 } });
  const log = { type: "log", items: [{ t_s: 0, level: "info", text: "goal" }] };
  store.accept(hello("1-0"), 0);
  store.accept(log, 0);
  store.accept(hello("1-0"), 1);
  store.accept(log, 1);
  assert.equal(store.log.length, 1);
  store.accept(hello("1-1"), 2);
  assert.equal(store.log.length, 0);
  store.accept(log, 2);
  store.accept({ type: "state", t_s: 0, robots: [], decision: null }, 3);
  assert.equal(store.log.length, 1, "what was told at the very beginning stays");
});

test("packed cells come back as the program packed them", async () => {
  const { unpack } = await load("src/mapping/decode.ts");
  assert.deepEqual([...unpack(Uint8Array.from([2, 7, 8, 9, 253, 5, 0, 1]), 8)], [7, 8, 9, 5, 5, 5, 5, 1]);
  assert.equal(unpack(Uint8Array.from([129, 3]), 128).every((cell) => cell === 3), true);
  assert.deepEqual([...unpack(Uint8Array.from([4, 1, 2]), 3)], [1, 2, 0], "what is missing is unknown");
});

test("binary messages are read as they are described, and damaged ones are left out", async () => {
  const { decode } = await load("src/mapping/decode.ts");
  const bytes = new DataView(new ArrayBuffer(8 + 12 + 12));
  bytes.setUint8(0, 2);
  bytes.setUint8(1, 1);
  [7, 1, 5, 1].forEach((value, i) => bytes.setUint32(4 + 4 * i, value, true));
  [1.5, -2, 0.25].forEach((value, i) => bytes.setFloat32(20 + 4 * i, value, true));
  const track = decode(bytes.buffer);
  assert.deepEqual({ ...track, poses: [...track.poses] }, { slot: 1, run: 7, kind: "track", which: 1, first: 5, poses: [1.5, -2, 0.25] });
  for (const length of [30, 28, 9]) assert.equal(decode(bytes.buffer.slice(0, length)), null);
  bytes.setUint8(0, 99);
  assert.equal(decode(bytes.buffer), null);
});

test("beams are told apart: echoes, free ones, and those that say nothing", async () => {
  const { beamsOf, endsOf } = await load("src/map/lasers.ts");
  const bytes = Buffer.alloc(6);
  [1500, 65535, 0].forEach((beam, i) => bytes.writeUInt16LE(beam, 2 * i));
  const beams = beamsOf(bytes.toString("base64"));
  assert.deepEqual([...beams], [1500, 65535, 0]);
  const ends = endsOf({ first_angle_rad: 0, step_rad: Math.PI / 2, range_max_m: 8 }, [1, 2, 0], beams);
  assert.ok(Math.hypot(ends[0] - 2.5, ends[1] - 2) < 1e-5 && ends[2] === 1, "an echo ahead");
  assert.ok(Math.hypot(ends[3] - 1, ends[4] - 10) < 1e-5 && ends[5] === 0, "free to the left as far as it sees");
  assert.ok(Number.isNaN(ends[6]), "what is unseen is nowhere");
});

test("parameters and figures are written with their units", async () => {
  const { unitOf, figureText } = await load("src/mapping/units.ts");
  assert.deepEqual(unitOf("resolution_m"), { stem: "Resolution", unit: "m" });
  assert.deepEqual(unitOf("window_max_deg"), { stem: "Window max", unit: "°" });
  assert.equal(figureText(0.0123, "m"), "12.3 mm");
  assert.equal(figureText(null, "m"), "–");
  assert.equal(figureText(42, ""), "42");
});

test("the chosen candidate stands first, then those with the nearest scores", async () => {
  const { ranked } = await load("src/mapping/candidates.ts");
  const candidates = [[0, 0, 0, 0.2], [0.1, 0, 0, 0.9], [0, 0.1, 0, null], [0, 0, 0.1, 0.8]];
  assert.deepEqual(ranked({ candidates, best: 1 }).map(([index]) => index), [1, 3, 0, 2]);
  assert.deepEqual(ranked({ candidates, best: null }).map(([index]) => index), [0, 1, 3, 2]);
});

test("a robot's task is told before its phase, its failure with the goal, and a hand at the wheel before both", async () => {
  const { taskWords } = await load("src/format.ts");
  const [goal, why] = ["(1.5, -0.5)", "no trail leads to the goal; the nearest point of a trail is 1.7 m away from it"];
  assert.equal(taskWords({ phase: "idle", task: "", failure: null }), "idle");
  assert.equal(taskWords({ phase: "idle" }), "idle", "an older program says nothing of its task");
  assert.equal(taskWords({ phase: "following the trail", task: `on the way to ${goal}: 8.3 m to go`, failure: null }), `on the way to ${goal}: 8.3 m to go`);
  assert.equal(taskWords({ phase: "failed", task: `gave up ${goal}: ${why}`, failure: why }), `gave up ${goal}: ${why}`);
  assert.equal(taskWords({ phase: "idle", task: "", failure: "the link was lost" }), "gives up: the link was lost");
  assert.equal(taskWords({ phase: "driven by hand", task: `on the way to ${goal}: 8.3 m to go`, failure: null }), "driven by hand");
});

test("an axis has three to six round marks, whatever its range", async () => {
  const { ticks } = await load("src/ticks.ts");
  assert.deepEqual(ticks(-150, 357), [-100, 0, 100, 200, 300]);
  assert.deepEqual(ticks(0, 1.02), [0, 0.5, 1]);
  assert.deepEqual(ticks(-520, 60), [-500, -250, 0]);
  assert.deepEqual(ticks(0, 0.3), [0, 0.1, 0.2, 0.3]);
  assert.ok(Object.is(ticks(-1, 1)[1], 0));
  for (let i = 0; i < 4000; i += 1) {
    const low = -((i * 7919) % 1000) * 10 ** ((i % 7) - 4);
    const high = low + (1 + ((i * 104729) % 9973)) * 10 ** ((i % 9) - 5);
    const marks = ticks(low, high);
    assert.ok(marks.length >= 3 && marks.length <= 6, `${low} ${high}: ${marks}`);
    assert.ok(marks.every((mark) => mark >= low - 1e-6 * (high - low) && mark <= high + 1e-6 * (high - low)), `${low} ${high}: ${marks}`);
  }
  assert.deepEqual(ticks(2, 2), [2]);
  assert.deepEqual(ticks(0, Infinity), [0]);
});

test("marks of plain text in a mission's own words are shown as what they mean", async () => {
  const { pieces, plain } = await load("src/prose.ts");
  const about = "Try *Send to a goal* anywhere, or --set robots.mind.how.preview_m=0: antennas alone. `cairn run`, 2 * 3 * 4.";
  assert.deepEqual(pieces(about).filter(({ kind }) => kind !== "text"), [
    { kind: "emphasis", text: "Send to a goal" }, { kind: "code", text: "--set robots.mind.how.preview_m=0" }, { kind: "code", text: "cairn run" },
  ]);
  assert.equal(plain(about), "Try Send to a goal anywhere, or --set robots.mind.how.preview_m=0: antennas alone. cairn run, 2 * 3 * 4.");
  assert.equal(plain(""), "");
});

test("only another place than the goal is a detour", async () => {
  const { isDetour } = await load("src/map/robots.ts");
  assert.ok(!isDetour([1, 2], [1, 2, 0.3]) && !isDetour([1.001, 2], [1, 2, 0]));
  assert.ok(isDetour([1.1, 2], [1, 2, 0]) && isDetour([1, 2], null));
});

test("a bare floor is told of one's own mission until something happens, never of a crowd", async () => {
  const { isBare, hasBegun } = await load("src/map/chrome.ts");
  const hello = (more) => ({ mission: { name: "mine" }, missions: [{ name: "swarm" }, { name: "mine", own: true }], world: { walls: [], points: [], things: [] }, robots: [{}], crowd: null, pheromones: null, ...more });
  assert.ok(isBare(hello({})));
  assert.ok(!isBare(hello({ crowd: {} })) && !isBare(hello({ mission: { name: "swarm" } })));
  assert.ok(isBare(hello({ mission: { name: "swarm" }, robots: [] })), "without a robot the floor needs a word");
  assert.ok(!isBare(hello({ world: { walls: [[0, 0, 1, 1, ""]], points: [], things: [] } })));
  const still = { goal: null, phase: "idle", wheels_mps: [0, 0] };
  const state = (robot, things = []) => ({ robots: [{ ...still, ...robot }], things });
  assert.ok(!hasBegun(null) && !hasBegun(state({})));
  for (const begun of [state({ goal: [0, 0, 0] }), state({ phase: "driven by hand" }), state({ wheels_mps: [0.1, 0] }), state({}, [{}])]) assert.ok(hasBegun(begun));
});
