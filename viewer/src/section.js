// Plane sections through the cells: the cut polygons with their values, and the outlines of the cut elements.

// A quadratic tetrahedron as eight linear ones, nodes in VTK order, and for each of their faces (opposite corner 0 … 3) whether it is part of a face
// of the parent.
const LINEAR = [{ nodes: [0, 1, 2, 3], outer: [1, 1, 1, 1] }];
const QUADRATIC = [
  { nodes: [0, 4, 6, 7], outer: [0, 1, 1, 1] },
  { nodes: [4, 1, 5, 8], outer: [1, 0, 1, 1] },
  { nodes: [6, 5, 2, 9], outer: [1, 1, 0, 1] },
  { nodes: [7, 8, 9, 3], outer: [1, 1, 1, 0] },
  { nodes: [4, 5, 6, 8], outer: [0, 0, 0, 1] },
  { nodes: [4, 6, 7, 8], outer: [0, 1, 0, 0] },
  { nodes: [5, 6, 8, 9], outer: [0, 1, 0, 0] },
  { nodes: [6, 7, 8, 9], outer: [0, 0, 1, 0] },
];

/** A growable array of numbers. */
class Numbers {
  constructor() {
    this.data = new Float32Array(1 << 14);
    this.size = 0;
  }

  push(...values) {
    if (this.size + values.length > this.data.length) {
      const next = new Float32Array(2 * this.data.length);
      next.set(this.data);
      this.data = next;
    }
    for (const v of values) this.data[this.size++] = v;
  }

  get used() {
    return this.data.subarray(0, this.size);
  }
}

/**
 * The section of the plane normal · x = offset. Positions x of the points; values of the points or cells, or none.
 * Returns triangles (positions), their values, and segments of the outlines.
 */
export function section(body, x, values, nodal, normal, offset) {
  const [triangles, colours, lines] = [new Numbers(), new Numbers(), new Numbers()];
  const { cells, cellNodes } = body;
  const distance = new Float32Array(body.nodes);
  for (let p = 0; p < body.nodes; p++) distance[p] = normal[0] * x[3 * p] + normal[1] * x[3 * p + 1] + normal[2] * x[3 * p + 2] - offset;
  const kinds = cellNodes === 10 ? QUADRATIC : LINEAR;
  const count = cells.length / cellNodes;
  /** The point of the section between two points: position and value. */
  const cut = (a, b, cell) => {
    const s = distance[a] / (distance[a] - distance[b]);
    const mix = (i) => x[3 * a + i] + s * (x[3 * b + i] - x[3 * a + i]);
    const value = values === null ? 0 : nodal ? values[a] + s * (values[b] - values[a]) : values[cell];
    return [mix(0), mix(1), mix(2), value];
  };
  const triangle = (p, q, r) => {
    for (const c of [p, q, r]) {
      triangles.push(c[0], c[1], c[2]);
      colours.push(c[3]);
    }
  };
  const line = (p, q, isOuter) => {
    if (isOuter) lines.push(p[0], p[1], p[2], q[0], q[1], q[2]);
  };
  for (let c = 0; c < count; c++) {
    let [above, below] = [false, false];
    for (let k = 0; k < cellNodes; k++) {
      if (distance[cells[c * cellNodes + k]] > 0) above = true;
      else below = true;
    }
    if (!(above && below)) continue;
    for (const { nodes, outer } of kinds) {
      const of = nodes.map((k) => cells[c * cellNodes + k]);
      const up = [0, 1, 2, 3].filter((k) => distance[of[k]] > 0);
      const down = [0, 1, 2, 3].filter((k) => distance[of[k]] <= 0);
      if (up.length === 2) {
        const [[a, b], [d, e]] = [up, down];
        const [ad, ae, be, bd] = [cut(of[a], of[d], c), cut(of[a], of[e], c), cut(of[b], of[e], c), cut(of[b], of[d], c)];
        triangle(ad, ae, be);
        triangle(ad, be, bd);
        line(ad, ae, outer[b]);
        line(ae, be, outer[d]);
        line(be, bd, outer[a]);
        line(bd, ad, outer[e]);
      } else if (up.length === 1 || up.length === 3) {
        const [one, others] = up.length === 1 ? [up[0], down] : [down[0], up];
        const [p, q, r] = others.map((k) => cut(of[one], of[k], c));
        triangle(p, q, r);
        line(p, q, outer[others[2]]);
        line(q, r, outer[others[0]]);
        line(r, p, outer[others[1]]);
      }
    }
  }
  return { triangles: triangles.used, values: colours.used, lines: lines.used };
}
