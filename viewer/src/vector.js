// The views as a vector graphic: faces and lines are drawn from back to front, so that nearer ones hide farther ones.

import { colour, css } from "./colours.js";
import { lineOf, share } from "./picture.js";
import { ticks } from "./units.js";

/** Number of shapes above which a view becomes a bitmap within the graphic: editors of vector graphics cannot open more. */
const MOST = 60_000;
/** Number of colour grades: a triangle is divided until each part has a single grade. */
const GRADES = 32;
/** Largest number of parts of a triangle side. */
const PARTS = 4;

const escape = (text) => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
const hex = (c) => `#${c.map((v) => Math.round(Math.min(255, Math.max(0, v))).toString(16).padStart(2, "0")).join("")}`;
const short = (v) => String(Math.round(v * 100) / 100);

/** Maps points in space to [x, y] in a picture of this size, and the depth, which increases towards the eye. */
function projection(view, width, height) {
  const { eye, right, up } = view.axes();
  const scale = view.scale(width, height);
  const target = [0, 1, 2].map((i) => view.center[i] + view.radius * (right[i] * view.shift[0] + up[i] * view.shift[1]));
  const along = (axis, p) => axis[0] * (p[0] - target[0]) + axis[1] * (p[1] - target[1]) + axis[2] * (p[2] - target[2]);
  return (p) => [width / 2 + scale * along(right, p), height / 2 - scale * along(up, p), scale * along(eye, p)];
}

/** Clips a polygon of vertices [x, y, z, …] to the side normal · x ≤ offset. */
function clipped(polygon, [a, b, c, d]) {
  const side = (p) => a * p[0] + b * p[1] + c * p[2] - d;
  const out = [];
  polygon.forEach((p, k) => {
    const q = polygon[(k + 1) % polygon.length];
    const [s, t] = [side(p), side(q)];
    if (s <= 0) out.push(p);
    if (s <= 0 !== t <= 0) out.push(p.map((v, i) => v + (s / (s - t)) * (q[i] - v)));
  });
  return out;
}

/** A triangle as n² smaller ones. */
function divided([p, q, r], n) {
  if (n === 1) return [[p, q, r]];
  const at = (i, j) => p.map((v, k) => v + (i / n) * (q[k] - v) + (j / n) * (r[k] - v));
  const out = [];
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n - i; j++) {
      out.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
      if (j < n - i - 1) out.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
  }
  return out;
}

/** Light direction, as components to the right, up and towards the eye. */
const LIGHT = [-0.35, 0.5, 0.8].map((v) => v / Math.hypot(0.35, 0.5, 0.8));

/** The colour of a triangle of [x, y, depth, value]. */
function shaded(corners, faces, colours) {
  const { mode, colour: plain, range = [0, 1], shade = 0.38 } = faces.options;
  const [p, q, r] = corners;
  const [u, v] = [[q[0] - p[0], p[1] - q[1], q[2] - p[2]], [r[0] - p[0], p[1] - r[1], r[2] - p[2]]];
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const light = Math.abs(n[0] * LIGHT[0] + n[1] * LIGHT[1] + n[2] * LIGHT[2]) / (Math.hypot(...n) || 1);
  const value = (p[3] + q[3] + r[3]) / 3;
  let base = plain;
  const of = (k) => Array.from(colours.subarray(4 * k, 4 * k + 3));
  if (mode > 1.5) base = of(Math.min(255, Math.round(p[3])));
  else if (mode > 0.5 && Math.min(p[3], q[3], r[3]) > -1e38) base = of(Math.round(255 * Math.min(1, Math.max(0, (value - range[0]) / Math.max(range[1] - range[0], 1e-30)))));
  return hex(base.map((c) => c * (1 - shade * (1 - light))));
}

/** Whether a triangle that is counter-clockwise from outside shows its inner side; y points down. */
const isTurnedAway = ([p, q, r]) => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) >= 0;

