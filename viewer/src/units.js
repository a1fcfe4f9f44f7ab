// Formats and parses numbers with units.

const PREFIXES = {
  m: [[1e-6, "µm", 1e6], [1e-3, "mm", 1e3], [1, "mm", 1e3], [Infinity, "m", 1]],
  Pa: [[1, "Pa", 1], [1e3, "Pa", 1], [1e6, "kPa", 1e-3], [1e9, "MPa", 1e-6], [Infinity, "GPa", 1e-9]],
  N: [[1e-3, "µN", 1e6], [1, "mN", 1e3], [Infinity, "N", 1]],
  "m/s": [[1, "mm/s", 1e3], [Infinity, "m/s", 1]],
};

/** Unit and factor for numbers up to `size` in an SI unit. */
export function scaled(unit, size) {
  const all = PREFIXES[unit];
  if (!all || !(size > 0)) return { unit, factor: 1 };
  const [, name, factor] = all.find(([below]) => size < below);
  return { unit: name, factor };
}

/** Parses a number with a decimal point or comma; NaN for any other text. */
export const read = (text) => {
  const plain = text.trim().replaceAll("−", "-").replace(",", ".");
  return plain === "" ? NaN : Number(plain);
};

/** The largest value of the form 1, 2 or 5 times a power of ten that is not above a size. */
export function rounded(size) {
  const ten = 10 ** Math.floor(Math.log10(size));
  return [5, 2, 1].map((f) => f * ten).find((v) => v <= size * 1.000001) ?? ten;
}

/** In exponential notation, with a given number of decimals, without trailing zeros. */
const powered = (v, decimals) => v.toExponential(Math.max(0, decimals)).replace(/\.?0+e/, "e");

/** Four digits. */
export function number(v, digits = 4) {
  if (!Number.isFinite(v)) return "–";
  if (v === 0) return "0";
  const size = Math.abs(v);
  const text = size >= 1e5 || size < 1e-3 ? powered(v, digits - 1) : String(Number(v.toPrecision(digits)));
  return text.replaceAll("-", "−");
}

/** Number of digits that resolves a tenth of the distance to other numbers: four or more. */
export function digits(v, gap) {
  const count = Math.ceil(Math.log10(Math.abs(v) / gap)) + 2;
  return Number.isFinite(count) ? Math.min(15, Math.max(4, count)) : 4;
}

const exponent = (v) => Number(Math.abs(v).toExponential().split("e")[1]);

/** Round numbers between two ends, each with its text: in one notation, with the digits that distinguish neighbours. */
export function ticks(low, high, count = 5) {
  const span = high - low;
  if (!(span > 0)) return [{ value: low, text: number(low) }];
  const raw = span / count;
  const ten = Math.floor(Math.log10(raw));
  const size = 10 ** ten;
  const factor = [1, 2, 2.5, 5, 10].find((f) => f * size >= raw * 0.999);
  const step = factor * size;
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k++) values.push(Number((k * step).toPrecision(15)));
  const last = factor === 2.5 ? ten - 1 : ten;
  const largest = Math.max(...values.map(Math.abs));
  const isPlain = largest === 0 || (largest >= 1e-3 && largest < 1e5);
  const written = (v) => (v === 0 ? "0" : isPlain ? String(Number(v.toFixed(Math.max(0, -last)))) : powered(v, exponent(v) - last));
  return values.map((value) => ({ value, text: written(value).replaceAll("-", "−") }));
}
