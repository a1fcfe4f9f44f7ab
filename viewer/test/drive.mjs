// Drives a page of the viewer in a headless browser, as a user would, and prints what it found as JSON.
//
//     node viewer/test/drive.mjs page.html [folder for pictures]
//
// BROWSER=firefox takes Firefox instead of Chromium. REFERENCE=folder compares the views with the pictures there; with DUROMETER_BLESS=1 it writes them. PAINT=1 measures the first paint alone, of any page.
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { decode, difference, encode, reduced } from "./png.mjs";

const [page, pictures] = process.argv.slice(2);
const { start } = await import(process.env.BROWSER === "firefox" ? "./firefox.mjs" : "./chromium.mjs");
const found = { errors: [], requests: [], reference: {}, acts: {} };
const browser = await start(found);
const { run } = browser;
const pause = (ms) => new Promise((next) => setTimeout(next, ms));

const settle = () => run("for (let k = 0; k < 4; k++) await new Promise(requestAnimationFrame)");
const shots = {};

/** Takes a picture of the window, and compares the views in it with their reference. */
async function shoot(name) {
  await settle();
  shots[name] = await browser.picture();
  const bytes = Buffer.from(shots[name], "base64");
  if (pictures) writeFileSync(join(pictures, `${name}.png`), bytes);
  if (!process.env.REFERENCE) return;
  const area = await run('const b = document.querySelector(".pane").getBoundingClientRect(); return [b.x, b.y, b.width, b.height].map(Math.round)');
  const view = reduced(decode(bytes), area);
  const file = join(process.env.REFERENCE, `${name}.png`);
  if (process.env.DUROMETER_BLESS) writeFileSync(file, encode(view));
  found.reference[name] = existsSync(file) ? difference(view, decode(readFileSync(file))) : 1;
}

/** Positions and time of every state as the page computes them, in base64 of single precision. */
const POSITIONS = `const all = [];
for (const c of viewer.cases) {
  const pack = (a) => { const b = new Uint8Array(a.buffer); let s = ""; for (let k = 0; k < b.length; k += 32768) s += String.fromCharCode(...b.subarray(k, k + 32768)); return btoa(s); };
  all.push({ title: c.title, nodes: c.nodes, times: c.times, error: c.motion.error, states: c.times.map((_, k) => pack(c.positions(k, 1))) });
}
return all;`;

/** How far the nodes of the bodies are from the middle of the picture at their states, as shares of half its width and height: more than 1 is outside. */
const REACH = `const { view, panes: [{ canvas: { size: [w, h] } }] } = viewer;
const { right, up } = view.axes(), half = view.half * Math.max(1, h / w), reach = [0, 0];
for (const c of viewer.cases) {
  for (let state = 0; state < c.states; state++) {
    const x = c.positions(state, viewer.s.scale);
    for (let p = 0; p < c.nodes; p++) {
      const along = (axis) => Math.abs([0, 1, 2].reduce((sum, i) => sum + axis[i] * (x[3 * p + i] - view.center[i]), 0));
      [(along(right) / half) * (h / w), along(up) / half].forEach((share, k) => (reach[k] = Math.max(reach[k], share)));
    }
  }
}
return reach;`;

