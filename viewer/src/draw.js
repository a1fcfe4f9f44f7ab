// Drawing on one canvas: faces coloured by a lookup table, and lines of any width with round ends.

import { Camera, Geometry, Mesh, Program, Renderer, Texture, Transform } from "ogl";

/** Marks a missing value. */
const NONE = -3e38;

const FACE_VERTEX = `#version 300 es
in vec3 position; in float value; in vec2 local;
uniform mat4 modelViewMatrix; uniform mat4 projectionMatrix;
out vec3 seen; out vec3 place; out float v; out vec3 corners;
void main() {
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  seen = p.xyz; place = position; v = value; corners = vec3(1.0 - local.x - local.y, local);
  gl_Position = projectionMatrix * p;
}`;

/** Parts of the face shader that cost time in every pixel: a section disables the early depth test, edges take three more derivatives. */
const FACE_FRAGMENT = (cut, edges) => `#version 300 es
precision highp float;
in vec3 seen; in vec3 place; in float v; in vec3 corners;
uniform vec3 ink; uniform vec2 stroke;
uniform sampler2D table; uniform vec2 range; uniform vec4 plane; uniform vec3 plain; uniform float opacity; uniform float mode; uniform float shade;
out vec4 result;
void main() {
  ${cut ? "if (dot(plane.xyz, place) > plane.w) discard;" : ""}
  vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
  float light = abs(dot(n, normalize(vec3(-0.35, 0.5, 0.8))));
  vec3 base = plain;
  if (mode > 1.5) base = texelFetch(table, ivec2(int(v + 0.5), 0), 0).rgb;
  else if (mode > 0.5 && v > -1e38) base = texture(table, vec2(clamp((v - range.x) / max(range.y - range.x, 1e-30), 0.002, 0.998), 0.5)).rgb;
  base *= 1.0 - shade * (1.0 - light);
  // Pixels to the nearest edge of the element: one of its three barycentric coordinates is zero there
  ${edges ? `vec3 away = corners / max(fwidth(corners), vec3(1e-9));
  base = mix(base, ink, stroke.y * (1.0 - smoothstep(stroke.x - 0.5, stroke.x + 0.5, min(away.x, min(away.y, away.z)))));` : ""}
  result = vec4(base * opacity, opacity);
}`;

const LINE_VERTEX = `#version 300 es
in vec2 corner; in vec3 a; in vec3 b; in vec2 ends;
uniform mat4 modelViewMatrix; uniform mat4 projectionMatrix; uniform vec2 size; uniform float width; uniform float lift;
out vec2 at; flat out float len; flat out vec2 radii; out vec3 place;
void main() {
  vec4 p = projectionMatrix * modelViewMatrix * vec4(a, 1.0);
  vec4 q = projectionMatrix * modelViewMatrix * vec4(b, 1.0);
  vec2 d = (q.xy - p.xy) * size * 0.5;
  len = length(d);
  vec2 along = len > 1e-4 ? d / len : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  radii = 0.5 * width * ends;
  float r = max(radii.x, radii.y) + 1.0;
  at = vec2(corner.x > 0.5 ? len + r : -r, corner.y * r);
  vec4 at3 = mix(p, q, corner.x);
  vec2 pixel = (corner.x > 0.5 ? r : -r) * along + corner.y * r * across;
  place = mix(a, b, corner.x);
  gl_Position = vec4(at3.xy + pixel * 2.0 / size, at3.z - lift, 1.0);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec2 at; flat in float len; flat in vec2 radii; in vec3 place;
uniform vec3 plain; uniform vec4 plane; uniform float opacity;
out vec4 result;
void main() {
  if (dot(plane.xyz, place) > plane.w) discard;
  float s = len > 1e-4 ? clamp(at.x / len, 0.0, 1.0) : 0.0;
  float cover = clamp(mix(radii.x, radii.y, s) + 0.5 - distance(at, vec2(s * len, 0.0)), 0.0, 1.0);
  if (cover < 0.02) discard;
  result = vec4(plain * cover * opacity, cover * opacity);
}`;

/** A plane that cuts nothing. */
export const EVERYWHERE = [0, 0, 0, 1];

/** Whether the machine renders in software: then there is no multisampling, and only lines smooth the edges. */
const isSlow = (() => {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  // Frees the context for the canvases of the page
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
})();
const dots = () => (isSlow ? 1 : Math.min(2, devicePixelRatio || 1));

