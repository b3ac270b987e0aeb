// Starts the real program for the browser tests: `CAIRN_BIN=/path/to/cairn`.

import { spawn } from "node:child_process";
import { eventually, noBrowser } from "./browser.mjs";

export const program = process.env.CAIRN_BIN;

/** A reason to skip, or false. */
export const noProgram = noBrowser || (program ? false : "skipped: CAIRN_BIN is not set");

/** Starts the program on a free port (or the given one) and waits for the address it prints. */
export async function start({ port = 0, args = ["run", "doorbell"] } = {}) {
  const child = spawn(program, [...args, "--port", String(port)], { stdio: ["ignore", "pipe", "pipe"] });
  let output = "";
  for (const stream of [child.stdout, child.stderr]) stream.on("data", (data) => (output += data));
  const stop = async () => {
    if (child.exitCode !== null || child.signalCode !== null) return;
    child.kill("SIGTERM");
    await new Promise((resolve) => child.once("exit", resolve));
  };
  try {
    const url = await eventually("the address of the studio", () => {
      if (child.exitCode !== null) throw new Error(`the program ended: ${output}`);
      return /http:\/\/127\.0\.0\.1:\d+\/?/.exec(output)?.[0];
    }, 30_000);
    return { url, port: Number(new URL(url).port), stop };
  } catch (error) {
    await stop();
    throw error;
  }
}
