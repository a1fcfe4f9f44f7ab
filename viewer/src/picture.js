// Pictures of the views as they are on the page: PNG, animated GIF, and WebM.

import { GIFEncoder, applyPalette, quantize } from "gifenc";
import { colour, css } from "./colours.js";
import { number, ticks } from "./units.js";

const FONT = "Arial, Helvetica, sans-serif";

/** Draws views, names, time and colour bar next to each other; `o` has width, background, ink, legend, time and titles. */
export function compose(canvas, panes, view, o) {
  const bar = o.legend ? 0.13 : 0;
  const each = Math.round((o.width * (1 - bar)) / panes.length);
  const height = Math.round(each / o.aspect);
  [canvas.width, canvas.height] = [o.width, height];
  const c = canvas.getContext("2d", { willReadFrequently: o.reads ?? false });
  c.clearRect(0, 0, canvas.width, canvas.height);
  if (o.background) {
    c.fillStyle = o.background;
    c.fillRect(0, 0, canvas.width, canvas.height);
  }
  const unit = Math.max(10, height / 32);
  c.fillStyle = c.strokeStyle = o.ink;
  panes.forEach((pane, k) => {
    // Pictures twice as fine and scaled down, as far as graphics cards can
    pane.canvas.resize(each, height, o.fine ? Math.min(2, 8192 / each, 8192 / height) : 1);
    pane.draw(view, each / o.shown);
    c.imageSmoothingQuality = "high";
    c.drawImage(pane.canvas.canvas, k * each, 0, each, height);
    if (panes.length > 1) {
      c.font = `${unit}px ${FONT}`;
      c.textAlign = "left";
      c.fillText(pane.body.title, k * each + unit, 1.6 * unit, each - 2 * unit);
    }
  });
  c.font = `${unit}px ${FONT}`;
  c.textAlign = "left";
  if (o.time) c.fillText(o.time, unit, height - unit);
  if (o.legend) legend(c, o, { x: o.width * (1 - bar), width: o.width * bar, height, unit });
}

function legend(c, o, { x, width, height, unit }) {
  const { map, bands, range, title } = o.legend;
  const [top, bottom] = [0.18 * height, 0.82 * height];
  const wide = Math.min(unit, 0.2 * width);
  const steps = bands || 256;
  for (let k = 0; k < steps; k++) {
    c.fillStyle = css(colour(map, (k + 0.5) / steps));
    const y = bottom - ((k + 1) / steps) * (bottom - top);
    c.fillRect(x, y, wide, (bottom - top) / steps + 1);
  }
  c.fillStyle = c.strokeStyle = o.ink;
  c.lineWidth = Math.max(1, unit / 14);
  c.strokeRect(x, top, wide, bottom - top);
  c.font = `${0.85 * unit}px ${FONT}`;
  const [low, high] = range;
  for (const v of ticks(low, high, 5)) {
    const y = bottom - ((v - low) / (high - low || 1)) * (bottom - top);
    c.fillRect(x + wide, y - c.lineWidth / 2, 0.3 * unit, c.lineWidth);
    c.fillText(number(v), x + wide + 0.5 * unit, y + 0.3 * unit);
  }
  const words = title.split(" ");
  const lines = [""];
  for (const word of words) {
    const next = `${lines.at(-1)} ${word}`.trim();
    if (c.measureText(next).width > width - 4 && lines.at(-1)) lines.push(word);
    else lines[lines.length - 1] = next;
  }
  lines.forEach((line, k) => c.fillText(line, x, top - 0.6 * unit - (lines.length - 1 - k) * unit));
}

/** Offers bytes as a file. */
export function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const png = (canvas) => new Promise((done) => canvas.toBlob(done, "image/png"));

/** An endless GIF of `count` pictures; `paint(k)` draws picture k on the canvas. */
export async function gif(canvas, count, milliseconds, paint) {
  const out = GIFEncoder();
  for (let k = 0; k < count; k++) {
    await paint(k);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const palette = quantize(data, 256);
    out.writeFrame(applyPalette(data, palette), canvas.width, canvas.height, { palette, delay: milliseconds });
    await new Promise((next) => setTimeout(next));
  }
  out.finish();
  return new Blob([out.bytes()], { type: "image/gif" });
}

/** A WebM of the same, in the time that it shows. */
export async function webm(canvas, count, milliseconds, paint) {
  await paint(0);
  const kind = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find((k) => globalThis.MediaRecorder?.isTypeSupported(k));
  if (!kind) throw new Error("this browser records no WebM; export a GIF");
  const stream = canvas.captureStream(0);
  const [track] = stream.getVideoTracks();
  const recorder = new MediaRecorder(stream, { mimeType: kind, videoBitsPerSecond: 8e6 });
  const parts = [];
  recorder.ondataavailable = (e) => parts.push(e.data);
  const ended = new Promise((done) => (recorder.onstop = done));
  recorder.start();
  for (let k = 0; k < count; k++) {
    const from = performance.now();
    await paint(k);
    // The track has it by the standard, the stream in Firefox
    (track.requestFrame ? track : stream).requestFrame();
    await new Promise((next) => setTimeout(next, Math.max(0, milliseconds - (performance.now() - from))));
  }
  recorder.stop();
  await ended;
  return new Blob(parts, { type: "video/webm" });
}
