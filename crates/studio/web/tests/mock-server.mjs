// A stand-in for the program: serves dist/ and speaks the studio protocol, for development and tests.
//
// `npm run mock` serves http://127.0.0.1:8137; options: --port N, --replay.

import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { WebSocketServer } from "ws";
import { MISSIONS, Run } from "./mock/run.mjs";

const DIST = join(dirname(dirname(fileURLToPath(import.meta.url))), "dist");
const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml", ".txt": "text/plain; charset=utf-8" };
const PERIOD_MS = 33;

/** Starts it; `received` collects every request of the page. `close` drops all connections. */
export async function startMock({ port = 0, kind = "live", mission = "doorbell", lag = 1, lasers = 0 } = {}) {
  let run = new Run(mission, 1, kind, lasers);
  /** One state in 0.1 s, to look back on. */
  let past = [];
  let playing = false;
  let speed = 1;
  let debt_s = 0;
  const received = [];

  const http = createServer((request, response) => void serve(request, response));
  const sockets = new WebSocketServer({ server: http, path: "/ws" });
  const broadcast = (message) => {
    const text = JSON.stringify(message);
    for (const client of sockets.clients) client.send(text);
  };
  const flush = () => {
    if (run.traces.length) broadcast({ type: "trace", items: run.traces });
    if (run.logs.length) broadcast({ type: "log", items: run.logs });
    run.traces = [];
    run.logs = [];
    broadcast(run.state(playing, speed, playing ? speed * lag : 0));
  };

  sockets.on("connection", (socket) => {
    socket.send(JSON.stringify(run.hello()));
    flush();
    socket.on("message", (data) => {
      const message = JSON.parse(String(data));
      received.push(message);
      if (message.type === "past") return lookBack(socket, message.t_s);
      const problem = answer(message);
      if (problem) socket.send(JSON.stringify({ type: "error", text: problem }));
      flush();
    });
  });

  const timer = setInterval(() => {
    if (!playing) return;
    debt_s += (PERIOD_MS / 1000) * speed * lag;
    while (debt_s >= 0.01) {
      debt_s -= 0.01;
      run.tick();
      if (run.step_number % 10 === 0) past.push(run.state(true, 1, 1));
    }
    if (run.verdict && run.t_s > 1) playing = !isOver(run);
    flush();
  }, PERIOD_MS);

  function lookBack(socket, asked_s) {
    const state = past.findLast(({ t_s }) => t_s <= asked_s + 1e-6) ?? past[0] ?? run.state(false, 1, 0);
    const kept = { n_states: past.length, n_bytes: 3000 * past.length, bytes_max: 16 * 1024 * 1024, period_s: 0.1, gap_max_s: 0.1 };
    socket.send(JSON.stringify({ type: "past", asked_s, kept, state }));
  }

  function answer(message) {
    switch (message.type) {
      case "play": playing = true; return null;
      case "pause": playing = false; return null;
      case "step": playing = false; for (let i = 0; i < 20; i += 1) run.tick(); return null;
      case "speed":
        if (!(message.ratio >= 0.1 && message.ratio <= 20)) return `speed ${message.ratio} is outside 0.1 to 20`;
        speed = message.ratio;
        return null;
      case "restart":
        run = new Run(message.mission ?? run.mission.name, message.seed ?? run.seed, kind, lasers);
        past = [];
        playing = false;
        broadcast(run.hello());
        return null;
      case "place": return kind === "replay" ? "a replay cannot be changed" : run.place(message.at_m, message.size_m);
      case "remove": return run.remove(message.id);
      case "goal": run.goal(message.pose); return null;
      case "press": run.press(message.device); return null;
      case "drive": return null;
      case "cut": run.say("warn", `${message.line} ${message.cut ? "cut" : "mended"} by hand`); return null;
      case "stop": run.robot.goal = null; return null;
      default: return `unknown request "${message.type}"`;
    }
  }

  async function serve(request, response) {
    const path = new URL(request.url, "http://localhost").pathname;
    if (path === "/healthz") return void response.end("ok");
    if (path === "/api/missions") return void response.setHeader("content-type", "application/json").end(JSON.stringify(MISSIONS));
    try {
      const file = path === "/" || path === "/map" ? "index.html" : normalize(path).replace(/^(\.\.[/\\])+/, "");
      const body = await readFile(join(DIST, file));
      response.setHeader("content-type", TYPES[extname(file)] ?? "application/octet-stream").end(body);
    } catch {
      response.statusCode = 404;
      response.end("not found");
    }
  }

  await new Promise((resolve) => http.listen(port, "127.0.0.1", resolve));
  const address = http.address();
  return {
    port: address.port,
    url: `http://127.0.0.1:${address.port}/`,
    received,
    get run() { return run; },
    async close() {
      clearInterval(timer);
      for (const client of sockets.clients) client.terminate();
      sockets.close();
      http.closeAllConnections();
      await new Promise((resolve) => http.close(resolve));
    },
  };
}

/** The run goes on for two seconds after the verdict, then rests. */
function isOver(run) {
  run.over_s ??= run.t_s;
  return run.t_s > run.over_s + 2;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const at = process.argv.indexOf("--port");
  const port = at > 0 ? Number(process.argv[at + 1]) : 8137;
  const mock = await startMock({ port, kind: process.argv.includes("--replay") ? "replay" : "live" });
  process.stdout.write(`mock studio at ${mock.url}\n`);
}
