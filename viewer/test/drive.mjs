// Drives a page of the viewer in headless Chromium over a pipe, as a user would, and prints what it found as JSON.
//
//     node viewer/test/drive.mjs page.html [folder for pictures]
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [page, pictures] = process.argv.slice(2);
const profile = mkdtempSync(join(tmpdir(), "viewer-"));
const flags = [
  "--headless", "--no-sandbox", "--remote-debugging-pipe", `--user-data-dir=${profile}`, "--window-size=1280,800", "--use-gl=angle", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader", "--no-first-run", "--disable-quic", "--disable-background-networking", "--disable-component-update", "--disable-sync",
];
const chromium = spawn(process.env.CHROMIUM ?? "chromium", flags, { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
const [into, from] = [chromium.stdio[3], chromium.stdio[4]];
const waiting = new Map();
const found = { errors: [], requests: [] };
let [count, rest, session] = [0, "", undefined];

function send(method, params = {}) {
  const id = ++count;
  into.write(`${JSON.stringify({ id, method, params, sessionId: session })}\0`);
  return new Promise((done, fail) => waiting.set(id, { done, fail }));
}

function receive(message) {
  const { id, method, params, result, error } = message;
  if (id) {
    const { done, fail } = waiting.get(id);
    waiting.delete(id);
    return error ? fail(new Error(error.message)) : done(result);
  }
  if (method === "Runtime.exceptionThrown") found.errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
  if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type)) found.errors.push(params.args.map((a) => a.value ?? a.description).join(" "));
  // A software renderer says that reading pixels waits for it
  if (method === "Log.entryAdded" && ["error", "warning"].includes(params.entry.level) && !/GPU stall/.test(params.entry.text)) found.errors.push(params.entry.text);
  if (method === "Network.requestWillBeSent" && !/^(blob|data):/.test(params.request.url)) found.requests.push(params.request.url);
}

from.setEncoding("utf8").on("data", (text) => {
  const parts = (rest + text).split("\0");
  rest = parts.pop();
  parts.forEach((part) => receive(JSON.parse(part)));
});

async function run(expression) {
  const { result, exceptionDetails } = await send("Runtime.evaluate", { expression: `(async () => { ${expression} })()`, awaitPromise: true, returnByValue: true });
  if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
  return result.value;
}

async function picture(name) {
  const { data } = await send("Page.captureScreenshot", { format: "png" });
  if (pictures) writeFileSync(join(pictures, `${name}.png`), Buffer.from(data, "base64"));
  return data;
}

const settle = () => run("for (let k = 0; k < 4; k++) await new Promise(requestAnimationFrame)");

/** Positions and time of every state as the page computes them, in base64 of single precision. */
const POSITIONS = `const all = [];
for (const c of viewer.cases) {
  const pack = (a) => { const b = new Uint8Array(a.buffer); let s = ""; for (let k = 0; k < b.length; k += 32768) s += String.fromCharCode(...b.subarray(k, k + 32768)); return btoa(s); };
  all.push({ title: c.title, nodes: c.nodes, times: c.times, error: c.motion.error, states: c.times.map((_, k) => pack(c.positions(k, 1))) });
}
return all;`;

async function drive() {
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  session = (await send("Target.attachToTarget", { targetId, flatten: true })).sessionId;
  for (const domain of ["Page", "Runtime", "Log", "Network"]) await send(`${domain}.enable`);
  await send("Page.navigate", { url: pathToFileURL(resolve(page)).href });
  await run("for (let k = 0; k < 600 && !globalThis.viewer?.drawn; k++) await new Promise((next) => setTimeout(next, 50))");
  Object.assign(found, await run(`return { drawn: viewer.drawn, firstDraw_ms: viewer.firstDraw,
    firstPaint_ms: performance.getEntriesByName("first-contentful-paint")[0]?.startTime, title: document.title, heading: document.querySelector("h1").textContent,
    elements: document.querySelectorAll("img, iframe, object, embed, link, form").length, quantities: viewer.cases.map((c) => c.quantities.map((q) => q.name)),
    absent: viewer.cases[0].head.absent, notes: viewer.cases[0].head.notes }`));
  await settle();
  const shots = { start: await picture("start") };
  found.cases = await run(POSITIONS);
  if (await run("return viewer.moves")) {
    await run('viewer.slider.value = viewer.times[0]; viewer.slider.dispatchEvent(new Event("input"))');
    await settle();
    shots.slider = await picture("slider");
    found.clock = await run("return viewer.clock.textContent");
    await run("viewer.seek(viewer.times[1] * 0.5)");
    await settle();
    shots.middle = await picture("middle");
  }
  await run('viewer.pick.value = "displacement, x"; if (viewer.pick.value) viewer.pick.dispatchEvent(new Event("change"))');
  await settle();
  shots.colour = await picture("colour");
  found.legend = await run('return document.querySelector(".legend").textContent');
  await run('viewer.cutBox.querySelector("input").click()');
  await settle();
  shots.section = await picture("section");
  found.section = await run("return viewer.panes.map((p) => p.cut.used)");
  await run('viewer.choose("regions")');
  await settle();
  shots.regions = await picture("regions");
  await run("viewer.cut(false); viewer.view.direct('front')");
  await settle();
  shots.front = await picture("front");
  await run('document.querySelector("header button").click()');
  await settle();
  shots.theme = await picture("theme");
  if (await run("return viewer.moves")) {
    found.frames_per_s = await run(`viewer.choose(viewer.cases[0].quantities[0].name); viewer.toggle(true); const from = viewer.drawn, t = performance.now();
      await new Promise((next) => setTimeout(next, 3000)); viewer.toggle(false); return (1000 * (viewer.drawn - from)) / (performance.now() - t)`);
  }
  await run("viewer.export && (globalThis.saved = []); URL.createObjectURL = (blob) => { saved.push([blob.type, blob.size]); return 'data:,'; }; HTMLAnchorElement.prototype.click = () => {}");
  await run("viewer.out.width = 800; await viewer.export('png')");
  if (await run("return viewer.moves")) await run("viewer.s.seconds = 1; await viewer.export('gif'); await viewer.export('webm')");
  found.saved = await run("return saved");
  found.different = Object.keys(shots).filter((name, k, all) => k > 0 && shots[name] !== shots[all[k - 1]]);
  await settle();
}

const patience = setTimeout(() => {
  console.error("the browser did not answer within 120 s");
  chromium.kill("SIGKILL");
  process.exit(1);
}, 120_000);
try {
  await drive();
  console.log(JSON.stringify(found));
} finally {
  clearTimeout(patience);
  // Its processes end together and leave their folder; killed one by one they would still write into it
  const ended = new Promise((done) => chromium.on("exit", done));
  session = undefined;
  send("Browser.close").catch(() => {});
  await Promise.race([ended, new Promise((next) => setTimeout(next, 5000))]);
  chromium.kill("SIGKILL");
  try {
    rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
  } catch (error) {
    console.error(`${profile} is left: ${error.message}`);
  }
}
