// Starts the viewer: reads the cases and shows one, two or all of them.

import { App } from "./app.js";
import { readCases } from "./data.js";

readCases().then((all) => {
  const root = document.getElementById("viewer");
  let app = null;
  const show = (chosen) => {
    app?.end();
    // For those who look with the tools of the browser, and for tests
    globalThis.viewer = app = new App(root, chosen.map((k) => all[k]), { all, chosen, show });
  };
  // Two cases are next to each other; of more than two the reader chooses
  show(all.length > 2 ? [0] : all.map((_, k) => k));
});
