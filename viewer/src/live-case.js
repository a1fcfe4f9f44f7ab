// A case whose states and rows arrive while its run computes.

import { Case } from "./data.js";

/** A history that keeps its states as they arrive, whereas a finished case has principal modes. */
class History {
  constructor(components, size) {
    Object.assign(this, { components, size, error: 0, shapes: [], states: [] });
  }

  /** Values [components × points] at a state, linear between two states. */
  at(state) {
    const low = Math.min(Math.floor(state), this.states.length - 1);
    if (low < 0) return new Float32Array(this.size);
    const [a, b, part] = [this.states[low], this.states[low + 1], state - low];
    if (!(part > 0) || !b) return a;
    return a.map((v, k) => v * (1 - part) + b[k] * part);
  }
}

/** Reorders values from point by point to component by component. */
function byComponent(values, components) {
  if (components === 1) return values;
  const out = new Float32Array(values.length);
  const count = values.length / components;
  for (let p = 0; p < count; p++) for (let i = 0; i < components; i++) out[i * count + p] = values[p * components + i];
  return out;
}

/** Largest force of a state. */
const strongest = (vectors) => {
  let largest = 0;
  for (let k = 0; k < vectors.length; k += 3) largest = Math.max(largest, Math.hypot(vectors[k], vectors[k + 1], vectors[k + 2]));
  return largest;
};

export class LiveCase extends Case {
  constructor(head, bytes) {
    super(head, bytes);
    this.live = true;
    this.motion = new History(3, 3 * this.count);
    this.fields = head.fields.map((f) => new History(f.modes.components, f.modes.components * this.nodes));
    this.quantities = [];
    this.offer("displacement", "m", true, this.motion);
    head.fields.forEach((f, k) => this.offer(f.name, f.unit, f.nodal, this.fields[k]));
    /** States by their numbers in the run */
    this.kept = new Map();
    this.rows = new Map();
    this.#arrange();
  }

  /** Reads a state from its bytes, which `Frame::bytes` describes. */
  read(buffer) {
    const view = new DataView(buffer);
    const count = view.getUint32(8, true);
    let at = 12 + 4 * count;
    const blocks = Array.from({ length: count }, (_, k) => {
      const length = view.getUint32(12 + 4 * k, true);
      const block = buffer.slice(at, at + 4 * length);
      at += 4 * length;
      return block;
    });
    const floats = blocks.map((b) => new Float32Array(b));
    return {
      t: view.getFloat64(0, true),
      motion: byComponent(floats[0], 3),
      fields: this.fields.map((f, k) => byComponent(floats[k + 1], f.components)),
      points: new Uint32Array(blocks.at(-2)),
      vectors: floats.at(-1),
    };
  }

  /** Adds a state, and drops states that the run no longer keeps; the run keeps the last one. */
  take(number, state, { stride, count }) {
    this.kept.set(number, state);
    for (const k of this.kept.keys()) if (k !== number && k !== count - 1 && (k % stride || k >= count)) this.kept.delete(k);
    this.#arrange();
    const own = [...this.kept.keys()].sort((a, b) => a - b).indexOf(number);
    if (this.frame) this.widen(own);
    for (const [name, range] of this.ranges) {
      const quantity = this.quantity(name);
      if (!quantity) {
        this.ranges.delete(name);
        continue;
      }
      const found = this.extremes(quantity, own);
      this.ranges.set(name, [Math.min(range[0], found.low), Math.max(range[1], found.high)]);
    }
  }

  /** Adds rows, each with its number. */
  takeRows(rows, { stride, count }) {
    for (const [number, values] of rows) this.rows.set(number, values);
    for (const k of this.rows.keys()) if (k % stride && k !== count - 1) this.rows.delete(k);
    this.#arrange();
  }

  /** Sorts histories, times and curves in the order of the run. */
  #arrange() {
    const states = [...this.kept].sort(([a], [b]) => a - b).map(([, s]) => s);
    this.motion.states = states.map((s) => s.motion);
    this.fields.forEach((f, k) => (f.states = states.map((s) => s.fields[k])));
    this.arrows = this.head.arrows.map(({ name, unit }) => ({ name, unit, ...this.#forces(states) }));
    const rows = [...this.rows].sort(([a], [b]) => a - b).map(([, values]) => values);
    this.curves.values = this.curves.columns.map((_, k) => (k ? Float32Array : Float64Array).from(rows, (r) => r[k]));
    this.order(states.map((s) => s.t));
  }

  #forces(states) {
    const starts = [0];
    states.forEach((s) => starts.push(starts.at(-1) + s.points.length));
    const [points, vectors] = [new Uint32Array(starts.at(-1)), new Float32Array(3 * starts.at(-1))];
    states.forEach((s, k) => {
      points.set(s.points, starts[k]);
      vectors.set(s.vectors, 3 * starts[k]);
    });
    return { starts, points, vectors, largest: strongest(vectors) };
  }
}
