// A plot of a recorded column over time, with a mark at the displayed state.

import { ticks } from "./units.js";
import { PALETTE, css } from "./colours.js";

const NS = "http://www.w3.org/2000/svg";

const node = (name, attributes, text) => {
  const out = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) out.setAttribute(key, value);
  if (text !== undefined) out.textContent = text;
  return out;
};

/** Change of a column, relative to the largest number in its unit, below which it is rounding. */
const ROUNDING = 1e-5;

/** Label and unit of a column, from the first case that has it. */
export function label(cases, name) {
  const { columns, labels } = cases.find((c) => c.curves.columns.includes(name)).curves;
  const [words, unit] = labels[columns.indexOf(name)];
  return { words, unit };
}

/** The column that is shown first: a position, tension or angle that changes by more than rounding, otherwise the first column that does; energies and
solver counts come last. */
export function firstColumn(cases) {
  const all = cases.flatMap((c) => c.curves.columns.slice(1).map((name, k) => ({ name, unit: label([c], name).unit, values: c.curves.values[k + 1].filter(Number.isFinite) })));
  const largest = new Map();
  for (const { unit, values } of all) largest.set(unit, values.reduce((most, v) => Math.max(most, Math.abs(v)), largest.get(unit) ?? 0));
  const changes = ({ unit, values }) => values.length > 0 && values.reduce((m, v) => Math.max(m, v), -Infinity) - values.reduce((m, v) => Math.min(m, v), Infinity) > ROUNDING * largest.get(unit);
  const usual = all.filter(({ name }) => !/energy|newton|_J$/.test(name));
  const moving = usual.filter(changes);
  return (moving.find(({ name }) => /(_[xyz]_m|_tension_N|_angle_deg)$/.test(name)) ?? moving[0] ?? usual[0] ?? all[0])?.name;
}

/** Draws a column of all cases along their axis; `seek` receives the time under the pointer. */
export class Plot {
  constructor(svg, cases, seek) {
    Object.assign(this, { svg, cases, seek });
    const follow = (e) => {
      if (!this.scale || !(e.buttons & 1 || e.type === "pointerdown")) return;
      const box = svg.getBoundingClientRect();
      const { x0, x1, t0, t1 } = this.scale;
      const px = ((e.clientX - box.left) / box.width) * this.width;
      seek(t0 + (Math.min(1, Math.max(0, (px - x0) / (x1 - x0)))) * (t1 - t0));
    };
    svg.addEventListener("pointerdown", follow);
    svg.addEventListener("pointermove", follow);
  }

  draw(name) {
    this.name = name;
    const { svg } = this;
    const [w, h] = [(this.width = svg.clientWidth || 300), (this.height = svg.clientHeight || 150)];
    svg.setAttribute("viewBox", `0 0 ${w} ${h}`);
    svg.replaceChildren();
    const lines = this.cases.map((c) => [c.axis, c.curves.values[c.curves.columns.indexOf(name)]]).filter(([, v]) => v);
    if (!lines.length) return;
    const ends = (list) => list.reduce(([a, b], array) => array.reduce(([l, m], v) => (Number.isFinite(v) ? [Math.min(l, v), Math.max(m, v)] : [l, m]), [a, b]), [Infinity, -Infinity]);
    const [t0, t1] = ends(lines.map(([t]) => t));
    let [y0, y1] = ends(lines.map(([, v]) => v));
    if (!(y1 > y0)) [y0, y1] = [y0 - 1, y1 + 1];
    const marks = ticks(y0, y1, 4);
    const [x0, x1, top, bottom] = [12 + 6.4 * Math.max(...marks.map(({ text }) => text.length)), w - 10, 22, h - 22];
    this.scale = { x0, x1, t0, t1 };
    const px = (t) => x0 + ((t - t0) / (t1 - t0 || 1)) * (x1 - x0);
    const py = (v) => bottom - ((v - y0) / (y1 - y0)) * (bottom - top);
    for (const { value, text } of marks) {
      svg.append(node("line", { class: "grid", x1: x0, x2: x1, y1: py(value), y2: py(value) }), node("text", { x: x0 - 5, y: py(value) + 4, "text-anchor": "end" }, text));
    }
    ticks(t0, t1, 4).forEach(({ value, text }, k, all) => {
      const isLast = k === all.length - 1;
      svg.append(node("text", { x: isLast ? Math.min(px(value), w - 14) : px(value), y: h - 6, "text-anchor": "middle" }, `${text}${isLast && this.cases[0].isCounted ? "" : " s"}`));
    });
    const { words, unit } = label(this.cases, name);
    svg.append(node("text", { x: 4, y: 13 }, `${words}${unit ? ` [${unit}]` : ""}`));
    lines.forEach(([t, v], k) => {
      const points = Array.from(t, (time, i) => (Number.isFinite(time) && Number.isFinite(v[i]) ? `${px(time).toFixed(1)},${py(v[i]).toFixed(1)}` : "")).filter(Boolean);
      svg.append(node("polyline", { points: points.join(" "), class: `curve curve-${k}`, stroke: css(PALETTE[k]) }));
    });
    this.marks = lines.map((_, k) => [node("line", { class: "now", y1: top, y2: bottom }), node("circle", { r: 4, fill: css(PALETTE[k]) })]);
    svg.append(...this.marks.flat());
    Object.assign(this, { px, py });
  }

  /** Moves the mark of each case to its state. */
  mark(state) {
    if (!this.marks) return;
    this.cases.filter((c) => c.curves.columns.includes(this.name)).forEach((c, k) => {
      const [line, dot] = this.marks[k];
      const x = this.px(c.timeAt(state(c)));
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
      const v = c.recordedAt(this.name, state(c));
      if (!Number.isFinite(v)) return dot.setAttribute("visibility", "hidden");
      dot.setAttribute("visibility", "visible");
      dot.setAttribute("cx", x);
      dot.setAttribute("cy", this.py(v));
    });
  }
}
