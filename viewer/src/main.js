// Starts the viewer: reads the cases and shows one, two or all of them, or follows the live run.

import { App } from "./app.js";
import { listCases } from "./data.js";
import { Live } from "./live.js";
import { LiveCase } from "./live-case.js";

const settings = document.getElementById("live");
const all = listCases(settings ? LiveCase : undefined);
const root = document.getElementById("viewer");
let app = null;
let wanted = null;
const open = (cases, chosen) => {
  app?.end();
  // For the developer tools of the browser, and for tests
  globalThis.viewer = app = new App(root, cases, { all, chosen, show });
  return app;
};
const show = async (chosen) => {
  wanted = chosen;
  const cases = await Promise.all(chosen.map((k) => all[k].read()));
  // The selection may have changed while these were read
  if (wanted === chosen) open(cases, chosen);
};
if (settings) {
  all[0].read().then((only) => {
    globalThis.live = new Live(only, JSON.parse(settings.textContent), () => open([only], [0]));
  });
} else {
  // Two cases are shown next to each other; with more than two the reader chooses
  show(all.length > 2 ? [0] : all.map((_, k) => k));
}
