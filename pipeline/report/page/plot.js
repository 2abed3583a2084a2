// Figures of the report in the page's colours, redrawn when these change, and curves with a common legend.
import { Chart } from "./chart.js";
import { el } from "./page.js";
import { Space } from "./space.js";

const N_COLOURS = 8;
const DASHES = { solid: [], dash: [7, 4], dot: [2, 4], dashdot: [7, 3, 2, 3], longdash: [11, 4] };

const drawn = [];

/** Colours of the page for plots. */
export function theme() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(name).trim();
  const series = Array.from({ length: N_COLOURS }, (_, k) => of(`--series-${k}`));
  return { ink: of("--ink"), quiet: of("--quiet"), rule: of("--rule"), panel: of("--panel"), series };
}

/** Colour and dash of the k-th series. */
export function lineStyle(k) {
  const { series } = theme();
  return { colour: series[k % N_COLOURS], dash: Object.values(DASHES)[Math.floor(k / N_COLOURS) % Object.keys(DASHES).length] };
}

/** A dash by its name: dash, dot. */
export function dashNamed(name) {
  return DASHES[name];
}

/** Colour of a compartment. */
export function compartmentColor(name) {
  return theme().series[name === "medial" ? 0 : 1];
}

const FLEXION = "flexion, degrees";
let key = null;

/** The name of the key over which everything is drawn; null: flexion. */
export function drawOver(keyName) {
  key = keyName ?? null;
}

/** A value of flexion or of the key, for labels. */
export function abscissaText(value) {
  return key === null ? `${value}°` : `${value}`;
}

/** "flexion", or the name of the key. */
export function abscissaName() {
  return key ?? "flexion";
}

/** An axis with its title; that of flexion is renamed to the key. */
export function axis(title, more = {}) {
  return { title: title === FLEXION && key !== null ? key : title, ...more };
}

/** A reading of a curve: its name, value and place. */
export function reading(name, values, x, unit, digits = 2) {
  return (k) => `${name}: ${values[k].toFixed(digits)} ${unit} at ${abscissaText(Number(x[k].toFixed(1)))}`;
}

/** A named curve with its reading; `more`: other members of a layer (chart.js). */
export function curve(name, x, y, unit, more = {}) {
  return { kind: "line", name, x, y, text: reading(name, y, x, unit), ...more };
}

function swatch({ colour, dash = [], kind }) {
  const isMark = kind === "points" || kind === "band", ns = "http://www.w3.org/2000/svg", svg = document.createElementNS(ns, "svg"), shape = document.createElementNS(ns, isMark ? "circle" : "line");
  const of = (node, attributes) => { for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value); };
  of(svg, { width: 30, height: 12, "aria-hidden": true });
  of(shape, isMark ? { cx: 15, cy: 6, r: 3.5, style: `fill: ${colour}` } : { x1: 1, y1: 6, x2: 29, y2: 6, style: `stroke: ${colour}`, "stroke-width": 2.5, "stroke-dasharray": dash.join(" ") });
  svg.append(shape);
  return svg;
}

/** One box a curve, which switches it off. `entries`: { name, isOff, and the style of its layer }; `change(entry, isOff)`. */
function legend(entries, change) {
  return el("ul", { class: "legend", "aria-label": "Curves shown" }, entries.map((entry) => {
    const box = el("input", { type: "checkbox" });
    box.checked = !entry.isOff;
    box.addEventListener("change", () => change(entry, !box.checked));
    return el("li", {}, el("label", {}, box, swatch(entry), entry.name));
  }));
}

/**
 * A figure with a plot: a chart, or a picture in space if `view` is given. `make()` returns what chart.js or space.js shows, and `key`: elements below it; it is called again
 * when colours or selections change. Named layers have a legend, unless `hasLegend` is false. The returned element has `redraw()`.
 */
export function figure({ title, caption, size = "", view, make, hasLegend = true }) {
  const node = el("div", { class: `drawing ${size}`, role: "img", "aria-label": `${title}. ${caption}` }), below = el("div", { class: "key" });
  const picture = view ? new Space(node, view) : new Chart(node), off = new Set();
  const result = el("figure", {}, el("h3", {}, title), node, below, el("figcaption", {}, caption));
  result.redraw = () => {
    const { ink: text, quiet, rule } = theme(), what = { ...make(), ink: { text, quiet, rule } };
    const named = (what.layers ?? []).filter((layer, k, all) => layer.name && all.findIndex((one) => one.name === layer.name) === k);
    const items = hasLegend && named.length > 1 ? [legend(named.map((layer) => ({ ...layer, isOff: off.has(layer.name) })), ({ name }, isOff) => { if (isOff) off.add(name); else off.delete(name); result.redraw(); })] : [];
    below.replaceChildren(...items, ...(what.key ?? []));
    picture.show({ ...what, layers: what.layers?.filter((layer) => !off.has(layer.name)) });
  };
  drawn.push(result);
  return result;
}

