// Texts of the marks of axes and colour bars: no two marks have one text, and each text is the number to which it belongs.
import assert from "node:assert/strict";
import { number, ticks } from "../src/units.js";

const texts = (low, high) => ticks(low, high).map(({ text }) => text);
assert.deepEqual(texts(0.99999, 1.00001), ["0.99999", "0.999995", "1", "1.000005", "1.00001"]);
assert.deepEqual(texts(1, 1.0125), ["1", "1.0025", "1.005", "1.0075", "1.01", "1.0125"]);
assert.deepEqual(texts(-0.001, 0), ["−0.001", "−0.0008", "−0.0006", "−0.0004", "−0.0002", "0"]);
assert.deepEqual(texts(0, 5e-4), ["0", "1e−4", "2e−4", "3e−4", "4e−4", "5e−4"]);
assert.deepEqual(texts(200000, 200001), ["2e+5", "2.000002e+5", "2.000004e+5", "2.000006e+5", "2.000008e+5", "2.00001e+5"]);
assert.deepEqual(texts(0, 200000), ["0", "5e+4", "1e+5", "1.5e+5", "2e+5"]);
assert.deepEqual(texts(0, 50), ["0", "10", "20", "30", "40", "50"]);
assert.deepEqual(texts(3, 3), ["3"]);
assert.deepEqual([0, 1234.56, 2e5, 1.5e-4, NaN].map((v) => number(v)), ["0", "1235", "2e+5", "1.5e−4", "–"]);
for (const offset of [0, 1, -1, 37.3, 1e3, 1e6]) {
  for (const span of [1e-7, 3e-5, 0.0125, 0.7, 4, 900]) {
    const marks = ticks(offset, offset + span);
    assert.equal(new Set(marks.map(({ text }) => text)).size, marks.length);
    for (const { value, text } of marks) {
      assert.ok(Math.abs(Number(text.replaceAll("−", "-")) - value) < 1e-6 * span + 1e-14 * Math.abs(offset), `${text} for ${value}`);
    }
  }
}
