// Data of a case: reads the packed block, and provides positions and values at a state.

import { digits, number } from "./units.js";

const FORMAT = 2;

/** All cases of the page: the title of each, and a function that reads its numbers when it is first shown. */
export function listCases(Kind = Case) {
  const heads = [...document.querySelectorAll("script.head")];
  const blocks = [...document.querySelectorAll("script.data")];
  return heads.map((head, k) => {
    const description = JSON.parse(head.textContent);
    if (description.format > FORMAT) throw new Error(`the data have format ${description.format}, this viewer reads ${FORMAT}`);
    let read = null;
    return { title: description.title, read: () => (read ??= globalThis.inflate(blocks[k].textContent).then((bytes) => new Kind(description, new Uint8Array(bytes)))) };
  });
}

/** Numbers that are stored byte by byte: the first bytes of all numbers come first. */
function array(bytes, { kind, at, count }) {
  const width = { i16: 2, f64: 8 }[kind] ?? 4;
  const buffer = new ArrayBuffer(count * width);
  const plain = new Uint8Array(buffer);
  for (let plane = 0; plane < width; plane++) {
    const from = at + plane * count;
    // Typed arrays are little-endian on every machine that runs browsers
    for (let k = 0; k < count; k++) plain[k * width + (width - 1 - plane)] = bytes[from + k];
  }
  if (kind === "f64") return new Float64Array(buffer);
  if (kind === "f32") return new Float32Array(buffer);
  if (kind === "i16") return new Int16Array(buffer);
  const values = new Uint32Array(buffer);
  for (let k = 0, past = 0; k < count; k++) {
    past += (values[k] >>> 1) ^ -(values[k] & 1);
    values[k] = past;
  }
  return values;
}

/** A history as principal modes. */
class Modes {
  constructor(bytes, { components, error, shapes, amplitudes }) {
    this.components = components;
    this.error = error;
    this.shapes = shapes.map((s) => array(bytes, s));
    // A state without values is null, because JSON has no NaN
    this.amplitudes = amplitudes.map((a) => a.map((v) => v ?? NaN));
    this.size = this.shapes.length ? this.shapes[0].length : 0;
  }

  /** Values [components × points] at a state, linear between two states; NaN where there is no value. */
  at(state) {
    const out = new Float32Array(this.size);
    if (!this.size) return out;
    const low = Math.floor(state);
    const part = state - low;
    this.shapes.forEach((shape, k) => {
      const a = this.amplitudes[k];
      const factor = part > 0 ? a[low] * (1 - part) + a[low + 1] * part : a[low];
      if (factor !== 0) for (let p = 0; p < shape.length; p++) out[p] += factor * shape[p];
    });
    const first = this.shapes[0];
    for (let p = 0; p < first.length; p++) if (first[p] === -32768) out[p] = NaN;
    return out;
  }
}

/** Von Mises stress of the components xx, yy, zz, xy, yz, xz. */
const vonMises = (s) =>
  Math.sqrt(0.5 * ((s[0] - s[1]) ** 2 + (s[1] - s[2]) ** 2 + (s[2] - s[0]) ** 2) + 3 * (s[3] ** 2 + s[4] ** 2 + s[5] ** 2));

/** Largest eigenvalue of a symmetric tensor (Smith 1961). */
function largestPrincipal(s) {
  const q = (s[0] + s[1] + s[2]) / 3;
  const off = s[3] ** 2 + s[4] ** 2 + s[5] ** 2;
  const p = Math.sqrt(((s[0] - q) ** 2 + (s[1] - q) ** 2 + (s[2] - q) ** 2 + 2 * off) / 6);
  if (!(p > 0)) return q;
  const [a, b, c, d, e, f] = [(s[0] - q) / p, (s[1] - q) / p, (s[2] - q) / p, s[3] / p, s[4] / p, s[5] / p];
  const r = (a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f)) / 2;
  return q + 2 * p * Math.cos(Math.acos(Math.min(1, Math.max(-1, r))) / 3);
}

