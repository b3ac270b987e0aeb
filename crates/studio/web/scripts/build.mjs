// Builds the page into dist/ with stable names, so that the Rust program can embed it and CI can
// rebuild it and compare byte for byte. `--watch` rebuilds at every change (for development).

import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const dist = join(web, "dist");
const assets = join(dist, "assets");
const watching = process.argv.includes("--watch");

/** @type {esbuild.BuildOptions} */
const options = {
  absWorkingDir: web,
  entryPoints: { studio: "src/main.ts", theme: "src/theme_boot.ts" },
  outdir: "dist/assets",
  bundle: true,
  minify: !watching,
  sourcemap: watching ? "inline" : false,
  format: "iife",
  target: ["chrome109", "firefox115", "safari16.4"],
  charset: "utf8",
  legalComments: "none",
  metafile: true,
  logLevel: "warning",
};

rmSync(dist, { recursive: true, force: true });
mkdirSync(assets, { recursive: true });
cpSync(join(web, "static", "index.html"), join(dist, "index.html"));
cpSync(join(web, "static", "favicon.svg"), join(assets, "favicon.svg"));

if (watching) {
  const context = await esbuild.context(options);
  await context.watch();
  process.stdout.write("watching src/ (Ctrl-C ends)\n");
} else {
  const { metafile } = await esbuild.build(options);
  writeFileSync(join(assets, "third-party.txt"), thirdPartyNotices(metafile));
  report();
}

/** The licence texts of the packages that are inside the bundle, in alphabetical order. */
function thirdPartyNotices(metafile) {
  const packages = new Set();
  for (const input of Object.keys(metafile.inputs)) {
    const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (found) packages.add(found[1]);
  }
  const parts = [...packages].sort().map((name) => {
    const folder = join(web, "node_modules", name);
    const { version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
    const text = file && existsSync(join(folder, file)) ? readFileSync(join(folder, file), "utf8").trim() : "";
    return `${name} ${version} (${license})\n\n${text}\n`;
  });
  return `Cairn's studio contains these packages.\n\n${parts.join("\n----\n\n")}`;
}

function report() {
  for (const file of readdirSync(assets).sort()) {
    const size = readFileSync(join(assets, file)).length;
    process.stdout.write(`dist/assets/${file}  ${(size / 1024).toFixed(1)} kB\n`);
  }
}
