// One case on its canvas: body, ghost, section, cables, rigid bodies, marks and forces at a state.

import { Canvas, EVERYWHERE, Faces, Lines } from "./draw.js";
import { Surface } from "./surface.js";
import { section } from "./section.js";
import { distinct, listTable, table } from "./colours.js";

const LIGHT = { body: [205, 213, 221], edge: [40, 48, 58], ghost: [110, 118, 128], rigid: [150, 156, 164], floor: [150, 160, 172], held: [20, 20, 20], cable: [0, 114, 178], force: [213, 94, 0] };
const DARK = { body: [150, 160, 172], edge: [12, 16, 20], ghost: [170, 178, 188], rigid: [112, 120, 130], floor: [120, 132, 146], held: [240, 240, 240], cable: [86, 180, 233], force: [240, 140, 60] };

/** Segments of zero length, which are drawn as discs. */
const discs = (x, points) => {
  const out = new Float32Array(6 * points.length);
  points.forEach((p, k) => {
    for (let i = 0; i < 3; i++) out[6 * k + i] = out[6 * k + 3 + i] = x[3 * p + i];
  });
  return out;
};

/** The part below a box, with a margin, of the plane given by four points in x: two triangles. */
function patch(x, first, [low, high]) {
  const at = (k) => [0, 1, 2].map((i) => x[3 * (first + k) + i]);
  const [corner, ...others] = [at(0), at(1), at(3)];
  const sides = others.map((p) => p.map((v, i) => v - corner[i]));
  const ends = sides.map((side) => {
    const share = (k) => side.reduce((sum, v, i) => sum + v * ((k & (1 << i) ? high[i] : low[i]) - corner[i]), 0) / side.reduce((sum, v) => sum + v * v, 0);
    const shares = [0, 1, 2, 3, 4, 5, 6, 7].map(share);
    return [Math.min(...shares), Math.max(...shares)];
  });
  // The sides have equal length
  const margin = 0.1 * Math.max(...ends.map(([from, to]) => to - from));
  const point = (a, b) => corner.map((v, i) => v + (ends[0][a] + (2 * a - 1) * margin) * sides[0][i] + (ends[1][b] + (2 * b - 1) * margin) * sides[1][i]);
  const [p, q, r, s] = [point(0, 0), point(1, 0), point(1, 1), point(0, 1)];
  return [...p, ...q, ...r, ...p, ...r, ...s];
}

export class Pane {
  constructor(body, element) {
    this.body = body;
    this.surface = new Surface(body);
    this.canvas = new Canvas(element);
    const add = (object) => this.canvas.add(object);
    this.faces = add(new Faces({}));
    // Faces of cells are oriented outwards; those of a surface from a file need not be
    this.faces.isClosed = body.cells.length > 0;
    this.rigid = add(new Faces({ shade: 0.6 }));
    this.cut = add(new Faces({ shade: 0.12 }));
    this.cutEdges = add(new Lines({ width: 1.1 }));
    this.ghost = add(new Lines({ width: 1.2, opacity: 0.75, writes: true }));
    this.held = add(new Lines({ width: 4 }));
    this.nodeMarks = body.marked.filter((m) => m.kind === "region" && m.points.length).map(() => add(new Lines({ width: 5 })));
    this.cables = add(new Lines({ width: 3, through: true }));
    this.guides = add(new Lines({ width: 6, through: true }));
    this.forces = add(new Lines({ width: 2, through: true }));
    this.picked = add(new Lines({ width: 9, through: true }));
    // A floor hides nothing, even when seen from below
    this.floors = add(new Faces({ shade: 0.1, opacity: 0.4 }));
    this.floors.isFloor = true;
    this.ghost.show(this.surface.sharp());
    this.edgeLength = this.surface.meanEdge();
    this.pick = -1;
    this.#rigidIndex();
    this.#regionColours();
  }