/** Row of each state: the row with its time, after the row of the previous state; if there is none, the fractional position between two rows; NaN if the
rows end before it. */
function rowsOf(times, rows) {
  const stored = rows instanceof Float32Array ? Math.fround : (t) => t;
  let next = 0;
  return times.map((time) => {
    const t = stored(time);
    const exact = rows.indexOf(t, next);
    if (exact >= 0) {
      next = exact + 1;
      return exact;
    }
    for (let k = Math.max(1, next); k < rows.length; k++) {
      if ((rows[k - 1] - t) * (rows[k] - t) > 0) continue;
      next = k;
      return k - 1 + (t - rows[k - 1]) / (rows[k] - rows[k - 1] || 1);
    }
    return NaN;
  });
}

const AXES = ["x", "y", "z"];
/** Distance from zero, relative to the extent of what is shown, from which on positions are stored relative to a corner. */
const FAR = 1e3;
const TENSOR = ["xx", "yy", "zz", "xy", "yz", "xz"];

/** Scalars of a field: name, whether they are signed, and the function of the components. A tensor is a stress if its unit is that of a stress. */
function scalars(name, unit, components) {
  if (components === 1) return [{ name, of: null }];
  if (components === 3) {
    const size = { name, of: (v) => Math.hypot(v[0], v[1], v[2]) };
    return [size, ...AXES.map((axis, i) => ({ name: `${name}, ${axis}`, signed: true, of: (v) => v[i] }))];
  }
  const mean = (s) => (s[0] + s[1] + s[2]) / 3;
  const of = (scalar) => (unit !== "Pa" || name !== "stress" ? `${name}, ${scalar}` : scalar === "von Mises" ? "von Mises stress" : scalar);
  return [
    { name: of("von Mises"), of: vonMises },
    unit === "Pa" ? { name: of("pressure"), signed: true, of: (s) => -mean(s) } : { name: of("mean"), signed: true, of: mean },
    { name: `${name}, largest principal`, signed: true, of: largestPrincipal },
    ...TENSOR.map((pair, i) => ({ name: `${name}, ${pair}`, signed: true, of: (s) => s[i] })),
  ];
}

