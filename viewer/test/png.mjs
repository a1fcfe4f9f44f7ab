// Pictures as bytes: reads the PNG that browsers write, and compares two of them.
import { deflateSync, inflateSync } from "node:zlib";

/** Width, height and [height × width × 3] red, green and blue of a PNG of 8 bits without interlacing. */
export function decode(bytes) {
  const read = (at) => bytes.readUInt32BE(at);
  const [width, height, depth, kind, interlaced] = [read(16), read(20), bytes[24], bytes[25], bytes[28]];
  const channels = { 2: 3, 6: 4 }[kind];
  if (depth !== 8 || !channels || interlaced) throw new Error(`a PNG of ${depth} bits, kind ${kind}, is not read`);
  const parts = [];
  for (let at = 8; at < bytes.length; at += read(at) + 12) if (bytes.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(bytes.subarray(at + 8, at + 8 + read(at)));
  const data = inflateSync(Buffer.concat(parts));
  const row = width * channels;
  const lines = new Uint8Array(row * height);
  for (let y = 0; y < height; y++) {
    const filter = data[y * (row + 1)];
    for (let x = 0; x < row; x++) {
      const left = x < channels ? 0 : lines[y * row + x - channels];
      const up = y ? lines[(y - 1) * row + x] : 0;
      const corner = y && x >= channels ? lines[(y - 1) * row + x - channels] : 0;
      const p = left + up - corner;
      const [a, b, c] = [Math.abs(p - left), Math.abs(p - up), Math.abs(p - corner)];
      const paeth = a <= b && a <= c ? left : b <= c ? up : corner;
      lines[y * row + x] = data[y * (row + 1) + 1 + x] + [0, left, up, (left + up) >> 1, paeth][filter];
    }
  }
  const rgb = new Uint8Array(3 * width * height);
  for (let k = 0; k < width * height; k++) for (let i = 0; i < 3; i++) rgb[3 * k + i] = lines[channels * k + i];
  return { width, height, rgb };
}

/** The check of a part of a PNG (ISO 3309). */
function crc32(bytes) {
  let crc = -1;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; k++) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return ~crc >>> 0;
}

/** A picture as PNG. */
export function encode({ width, height, rgb }) {
  const chunk = (name, body) => {
    const out = Buffer.alloc(12 + body.length);
    out.writeUInt32BE(body.length, 0);
    out.write(name, 4, "latin1");
    out.set(body, 8);
    out.writeUInt32BE(crc32(out.subarray(4, 8 + body.length)), 8 + body.length);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 2, 0, 0, 0], 8);
  const lines = Buffer.alloc(height * (3 * width + 1));
  for (let y = 0; y < height; y++) lines.set(rgb.subarray(3 * width * y, 3 * width * (y + 1)), y * (3 * width + 1) + 1);
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  return Buffer.concat([signature, chunk("IHDR", head), chunk("IDAT", deflateSync(lines, { level: 9 })), chunk("IEND", Buffer.alloc(0))]);
}

/** The part of a picture from a corner, in squares of 4 × 4 pixels by their means: what is left where the smoothing of edges differs. */
export function reduced({ width, rgb }, [x0, y0, w, h]) {
  const small = { width: w >> 2, height: h >> 2 };
  const sums = new Float32Array(3 * small.width * small.height);
  for (let y = 0; y < 4 * small.height; y++) {
    for (let x = 0; x < 4 * small.width; x++) for (let i = 0; i < 3; i++) sums[3 * ((y >> 2) * small.width + (x >> 2)) + i] += rgb[3 * ((y0 + y) * width + x0 + x) + i] / 16;
  }
  return { ...small, rgb: Uint8Array.from(sums, Math.round) };
}

/** Share of the pixels that differ in a colour by more than `most` of 255; 1 for pictures of other sizes. */
export function difference(a, b, most = 24) {
  if (a.width !== b.width || a.height !== b.height) return 1;
  let count = 0;
  for (let k = 0; k < a.rgb.length; k += 3) if ([0, 1, 2].some((i) => Math.abs(a.rgb[k + i] - b.rgb[k + i]) > most)) count++;
  return count / (a.rgb.length / 3);
}