/** The shapes of faces: `depth` and `svg`. */
function* faceShapes(faces, project, width) {
  const { position, value, index, local } = faces.shown;
  const { plane = [0, 0, 0, 1], mode, range = [0, 1], edges = 0, ink = [0, 0, 0] } = faces.options;
  const colours = faces.table.image;
  const count = index ? index.length : position.length / 3;
  const vertex = (k) => {
    const p = index ? index[k] : k;
    const [b, c] = local ? [local[2 * p], local[2 * p + 1]] : [1, 1];
    return [position[3 * p], position[3 * p + 1], position[3 * p + 2], value[p], 1 - b - c, b, c];
  };
  const cuts = plane.slice(0, 3).some((v) => v !== 0);
  for (let k = 0; k < count; k += 3) {
    let polygon = [vertex(k), vertex(k + 1), vertex(k + 2)];
    if (cuts) polygon = clipped(polygon, plane);
    else if (faces.isClosed && isTurnedAway(polygon.map(project))) continue;
    for (let m = 1; m + 1 < polygon.length; m++) {
      const triangle = [polygon[0], polygon[m], polygon[m + 1]];
      const values = triangle.map((p) => p[3]);
      const spread = mode === 1 ? (Math.max(...values) - Math.min(...values)) / (range[1] - range[0] || 1) : 0;
      const n = Number.isFinite(spread) ? Math.min(PARTS, Math.max(1, Math.ceil(GRADES * spread))) : 1;
      for (const part of divided(triangle, n)) {
        const flat = part.map((p) => [...project(p), p[3]]);
        const fill = shaded(flat, faces, colours);
        const path = `M${flat.map((p) => `${short(p[0])} ${short(p[1])}`).join("L")}z`;
        // A stroke of the same colour closes the gaps between neighbours
        yield { depth: (flat[0][2] + flat[1][2] + flat[2][2]) / 3, svg: `<path d="${path}" fill="${fill}" stroke="${fill}" stroke-width=".4"/>` };
        if (!(edges > 0) || !local) continue;
        for (const [a, b] of [[0, 1], [1, 2], [2, 0]]) {
          // On an edge of the element one of the barycentric coordinates is zero
          if (![4, 5, 6].some((i) => Math.abs(part[a][i]) < 1e-6 && Math.abs(part[b][i]) < 1e-6)) continue;
          const [p, q] = [flat[a], flat[b]];
          yield { depth: (p[2] + q[2]) / 2 + 0.004 * width, svg: `<path d="M${short(p[0])} ${short(p[1])}L${short(q[0])} ${short(q[1])}" stroke="${hex(ink)}" stroke-width=".5" stroke-opacity="${short(edges)}"/>`, edge: true };
        }
      }
    }
  }
}

/** Floors, each as one shape: behind all others, or in front of them if they are seen from below. */
function* floorShapes(faces, project) {
  const { position } = faces.shown;
  const { colour: ink, opacity } = faces.options;
  for (let k = 0; k < position.length; k += 18) {
    const corners = [0, 3, 6, 15].map((i) => project(position.slice(k + i, k + i + 3)));
    const path = `M${corners.map((p) => `${short(p[0])} ${short(p[1])}`).join("L")}z`;
    yield { depth: isTurnedAway(corners) ? Infinity : -Infinity, svg: `<path d="${path}" fill="${hex(ink)}" fill-opacity="${opacity}"/>` };
  }
}

