// Starts the viewer: reads the cases and shows one, two or all of them; or the run that goes on.

import { App } from "./app.js";
import { readCases } from "./data.js";
import { Live } from "./live.js";
import { LiveCase } from "./live-case.js";

const settings = document.getElementById("live");

readCases(settings ? LiveCase : undefined).then((all) => {
  const root = document.getElementById("viewer");
  let app = null;
  const show = (chosen) => {
    app?.end();
    // For those who look with the tools of the browser, and for tests
    globalThis.viewer = app = new App(root, chosen.map((k) => all[k]), { all, chosen, show });
    return app;
  };
  if (settings) {
    globalThis.live = new Live(all[0], JSON.parse(settings.textContent), () => show([0]));
    return;
  }
  // Two cases are next to each other; of more than two the reader chooses
  show(all.length > 2 ? [0] : all.map((_, k) => k));
});
