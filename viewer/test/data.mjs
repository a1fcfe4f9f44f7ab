// Rows and times of states, names of fields, and numbers of nodes, as a case of a page gives them.
import assert from "node:assert/strict";
import { Case } from "../src/data.js";
import { LiveCase } from "../src/live-case.js";
import { digits, number } from "../src/units.js";

/** The bytes of all arrays of a page, as `pack.rs` writes them. */
class Block {
  bytes = [];

  #planes(kind, values, width, write) {
    const at = this.bytes.length;
    const words = Array.from(values, (v) => {
      const view = new DataView(new ArrayBuffer(width));
      write(view, v);
      return new Uint8Array(view.buffer);
    });
    for (let plane = 0; plane < width; plane++) for (const word of words) this.bytes.push(word[plane]);
    return { kind, at, count: words.length };
  }

  f64 = (values) => this.#planes("f64", values, 8, (view, v) => view.setFloat64(0, v));
  f32 = (values) => this.#planes("f32", values, 4, (view, v) => view.setFloat32(0, v));
  i16 = (values) => this.#planes("i16", values, 2, (view, v) => view.setInt16(0, v));
  u32 = (values) => {
    let past = 0;
    return this.#planes("u32", values, 4, (view, v) => {
      const d = v - past;
      past = v;
      view.setUint32(0, d < 0 ? -2 * d - 1 : 2 * d);
    });
  };
}

/** A triangle at these times with rows [t, value], fields [name, unit, components], and what else its head has. */
function triangle(times, rows = [], fields = [], more = () => ({}), Kind = Case) {
  const block = new Block();
  const modes = (components) => ({ components, error: 0, shapes: [block.i16(new Array(3 * components).fill(1))], amplitudes: [times.map((_, k) => k)] });
  const none = { components: 3, error: 0, shapes: [], amplitudes: [] };
  const head = {
    title: "", origin: [0, 0, 0], points: block.f32([0, 1, 0, 0, 0, 1, 0, 0, 0]), nodes: 3, facetNodes: 3, facets: block.u32([0, 1, 2]), facetCells: block.u32([0]), cellNodes: 4,
    cells: block.u32([]), parts: [], marked: [], motion: none, arrows: [], absent: [], times, fields: fields.map(([name, unit, n]) => ({ name, unit, nodal: true, modes: modes(n) })),
    curves: { columns: rows.length ? ["t_s", "v"] : [], labels: [], values: rows.length ? [block.f64(rows.map(([t]) => t)), block.f32(rows.map(([, v]) => v))] : [] }, ...more(block),
  };
  return new Kind(head, Uint8Array.from(block.bytes));
}

// Late in a run, neighbouring times are one in single precision; each state has the value of its row, and half way to the next one half of the change
const late = [0, 86400, ...Array.from({ length: 20 }, (_, k) => 86400 + (k + 1) / 1000)];
const run = triangle(late, late.map((t, k) => [t, k * k]));
late.forEach((_, k) => assert.equal(run.recordedAt("v", k), k * k));
assert.ok(Math.abs(run.recordedAt("v", 5.5) - 30.5) < 1e-3);
assert.equal(new Set(late.map((_, k) => run.timeText(k))).size, late.length);
assert.equal(run.timeText(2), "t = 86400.001 s");

// Between two states, rows that lie there count: the value is that of the time
const dense = triangle([0, 1], [[0, 0], [0.25, 4], [0.5, 2], [1, 3]]);
assert.deepEqual([0, 0.125, 0.25, 0.5, 0.75, 1].map((state) => dense.recordedAt("v", state)), [0, 2, 4, 2, 2.5, 3]);

// By arc length time runs back, and rows are not spread evenly over the states
const path = triangle([0, 1, 0.6, 0.8], [[0, 0], [0.5, 1], [1, 2], [1.1, 3], [0.9, 4], [0.6, 5], [0.8, 6]]);
assert.equal(path.isCounted, true);
assert.deepEqual([0, 1, 2, 3].map((state) => path.recordedAt("v", state)), [0, 2, 5, 6]);
assert.deepEqual(Array.from(path.axis), [1, 1.5, 2, 2 + 1 / 3, 2 + 2 / 3, 3, 4]);
assert.deepEqual([path.stateAt(3), path.timeText(2)], [2, "t = 0.6 s"]);
// Next to such a case the states of the other one are numbered too, and again lie along time by themselves
dense.along(true);
assert.deepEqual([dense.times, Array.from(dense.axis), dense.recordedAt("v", 1)], [[1, 2], [1, 1 + 1 / 3, 1 + 2 / 3, 2], 3]);
dense.along(false);
assert.deepEqual([dense.times, Array.from(dense.axis)], [[0, 1], [0, 0.25, 0.5, 1]]);

