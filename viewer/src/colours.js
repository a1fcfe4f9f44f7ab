// Colour maps that are readable with any colour vision, and the colours of marks.

const stops = (text) => text.match(/.{6}/g).map((hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16)));

/** viridis (van der Walt & Smith 2015), cividis (Nuñez, Anderton & Renslow 2018), vik (Crameri 2018), grey: equidistant stops. */
export const MAPS = {
  viridis: stops("44015448186a472d7b424086355f8d2d708e26828e21918c1f9e8928ae8034b679 4ec36b6ccd5a8fd744b5de2bdde318fde725".replaceAll(" ", "")),
  cividis: stops("00224e123570 2b446e3b496c4d556b 5a5d6d666970 72747578798382867d8f8978 9c9570aba074 b9ac70c9b86fd9c65ae5cf52fee838".replaceAll(" ", "")),
  "blue–orange": stops("0012612a5b8f3a78a46e9fbfa4c3d7d6e2e9f0ece4e8d2bfdcae90ce8c60bd6a34a14a12590008"),
  grey: stops("262626f2f2f2"),
};

/** Okabe & Ito 2008, as in the figures of the reports; from the ninth on, the colours farthest in CIELAB from the preceding ones. */
export const PALETTE = stops(
  "0072b2d55e00009e73cc79a7e69f0056b4e9f0e4428c6bb1" +
    "1010e810e810e810d0e810507050103030b0509010b0b070e8907050e8e890303010e890901070105010b0e870d070e8",
);

/** Colour number k; after the end of the palette the colours repeat, darker. */
export const distinct = (k) => PALETTE[k % PALETTE.length].map((v) => v * 0.6 ** Math.floor(k / PALETTE.length));

export const css = (c) => `rgb(${c.map((v) => Math.round(v)).join(",")})`;

/** Colour at s from 0 to 1. */
export function colour(map, s) {
  const all = MAPS[map];
  const x = Math.min(1, Math.max(0, s)) * (all.length - 1);
  const k = Math.min(all.length - 2, Math.floor(x));
  return all[k].map((v, i) => v + (x - k) * (all[k + 1][i] - v));
}

/** 256 colours as bytes for a texture, in `bands` equal ones if it is not 0. */
export function table(map, bands) {
  const out = new Uint8Array(4 * 256);
  for (let k = 0; k < 256; k++) {
    const s = bands ? (Math.min(bands - 1, Math.floor((k / 256) * bands)) + 0.5) / bands : k / 255;
    out.set([...colour(map, s).map(Math.round), 255], 4 * k);
  }
  return out;
}

/** The colours of a list as a texture. */
export function listTable(list) {
  const out = new Uint8Array(4 * 256);
  for (let k = 0; k < 256; k++) out.set([...list[Math.min(list.length - 1, k)], 255], 4 * k);
  return out;
}