  #rigidIndex() {
    const parts = this.body.parts.filter((p) => !["cable", "floor"].includes(p.kind) && p.triangles.length);
    this.rigidCorners = Uint32Array.from(parts.flatMap((p) => Array.from(p.triangles, (t) => p.first + t)));
  }

  /** The regions that have facets, each with a colour; later regions are drawn over earlier ones. */
  #regionColours() {
    this.regions = this.body.marked.filter((m) => m.facets.length).map((m, k) => ({ ...m, colour: distinct(k), visible: true }));
    this.sets = this.body.marked.filter((m) => m.kind === "region" && m.points.length).map((m, k) => ({ ...m, colour: distinct(this.regions.length + k), visible: true }));
  }

  /** Updates everything to a state with the page's settings. */
  update(s) {
    const { body } = this;
    const state = this.state = s.state(body);
    const x = this.x = body.positions(state, s.scale);
    const ink = s.dark ? DARK : LIGHT;
    const quantity = s.quantity === "regions" ? null : body.quantity(s.quantity);
    const values = quantity ? body.values(quantity, state) : null;
    this.values = values;
    const inside = s.section.on && body.cells.length > 0;
    const plane = s.section.on ? [...s.section.normal, s.section.offset] : EVERYWHERE;
    this.#body(s, x, quantity, values, ink, plane);
    this.#section(s, x, quantity, values, ink, inside);
    Object.assign(this.ghost.options, { visible: s.show.ghost, colour: ink.ghost });
    this.#parts(s, x, ink);
    this.#forces(s, x, state, ink);
    this.#marks(s, x, ink, plane);
  }

  #body(s, x, quantity, values, ink, plane) {
    const { surface, faces } = this;
    let numbers = null;
    let mode = 0;
    if (s.quantity === "regions") {
      const of = new Float32Array(surface.facetCount);
      this.regions.forEach((r, k) => r.visible && r.facets.forEach((f) => (of[f] = k + 1)));
      const seen = new Set(of);
      this.seen = [...this.regions.filter((_, k) => seen.has(k + 1)), ...this.sets.filter((set) => set.visible)];
      numbers = surface.perFacet(of);
      faces.setTable(listTable([ink.body, ...this.regions.map((r) => r.colour)]));
      mode = 2;
    } else if (quantity) {
      numbers = surface.values(values, quantity.nodal);
      faces.setTable(table(s.map, s.bands));
      mode = 1;
    }
    this.hasEdges = s.show.edges;
    Object.assign(faces.options, { visible: s.show.body, mode, colour: ink.body, plane, range: s.range, ink: ink.edge });
    if (this.indexed) faces.show(surface.vertices(x), numbers);
    else faces.show(surface.vertices(x), numbers, surface.index, surface.local);
    this.indexed = true;
  }

  #section(s, x, quantity, values, ink, inside) {
    this.cut.options.visible = this.cutEdges.options.visible = inside;
    if (!inside) return;
    const found = section(this.body, x, values, quantity?.nodal ?? true, s.section.normal, s.section.offset);
    if (quantity) this.cut.setTable(table(s.map, s.bands));
    Object.assign(this.cut.options, { mode: quantity ? 1 : 0, colour: ink.body, range: s.range, shade: 0.1 });
    this.cut.show(found.triangles, quantity ? found.values : null);
    Object.assign(this.cutEdges.options, { visible: s.show.edges, colour: ink.edge, writes: true });
    this.cutEdges.show(found.lines);
  }

  #parts(s, x, ink) {
    const { body } = this;
    const lines = body.parts.filter((p) => p.kind === "cable");
    const segments = [];
    for (const p of lines) {
      for (let k = p.first; k + 1 < p.first + p.count; k++) segments.push(...x.subarray(3 * k, 3 * k + 6));
    }
    Object.assign(this.cables.options, { visible: s.show.cables, colour: ink.cable });
    this.cables.show(Float32Array.from(segments));
    Object.assign(this.guides.options, { visible: s.show.cables, colour: ink.cable });
    this.guides.show(discs(x, lines.flatMap((p) => Array.from({ length: p.count }, (_, k) => p.first + k))));
    const corners = this.rigidCorners;
    const positions = new Float32Array(3 * corners.length);
    corners.forEach((p, k) => positions.set(x.subarray(3 * p, 3 * p + 3), 3 * k));
    Object.assign(this.rigid.options, { visible: s.show.rigid, colour: ink.rigid });
    this.rigid.show(positions, null);
    const floors = body.parts.filter((p) => p.kind === "floor");
    Object.assign(this.floors.options, { visible: s.show.rigid, colour: ink.floor });
    this.floors.show(Float32Array.from(floors.flatMap((p) => patch(x, p.first, s.box))), null);
  }

  #forces(s, x, state, ink) {
    const all = this.body.arrows[0];
    this.forceColour = ink.force;
    this.forces.options.visible = Boolean(all) && s.show.forces;
    if (!this.forces.options.visible) return;
    const k = Math.round(state);
    const [segments, ends] = [[], []];
    for (let a = all.starts[k]; a < all.starts[k + 1]; a++) {
      const p = all.points[a];
      const at = (share) => [0, 1, 2].map((i) => x[3 * p + i] + share * s.arrow * all.vectors[3 * a + i]);
      segments.push(...at(0), ...at(0.7), ...at(0.7), ...at(1));
      ends.push(1, 1, 4, 0);
    }
    this.forces.options.colour = ink.force;
    this.forces.show(Float32Array.from(segments), Float32Array.from(ends));
  }

  #marks(s, x, ink, plane) {
    const held = this.body.marked.find((m) => m.kind === "held");
    this.held.options.visible = Boolean(held) && s.show.held;
    if (held) {
      Object.assign(this.held.options, { colour: ink.held, plane });
      this.held.show(discs(x, Array.from(held.points)));
    }
    this.sets.forEach((set, k) => {
      const marks = this.nodeMarks[k];
      Object.assign(marks.options, { visible: s.quantity === "regions" && set.visible, colour: set.colour, plane });
      marks.show(discs(x, Array.from(set.points)));
    });
    this.picked.options.colour = ink.force;
    this.picked.show(this.pick >= 0 ? discs(x, [this.pick]) : new Float32Array(0));
  }

  /** Draws the updated state. Edges that are only a few pixels long are drawn paler, so that they do not hide the colours. */
  draw(view, pixels = 1) {
    const [w, h] = this.canvas.size;
    const half = view.half * Math.max(1, h / w);
    const long = (this.edgeLength / half) * (h / 2) / (this.canvas.renderer.dpr * pixels);
    const opacity = Math.min(0.85, Math.max(0.12, long / 22));
    this.faces.options.edges = this.hasEdges ? opacity : 0;
    this.cutEdges.options.opacity = opacity;
    this.canvas.draw(view, pixels);
  }

  /** The visible surface node nearest to a position on the canvas [CSS pixels]; −1 if there is none. */
  nodeAt(view, px, py, plane) {
    const { eye, right, up } = view.axes();
    const [w, h] = [this.canvas.canvas.clientWidth, this.canvas.canvas.clientHeight];
    const half = view.half * Math.max(1, h / w);
    const nodes = new Set(this.body.facets);
    let best = { at: -1, score: Infinity };
    for (const p of nodes) {
      const d = [0, 1, 2].map((i) => this.x[3 * p + i] - view.center[i] - view.radius * (right[i] * view.shift[0] + up[i] * view.shift[1]));
      if (plane && [0, 1, 2].reduce((sum, i) => sum + plane[i] * this.x[3 * p + i], 0) > plane[3]) continue;
      const dot = (v) => v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
      const away = Math.hypot(w / 2 + (dot(right) / half) * (h / 2) - px, h / 2 - (dot(up) / half) * (h / 2) - py);
      // Of the nodes under the pointer, the frontmost
      const score = away - (dot(eye) / view.radius) * 12;
      if (away < 14 && score < best.score) best = { at: p, score };
    }
    return best.at;
  }
}
