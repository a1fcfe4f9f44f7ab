// Controls of the live view: pause and step, signals, time, step size and iterations.

import { button, el, field, group, row, slider } from "./panel.js";
import { digits, number, read, scaled } from "./units.js";

const svg = (name, attributes, text) => {
  const out = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) out.setAttribute(key, value);
  if (text) out.textContent = text;
  return out;
};

/** Number of positions of a slider, of which the first and the last are the ends of its range. */
const STEPS = 500;

export class LivePanel {
  constructor(settings, command) {
    Object.assign(this, { settings, command, signals: new Map() });
    this.state = el("output", { class: "live", "aria-live": "polite" });
    this.step = el("output", { class: "value", "aria-live": "off" });
    this.plot = svg("svg", { class: "plot low", role: "img", viewBox: "0 0 300 110", "aria-label": "Error of the forces over the iterations" });
    this.pause = button("Pause", "Pause the run, or let it go on", () => command({ name: this.paused ? "resume" : "pause" }));
    this.one = button("One step", "Take one step and pause", () => command({ name: "step" }));
    this.buttons = el("div", { class: "buttons" }, this.pause, this.one);
    this.list = el("div", { class: "signals" });
    const note = settings.recorded ? [el("p", { class: "small" }, `A value takes effect at the next step, and is recorded in ${settings.recorded}.`)] : [];
    this.element = group("Run", true, this.state, this.buttons, this.list, ...note, this.step, this.plot);
  }

  /** Inserts the controls as the first group of a panel. */
  place(panel) {
    panel.prepend(this.element);
  }

  say(text) {
    this.state.textContent = text;
  }

  /** Shows that the run has ended. */
  end(text) {
    this.say(text);
    for (const input of this.element.querySelectorAll("button, input")) input.disabled = true;
  }

  update(news, iterations) {
    const { t, end, paused, waiting, ended } = news;
    const last = iterations.at(-1);
    if (t !== this.past) [this.gap, this.past] = [t - this.past, t];
    const precise = (time) => number(time, digits(time, last?.[2] ?? this.gap));
    const at = `t = ${precise(t)} of ${precise(end)} s`;
    this.paused = paused;
    this.pause.textContent = paused ? "Go on" : "Pause";
    const [whole, next] = this.settings.case ? ["case", "; load the page again to see the case that runs then"] : ["run", ""];
    if (ended) this.end(`The ${whole} has ended: ${ended.status}${ended.detail ? ` (${ended.detail})` : ""}, ${at}. All states that have come stay${next}.`);
    else this.say(waiting ? `Paused at ${at}` : paused ? `Pauses after this step, ${at}` : `Running, ${at}`);
    this.#signals(news.signals);
    this.step.textContent = last ? `step to t = ${precise(last[1])} s, step size ${number(last[2])} s, iteration ${last[3]}, error ${number(last[4], 2)} × tolerance` : "";
    this.#iterations(iterations);
    this.plot.style.display = last ? "" : "none";
  }

  #signals(signals) {
    for (const signal of signals) {
      const known = this.signals.get(signal.name) ?? this.#signal(signal);
      known.value = signal.value;
      // A value that is being typed is not overwritten; a value set by another page is shown
      if (document.activeElement !== known.text && document.activeElement !== known.slide) known.show(signal.value);
    }
  }

  /** The inputs of a signal, in the unit that fits its range. */
  #signal({ name, words, unit: si, value, range }) {
    const size = range ? Math.max(...range.map(Math.abs)) : Math.max(Math.abs(value), 1e-3);
    const { unit, factor } = scaled(si, size);
    const label = `${words}${unit ? ` [${unit}]` : ""}`;
    const shown = (v) => `${number(v * factor)}${unit ? ` ${unit}` : ""}`;
    const said = el("output", { class: "small", "aria-live": "polite" });
    const set = (v) => {
      known.value = v;
      known.show(v);
      this.command({ set: { signal: name, value: v } });
    };
    const text = field(label, "", (t) => {
      const v = read(t) / factor;
      const taken = range ? Math.min(range[1], Math.max(range[0], v)) : v;
      if (!Number.isFinite(v)) {
        said.textContent = `“${t}” is no number; write one${unit ? ` in ${unit}` : ""}, such as ${number(known.value * factor)}.`;
        return known.show(known.value);
      }
      said.textContent = taken === v ? "" : `The range is ${shown(range[0])} to ${shown(range[1])}; ${shown(taken)} is taken.`;
      set(taken);
    });
    const slide = range && slider(label, [0, STEPS, 1], 0, (k) => {
      said.textContent = "";
      set(k === STEPS ? range[1] : range[0] + (k / STEPS) * (range[1] - range[0]));
    });
    const known = {
      text, slide, value,
      show: (v) => {
        text.value = number(v * factor);
        if (!slide) return;
        slide.value = Math.round(((v - range[0]) / (range[1] - range[0])) * STEPS);
        slide.setAttribute("aria-valuetext", shown(v));
      },
    };
    known.show(value);
    this.signals.set(name, known);
    this.list.append(row(label, text), ...(slide ? [slide] : [el("p", { class: "small" }, "The scene declares no range; the key is `range`.")]), said);
    return known;
  }

  /** Errors of the last iterations on a logarithmic axis, one line for each attempted step. */
  #iterations(iterations) {
    this.plot.replaceChildren();
    const log = ([, , , , error]) => Math.log10(Math.max(error, 1e-9));
    const values = iterations.map(log);
    const [low, high] = [Math.min(-1, ...values), Math.max(1, ...values)];
    const [x, y] = [(k) => 34 + (k / Math.max(1, iterations.length - 1)) * 256, (v) => 98 - ((v - low) / (high - low)) * 80];
    this.plot.append(svg("text", { x: 4, y: 12 }, "error of the forces / tolerance"));
    for (let v = Math.ceil(low); v <= high; v += Math.max(1, Math.ceil((high - low) / 4))) {
      this.plot.append(svg("line", { class: "grid", x1: 34, x2: 290, y1: y(v), y2: y(v) }), svg("text", { x: 30, y: y(v) + 4, "text-anchor": "end" }, `1e${v}`));
    }
    this.plot.append(svg("line", { class: "now", x1: 34, x2: 290, y1: y(0), y2: y(0) }));
    let points = [];
    const draw = () => {
      if (points.length) this.plot.append(svg("polyline", { class: "curve curve-0", stroke: "#0072b2", points: points.join(" ") }));
      points = [];
    };
    iterations.forEach((iteration, k) => {
      if (iteration[3] === 0) draw();
      points.push(`${x(k).toFixed(1)},${y(values[k]).toFixed(1)}`);
    });
    draw();
  }
}