export class Case {
  constructor(head, bytes) {
    const read = (place) => array(bytes, place);
    Object.assign(this, { head, title: head.title, nodes: head.nodes, facetNodes: head.facetNodes, cellNodes: head.cellNodes });
    const relative = read(head.points);
    this.count = relative.length / 3;
    this.relative = relative;
    this.extent = relative.reduce((most, v) => Math.max(most, v), 0);
    /** Whether single precision has too few digits for absolute positions */
    this.isFar = Math.max(...head.origin.map(Math.abs)) > FAR * this.extent;
    this.place([0, 0, 0]);
    /** Numbers in the mesh, if they are not 0, 1, 2, … */
    [this.nodeNumbers, this.cellNumbers] = [head.nodeNumbers, head.cellNumbers].map((numbers) => numbers && read(numbers));
    this.facets = read(head.facets);
    this.facetCells = read(head.facetCells);
    this.cells = read(head.cells);
    /** Pages of earlier versions have the numbers of the mesh if they contain its inside */
    this.hasOwnNumbers = head.ownNumbers ?? !this.cells.length;
    this.parts = head.parts.map((p) => ({ ...p, triangles: read(p.triangles) }));
    this.marked = head.marked.map((m) => ({ ...m, facets: read(m.facets), points: read(m.points) }));
    this.motion = new Modes(bytes, head.motion);
    this.arrows = head.arrows.map((a) => this.#arrows(a, read));
    this.curves = { columns: head.curves.columns, labels: head.curves.labels, values: head.curves.values.map(read) };
    this.order(head.times);
    this.recorded = new Set(head.fields.map((f) => f.name));
    this.quantities = [];
    if (this.motion.size) this.offer("displacement", "m", true, this.motion);
    for (const f of head.fields) this.offer(f.name, f.unit, f.nodal, new Modes(bytes, f.modes));
    this.ranges = new Map();
  }

  /** Reference positions relative to a reference point, point by point. */
  place(base) {
    const { origin } = this.head;
    this.base = base;
    this.frame = null;
    this.rest = new Float32Array(this.relative.length);
    for (let p = 0; p < this.count; p++) for (let i = 0; i < 3; i++) this.rest[3 * p + i] = origin[i] - base[i] + this.relative[i * this.count + p];
  }

  /** Sets the times of the states, and finds their rows. */
  order(times) {
    this.realTimes = times;
    this.rises = times.every((t, k) => k === 0 || t > times[k - 1]);
    this.stateRows = rowsOf(times, this.curves.values[0] ?? []);
    this.along(!this.rises);
  }

  /** Arranges states and rows along time or along the state numbers, which is needed if time does not increase from state to state. */
  along(isCounted) {
    this.isCounted = isCounted;
    this.times = isCounted ? this.realTimes.map((_, k) => k + 1) : this.realTimes;
    const [t] = this.curves.values;
    this.axis = t;
    if (!isCounted || !t) return;
    this.axis = new Float64Array(t.length).fill(NaN);
    this.stateRows.forEach((from, k) => {
      const to = this.stateRows[k + 1] ?? from;
      for (let row = Math.ceil(from); row <= to; row++) this.axis[row] = k + 1 + (row - from) / (to - from || 1);
    });
  }

  /** Row of a state, linear between two states and between two rows. */
  rowAt(state) {
    const low = Math.floor(state);
    const [from, to] = [this.stateRows[low], this.stateRows[low + 1]];
    if (!(state > low)) return from;
    const at = this.timeAt(state);
    let k = Math.floor(from) + 1;
    while (k < to && this.axis[k] < at) k++;
    const [a, b] = [this.axis[k - 1], this.axis[k]];
    return b > a ? k - 1 + Math.min(1, Math.max(0, (at - a) / (b - a))) : k;
  }

  /** Value of a recorded column at a state; NaN if there is none. */
  recordedAt(name, state) {
    const values = this.curves.values[this.curves.columns.indexOf(name)];
    const row = this.rowAt(state);
    const low = Math.floor(row);
    return (row > low ? values?.[low] * (1 - row + low) + values?.[low + 1] * (row - low) : values?.[low]) ?? NaN;
  }

  #arrows({ name, unit, counts, points, vectors }, read) {
    const [n, p, v] = [read(counts), read(points), read(vectors)];
    const starts = [0];
    n.forEach((count) => starts.push(starts.at(-1) + count));
    let largest = 0;
    for (let k = 0; k < p.length; k++) largest = Math.max(largest, Math.hypot(v[3 * k], v[3 * k + 1], v[3 * k + 2]));
    return { name, unit, starts, points: p, vectors: v, largest };
  }

  offer(name, unit, nodal, modes) {
    for (const s of scalars(name, unit, modes.components)) {
      // A stored field takes precedence over one derived from another field
      if (s.name !== name && this.recorded.has(s.name)) continue;
      this.quantities.push({ name: s.name, field: name, unit, nodal, signed: s.signed ?? false, modes, of: s.of });
    }
  }

  get states() {
    return this.times.length;
  }

  /** Positions of all points at a state, with displacements times `factor`. */
  positions(state, factor) {
    const out = this.rest.slice();
    if (!this.motion.size || factor === 0) return out;
    const u = this.motion.at(state);
    const n = this.count;
    for (let p = 0; p < n; p++) for (let i = 0; i < 3; i++) out[3 * p + i] += factor * u[i * n + p];
    return out;
  }

