// Building blocks of the page: elements, groups of controls, and the inputs in them.

import { read } from "./units.js";

/** An element with attributes, listeners (`on…`) and children. */
export function el(name, attributes = {}, ...children) {
  const out = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) out.addEventListener(key.slice(2), value);
    else if (key === "checked" || key === "value" || key === "disabled" || key === "open") out[key] = value;
    else if (value !== false && value !== undefined) out.setAttribute(key, value);
  }
  out.append(...children);
  return out;
}

/** A collapsible group. */
export const group = (title, open, ...children) => el("details", { open, class: "group" }, el("summary", {}, title), ...children);

export const row = (label, input) => el("label", { class: "row" }, el("span", {}, label), input);

export function check(label, checked, change, colour) {
  const box = el("input", { type: "checkbox", checked, onchange: () => change(box.checked) });
  const text = el("span", {}, label);
  const parts = [box];
  if (colour) {
    const swatch = el("i", { class: "swatch" });
    swatch.style.background = colour;
    parts.push(swatch);
  }
  return el("label", { class: "check" }, ...parts, text);
}

/** Options are [value, text, disabled, title]. */
export function select(label, options, value, change) {
  const make = ([key, text, disabled, title]) => el("option", { value: key, disabled: disabled ?? false, title }, text);
  const input = el("select", { onchange: () => change(input.value), "aria-label": label }, ...options.map(make));
  input.value = value;
  return input;
}

export function slider(label, [low, high, step], value, change) {
  const input = el("input", { type: "range", min: low, max: high, step, oninput: () => change(Number(input.value)), "aria-label": label });
  input.value = value;
  return input;
}

export function field(label, value, change, width = "5.5em") {
  const input = el("input", { type: "text", inputmode: "decimal", value, "aria-label": label, onchange: () => change(input.value) });
  input.style.width = width;
  return input;
}

/** A field for a number from `low` to `high`; any other text is replaced by the previous number. */
export function numeric(label, value, [low, high], change) {
  const input = field(label, String(value), (text) => {
    const v = read(text);
    if (Number.isFinite(v)) change((value = Math.min(high, Math.max(low, v))));
    input.value = String(value);
  });
  return input;
}

export const button = (text, label, click) => el("button", { type: "button", "aria-label": label, title: label, onclick: click }, text);

const PATHS = {
  start: "M3 3h2v10H3z M13 3v10L6 8z", back: "M11 3v10L4 8z", play: "M4 2v12l10-6z", pause: "M4 3h3v10H4z M9 3h3v10H9z", next: "M5 3v10l7-5z",
  theme: "M8 1a7 7 0 1 0 0 14z M8 1a7 7 0 0 1 0 14v-1a6 6 0 0 0 0-12z", menu: "M2 3h12v2H2z M2 7h12v2H2z M2 11h12v2H2z",
};

/** A 16-pixel icon for a button. */
export function icon(name) {
  const make = (kind, attributes) => {
    const out = document.createElementNS("http://www.w3.org/2000/svg", kind);
    for (const [key, value] of Object.entries(attributes)) out.setAttribute(key, value);
    return out;
  };
  const svg = make("svg", { viewBox: "0 0 16 16", width: 16, height: 16, "aria-hidden": "true" });
  svg.append(make("path", { d: PATHS[name], fill: "currentColor" }));
  return svg;
}
