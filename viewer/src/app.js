// The page: panes, controls, time, and the displayed numbers.

import { VIEWS, View } from "./camera.js";
import { MAPS, colour, css } from "./colours.js";
import { Exporter } from "./export.js";
import { Pane } from "./pane.js";
import { button, check, el, field, group, icon, numeric, row, select, slider } from "./panel.js";
import { Plot, firstColumn, label } from "./plot.js";
import { digits, number, read, rounded, scaled, ticks } from "./units.js";

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const KEYS =
  "Drag turns, Shift or the right button moves, the wheel or two fingers enlarge. Keys: arrows turn, Shift and arrows move, + and − enlarge, 0 fits, 1 to 7 are views, " +
  "space plays, comma and full stop step, S cuts, E shows edges, G the body at rest.";

/** The range that covers several ranges. */
const union = (ranges) => [Math.min(...ranges.map((r) => r[0])), Math.max(...ranges.map((r) => r[1]))];

/** Names a node or cell by its number in the mesh or, for a node whose number is not known, as a point of the page. */
const place = ({ hasOwnNumbers, nodeNumbers, cellNumbers }, isNode, k) => `${!isNode ? "cell" : hasOwnNumbers ? "point" : "node"} ${(isNode ? nodeNumbers : cellNumbers)?.[k] ?? k}`;

/** Whether a range has both signs, neither of which is negligible. */
const hasBothSigns = ([low, high]) => low < 0 && high > 0 && Math.min(-low, high) > 0.05 * Math.max(-low, high);

export class App {
  constructor(root, cases, library) {
    Object.assign(this, { cases, library });
    this.listening = new AbortController();
    const { signal } = this.listening;
    this.dirty = new Set(["all"]);
    this.view = new View(() => this.redraw("view"));
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const isDark = document.documentElement.dataset.theme ? document.documentElement.dataset.theme === "dark" : dark.matches;
    this.s = {
      time: 0, quantity: "", map: "viridis", bands: 0, range: [0, 1], fixed: "all", scale: 1, arrow: 0, smooth: false, playing: false, seconds: 5, dark: isDark, radius: 1,
      show: { body: true, edges: true, ghost: false, held: true, cables: true, rigid: true, forces: true },
      section: { on: false, axis: "y", normal: [0, 1, 0], share: 0.5, offset: 0, flip: false },
      column: "",
      state: (body) => this.#state(body),
    };
    dark.addEventListener("change", () => this.#theme(dark.matches), { signal });
    // Cases that are shown together share one axis and, far from zero, one reference point
    const isCounted = cases.some((c) => !c.rises);
    const base = cases.some((c) => c.isFar) ? cases[0].head.origin : [0, 0, 0];
    cases.forEach((c) => {
      c.along(isCounted);
      c.place(base);
    });
    this.times = [Math.min(...cases.map((c) => c.times[0] ?? 0)), Math.max(...cases.map((c) => c.times.at(-1) ?? 0))];
    this.s.time = this.times[0];
    this.moves = cases.some((c) => c.states > 1 || c.live);
    this.#build(root);
    this.#theme(isDark);
    this.#bounds();
    this.#begin();
    this.observer = new ResizeObserver(() => this.redraw("size"));
    this.canvases.forEach((canvas) => this.observer.observe(canvas.parentElement));
    addEventListener("keydown", (e) => this.#key(e), { signal });
    this.redraw("all");
  }

  /** Updates the page for new states. */
  grow() {
    this.times = [Math.min(...this.cases.map((c) => c.times[0] ?? 0)), Math.max(...this.cases.map((c) => c.times.at(-1) ?? 0))];
    const [min, max] = this.times;
    Object.assign(this.slider, { min, max });
    if (this.view.fits) this.#bounds();
    // Only the rows show which columns change
    if (this.plot && !this.hasColumn) this.columnPick.value = this.s.column = firstColumn(this.cases);
    this.redraw("all");
  }

  /** Stops listening to the window, before other cases are shown. */
  end() {
    this.listening.abort();
    this.observer.disconnect();
    this.panes = null;
    this.s.playing = false;
  }

  /** The cases to choose from, if there are more than two. */
  #choices() {
    const { all, chosen, show } = this.library;
    if (all.length <= 2) return [];
    const names = all.map((c, k) => [String(k), c.title]);
    const first = select("Case", names, String(chosen[0]), (k) => show([Number(k), ...chosen.slice(1)]));
    const second = select("Case next to it", [["", "next to it: none"], ...names], chosen.length > 1 ? String(chosen[1]) : "", (k) => show(k === "" ? [chosen[0]] : [chosen[0], Number(k)]));
    return [first, second];
  }

  /** Shows the first picture: the state farthest from rest, coloured by stretch if that is known. */
  #begin() {
    const names = this.#names();
    this.choose(["stretch", ...names, "regions"].find((n) => n === "regions" || names.includes(n)));
    const [c] = this.cases;
    const u = c.quantity("displacement");
    if (!u || !this.moves) return;
    const sizes = c.times.map((_, k) => c.extremes(u, k).high);
    this.seek(c.times[sizes.indexOf(Math.max(...sizes))]);
  }

