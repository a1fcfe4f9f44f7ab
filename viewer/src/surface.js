// The drawn surface of the body: its faces and the edges of its elements, subdivided where they are curved.

/** Number of segments of a curved edge: fewer if there are many faces. */
const segments = (facets) => (facets > 12000 ? 2 : facets > 4000 ? 3 : 4);

/** Faces and edges of a case as weighted sums of its points. */
export class Surface {
  constructor(body) {
    this.body = body;
    const { facetNodes, facets } = body;
    this.facetCount = facets.length / facetNodes;
    this.n = facetNodes === 6 ? segments(this.facetCount) : 1;
    this.#subdivide();
    this.#edges();
  }

  /** Local points of a face with their shape functions, and its triangles. */
  #subdivide() {
    const { n } = this;
    const [weights, local] = [[], []];
    const number = new Map();
    for (let i = 0; i <= n; i++) {
      for (let j = 0; j <= n - i; j++) {
        number.set(`${i},${j}`, weights.length);
        const [b, c] = [i / n, j / n];
        const a = 1 - b - c;
        local.push(b, c);
        weights.push(
          this.body.facetNodes === 3 ? [a, b, c] : [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a],
        );
      }
    }
    const at = (i, j) => number.get(`${i},${j}`);
    const triangles = [];
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n - i; j++) {
        triangles.push(at(i, j), at(i + 1, j), at(i, j + 1));
        if (j < n - i - 1) triangles.push(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
    this.weights = weights;
    /** Two barycentric coordinates of each vertex in its face, from which the edges of the element are drawn */
    this.local = new Float32Array(this.facetCount * local.length);
    for (let f = 0; f < this.facetCount; f++) this.local.set(local, f * local.length);
    this.vertexCount = this.facetCount * weights.length;
    this.index = new Uint32Array(this.facetCount * triangles.length);
    for (let f = 0, k = 0; f < this.facetCount; f++) for (const t of triangles) this.index[k++] = f * weights.length + t;
  }

  /** Every edge of an element once: its two corners, and the node between them. */
  #edges() {
    const { facets, facetNodes, count } = this.body;
    const seen = new Set();
    const edges = [];
    for (let f = 0; f < this.facetCount; f++) {
      for (let side = 0; side < 3; side++) {
        const a = facets[f * facetNodes + side];
        const b = facets[f * facetNodes + ((side + 1) % 3)];
        const key = Math.min(a, b) * count + Math.max(a, b);
        if (!seen.has(key)) {
          seen.add(key);
          edges.push(a, b, facetNodes === 6 ? facets[f * facetNodes + 3 + side] : a);
        }
      }
    }
    this.edges = Uint32Array.from(edges);
    this.segmentCount = (edges.length / 3) * this.n;
  }

  /** Positions of the vertices of the faces. */
  vertices(x, out = new Float32Array(3 * this.vertexCount)) {
    const { facets, facetNodes } = this.body;
    for (let f = 0, k = 0; f < this.facetCount; f++) {
      for (const w of this.weights) {
        let [sx, sy, sz] = [0, 0, 0];
        for (let i = 0; i < facetNodes; i++) {
          const p = 3 * facets[f * facetNodes + i];
          sx += w[i] * x[p];
          sy += w[i] * x[p + 1];
          sz += w[i] * x[p + 2];
        }
        out[k++] = sx;
        out[k++] = sy;
        out[k++] = sz;
      }
    }
    return out;
  }

  /** Values at the vertices: those of the nodes, or of the cell behind each face. */
  values(values, nodal, out = new Float32Array(this.vertexCount)) {
    const { facets, facetNodes, facetCells } = this.body;
    for (let f = 0, k = 0; f < this.facetCount; f++) {
      for (const w of this.weights) {
        let sum = 0;
        if (nodal) for (let i = 0; i < facetNodes; i++) sum += w[i] * values[facets[f * facetNodes + i]];
        else sum = values[facetCells[f]];
        out[k++] = sum;
      }
    }
    return out;
  }

  /** One number per face, at each of its vertices. */
  perFacet(numbers, out = new Float32Array(this.vertexCount)) {
    const local = this.weights.length;
    for (let k = 0; k < out.length; k++) out[k] = numbers[(k / local) | 0];
    return out;
  }

  /** Both ends of every segment of the edges. */
  lines(x, out = new Float32Array(6 * this.segmentCount)) {
    const { n, edges } = this;
    const at = (e, s, i) => {
      const [a, b, m] = [x[3 * edges[e] + i], x[3 * edges[e + 1] + i], x[3 * edges[e + 2] + i]];
      return n === 1 ? (s ? b : a) : (1 - s) * (1 - 2 * s) * a + s * (2 * s - 1) * b + 4 * s * (1 - s) * m;
    };
    for (let e = 0, k = 0; e < edges.length; e += 3) {
      for (let s = 0; s < n; s++) {
        for (let i = 0; i < 3; i++, k++) {
          out[k] = at(e, s / n, i);
          out[k + 3] = at(e, (s + 1) / n, i);
        }
        k += 3;
      }
    }
    return out;
  }

  /** Mean length of the edges at rest. */
  meanEdge() {
    const { rest } = this.body;
    let sum = 0;
    for (let e = 0; e < this.edges.length; e += 3) {
      const [a, b] = [3 * this.edges[e], 3 * this.edges[e + 1]];
      sum += Math.hypot(rest[a] - rest[b], rest[a + 1] - rest[b + 1], rest[a + 2] - rest[b + 2]);
    }
    return sum / Math.max(1, this.edges.length / 3);
  }

  /** The segments of edges at which two faces form an angle above 35° at rest: the outline of the ghost. */
  sharp() {
    const { facets, facetNodes, rest, count } = this.body;
    const normals = new Map();
    const faces = new Map();
    for (let f = 0; f < this.facetCount; f++) {
      const [a, b, c] = [0, 1, 2].map((k) => 3 * facets[f * facetNodes + k]);
      const u = [0, 1, 2].map((i) => rest[b + i] - rest[a + i]);
      const v = [0, 1, 2].map((i) => rest[c + i] - rest[a + i]);
      const m = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const size = Math.hypot(...m) || 1;
      normals.set(f, m.map((w) => w / size));
      for (let side = 0; side < 3; side++) {
        const [p, q] = [facets[f * facetNodes + side], facets[f * facetNodes + ((side + 1) % 3)]];
        const key = Math.min(p, q) * count + Math.max(p, q);
        faces.set(key, [...(faces.get(key) ?? []), f]);
      }
    }
    const out = [];
    const all = this.lines(rest);
    for (let e = 0; e < this.edges.length / 3; e++) {
      const [p, q] = [this.edges[3 * e], this.edges[3 * e + 1]];
      const own = faces.get(Math.min(p, q) * count + Math.max(p, q));
      const [g, h] = own.map((f) => normals.get(f));
      const smooth = own.length === 2 && g[0] * h[0] + g[1] * h[1] + g[2] * h[2] > Math.cos((35 * Math.PI) / 180);
      if (!smooth) out.push(...all.subarray(6 * this.n * e, 6 * this.n * (e + 1)));
    }
    return Float32Array.from(out);
  }
}