/** What the controls of time, colour, section and view change. */
async function views() {
  await shoot("start");
  found.reach = await run(REACH);
  found.column = await run("return viewer.s.column");
  found.cases = await run(POSITIONS);
  // A node by its number, the state and the recorded value in words
  found.said = await run(`viewer.panes[0].pick = viewer.cases[0].facets[0]; viewer.redraw("pick"); for (let k = 0; k < 3; k++) await new Promise(requestAnimationFrame);
    return [viewer.readout.textContent, viewer.value?.textContent, viewer.numbers.textContent]`);
  await run("viewer.panes[0].pick = -1; viewer.redraw('pick')");
  if (await run("return viewer.moves")) {
    await run('viewer.slider.value = viewer.times[0]; viewer.slider.dispatchEvent(new Event("input"))');
    await shoot("slider");
    found.clock = await run("return viewer.clock.textContent");
    // Nearer to the first state than to the second one: clock, curve and numbers are those of the first one
    found.between = await run(`const [first, second] = viewer.cases[0].times; viewer.seek(first + 0.4 * (second - first));
      await new Promise(requestAnimationFrame); await new Promise(requestAnimationFrame);
      return [viewer.clock.textContent, viewer.value?.textContent.split(" at ").at(-1), viewer.plot && viewer.plot.px(first) - Number(document.querySelector(".plot circle").getAttribute("cx"))]`);
    await run("viewer.seek(viewer.times[1] * 0.5)");
    await shoot("middle");
  }
  await run('viewer.pick.value = "displacement, x"; if (viewer.pick.value) viewer.pick.dispatchEvent(new Event("change"))');
  await shoot("colour");
  found.legend = await run('return document.querySelector(".legend").textContent');
  await run('viewer.cutBox.querySelector("input").click()');
  await shoot("section");
  found.section = await run("return viewer.panes.map((p) => p.cut.used)");
  await run('viewer.choose("regions")');
  await shoot("regions");
  await run("viewer.cut(false); viewer.view.direct('front')");
  await shoot("front");
  await run('document.querySelector("header button").click()');
  await shoot("theme");
}

/** What keys, the mouse and fingers change. Each act says whether it did what it should. */
async function acts() {
  const look = () => run("const v = viewer.view; return { yaw: v.yaw, pitch: v.pitch, zoom: v.zoom, shift: [...v.shift], time: viewer.s.time, cut: viewer.s.section.on, playing: viewer.s.playing, edges: viewer.s.show.edges }");
  const [x, y] = await run('viewer.view.direct("3-D"); viewer.cut(false); viewer.canvases[0].focus(); const b = viewer.canvases[0].getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]');
  const act = async (name, does, changed) => {
    const before = await look();
    await does();
    await settle();
    const after = await look();
    found.acts[name] = changed(before, after);
    if (!found.acts[name]) console.error(name, before, after);
  };
  const press = (key) => () => browser.key(key);
  await act("arrow key turns", press("ArrowLeft"), (a, b) => b.yaw === a.yaw - 5 && b.pitch === a.pitch);
  await act("plus enlarges", press("+"), (a, b) => Math.abs(b.zoom / a.zoom - 1.1) < 1e-9);
  await act("0 fits", press("0"), (a, b) => b.zoom < a.zoom && b.yaw === a.yaw);
  await act("2 is the front", press("2"), (_, b) => b.yaw === -90 && b.pitch === 0);
  await act("s cuts", press("s"), (a, b) => b.cut && !a.cut);
  await act("s again ends the section", press("s"), (_, b) => !b.cut);
  await act("e hides the edges", press("e"), (a, b) => a.edges !== b.edges);
  await act("e shows them", press("e"), (a, b) => a.edges !== b.edges);
  await act("dragging turns", () => browser.drag([x, y], [x + 50, y + 20]), (a, b) => Math.abs(b.yaw - a.yaw + 20) < 1e-6 && Math.abs(b.pitch - a.pitch - 8) < 1e-6);
  await act("one finger turns", () => browser.pinch([[x, y]], [[x + 50, y]]), (a, b) => Math.abs(b.yaw - a.yaw + 20) < 1e-6);
  await act("two fingers enlarge", () => browser.pinch([[x - 30, y], [x + 30, y]], [[x - 60, y], [x + 60, y]]), (a, b) => Math.abs(b.zoom / a.zoom - 2) < 1e-6);
  if (await run("return viewer.moves")) {
    await run("viewer.seek(viewer.times[0])");
    await act("full stop is the next state", press("."), (a, b) => b.time > a.time);
    await act("comma is the state before", press(","), (a, b) => b.time < a.time);
    // From a place between the first two states, whatever step a browser has
    const second = await run("const [first, second] = viewer.cases.reduce((a, b) => (b.states > a.states ? b : a)).times; viewer.seek(first + 0.1 * (second - first)); viewer.slider.focus(); return second");
    await act("arrow key on the slider is the next state", press("ArrowRight"), (_, b) => b.time === second);
    await run("viewer.canvases[0].focus()");
    await act("space plays", press(" "), (_, b) => b.playing);
    await act("space stops", press(" "), (_, b) => !b.playing);
    const plot = await run('const b = document.querySelector(".plot")?.getBoundingClientRect(); return b && [b.x + b.width * 0.7, b.y + b.height / 2]');
    if (plot) await act("a click into the curve goes there", () => browser.drag(plot, plot), (a, b) => b.time > a.time);
  }
  // Cases next to each other share camera and time
  found.linked = await run(`viewer.view.direct("top"); viewer.seek(viewer.times[1]); await new Promise(requestAnimationFrame); await new Promise(requestAnimationFrame);
    return viewer.panes.map((p) => [p.state, ...p.canvas.camera.position].map((v) => Number(v.toPrecision(9))))`);
}