  /** State of a case at the displayed time: a stored state, or one between two if requested. */
  #state(body) {
    const exact = body.stateAt(this.s.time);
    return this.s.smooth ? exact : Math.round(exact);
  }

  /** Names of the quantities of all cases. */
  #names() {
    return [...new Set(this.cases.flatMap((c) => c.quantities.map((q) => q.name)))];
  }

  /** Fits the view to the box of the bodies over all states. */
  #bounds() {
    const boxes = this.cases.map((c) => c.box(this.s.scale));
    const ends = (of, key) => [0, 1, 2].map((i) => of(...boxes.map((box) => box[key][i])));
    this.box = this.s.box = [ends(Math.min, "low"), ends(Math.max, "high")];
    this.view.frame(...this.box);
    this.s.radius = this.view.radius;
  }

  #build(root) {
    root.replaceChildren();
    this.canvases = this.cases.map((c, k) => {
      const label = `${c.title}: body in three dimensions. ${KEYS}`;
      return el("canvas", { tabindex: 0, role: "img", "aria-label": label, id: `canvas-${k}` });
    });
    const frames = this.canvases.map((canvas, k) => el("figure", { class: "pane" }, canvas, this.cases.length > 1 ? el("figcaption", {}, this.cases[k].title) : ""));
    this.legend = el("div", { class: "legend", "aria-hidden": "true" });
    this.readout = el("output", { class: "readout", "aria-live": "polite" });
    this.forceScale = el("div", { class: "scale", "aria-hidden": "true" });
    this.stage = el("div", { class: "stage" }, ...frames, this.legend, this.forceScale, this.readout);
    this.panel = el("aside", { class: "panel" });
    const head = el(
      "header", {}, el("h1", {}, this.cases.map((c) => c.title).join(" · ")), ...this.#choices(),
      button(icon("theme"), "Light or dark", () => this.#theme(!this.s.dark)), button(icon("menu"), "Show or hide the controls", () => root.classList.toggle("wide")),
    );
    this.foot = el("footer", {});
    root.className = "app";
    root.append(head, this.stage, this.panel, this.foot);
    this.panes = this.cases.map((c, k) => new Pane(c, this.canvases[k]));
    this.canvases.forEach((canvas, k) => {
      this.view.listen(canvas);
      this.#pick(canvas, this.panes[k]);
    });
    this.#timeControls();
    this.#panel();
  }

  #timeControls() {
    const still = [...new Set(this.cases.map((c) => c.head.still).filter(Boolean))];
    if (still.length) this.foot.append(el("p", { class: "still" }, still.join(" ")));
    if (!this.moves) return;
    this.play = button(icon("play"), "Play or pause (space)", () => this.toggle());
    this.slider = slider("Time", [...this.times, "any"], this.s.time, (t) => this.seek(t));
    this.clock = el("output", { class: "clock" });
    this.foot.append(button(icon("start"), "First state", () => this.seek(this.times[0])), button(icon("back"), "State before (comma)", () => this.step(-1)), this.play,
      button(icon("next"), "Next state (full stop)", () => this.step(1)), this.slider, this.clock);
  }

  #panel() {
    this.panel.append(this.#colourGroup());
    const columns = [...new Set(this.cases.flatMap((c) => c.curves.columns.slice(1)))];
    if (columns.length) this.panel.append(this.#curveGroup(columns));
    this.panel.append(this.#showGroup(), this.#sectionGroup());
    if (this.moves) this.panel.append(this.#motionGroup());
    this.panel.append(this.#viewGroup(), this.#exportGroup(), this.#numbersGroup(), this.#aboutGroup());
  }

  #curveGroup(columns) {
    const { s } = this;
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("class", "plot");
    svg.setAttribute("role", "img");
    this.plot = new Plot(svg, this.cases, (t) => this.seek(t));
    s.column = firstColumn(this.cases);
    this.columnPick = select("Recorded column", columns.map((c) => [c, c]), s.column, (c) => {
      s.column = c;
      this.hasColumn = true;
      this.redraw("plot");
    });
    this.value = el("output", { class: "value", "aria-live": "off" });
    return group("Recorded curves", true, this.columnPick, svg, this.value);
  }

  #colourGroup() {
    const { s } = this;
    const absent = new Map(this.cases.flatMap((c) => c.head.absent));
    const options = [...this.#names().map((n) => [n, n]), ["regions", "regions"], ["plain", "plain"]];
    for (const [name, key] of absent) if (!this.#names().includes(name)) options.push([`absent ${name}`, `${name} (not recorded)`, true, key]);
    this.pick = select("Colour by", options, "", (n) => this.choose(n));
    this.ends = [0, 1].map((k) => field(k ? "Upper end" : "Lower end", "", (text) => this.#end(k, text)));
    this.endsSaid = el("output", { class: "small", "aria-live": "polite" });
    const ranges = [["all", "of all states"], ["core", "without 1 % at each end"], ["now", "of this state"], ["own", "as given"]];
    this.rangePick = select("Range", ranges, "all", (v) => this.#fix(v));
    const hints = [...absent].filter(([name]) => !this.#names().includes(name)).map(([name, key]) => el("li", {}, `${name}: `, el("code", {}, key)));
    const more = hints.length ? [el("details", { class: "hint" }, el("summary", {}, "Other fields"), el("p", {}, "They are shown where the run has them:"), el("ul", {}, ...hints))] : [];
    this.mapPick = select("Colour map", Object.keys(MAPS).map((m) => [m, m]), s.map, (m) => {
      s.map = m;
      this.redraw("all");
    });
    return group("Colour", true, row("Colour by", this.pick), row("Map", this.mapPick),
      row("Range", this.rangePick), el("div", { class: "row" }, el("span", {}, "From, to"), ...this.ends), this.endsSaid,
      row("Bands", select("Bands of colour", [["0", "smooth"], ["6", "6"], ["8", "8"], ["10", "10"], ["16", "16"]], "0", (v) => {
        s.bands = Number(v);
        this.redraw("all");
      })), ...more);
  }

  #showGroup() {
    const { s, cases } = this;
    const has = (test) => cases.some((c) => test(c));
    const all = [
      ["body", "body", true], ["edges", "element edges", true], ["ghost", "outline at rest", has((c) => c.motion.size)], ["held", "held or moved nodes", has((c) => c.marked.some((m) => m.kind === "held"))],
      ["cables", "cables with their guides", has((c) => c.parts.some((p) => p.kind === "cable"))],
      ["rigid", "rigid bodies, obstacles, skins", has((c) => c.parts.some((p) => p.kind !== "cable"))], ["forces", "normal contact forces", has((c) => c.arrows.length)],
    ];
    this.boxes = {};
    const checks = all.filter(([, , there]) => there).map(([key, label]) => {
      const box = check(label, s.show[key], (on) => {
        s.show[key] = on;
        this.redraw("all");
      });
      this.boxes[key] = box.querySelector("input");
      return box;
    });
    const kinds = { cavity: "cavity", region: "region" };
    const regions = this.panes.flatMap((p, k) => [...p.regions, ...p.sets].filter((r) => r.kind !== "held").map((r) => {
      const amount = r.facets.length ? `${r.facets.length} faces` : `${r.points.length} nodes`;
      return check(`${cases.length > 1 ? `${k + 1}: ` : ""}${r.name} (${kinds[r.kind]}, ${amount})`, true, (on) => {
        r.visible = on;
        this.choose("regions");
      }, css(r.colour));
    }));
    this.regionList = el("details", { class: "hint", open: this.#names().length === 0 }, el("summary", {}, `${regions.length} regions`), ...regions);
    return group("Show", true, ...checks, ...(regions.length ? [this.regionList] : []));
  }

  #sectionGroup() {
    const { s } = this;
    this.cutBox = check("cut the body", false, (on) => this.cut(on));
    this.cutAt = slider("Place of the section", [0, 1, 0.005], 0.5, (v) => this.#plane({ share: v }));
    const hollow = this.cases.some((c) => !c.cells.length) ? [el("p", { class: "small" }, "The data have no inside: the body is shown hollow.")] : [];
    return group("Section", false, this.cutBox,
      row("Across", select("Direction of the section", [...Object.keys(AXES).map((a) => [a, a]), ["view", "this view"]], s.section.axis, (a) => this.#plane({ axis: a, on: true }))),
      row("Place", this.cutAt), check("other side", false, (flip) => this.#plane({ flip })), ...hollow);
  }

  #motionGroup() {
    const { s } = this;
    const largest = Math.max(...this.cases.map((c) => (c.quantity("displacement") ? c.range(c.quantity("displacement"))[1] : 0)));
    const small = largest > 0 && largest < 0.02 * this.#extent() ? [el("p", { class: "small" }, "The displacements are small; enlarge them to see the shape.")] : [];
    return group("Motion", false, row("Displacement ×", numeric("Factor of the displacements", 1, [-1e6, 1e6], (v) => {
      s.scale = v;
      if (this.view.fits) this.#bounds();
      this.redraw("all");
    })), row("Plays in [s]", numeric("Seconds that the motion plays", s.seconds, [0.2, 3600], (v) => (s.seconds = v))),
    check("in between, linear", false, (on) => {
      s.smooth = on;
      this.redraw("all");
    }), ...small);
  }

  #extent() {
    const c = this.cases[0];
    let [low, high] = [Infinity, -Infinity];
    for (let k = 0; k < 3 * c.nodes; k++) [low, high] = [Math.min(low, c.rest[k]), Math.max(high, c.rest[k])];
    return high - low;
  }

  #viewGroup() {
    const buttons = Object.keys(VIEWS).map((name) => button(name, `View: ${name}`, () => this.view.direct(name)));
    return group("View", false, el("div", { class: "buttons" }, ...buttons, button("fit", "Fit (0)", () => this.view.fit())), el("p", { class: "small" }, KEYS));
  }

  #exportGroup() {
    this.out = new Exporter(this, {
      update: () => this.#update(), clock: () => this.#clockText(), quantity: () => this.#quantity(), scaled: () => this.#scaled(), arrow: (width, height) => this.#forceArrow(width, height),
    });
    return this.out.group();
  }

  #numbersGroup() {
    this.numbers = el("table", {});
    return group("Numbers of this state", false, this.numbers);
  }

  #aboutGroup() {
    const facts = this.cases.flatMap((c, k) => [
      ...(this.cases.length > 1 ? [el("dt", { class: "title" }, `${k + 1}: ${c.title}`)] : []),
      ...c.head.facts.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]),
      ...(c.states > 1 && !c.live ? [el("dt", {}, "error of the positions"), el("dd", {}, `at most ${this.#length(c.motion.error)} at any node and state (${c.motion.shapes.length} principal modes for ${c.states} states)`)] : []),
      ...(c.states > 1 && !c.live && c.quantity("stretch") ? [el("dt", {}, "error of the colours"), el("dd", {}, this.#errors(c))] : []),
    ]);
    const notes = this.cases.flatMap((c) => c.head.notes).map((n) => el("li", {}, n));
    return group("About", notes.length > 0, notes.length ? el("ul", { class: "notes" }, ...notes) : "", el("dl", {}, ...facts));
  }

  #length(v) {
    const { unit, factor } = scaled("m", v);
    return `${number(v * factor, 2)} ${unit}`;
  }

  /** The stated error of every stored field. */
  #errors(c) {
    const stored = new Map(c.quantities.filter((q) => q.modes !== c.motion).map((q) => [q.modes, q]));
    return [...stored.values()].map((q) => `${q.field} ${number(q.modes.error, 2)}${q.unit ? ` ${q.unit}` : ""}`).join(", ");
  }

  /** Colours by a quantity, the regions, or nothing. */
  choose(name) {
    const { s } = this;
    s.quantity = name;
    this.pick.value = name;
    const q = this.#quantity();
    const range = q ? this.#range("all") : [0, 1];
    const isSigned = q?.signed && hasBothSigns(range);
    if (isSigned && s.map === "viridis") this.mapPick.value = s.map = "blue–orange";
    if (!isSigned && s.map === "blue–orange") this.mapPick.value = s.map = "viridis";
    if (name === "regions") this.regionList.open = true;
    this.#fix(s.fixed === "own" ? "all" : s.fixed);
  }

  #quantity() {
    return this.cases.map((c) => c.quantity(this.s.quantity)).find(Boolean);
  }

  /** Range of the colours over all cases; symmetric about zero if the values have both signs. */
  #range(fixed) {
    const own = this.cases.filter((c) => c.quantity(this.s.quantity));
    const of = (c) => {
      const q = c.quantity(this.s.quantity);
      if (fixed === "all") return c.range(q);
      if (fixed === "core") return c.core(q);
      const found = c.extremes(q, this.s.state(c));
      return [found.low, found.high];
    };
    let [low, high] = union(own.map(of));
    if (!Number.isFinite(low)) return [0, 1];
    if (this.#quantity().signed && hasBothSigns([low, high])) [low, high] = [-Math.max(-low, high), Math.max(-low, high)];
    return [low, high];
  }

  #scaled() {
    const q = this.#quantity();
    return q ? scaled(q.unit, Math.max(...this.s.range.map(Math.abs))) : { unit: "", factor: 1 };
  }

  /** Where the range of the colours comes from. */
  #fix(fixed) {
    this.rangePick.value = this.s.fixed = fixed;
    this.endsSaid.textContent = "";
    this.redraw("all");
  }

  /** Accepts a typed end of the range; invalid text is reported, and the previous end is kept. */
  #end(k, text) {
    const { unit, factor } = this.#scaled();
    const range = this.s.range.map((end, i) => (i === k ? read(text) / factor : end));
    const isBelow = range[0] < range[1];
    if (isBelow && range.every(Number.isFinite)) {
      this.s.range = range;
      return this.#fix("own");
    }
    const other = `${number(this.s.range[1 - k] * factor)} ${unit}`.trim();
    this.endsSaid.textContent = Number.isFinite(range[k]) ? `${text} is not ${k ? "above" : "below"} the other end, ${other}; change that first.` : `“${text}” is no number.`;
    this.#legend();
  }

  cut(on) {
    this.cutBox.querySelector("input").checked = on;
    this.#plane({ on });
  }

  #plane(change) {
    const c = Object.assign(this.s.section, change);
    if (change.on) this.cutBox.querySelector("input").checked = true;
    if (c.axis !== "view" || change.axis) c.normal = (AXES[c.axis] ?? this.view.axes().eye).map((v) => (c.flip && AXES[c.axis] ? -v : v));
    const [low, high] = this.box;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].reduce((sum, i) => sum + c.normal[i] * (k & (1 << i) ? high[i] : low[i]), 0));
    const share = c.flip && AXES[c.axis] ? 1 - c.share : c.share;
    c.offset = Math.min(...corners) + share * (Math.max(...corners) - Math.min(...corners));
    this.redraw("all");
  }

  #theme(dark) {
    this.s.dark = dark;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    this.redraw("all");
  }

  seek(t) {
    this.s.time = Math.min(this.times[1], Math.max(this.times[0], t));
    if (this.slider) this.slider.value = this.s.time;
    this.redraw("time");
  }

  /** Goes to the stored state before or after the displayed one. */
  step(by) {
    const longest = this.cases.reduce((a, b) => (b.states > a.states ? b : a));
    const k = Math.round(longest.stateAt(this.s.time)) + by;
    this.seek(longest.times[Math.min(longest.states - 1, Math.max(0, k))]);
  }

  toggle(on = !this.s.playing) {
    this.s.playing = on;
    this.play.replaceChildren(icon(on ? "pause" : "play"));
    if (!on) return this.redraw("time");
    if (this.s.time >= this.times[1]) this.seek(this.times[0]);
    let past = performance.now();
    const advance = (now) => {
      if (!this.s.playing) return;
      const t = this.s.time + ((now - past) / 1000 / this.s.seconds) * (this.times[1] - this.times[0]);
      past = now;
      this.seek(t > this.times[1] ? this.times[0] : t);
      requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
  }

  #key(e) {
    if (/^(INPUT|SELECT|TEXTAREA)$/.test(e.target.tagName) && e.target.type !== "range" && e.target.type !== "checkbox") return;
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    // Browsers differ in the step of a continuous slider
    const by = e.target === this.slider ? { ArrowLeft: -1, ArrowDown: -1, PageDown: -10, ArrowRight: 1, ArrowUp: 1, PageUp: 10 }[e.key] : 0;
    if (by) {
      e.preventDefault();
      return this.step(by);
    }
    const views = Object.keys(VIEWS);
    const flip = (key) => this.boxes[key]?.click();
    const act = {
      " ": () => this.moves && this.toggle(), ",": () => this.step(-1), ".": () => this.step(1), 0: () => this.view.fit(), s: () => this.cut(!this.s.section.on),
      e: () => flip("edges"), g: () => flip("ghost"),
    }[e.key.toLowerCase()];
    if (act && !(e.key === " " && /^(BUTTON|SUMMARY|INPUT)$/.test(e.target.tagName))) {
      e.preventDefault();
      act();
    } else if (views[Number(e.key) - 1]) this.view.direct(views[Number(e.key) - 1]);
  }

  /** A click, not a drag, names the node under the pointer with its value. */
  #pick(canvas, pane) {
    let from = null;
    canvas.addEventListener("pointerdown", (e) => (from = [e.clientX, e.clientY]));
    canvas.addEventListener("pointerup", (e) => {
      if (!from || Math.hypot(e.clientX - from[0], e.clientY - from[1]) > 3) return;
      const box = canvas.getBoundingClientRect();
      const { section } = this.s;
      pane.pick = pane.nodeAt(this.view, e.clientX - box.left, e.clientY - box.top, section.on ? [...section.normal, section.offset] : null);
      this.redraw("pick");
    });
  }

  redraw(why) {
    this.dirty.add(why);
    if (!this.waiting) {
      this.waiting = true;
      requestAnimationFrame(() => this.draw());
    }
  }

  draw() {
    this.waiting = false;
    const { s, dirty } = this;
    const has = (...why) => why.some((w) => dirty.has(w) || dirty.has("all"));
    if (!this.panes) return;
    if (has("size")) this.#resize();
    // Between two states, playing only moves the slider
    const moved = has("pick") || this.panes.some((p) => p.state !== s.state(p.body));
    if (moved) this.#update();
    // With software rendering, text, tables and curves cost more than the picture: while the motion plays they are updated ten times a second
    const now = performance.now();
    const speaks = !s.playing || has("pick", "plot", "size") || now - (this.spoken ?? 0) > 100;
    if (speaks) this.spoken = now;
    if (has("time", "pick") && speaks) this.#words();
    if (has("time") && (s.fixed === "now" || has("all"))) this.#legend();
    if (moved || has("size", "view")) {
      this.panes.forEach((p) => p.draw(this.view));
      this.#showForceScale();
      this.drawn = (this.drawn ?? 0) + 1;
    }
    if (this.plot && has("size", "plot")) this.plot.draw(s.column);
    if (this.plot && has("time", "plot", "size") && speaks) this.#mark();
    dirty.clear();
    this.firstDraw ??= performance.now();
  }

  /** Updates the views to the displayed state. */
  #update() {
    const { s } = this;
    if (this.#quantity() && s.fixed !== "own") s.range = this.#range(s.fixed);
    // The arrow of the largest force over all cases and states is a quarter of the radius long
    const largest = this.#largestForce();
    s.arrow = largest > 0 ? (0.25 * s.radius) / largest : 0;
    this.panes.forEach((p) => p.update(s));
  }

  #largestForce() {
    return Math.max(...this.cases.map((c) => c.arrows[0]?.largest ?? 0));
  }

  /** A reference arrow for a round force at the scale of a picture of this size: its length in pixels, its colour and its label; nothing if there are no
  forces. */
  #forceArrow(width, height) {
    const pixels = this.s.arrow * this.view.scale(width, height);
    const [arrows] = this.cases.flatMap((c) => c.arrows);
    if (!this.s.show.forces || !(pixels > 0)) return null;
    const force = rounded(Math.min(this.#largestForce(), (0.2 * width) / pixels));
    const { unit, factor } = scaled(arrows.unit, force);
    return { length: force * pixels, colour: css(this.panes[0].forceColour), text: `${arrows.name} ${number(force * factor)} ${unit}` };
  }

  #showForceScale() {
    const { clientWidth: w, clientHeight: h } = this.canvases[0];
    const arrow = this.#forceArrow(w, h);
    this.forceScale.replaceChildren();
    if (!arrow) return;
    const line = el("i");
    line.style.width = `${arrow.length}px`;
    this.forceScale.style.color = arrow.colour;
    this.forceScale.append(line, el("span", {}, arrow.text));
  }

  #resize() {
    this.canvases.forEach((canvas, k) => {
      const { clientWidth: w, clientHeight: h } = canvas.parentElement;
      this.panes[k].canvas.resize(Math.max(1, w), Math.max(1, h));
    });
  }

  #legend() {
    const q = this.#quantity();
    this.legend.replaceChildren();
    this.ends.forEach((e) => (e.disabled = !q));
    if (!q) return;
    const { s } = this;
    const { unit, factor } = this.#scaled();
    const [low, high] = s.range;
    const steps = s.bands || 32;
    const grades = Array.from({ length: steps }, (_, k) => {
      const c = css(colour(s.map, s.bands ? (k + 0.5) / steps : k / (steps - 1)));
      return s.bands ? `${c} ${(100 * k) / steps}% ${(100 * (k + 1)) / steps}%` : c;
    });
    const bar = el("div", { class: "bar" });
    bar.style.background = `linear-gradient(to top, ${grades.join(",")})`;
    for (const { value, text } of ticks(low * factor, high * factor)) {
      const tick = el("span", {}, text);
      tick.style.bottom = `${(100 * (value / factor - low)) / (high - low || 1)}%`;
      bar.append(tick);
    }
    this.legend.append(el("b", {}, unit ? `${q.name} [${unit}]` : q.name), bar);
    this.ends.forEach((e, k) => (e.value = number(s.range[k] * factor)));
  }

  /** Time and numbers of the state as text, also for screen readers. */
  #words() {
    const { s } = this;
    if (this.clock) this.clock.textContent = this.#clockText();
    if (this.slider) this.slider.setAttribute("aria-valuetext", this.#clockText());
    this.readout.textContent = this.panes.map((p) => this.#picked(p)).filter(Boolean).join(" · ");
    if (s.playing) return;
    const line = (...cells) => el("tr", {}, ...cells.map((c, k) => el(k ? "td" : "th", {}, c)));
    const lines = this.cases.flatMap((c, k) => {
      const state = s.state(c);
      const name = this.cases.length > 1 ? `${k + 1}: ` : "";
      const only = c.curves.columns.length ? c.timeText(state) : "the only one";
      const own = [line(`${name}state`, c.states > 1 ? `${number(state + 1)} of ${c.states}, ${c.timeText(state)}` : only)];
      for (const q of [...new Set([c.quantity("displacement"), c.quantity(s.quantity)])].filter(Boolean)) {
        const found = c.extremes(q, state);
        const { unit, factor } = scaled(q.unit, Math.max(Math.abs(found.low), Math.abs(found.high)));
        const ends = [["low", ""], ["high", unit && ` ${unit}`]].map(([end, unit]) => `${number(found[end] * factor)}${unit} (${place(c, q.nodal, found[`${end}At`])})`);
        own.push(line(`${name}${q.name}`, found.highAt < 0 ? "no values" : ends.join(" to ")));
      }
      for (const col of c.curves.columns.slice(1)) {
        const { words, unit } = label([c], col);
        own.push(line(`${name}${words}`, `${number(c.recordedAt(col, state))} ${unit}`));
      }
      return own;
    });
    this.numbers.replaceChildren(...lines);
  }

  /** The times of the displayed states, each once; with the number of the state if time does not increase. */
  #clockText(cases = this.cases.filter((c) => c.states > 1 || c.live)) {
    const words = cases.map((c) => {
      const state = this.s.state(c);
      return `${c.isCounted ? `state ${number(state + 1)}, ` : ""}${c.timeText(state)}`;
    });
    return [...new Set(words)].join(" · ");
  }

  #picked(pane) {
    if (pane.pick < 0) return "";
    const { body, pick: p } = pane;
    // Drawn displacements may be exaggerated
    const x = this.s.scale === 1 ? pane.x : body.positions(pane.state, 1);
    const coordinates = [0, 1, 2].map((i) => body.base[i] + x[3 * p + i]);
    const size = Math.max(...coordinates.map(Math.abs));
    const { unit, factor } = scaled("m", size);
    const at = coordinates.map((v) => number(v * factor, digits(size, 0.01 * body.extent))).join(", ");
    const q = body.quantity(this.s.quantity);
    let text = `${place(body, true, p)} at (${at}) ${unit}`;
    if (q?.nodal) {
      const own = scaled(q.unit, Math.abs(pane.values[p]));
      text += `, ${q.name} ${number(pane.values[p] * own.factor)} ${own.unit}`;
    }
    return text;
  }

  #mark() {
    const { s } = this;
    this.plot.mark(s.state);
    const { words, unit } = label(this.cases, s.column);
    const own = this.cases.filter((c) => c.curves.columns.includes(s.column));
    const values = own.map((c) => `${number(c.recordedAt(s.column, s.state(c)))} ${unit}`);
    this.value.textContent = `${words}: ${values.join(" · ")} at ${this.#clockText(own)}`;
    this.plot.svg.setAttribute("aria-label", this.value.textContent);
  }
}