  /** Points that the first view shows: the body, its cables, and rigid bodies that are not much larger than it. */
  #framed() {
    const size = (first, count) => {
      const ends = [0, 1, 2].map((i) => {
        let [low, high] = [Infinity, -Infinity];
        for (let p = first; p < first + count; p++) [low, high] = [Math.min(low, this.rest[3 * p + i]), Math.max(high, this.rest[3 * p + i])];
        return high - low;
      });
      return Math.hypot(...ends);
    };
    const own = size(0, this.nodes);
    const parts = this.parts.filter((part) => part.kind !== "floor").filter((part) => part.kind === "cable" || size(part.first, part.count) < 1.5 * own);
    return [{ first: 0, count: this.nodes }, ...parts];
  }

  /** Bounds of these points over all states, with displacements times `factor`. */
  box(factor) {
    if (this.frame?.factor !== factor) {
      this.frame = { factor, parts: this.#framed(), low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
      for (let state = 0; state < Math.max(1, this.states); state++) this.widen(state);
    }
    return this.frame;
  }

  /** Extends the box by a state. */
  widen(state) {
    const { factor, parts, low, high } = this.frame;
    const x = this.positions(state, factor);
    for (const { first, count } of parts) {
      for (let k = 3 * first; k < 3 * (first + count); k += 3) {
        for (let i = 0; i < 3; i++) {
          if (x[k + i] < low[i]) low[i] = x[k + i];
          if (x[k + i] > high[i]) high[i] = x[k + i];
        }
      }
    }
  }

  quantity(name) {
    return this.quantities.find((q) => q.name === name);
  }

  /** Values of a quantity at the points or in the cells. */
  values(quantity, state) {
    const all = quantity.modes.at(state);
    const { components } = quantity.modes;
    if (components === 1) return all;
    const n = all.length / components;
    const out = new Float32Array(n);
    const own = new Array(components);
    for (let p = 0; p < n; p++) {
      for (let i = 0; i < components; i++) own[i] = all[i * n + p];
      out[p] = quantity.of(own);
    }
    return out;
  }

  /** Least and largest value of a quantity at one state, with their indices; at the nodes of the body or in its cells. */
  extremes(quantity, state) {
    const values = this.values(quantity, state);
    const count = quantity.nodal ? Math.min(values.length, this.nodes) : values.length;
    const found = { low: Infinity, high: -Infinity, lowAt: -1, highAt: -1 };
    for (let k = 0; k < count; k++) {
      if (values[k] < found.low) [found.low, found.lowAt] = [values[k], k];
      if (values[k] > found.high) [found.high, found.highAt] = [values[k], k];
    }
    return found;
  }

  /** Least and largest value of a quantity over all states. */
  range(quantity) {
    if (!this.ranges.has(quantity.name)) {
      let [low, high] = [Infinity, -Infinity];
      for (let s = 0; s < this.states; s++) {
        const found = this.extremes(quantity, s);
        [low, high] = [Math.min(low, found.low), Math.max(high, found.high)];
      }
      this.ranges.set(quantity.name, [low, high]);
    }
    return this.ranges.get(quantity.name);
  }

  /** Range of a quantity without the outermost 1 % of the values at each end, from up to 20 states. */
  core(quantity) {
    const key = `${quantity.name}, core`;
    if (!this.ranges.has(key)) {
      const all = [];
      const every = Math.ceil(this.states / 20);
      for (let s = this.states - 1; s >= 0; s -= every) {
        const values = this.values(quantity, s);
        for (const v of values.subarray(0, quantity.nodal ? this.nodes : values.length)) if (Number.isFinite(v)) all.push(v);
      }
      const sorted = Float32Array.from(all).sort();
      const at = (share) => sorted[Math.round(share * (sorted.length - 1))] ?? NaN;
      this.ranges.set(key, [at(0.01), at(0.99)]);
    }
    return this.ranges.get(key);
  }

  /** The time of a state as text, with enough digits to distinguish it from its neighbours. */
  timeText(state) {
    const { realTimes } = this;
    const t = this.timeAt(state, realTimes);
    const low = Math.floor(state);
    const gaps = (state > low ? [low] : [low - 1, low]).map((k) => Math.abs(realTimes[k + 1] - realTimes[k])).filter((gap) => gap > 0);
    return `t = ${number(t, digits(t, Math.min(...gaps)))} s`;
  }

  /** State at a time, linear between two states. */
  stateAt(t) {
    const times = this.times;
    if (t <= times[0]) return 0;
    const k = times.findIndex((x) => x >= t);
    if (k < 0) return times.length - 1;
    const gap = times[k] - times[k - 1];
    return gap > 0 ? k - 1 + (t - times[k - 1]) / gap : k;
  }

  /** Time of a state, linear between two states; with `realTimes` the time of the run even if the slider counts states. */
  timeAt(state, times = this.times) {
    const low = Math.floor(state);
    const part = state - low;
    return part > 0 ? times[low] * (1 - part) + times[low + 1] * part : times[low];
  }
}
