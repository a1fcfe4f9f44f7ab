// Starts the viewer: reads the cases and shows them.

import { App } from "./app.js";
import { readCases } from "./data.js";

readCases().then((cases) => {
  globalThis.viewer = new App(document.getElementById("viewer"), cases);
});
