// Pictures of the current views: PNG, animated GIF, and WebM.

import { GIFEncoder, applyPalette, quantize } from "gifenc";
import { colour, css } from "./colours.js";
import { ticks } from "./units.js";

const FONT = "Arial, Helvetica, sans-serif";

/** Draws views, names, time and colour bar next to each other; `o` has width, background, ink, legend, words and the scale of the forces. */
export function compose(canvas, panes, view, o) {
  const bar = share(o.legend, Math.max(10, o.width / o.aspect / panes.length / 32) / o.width);
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
    // Views are drawn at twice the resolution and scaled down, as far as the graphics card allows
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
  if (o.words) c.fillText(o.words, unit, height - unit);
  const arrow = o.arrow(each, height);
  if (arrow) forceScale(c, arrow, [unit, height - (o.words ? 2.8 : 1.2) * unit], unit);
  const place = { x: o.width * (1 - bar), width: o.width * bar, height, unit };
  if (o.legend) (o.legend.entries ? list : legend)(c, o, place);
}

/** Fraction of a picture that its legend takes; `unit` is the font size as such a fraction. */
export function share(legend, unit) {
  if (!legend?.entries) return legend ? 0.13 : 0;
  const longest = Math.max(...legend.entries.map((e) => e.name.length));
  return Math.min(0.3, Math.max(0.13, (0.6 * longest + 3) * unit));
}

/** Line spacing of a list in a picture of this height. */
export const lineOf = (entries, height, unit) => Math.min(1.5 * unit, (0.9 * height) / (entries.length + 1));

/** A force arrow with its label. */
function forceScale(c, { length, colour: ink, text }, [x, y], unit) {
  const head = Math.min(0.5 * unit, 0.5 * length);
  c.fillStyle = ink;
  c.fillRect(x, y - 0.05 * unit, length - head, 0.1 * unit);
  c.beginPath();
  [[length, 0], [length - head, 0.25 * unit], [length - head, -0.25 * unit]].forEach(([dx, dy]) => c.lineTo(x + dx, y + dy));
  c.fill();
  c.fillText(text, x + length + 0.5 * unit, y + 0.35 * unit);
}

/** The entries of a legend with their colours. */
function list(c, o, { x, width, height, unit }) {
  const { entries, title } = o.legend;
  const line = lineOf(entries, height, unit);
  const top = (height - line * (entries.length + 1)) / 2;
  c.font = `${0.65 * line}px ${FONT}`;
  c.fillStyle = o.ink;
  c.fillText(title, x, top + 0.7 * line);
  entries.forEach((entry, k) => {
    const y = top + (k + 1) * line;
    c.fillStyle = entry.colour;
    c.fillRect(x, y + 0.15 * line, 0.7 * line, 0.7 * line);
    c.fillStyle = o.ink;
    c.fillText(entry.name, x + line, y + 0.73 * line, width - 1.2 * line);
  });
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
  for (const { value, text } of ticks(low, high, 5)) {
    const y = bottom - ((value - low) / (high - low || 1)) * (bottom - top);
    c.fillRect(x + wide, y - c.lineWidth / 2, 0.3 * unit, c.lineWidth);
    c.fillText(text, x + wide + 0.5 * unit, y + 0.3 * unit);
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

/** Offers bytes for download as a file. */
export function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const png = (canvas) => new Promise((done) => canvas.toBlob(done, "image/png"));

/** A looping GIF of `count` pictures; `paint(k)` draws picture k on the canvas. */
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

/** A WebM movie of the pictures, recorded in real time. */
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
    // In the standard it belongs to the track, in Firefox to the stream
    (track.requestFrame ? track : stream).requestFrame();
    await new Promise((next) => setTimeout(next, Math.max(0, milliseconds - (performance.now() - from))));
  }
  recorder.stop();
  await ended;
  return new Blob(parts, { type: "video/webm" });
}