/** The bytes of the file that was made last. */
async function made() {
  const program = "const b = new Uint8Array(await window.last.arrayBuffer()); let s = ''; for (let k = 0; k < b.length; k += 32768) s += String.fromCharCode(...b.subarray(k, k + 32768)); return btoa(s)";
  return Buffer.from(await run(program), "base64");
}

/** Pictures of a GIF, read block by block as GIF89a describes them; −1 where it does not end with its trailer. */
function picturesOf(gif) {
  if (gif.toString("latin1", 0, 6) !== "GIF89a") return -1;
  const table = (flags) => (flags & 0x80 ? 3 * 2 ** ((flags & 7) + 1) : 0);
  let [at, count] = [13 + table(gif[10]), 0];
  const skip = () => {
    while (gif[at]) at += gif[at] + 1;
    at += 1;
  };
  for (;;) {
    const block = gif[at];
    if (block === 0x3b) return at === gif.length - 1 ? count : -1;
    if (block === 0x21) at += 2;
    else if (block === 0x2c) {
      count += 1;
      at += 11 + table(gif[at + 9]);
    } else return -1;
    skip();
  }
}

const SVG_WORDS = "return [...(await window.last.text()).matchAll(/<text[^>]*>([^<]*)/g)].map((m) => m[1])";

/** What fields of numbers take, and what pictures say of what exaggerates and colours them. */
async function numbers() {
  const type = (label, text) => run(`const f = document.querySelector('input[aria-label=${JSON.stringify(label)}]'); f.value = ${JSON.stringify(text)}; f.dispatchEvent(new Event("change"));
    for (let k = 0; k < 3; k++) await new Promise(requestAnimationFrame);
    return [f.value, viewer.endsSaid.textContent, ...viewer.s.range.map((v) => Number(v.toPrecision(6))), viewer.rangePick.value]`);
  await run("viewer.choose('displacement')");
  found.typed = [];
  for (const [end, text] of [["Upper end", "20,5"], ["Lower end", ""], ["Lower end", "30"], ["Lower end", "abc"], ["Lower end", "-Infinity"], ["Upper end", "1e400"], ["Lower end", "0,5"]]) found.typed.push([text, ...(await type(end, text))]);
  found.factors = [];
  found.picked = [];
  for (const text of ["", "2,5"]) {
    found.factors.push((await type("Factor of the displacements", text))[0]);
    found.picked.push(await run("const [c, pane] = [viewer.cases[0], viewer.panes[0]]; pane.pick = c.extremes(c.quantity('displacement'), pane.state).highAt; viewer.redraw('pick'); for (let k = 0; k < 3; k++) await new Promise(requestAnimationFrame); return viewer.readout.textContent"));
  }
  await run("viewer.choose('regions'); await viewer.out.file('svg')");
  found.words = await run(SVG_WORDS);
  found.colours = await run("return viewer.panes.flatMap((p) => [...p.regions, ...p.sets].map((r) => [r.name, r.colour.join()]))");
  found.floors = await run("return viewer.panes.flatMap((p) => Array.from(p.floors.shown.position))");
  found.box = await run("return viewer.box");
  found.checks = await run("return [...document.querySelectorAll('.group > .check')].map((c) => c.textContent)");
  found.force = await run("return viewer.forceScale.textContent");
  found.about = await run("return Object.fromEntries([...document.querySelectorAll('dt')].map((d) => [d.textContent, d.nextSibling?.textContent]))");
  await type("Factor of the displacements", "1");
  await run("viewer.choose(viewer.cases[0].quantities[0].name)");
}