/** One canvas with its objects, which are drawn in the order in which they were added. */
export class Canvas {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new Renderer({ canvas, alpha: true, antialias: !isSlow, premultipliedAlpha: true, webgl: 2, dpr: dots() });
    this.gl = this.renderer.gl;
    if (!this.renderer.isWebgl2) throw new Error("this browser draws without WebGL 2, which the viewer needs");
    this.camera = new Camera(this.gl);
    this.scene = new Transform();
    this.size = [1, 1];
    this.objects = [];
    this.programs = new Map();
  }

  /** A shader program of this canvas: it is built when it is first needed, and shared by all objects of its kind. */
  program(key, parts) {
    if (!this.programs.has(key)) {
      const program = new Program(this.gl, { uniforms: {}, transparent: true, ...parts() });
      this.programs.set(key, program);
    }
    return this.programs.get(key);
  }

  resize(width, height, dpr = dots()) {
    this.renderer.dpr = dpr;
    this.renderer.setSize(width, height);
    this.size = [this.gl.drawingBufferWidth, this.gl.drawingBufferHeight];
  }

  add(object) {
    object.attach(this);
    this.objects.push(object);
    return object;
  }

  draw(view, pixels = 1) {
    view.apply(this.camera, this.size[0] / this.size[1]);
    for (const o of this.objects) o.prepare(this.size, this.renderer.dpr * pixels);
    this.renderer.render({ scene: this.scene, camera: this.camera, sort: false, frustumCull: false });
  }
}

/** The common base of faces and lines: a mesh of the library that is rebuilt when the number of vertices grows. */
class Drawn {
  constructor(options) {
    this.options = { colour: [200, 200, 200], opacity: 1, visible: true, plane: EVERYWHERE, ...options };
    this.capacity = 0;
    this.used = 0;
  }

  attach(canvas) {
    Object.assign(this, { canvas, gl: canvas.gl, program: null });
  }

  /** The library's node, which exists once there are numbers. */
  #make() {
    this.node = new Mesh(this.gl, { geometry: new Geometry(this.gl, { position: { size: 3, data: new Float32Array(9) } }), program: this.chosen() });
    this.node.frustumCulled = false;
    this.node.setParent(this.canvas.scene);
    // All objects of a kind share the program: each sets its own uniforms just before it is drawn
    this.node.onBeforeRender(() => this.#apply());
  }

  /** Sets the attributes of `count` vertices; the index does not change. */
  set(count, attributes, index, local) {
    this.used = count;
    if (count === 0) return;
    if (!this.node) this.#make();
    if (count > this.capacity || index) {
      this.node.geometry.remove();
      this.capacity = index ? count : 4 * Math.ceil(0.33 * count);
      this.node.geometry = this.makeGeometry(attributes, index, this.capacity, local);
    } else {
      for (const [name, data] of Object.entries(attributes)) {
        const attribute = this.node.geometry.attributes[name];
        attribute.data.set(data);
        attribute.needsUpdate = true;
      }
    }
  }

  prepare(size, dpr) {
    if (!this.node) return;
    this.node.visible = this.options.visible && this.used > 0;
    this.frame = { size, dpr };
    if (this.node.visible) this.node.program = this.chosen();
  }

  #apply() {
    const { colour, opacity, plane } = this.options;
    const { program } = this.node;
    program.depthWrite = opacity === 1 || this.options.writes === true;
    program.depthTest = !this.options.through;
    const values = { plain: colour.map((c) => c / 255), opacity, plane, ...this.own(this.frame) };
    for (const [name, value] of Object.entries(values)) (program.uniforms[name] ??= {}).value = value;
  }
}

/** Triangles with a number at each vertex. */
export class Faces extends Drawn {
  isFaces = true;

  /** Selects the cheapest program for the options. Opaque faces do not blend, and a closed uncut body shows only its outer sides. */
  chosen() {
    const { plane, opacity, edges } = this.options;
    const [cut, lined] = [plane !== EVERYWHERE, (edges ?? 0) > 0];
    const program = this.canvas.program(`faces ${cut} ${lined}`, () => ({ vertex: FACE_VERTEX, fragment: FACE_FRAGMENT(cut, lined) }));
    program.blendFunc = opacity === 1 ? {} : { src: this.gl.ONE, dst: this.gl.ONE_MINUS_SRC_ALPHA };
    program.cullFace = this.isClosed && !cut ? this.gl.BACK : false;
    return program;
  }

