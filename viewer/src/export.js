// Export of pictures and movies of the current views as files.

import { css } from "./colours.js";
import { button, el, group, numeric, row, select } from "./panel.js";
import { compose, gif, png, save, webm } from "./picture.js";
import { number } from "./units.js";
import { svg } from "./vector.js";

export class Exporter {
  /** `shown` has functions of the page: to update the views to a time, and to get the time as text, the quantity, its unit, and the reference arrow of
  the forces. */
  constructor(app, shown) {
    Object.assign(this, { app, shown, width: 2400, background: "white", running: false });
    this.busy = el("output", { class: "small", "aria-live": "polite" });
  }

  /** The controls. */
  group() {
    const width = numeric("Width of the picture", this.width, [200, 8000], (v) => (this.width = Math.round(v)));
    const paper = select("Background", [["white", "white"], ["dark", "dark"], ["none", "transparent"]], "white", (v) => (this.background = v));
    const file = (name, words, kind) => button(name, words, () => this.file(kind));
    const movies = this.app.moves ? [file("GIF", "Motion as GIF", "gif"), file("WebM", "Motion as WebM", "webm")] : [];
    return group("Export", false, row("Width [px]", width), row("Background", paper), el("div", { class: "buttons" }, file("PNG", "This view as PNG", "png"),
      file("SVG", "This view as SVG: lines and text for a paper", "svg"), ...movies), this.busy);
  }

  /** The legend of a picture: the colour bar of the quantity, or the regions with their colours. */
  #legend() {
    const { s, panes } = this.app;
    const q = this.shown.quantity();
    if (q) {
      const { unit, factor } = this.shown.scaled();
      return { map: s.map, bands: s.bands, range: s.range.map((v) => v * factor), title: unit ? `${q.name} [${unit}]` : q.name };
    }
    const regions = s.quantity === "regions" ? panes.flatMap((p) => p.seen) : [];
    const entries = new Map(regions.map((r) => [`${r.name} ${css(r.colour)}`, { name: r.name, colour: css(r.colour) }]));
    return entries.size ? { title: "regions", entries: [...entries.values()] } : null;
  }

  /** Settings of a picture of the current views. */
  #picture(width, fine) {
    const { canvases, moves, s } = this.app;
    const { clientWidth: w, clientHeight: h } = canvases[0];
    const ink = this.background === "dark" ? "#eee" : "#111";
    const background = { white: "#fff", dark: "#14181d", none: null }[this.background];
    return {
      width, background, ink, fine, aspect: w / h, shown: w, size: { width: w, height: h },
      words: [moves ? this.shown.clock() : "", s.scale === 1 ? "" : `displacements × ${number(s.scale)}`].filter(Boolean).join(", "),
      arrow: this.shown.arrow, legend: this.#legend(),
    };
  }

  /** A single view as the data URL of a picture. */
  #alone(pane) {
    const canvas = document.createElement("canvas");
    compose(canvas, [pane], this.app.view, { ...this.#picture(this.width, true), background: null, legend: null, arrow: () => null, words: "" });
    return canvas.toDataURL("image/png");
  }

  /** A movie over all times. */
  #movie(kind, canvas, paint) {
    const { app } = this;
    const { s } = app;
    const longest = Math.max(...app.cases.map((c) => c.states));
    const count = s.smooth ? 60 : Math.min(longest, 120);
    const wait = (1000 * s.seconds) / count;
    const at = (k) => app.times[0] + (count > 1 ? k / (count - 1) : 0) * (app.times[1] - app.times[0]);
    const width = Math.min(this.width, kind === "gif" ? 900 : 1600) & ~1;
    const frame = async (k) => {
      this.busy.textContent = `${kind}: picture ${k + 1} of ${count}`;
      paint(at(k), width);
    };
    return (kind === "gif" ? gif : webm)(canvas, count, wait, frame);
  }

  /** Makes a picture, or a movie over all times, and offers it for download. */
  async file(kind) {
    if (this.running) return null;
    this.running = true;
    const { app } = this;
    app.toggle && app.play && app.toggle(false);
    const canvas = document.createElement("canvas");
    const [was, time] = [app.s.dark, app.s.time];
    app.s.dark = this.background === "dark";
    const paint = (t, width) => {
      app.s.time = t;
      this.shown.update();
      compose(canvas, app.panes, app.view, this.#picture(width, kind === "png"));
    };
    let blob = null;
    try {
      if (kind === "png") {
        paint(time, this.width);
        blob = await png(canvas);
      } else if (kind === "svg") {
        paint(time, this.width);
        blob = new Blob([svg(app.panes, app.view, this.#picture(this.width), (pane) => this.#alone(pane))], { type: "image/svg+xml" });
      } else {
        blob = await this.#movie(kind, canvas, paint);
      }
      const title = app.cases.map((c) => c.title).join("-").replace(/[^\p{L}\p{N}]+/gu, "-").slice(0, 60).replace(/^-|-$/g, "") || "view";
      save(blob, `${title}.${kind}`);
      this.busy.textContent = `${title}.${kind}, ${number(blob.size / 1e6, 2)} MB`;
    } catch (error) {
      this.busy.textContent = error.message;
    } finally {
      [app.s.dark, this.running] = [was, false];
      app.seek(time);
      app.redraw("all");
    }
    return blob;
  }
}
