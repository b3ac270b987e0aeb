// Cheap checks of our own rules: every source file says in its first line what it is for, stays
// under 400 lines, and never uses `any`.

import { readFileSync, readdirSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { fileURLToPath } from "node:url";

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const N_LINES_MAX = 400;
const complaints = [];
let n_files = 0;

for (const folder of ["src", "tests", "scripts"]) {
  for (const entry of readdirSync(join(web, folder), { recursive: true, withFileTypes: true })) {
    if (!entry.isFile() || !/\.(ts|mjs|css)$/.test(entry.name)) continue;
    const path = join(entry.parentPath ?? entry.path, entry.name);
    check(relative(web, path), readFileSync(path, "utf8"));
  }
}

for (const complaint of complaints) process.stderr.write(`${complaint}\n`);
process.stdout.write(`tidy: ${n_files} files, ${complaints.length} complaints\n`);
process.exit(complaints.length === 0 ? 0 : 1);

function check(name, text) {
  n_files += 1;
  const lines = text.split("\n");
  if (!/^(\/\/ |\/\* )[A-Z]/.test(lines[0] ?? "")) {
    complaints.push(`${name}:1 has no head comment; say in the first line what the file is for`);
  }
  if (lines.length > N_LINES_MAX) {
    complaints.push(`${name} has ${lines.length} lines; ${N_LINES_MAX} are allowed; split it`);
  }
  if (!name.endsWith(".ts")) return;
  lines.forEach((line, index) => {
    if (/(:\s*any\b|<any>|\bas any\b|@ts-ignore)/.test(line)) {
      complaints.push(`${name}:${index + 1} uses any; name the type`);
    }
  });
}
