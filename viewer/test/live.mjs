// Opens the live view of a run that waits at its first state in headless Chromium, drives the run as a user would, and prints what it found as JSON.
//
//     node viewer/test/live.mjs address [folder for pictures]
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { start } from "./chromium.mjs";

const [address, pictures] = process.argv.slice(2);
const found = { errors: [], requests: [] };
const browser = await start(found);
const patience = setTimeout(() => {
  console.error("the browser did not answer within 120 s");
  browser.kill();
  process.exit(1);
}, 120_000);

const shots = {};
async function picture(name) {
  await browser.run("for (let k = 0; k < 4; k++) await new Promise(requestAnimationFrame)");
  shots[name] = await browser.picture();
  if (pictures) writeFileSync(join(pictures, `${name}.png`), Buffer.from(shots[name], "base64"));
}

/** Waits for a condition in the page. */
const until = (condition) => browser.run(`for (let k = 0; k < 1200 && !(${condition}); k++) await new Promise((next) => setTimeout(next, 50));
  if (!(${condition})) throw new Error("in vain: " + ${JSON.stringify(condition)} + ": " + document.body.innerText.slice(0, 300))`);
const words = () => browser.run("return live.panel.state.textContent");
const press = (label) => browser.run(`document.querySelector('button[aria-label=${JSON.stringify(label)}]').click()`);

/** Types a text into the field of the signal; what the field and the panel say then. */
const type = (text) => browser.run(`const [field, said, slide] = ["input[type=text]", "output", "input[type=range]"].map((part) => document.querySelector(".signals " + part));
  field.value = ${JSON.stringify(text)}; field.dispatchEvent(new Event("change"));
  return [field.value, said.textContent, slide.getAttribute("aria-valuetext")]`);

try {
  // A page that finds no place says so, and comes in when others have gone
  const crowd = new AbortController();
  await Promise.all(Array.from({ length: 16 }, () => fetch(`${address}events`, { signal: crowd.signal })));
  await browser.open(address);
  await until('document.getElementById("state")?.textContent.includes("too many pages are open")');
  crowd.abort();
  await until("globalThis.viewer?.drawn && live.news.waiting");
  found.errors = found.errors.filter((text) => !text.includes("503"));
  found.begins = await words();
  await picture("paused");
  found.typed = {};
  for (const text of ["1,5", "", "abc", "7 mm", "99"]) found.typed[text] = await type(text);
  await until("live.news.signals[0].value === live.news.signals[0].range[1]");
  await type("0");
  await until("live.news.signals[0].value === 0");
  // The slider, by its input event as a hand moves it
  await browser.run('const s = document.querySelector(".group input[type=range]"); s.value = s.max; s.dispatchEvent(new Event("input"))');
  await until("live.news.signals[0].value > 0");
  await press("Take one step and pause");
  await until("live.body.states === 2 && live.news.waiting");
  // The newest state is shown with the next picture
  await until("viewer.clock.textContent === 't = 0.25 s'");
  found.stepped = await words();
  found.step = await browser.run("return live.panel.step.textContent");
  found.clock = await browser.run("return viewer.clock.textContent");
  await picture("stepped");
  // An earlier state stays while the run goes on
  await browser.run("viewer.seek(0)");
  await press("Take one step and pause");
  await until("live.body.states === 3 && live.news.waiting");
  found.looksBack = await browser.run("return viewer.clock.textContent");
  // A message that is older than the rows that come after it
  await browser.run("live.body.rows.clear(); live.rows = 0; live.source.onmessage({ data: JSON.stringify({ ...live.news, rows: { stride: 2, count: 1 } }) })");
  await until("live.body.rows.size === 3");
  // Near its end the slider shows the newest state, which is followed again
  found.follows = await browser.run("const before = live.follows; viewer.seek(0.99 * viewer.times[1]); return [before, live.follows]");
  await press("Pause the run, or let it go on");
  await until("live.news.ended && live.source.readyState === 2");
  found.ended = await words();
  found.title = await browser.run("return document.title");
  // The same news of a case of a study
  await browser.run("live.panel.settings.case = true; live.panel.update(live.news, live.iterations)");
  found.case = await words();
  found.states = await browser.run("return live.body.states");
  found.rows = await browser.run("return [...live.body.rows].sort(([a], [b]) => a - b).map(([, row]) => row)");
  found.positions = await browser.run("return Array.from(live.body.positions(live.body.states - 1, 1))");
  await picture("ended");
  // The page stays usable when the server has gone
  await new Promise((next) => setTimeout(next, 3500));
  await browser.run("viewer.seek(viewer.times[0])");
  await picture("back");
  found.disabled = await browser.run("return live.panel.pause.disabled");
  // Of a run that keeps every hundredth state, the page keeps the last one too
  await browser.run("const [first] = live.body.kept; live.body.take(...first, { stride: 100, count: live.body.states })");
  found.kept = await browser.run("return [...live.body.kept.keys()].sort((a, b) => a - b)");
  found.different = Object.keys(shots).filter((name, k, all) => k > 0 && shots[name] !== shots[all[k - 1]]);
  console.log(JSON.stringify(found));
} finally {
  clearTimeout(patience);
  await browser.close();
}