  makeGeometry({ position, value }, index, capacity, local) {
    const grow = (data, size) => {
      const out = new Float32Array(size * capacity);
      out.set(data);
      return out;
    };
    const attributes = { position: { size: 3, data: grow(position, 3), usage: this.gl.DYNAMIC_DRAW }, value: { size: 1, data: grow(value, 1), usage: this.gl.DYNAMIC_DRAW } };
    attributes.local = { size: 2, data: grow(local ?? [], 2) };
    if (index) attributes.index = { data: index };
    return new Geometry(this.gl, attributes);
  }

  /** Sets positions and values of the vertices; values that are not finite are drawn in the plain colour. With the index: two barycentric coordinates of
  each vertex. */
  show(position, value, index, local) {
    const numbers = value ?? new Float32Array(position.length / 3);
    this.shown = { position, value: numbers, index: index ?? this.shown?.index, local: local ?? this.shown?.local };
    for (let k = 0; k < numbers.length; k++) if (!Number.isFinite(numbers[k])) numbers[k] = NONE;
    this.set(position.length / 3, { position, value: numbers }, index, local);
    if (this.node && !this.node.geometry.attributes.index) this.node.geometry.setDrawRange(0, this.used);
  }

  setTable(bytes) {
    this.table ??= new Texture(this.gl, { image: bytes, width: 256, height: 1, generateMipmaps: false, flipY: false, minFilter: this.gl.NEAREST, magFilter: this.gl.NEAREST });
    this.table.image = bytes;
    this.table.needsUpdate = true;
  }

  own({ dpr }) {
    if (!this.table) this.setTable(new Uint8Array(1024));
    return {
      table: this.table, ink: (this.options.ink ?? [0, 0, 0]).map((c) => c / 255), stroke: [0.1 + 0.3 * dpr, this.options.edges ?? 0],
      range: this.options.range ?? [0, 1], mode: this.options.mode ?? 0, shade: this.options.shade ?? 0.38,
    };
  }
}

/** Line segments; a segment of zero length is a disc. */
export class Lines extends Drawn {
  chosen() {
    const program = this.canvas.program("lines", () => ({ vertex: LINE_VERTEX, fragment: LINE_FRAGMENT, cullFace: false }));
    program.setBlendFunc(this.gl.ONE, this.gl.ONE_MINUS_SRC_ALPHA);
    return program;
  }

  /** Four vertices for each segment. (Instancing would be shorter, but software renderers draw each instance separately.) */
  makeGeometry({ a, b, ends }, _, capacity) {
    const grow = (data, size) => {
      const out = new Float32Array(size * capacity);
      out.set(data);
      return { size, data: out, usage: this.gl.DYNAMIC_DRAW };
    };
    const segments = Math.ceil(capacity / 4);
    const corner = new Float32Array(8 * segments);
    const index = new Uint32Array(6 * segments);
    for (let s = 0; s < segments; s++) {
      corner.set([0, -1, 1, -1, 1, 1, 0, 1], 8 * s);
      index.set([4 * s, 4 * s + 1, 4 * s + 2, 4 * s, 4 * s + 2, 4 * s + 3], 6 * s);
    }
    return new Geometry(this.gl, { corner: { size: 2, data: corner }, a: grow(a, 3), b: grow(b, 3), ends: grow(ends, 2), index: { data: index } });
  }

  /** Sets both ends [segments × 6], and the width factors at the ends [segments × 2]. */
  show(segments, factors) {
    const n = segments.length / 6;
    this.shown = { segments, factors };
    const [a, b, ends] = [new Float32Array(12 * n), new Float32Array(12 * n), new Float32Array(8 * n).fill(1)];
    for (let s = 0; s < n; s++) {
      for (let k = 4 * s; k < 4 * s + 4; k++) {
        for (let i = 0; i < 3; i++) {
          a[3 * k + i] = segments[6 * s + i];
          b[3 * k + i] = segments[6 * s + 3 + i];
        }
        if (factors) ends.set([factors[2 * s], factors[2 * s + 1]], 2 * k);
      }
    }
    this.set(4 * n, { a, b, ends });
    this.node?.geometry.setDrawRange(0, 6 * n);
  }

  own({ size, dpr }) {
    return { size, width: this.options.width * dpr, lift: this.options.lift ?? 1.5e-3 };
  }
}
