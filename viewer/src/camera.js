// The camera that all cases share: an orthographic orbit camera, controlled by pointer, touch and keys.

import { Vec3 } from "ogl";

/** Viewing directions [yaw, pitch] in degrees; the first is that of the figures in reports. */
export const VIEWS = { "3-D": [-61, 21], front: [-90, 0], back: [90, 0], left: [180, 0], right: [0, 0], top: [-90, 89.99], bottom: [-90, -89.99] };

export class View {
  constructor(changed) {
    this.changed = changed;
    this.center = new Vec3();
    this.radius = 1;
    this.box = [[-1, -1, -1], [1, 1, 1]];
    this.aspect = 1;
    this.direct("3-D");
  }

  /** Brings a box into view without changing the direction. */
  frame(low, high) {
    this.box = [low, high];
    this.center.set(...low.map((l, i) => (l + high[i]) / 2));
    this.radius = 0.5 * Math.hypot(...low.map((l, i) => high[i] - l)) || 1;
    this.fit();
  }

  /** Zooms to the largest picture of the box in this direction. */
  fit() {
    const { right, up } = this.axes();
    const size = this.box[0].map((l, i) => (this.box[1][i] - l) / 2);
    const extent = (v) => Math.abs(v[0]) * size[0] + Math.abs(v[1]) * size[1] + Math.abs(v[2]) * size[2];
    const high = 1.1 * this.radius * Math.max(1, 1 / this.aspect);
    const zoom = Math.min(high / extent(up), (high * this.aspect) / extent(right));
    [this.zoom, this.shift, this.fits] = [Number.isFinite(zoom) ? 0.88 * zoom : 1, [0, 0], true];
    this.changed();
  }

  direct(name) {
    [this.yaw, this.pitch] = VIEWS[name];
    this.fit();
  }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.min(89.99, Math.max(-89.99, this.pitch + pitch));
    this.changed();
  }

  /** Pans the picture by fractions of its height. */
  pan(right, up) {
    this.fits = false;
    this.shift = [this.shift[0] - (right * 2.2) / this.zoom, this.shift[1] - (up * 2.2) / this.zoom];
    this.changed();
  }

  enlarge(factor) {
    this.fits = false;
    this.zoom = Math.min(200, Math.max(0.1, this.zoom * factor));
    this.changed();
  }

  /** Unit vectors towards the eye, to the right and upwards. */
  axes() {
    const [y, p] = [(this.yaw * Math.PI) / 180, (this.pitch * Math.PI) / 180];
    const eye = [Math.cos(y) * Math.cos(p), Math.sin(y) * Math.cos(p), Math.sin(p)];
    const right = [-Math.sin(y), Math.cos(y), 0];
    const up = [-Math.cos(y) * Math.sin(p), -Math.sin(y) * Math.sin(p), Math.cos(p)];
    return { eye, right, up };
  }

  /** Half the height of the picture [m]. */
  get half() {
    return (1.1 * this.radius) / this.zoom;
  }

  /** Pixels per metre in a picture of this size; a narrow one shows the whole width of the body. */
  scale(width, height) {
    return height / 2 / (this.half * Math.max(1, height / width));
  }

  /** Sets a camera of the library for a picture of this shape (width over height). */
  apply(camera, aspect) {
    if (this.aspect !== aspect) {
      this.aspect = aspect;
      if (this.fits) this.fit();
    }
    const { eye, right, up } = this.axes();
    // A narrow picture shows the whole width of the body
    const h = this.half * Math.max(1, 1 / aspect);
    const depth = 4 * this.radius;
    const target = [0, 1, 2].map((i) => this.center[i] + this.radius * (right[i] * this.shift[0] + up[i] * this.shift[1]));
    camera.orthographic({ left: -h * aspect, right: h * aspect, bottom: -h, top: h, near: 0.01 * depth, far: 2 * depth });
    camera.position.set(...target.map((t, i) => t + depth * eye[i]));
    camera.up.set(0, 0, 1);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    return h;
  }

  /** Follows the pointers and keys of a canvas. */
  listen(canvas) {
    const down = new Map();
    const gap = () => {
      const [a, b] = [...down.values()];
      return { size: Math.hypot(a.x - b.x, a.y - b.y), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
    };
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId);
      down.set(e.pointerId, { x: e.clientX, y: e.clientY });
    });
    canvas.addEventListener("pointermove", (e) => {
      const last = down.get(e.pointerId);
      if (!last) return;
      const high = canvas.clientHeight;
      const before = down.size === 2 ? gap() : null;
      const [dx, dy] = [e.clientX - last.x, e.clientY - last.y];
      down.set(e.pointerId, { x: e.clientX, y: e.clientY });
      if (before) {
        const now = gap();
        this.enlarge(now.size / before.size);
        this.pan((now.x - before.x) / high, (before.y - now.y) / high);
      } else if (e.buttons & 6 || e.shiftKey || e.ctrlKey) this.pan(dx / high, -dy / high);
      else this.turn(-0.4 * dx, 0.4 * dy);
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => down.delete(e.pointerId));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.enlarge(Math.exp(-0.0015 * e.deltaY));
    }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const act = {
        ArrowLeft: () => (e.shiftKey ? this.pan(-0.05, 0) : this.turn(-5, 0)),
        ArrowRight: () => (e.shiftKey ? this.pan(0.05, 0) : this.turn(5, 0)),
        ArrowUp: () => (e.shiftKey ? this.pan(0, 0.05) : this.turn(0, 5)),
        ArrowDown: () => (e.shiftKey ? this.pan(0, -0.05) : this.turn(0, -5)),
        "+": () => this.enlarge(1.1),
        "=": () => this.enlarge(1.1),
        "-": () => this.enlarge(1 / 1.1),
      }[e.key];
      if (act && !e.ctrlKey && !e.metaKey && !e.altKey) {
        e.preventDefault();
        act();
      }
    });
  }
}
