// Starts the viewer: reads the cases and shows one, two or all of them.

import { App } from "./app.js";
import { listCases } from "./data.js";

const all = listCases();
const root = document.getElementById("viewer");
let app = null;
let wanted = null;
const show = async (chosen) => {
  wanted = chosen;
  const cases = await Promise.all(chosen.map((k) => all[k].read()));
  // Something else was chosen while these were read
  if (wanted !== chosen) return;
  app?.end();
  // For those who look with the tools of the browser, and for tests
  globalThis.viewer = app = new App(root, cases, { all, chosen, show });
};
// Two cases are next to each other; of more than two the reader chooses
show(all.length > 2 ? [0] : all.map((_, k) => k));