/** The shapes of segments: lines, discs if they have no length, arrows if the ends have different widths. */
function* lineShapes(lines, project, width) {
  const { segments, factors } = lines.shown;
  const { width: wide, colour: ink, opacity = 1, plane = [0, 0, 0, 1], through } = lines.options;
  const cuts = plane.slice(0, 3).some((v) => v !== 0);
  const lift = through ? Infinity : 0.004 * width;
  for (let s = 0; s < segments.length / 6; s++) {
    const [a, b] = [Array.from(segments.subarray(6 * s, 6 * s + 3)), Array.from(segments.subarray(6 * s + 3, 6 * s + 6))];
    if (cuts && [a, b].some((p) => plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] > plane[3])) continue;
    const [p, q] = [project(a), project(b)];
    const [from, to] = factors ? [factors[2 * s], factors[2 * s + 1]].map((f) => (f * wide) / 2) : [wide / 2, wide / 2];
    const depth = (p[2] + q[2]) / 2 + lift;
    const fill = `fill="${hex(ink)}"${opacity < 1 ? ` opacity="${short(opacity)}"` : ""}`;
    const long = Math.hypot(q[0] - p[0], q[1] - p[1]);
    if (long < 1e-3) yield { depth, svg: `<circle cx="${short(p[0])}" cy="${short(p[1])}" r="${short(Math.max(from, to))}" ${fill}/>` };
    else if (from === to) {
      const stroke = `stroke="${hex(ink)}" stroke-width="${short(wide)}"${opacity < 1 ? ` opacity="${short(opacity)}"` : ""}`;
      yield { depth, svg: `<path d="M${short(p[0])} ${short(p[1])}L${short(q[0])} ${short(q[1])}" ${stroke} stroke-linecap="round"/>` };
    } else {
      const [x, y] = [-(q[1] - p[1]) / long, (q[0] - p[0]) / long];
      const corners = [[p, from], [q, to], [q, -to], [p, -from]].map(([c, r]) => `${short(c[0] + r * x)} ${short(c[1] + r * y)}`);
      yield { depth, svg: `<path d="M${corners.join("L")}z" ${fill}/>` };
    }
  }
}

/** The shapes of a view from back to front; nothing if there are too many. */
function shapes(pane, view, width, height) {
  const project = projection(view, width, height);
  const all = [];
  for (const object of pane.canvas.objects) {
    if (!object.options.visible || !object.used) continue;
    const kind = object.isFloor ? floorShapes : object.isFaces ? faceShapes : lineShapes;
    for (const shape of kind(object, project, width)) {
      all.push(shape);
      if (all.length > 4 * MOST) return null;
    }
  }
  // Edges shared by two elements are drawn once
  const seen = new Set();
  const once = all.filter((s) => !s.edge || (!seen.has(s.svg) && seen.add(s.svg)));
  return once.length > MOST ? null : once.map((s, order) => ({ ...s, order })).sort((a, b) => a.depth - b.depth || a.order - b.order).map((s) => s.svg);
}

function legend(o, x, width, height, size) {
  const { map, bands, range, title } = o.legend;
  const [top, bottom] = [0.18 * height, 0.82 * height];
  const wide = Math.min(1.2 * size, 0.2 * width);
  const grade = (k, n) => css(colour(map, bands ? (k + 0.5) / n : k / (n - 1)));
  const steps = bands || 17;
  const stops = Array.from({ length: steps }, (_, k) =>
    bands
      ? `<stop offset="${k / steps}" stop-color="${grade(k, steps)}"/><stop offset="${(k + 1) / steps}" stop-color="${grade(k, steps)}"/>`
      : `<stop offset="${k / (steps - 1)}" stop-color="${grade(k, steps)}"/>`,
  );
  const out = [
    `<linearGradient id="grades" x1="0" y1="1" x2="0" y2="0">${stops.join("")}</linearGradient>`,
    `<rect x="${short(x)}" y="${short(top)}" width="${short(wide)}" height="${short(bottom - top)}" fill="url(#grades)" stroke="${o.ink}"/>`,
  ];
  const [low, high] = range;
  for (const { value, text } of ticks(low, high, 5)) {
    const y = bottom - ((value - low) / (high - low || 1)) * (bottom - top);
    out.push(`<path d="M${short(x + wide)} ${short(y)}h4" stroke="${o.ink}"/><text x="${short(x + wide + 7)}" y="${short(y + 0.35 * size)}">${text}</text>`);
  }
  const lines = [""];
  for (const word of title.split(" ")) {
    const next = `${lines.at(-1)} ${word}`.trim();
    // Letters of this font are about half as wide as they are high
    if (lines.at(-1) && 0.55 * size * next.length > width) lines.push(word);
    else lines[lines.length - 1] = next;
  }
  lines.forEach((line, k) => out.push(`<text x="${short(x)}" y="${short(top - 0.7 * size - (lines.length - 1 - k) * 1.2 * size)}">${escape(line)}</text>`));
  return out.join("");
}