// A state whose row is left out lies between two rows; rows that have not come have no value
assert.deepEqual([0, 1, 2].map((state) => triangle([0, 1, 4], [[0, 0], [2, 10]]).recordedAt("v", state)), [0, 5, NaN]);

// The same while a run goes on: states and rows come in any order, and are thinned out
const columns = () => ({ curves: { columns: ["t_s", "v"], labels: [], values: [] } });
const live = triangle([], [], [], columns, LiveCase);
const state = (t) => ({ t, motion: new Float32Array(9), fields: [], points: new Uint32Array(0), vectors: new Float32Array(0) });
live.take(1, state(late[3]), { stride: 1, count: 2 });
assert.deepEqual([live.states, live.recordedAt("v", 0)], [1, NaN]);
live.takeRows(late.slice(0, 5).map((t, k) => [k, [t, k * k]]), { stride: 1, count: 5 });
live.take(0, state(late[2]), { stride: 1, count: 2 });
assert.deepEqual([live.recordedAt("v", 0), live.recordedAt("v", 1), live.timeText(1)], [4, 9, "t = 86400.002 s"]);
live.takeRows([], { stride: 2, count: 5 });
assert.ok(Math.abs(live.recordedAt("v", 1) - 10) < 1e-3);

// What follows from a tensor is named by its field, is called stress only with the unit of one, and hides nothing
const names = (...fields) => triangle([0], [], fields).quantities.map((q) => q.name);
assert.deepEqual(names(["stress", "Pa", 6]).slice(0, 3), ["von Mises stress", "pressure", "stress, largest principal"]);
const tensors = names(["strain", "", 6], ["stress", "Pa", 6], ["pressure", "Pa", 1], ["Cauchy", "Pa", 6]);
assert.equal(new Set(tensors).size, tensors.length);
for (const name of ["strain, von Mises", "strain, mean", "von Mises stress", "Cauchy, von Mises", "Cauchy, pressure"]) assert.ok(tensors.includes(name), name);
const own = triangle([0], [], [["stress", "Pa", 6], ["pressure", "Pa", 1]]);
assert.equal(own.quantity("pressure").field, "pressure");

// A state without values has none, and the others keep theirs
const gap = triangle([0, 1, 2], [], [["v", "", 1]]);
gap.quantities[0].modes.amplitudes[0][1] = NaN;
assert.deepEqual([0, 1, 2].map((state) => gap.values(gap.quantities[0], state)[0]), [0, NaN, 2]);
assert.deepEqual(gap.range(gap.quantities[0]), [0, 2]);

// Numbers of the mesh, where the page has a part of its nodes
assert.deepEqual(Array.from(triangle([0], [], [], (block) => ({ nodeNumbers: block.u32([4, 7, 9]) })).nodeNumbers), [4, 7, 9]);
// A page of an earlier version does not say them: they are known where it has the inside
const earlier = [[], [0, 1, 2, 0]].map((cells) => triangle([0], [], [], (block) => ({ cells: block.u32(cells) })).hasOwnNumbers);
assert.deepEqual([...earlier, triangle([0], [], [], () => ({ ownNumbers: false })).hasOwnNumbers], [true, false, false]);

// Far from zero positions are relative to a corner
const far = triangle([0], [], [], () => ({ origin: [1e8, 0, 0] }));
far.place(far.head.origin);
assert.deepEqual([far.isFar, run.isFar, Array.from(far.positions(0, 1).subarray(0, 6))], [true, false, [0, 0, 0, 1, 0, 0]]);

// Four digits, or as many as tell neighbours apart
assert.deepEqual([digits(0.975, 0.025), digits(0, 1), digits(1, 0), digits(10.025, 0.025)], [4, 4, 4, 5]);
for (const t of [1, 37.3, 999, 86400, 3e7]) for (const gap of [0.5, 0.04, 1e-3]) assert.notEqual(number(t, digits(t, gap)), number(t + gap, digits(t + gap, gap)));