async function files() {
  await run("window.saved = []; window.URL.createObjectURL = (blob) => { window.saved.push([blob.type, blob.size]); window.last = blob; return 'data:,'; }; window.HTMLAnchorElement.prototype.click = () => {}");
  await run("viewer.out.width = 800; await viewer.out.file('png')");
  await run("viewer.view.direct('3-D'); viewer.s.show.ghost = true; viewer.seek(viewer.times[1] * 0.55); await viewer.out.file('svg'); viewer.s.show.ghost = false");
  found.svg = await run("return await window.last.text()");
  if (pictures) writeFileSync(join(pictures, "view.svg"), found.svg);
  found.svg = { size: found.svg.length, shapes: found.svg.split("<path").length - 1, text: await run(SVG_WORDS) };
  if (await run("return viewer.moves")) {
    await run("viewer.s.seconds = 1; await viewer.out.file('gif')");
    found.gif = picturesOf(await made());
    await run("await viewer.out.file('webm')");
    const webm = await made();
    // The header of EBML with the type of the document
    found.webm = webm.readUInt32BE(0) === 0x1a45dfa3 && webm.subarray(0, 64).includes("webm");
  }
  found.saved = await run("return window.saved");
  found.busy = await run("return viewer.out.busy.textContent");
  if (await run("return viewer.moves")) await numbers();
}

async function drive() {
  await browser.open(pathToFileURL(resolve(page)).href);
  const paint = 'return performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? performance.getEntriesByType("paint")[0]?.startTime';
  if (process.env.PAINT) {
    for (let k = 0; k < 100 && !(found.firstPaint_ms = await run(paint)); k++) await pause(50);
    return;
  }
  await run("for (let k = 0; k < 2400 && !globalThis.viewer?.drawn; k++) await new Promise((next) => setTimeout(next, 50))");
  Object.assign(found, await run(`return { drawn: viewer.drawn, firstDraw_ms: viewer.firstDraw, title: document.title, heading: document.querySelector("h1").textContent,
    elements: document.querySelectorAll("img, iframe, object, embed, link, form").length, quantities: viewer.cases.map((c) => c.quantities.map((q) => q.name)),
    absent: viewer.cases[0].head.absent, notes: viewer.cases[0].head.notes, still: document.querySelector(".still")?.textContent }`));
  await settle();
  found.firstPaint_ms = await run(paint);
  await views();
  if (await run("return viewer.moves")) {
    found.frames_per_s = await run(`viewer.choose(viewer.cases[0].quantities[0].name); viewer.s.smooth = true; viewer.toggle(true); const from = viewer.drawn, t = performance.now();
      await new Promise((next) => setTimeout(next, 3000)); viewer.toggle(false); viewer.s.smooth = false; return (1000 * (viewer.drawn - from)) / (performance.now() - t)`);
  }
  await acts();
  await files();
  found.different = Object.keys(shots).filter((name, k, all) => k > 0 && shots[name] !== shots[all[k - 1]]);
  await settle();
}

const patience = setTimeout(() => {
  console.error("the browser did not answer within 300 s");
  browser.kill();
  process.exit(1);
}, 300_000);
try {
  await drive();
} finally {
  clearTimeout(patience);
  await browser.close();
}
console.log(JSON.stringify(found));