/** Draws all figures that are in the document. */
export function drawAll() {
  for (const one of drawn) if (one.isConnected) one.redraw();
}

/** Redraws when the system's colour scheme changes and for printing, which is always light. */
export function followTheme() {
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  // A plot keeps its drawn width, so the page gets the paper's width before redrawing.
  const print = (isNow) => { document.documentElement.classList.toggle("printing", isNow); drawAll(); };
  window.addEventListener("beforeprint", () => print(true));
  window.addEventListener("afterprint", () => print(false));
}

// Curves of several quantities over flexion, with a common legend that switches them on and off.

/** True if flexion is not monotonic: the frames of a measured cycle are drawn as points, not as a line. */
export function isCycle(flexion) {
  return flexion.some((value, k) => k > 0 && value < flexion[k - 1]);
}

// Offset that makes curves agree at their first common flexion.
function startOf(one, key, flexion) {
  let nearest = null;
  one.flexion.forEach((value, k) => {
    if (one[key][k] === null) return;
    if (nearest === null || Math.abs(value - flexion) < Math.abs(one.flexion[nearest] - flexion)) nearest = k;
  });
  return nearest === null ? 0 : one[key][nearest];
}

function firstCommonFlexion(curves) {
  return Math.max(...curves.map((one) => Math.min(...one.flexion)));
}

function styleOf(one) {
  return one.isPoints ? { kind: "points", colour: `${lineStyle(one.index).colour}a6`, size: 5 } : { ...lineStyle(one.index), width: one.width };
}

function layersOf(state, { key, unit }) {
  const shown = state.curves.filter((one) => !one.isOff && one[key]);
  const start = state.isZeroed && shown.length > 0 ? firstCommonFlexion(shown) : null;
  return shown.flatMap((one) => {
    const offset = start === null ? 0 : startOf(one, key, start), y = one[key].map((value) => (value === null ? null : value - offset));
    const band = one.band && key === "internal" && start === null ? [{ kind: "band", x: one.flexion, ...one.band, colour: `${lineStyle(one.index).colour}26` }] : [];
    return [...band, curve(one.label, one.flexion, y, unit, styleOf(one))];
  });
}

// Rotations in rows of two, translations in rows of three.
function inRows(quantities, figures) {
  const row = (unit) => figures.filter((_, k) => quantities[k].unit === unit);
  return [["degrees", ""], ["mm", "three"]].filter(([unit]) => row(unit).length > 0)
    .map(([unit, columns]) => el("div", { class: `columns ${columns}` }, row(unit)));
}

/**
 * `curves`: { label, flexion, KEY: values, isOff, isPoints, band: { low, high } }; `quantities`: { key, name, unit, caption }.
 * `over` is the title of the axis of the curves' `flexion`. The result has `redraw()` and `state` ({ curves, isZeroed }).
 */
export function curvePlots(curves, quantities, { size = "", over = FLEXION } = {}) {
  // Visible curves come first: they get the most distinct colours.
  const ordered = [...curves].sort((a, b) => Boolean(a.isOff) - Boolean(b.isOff));
  const state = { curves: ordered.map((one, index) => ({ ...one, index })), isZeroed: false };
  const figures = quantities.map((quantity) => figure({
    title: quantity.title ?? quantity.name, caption: quantity.caption, size, hasLegend: false,
    make: () => ({ x: axis(over), y: axis(`${quantity.name}, ${quantity.unit}`), layers: layersOf(state, quantity) }),
  }));
  const redraw = () => figures.forEach((one) => one.redraw());
  const entries = state.curves.map((one) => ({ ...styleOf(one), colour: `var(--series-${one.index % N_COLOURS})`, name: one.label, isOff: one.isOff, one }));
  const result = el("div", {}, entries.length > 1 ? legend(entries, ({ one }, isOff) => { one.isOff = isOff; redraw(); }) : null, ...inRows(quantities, figures));
  result.redraw = redraw;
  result.state = state;
  return result;
}