/** A force arrow with its label. */
function forceScale({ length, colour: ink, text }, [x, y], size) {
  const head = Math.min(0.5 * size, 0.5 * length);
  const corners = [[length, 0], [length - head, 0.25 * size], [length - head, -0.25 * size]].map(([dx, dy]) => `${short(x + dx)} ${short(y + dy)}`);
  const line = `<path d="M${short(x)} ${short(y)}h${short(length - head)}" stroke="${ink}" stroke-width="${short(0.1 * size)}"/>`;
  return `${line}<path d="M${corners.join("L")}z" fill="${ink}"/><text x="${short(x + length + 0.5 * size)}" y="${short(y + 0.35 * size)}" fill="${ink}">${escape(text)}</text>`;
}

/** The entries of a legend with their colours. */
function list({ entries, title }, x, width, height, size) {
  const line = lineOf(entries, height, size);
  const top = (height - line * (entries.length + 1)) / 2;
  const room = width - 1.2 * line;
  const written = entries.map(({ name, colour: ink }, k) => {
    const y = top + (k + 1) * line;
    const wide = 0.38 * line * name.length > room ? ` textLength="${short(room)}" lengthAdjust="spacingAndGlyphs"` : "";
    const swatch = `<rect x="${short(x)}" y="${short(y + 0.15 * line)}" width="${short(0.7 * line)}" height="${short(0.7 * line)}" fill="${ink}"/>`;
    return `${swatch}<text x="${short(x + line)}" y="${short(y + 0.73 * line)}"${wide}>${escape(name)}</text>`;
  });
  return `<g font-size="${short(0.65 * line)}"><text x="${short(x)}" y="${short(top + 0.7 * line)}">${escape(title)}</text>${written.join("")}</g>`;
}

/** The graphic of all views next to each other with names, time and colour bar; `picture` gives a view as a bitmap if it has too many shapes. */
export function svg(panes, view, o, picture) {
  const { width: each, height } = o.size;
  const [size, all] = [13, each * panes.length];
  const bar = o.legend?.entries ? share(o.legend, size / all) * all : o.legend ? 100 : 0;
  const width = all + bar;
  const views = panes.map((pane, k) => {
    const found = shapes(pane, view, each, height);
    const inner = found ? `<g stroke-linejoin="round">${found.join("\n")}</g>` : `<image width="${each}" height="${height}" href="${picture(pane)}"/>`;
    const name = panes.length > 1 ? `<text x="${size}" y="${1.6 * size}">${escape(pane.body.title)}</text>` : "";
    return `<svg x="${k * each}" y="0" width="${each}" height="${height}">${inner}${name}</svg>`;
  });
  const paper = o.background ? `<rect width="${width}" height="${height}" fill="${o.background}"/>` : "";
  const words = o.words ? `<text x="${size}" y="${height - size}">${escape(o.words)}</text>` : "";
  const arrow = o.arrow(each, height);
  const forces = arrow ? forceScale(arrow, [size, height - (o.words ? 2.8 : 1.2) * size], size) : "";
  const place = [all, bar, height, size];
  const key = !o.legend ? "" : o.legend.entries ? list(o.legend, ...place) : legend(o, ...place);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" font-family="Arial, Helvetica, sans-serif" font-size="${size}" fill="${o.ink}">
${paper}${views.join("\n")}${words}${forces}${key}</svg>
`;
}
