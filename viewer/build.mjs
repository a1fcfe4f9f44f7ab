// Builds the program and the style of the viewer into src/report/viewer/bundle; with --check it compares them with what is there.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync, mkdirSync } from "node:fs";
import { deflateSync, inflateSync } from "node:zlib";

const root = new URL(".", import.meta.url);
const out = new URL("../src/report/viewer/bundle/", root);

/** SHA-256 over the names and contents of all sources; a test of the crate computes the same without node. */
function digest() {
  const sources = ["package-lock.json", "package.json", "start.js", "style.css"];
  sources.push(...readdirSync(new URL("src/", root)).map((name) => `src/${name}`));
  const hash = createHash("sha256");
  for (const name of sources.sort()) {
    const bytes = readFileSync(new URL(name, root));
    hash.update(`${name}\n${bytes.length}\n`).update(bytes);
  }
  return hash.digest("hex");
}

const shared = { bundle: true, minify: true, write: false, legalComments: "none", target: ["es2022"], logLevel: "error" };
const text = (result) => result.outputFiles[0].text;
const banner = `/* sources ${digest()}; with ogl (Unlicense) and gifenc (MIT, Matt DesLauriers) */`;
const entry = (name) => [new URL(name, root).pathname];
const program = text(await build({ ...shared, entryPoints: entry("src/main.js"), format: "iife", banner: { js: banner } }));
const style = text(await build({ ...shared, entryPoints: entry("style.css") }));
const start = text(await build({ ...shared, entryPoints: entry("start.js"), format: "iife" })).trim();

if (process.argv.includes("--check")) {
  const read = (name) => readFileSync(new URL(name, out));
  const same = inflateSync(read("viewer.js.z")).toString() === program && read("viewer.css").toString() === style && read("start.js").toString() === start;
  if (!same) {
    console.error("src/report/viewer/bundle is not built from viewer/: run `npm run build` in viewer/");
    process.exit(1);
  }
} else {
  mkdirSync(out, { recursive: true });
  writeFileSync(new URL("viewer.js.z", out), deflateSync(program, { level: 9 }));
  writeFileSync(new URL("viewer.css", out), style);
  writeFileSync(new URL("start.js", out), start);
  console.log(`program ${program.length} bytes, packed ${readFileSync(new URL("viewer.js.z", out)).length}; style ${style.length}`);
}
