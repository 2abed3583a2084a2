// Plots in the page's colours, redrawn when these change, and curves with a common legend.
import { el } from "./page.js";

// Plots in the page's colours, redrawn when these change.

const N_COLOURS = 8;
const DASHES = ["solid", "dash", "dot", "dashdot", "longdash"];

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
  return { color: series[k % series.length], dash: DASHES[Math.floor(k / series.length) % DASHES.length] };
}

/** Colour of the k-th series for page elements; follows the colour scheme. */
function cssColor(k) {
  return `var(--series-${k % N_COLOURS})`;
}

/** Colour of a compartment. */
export function compartmentColor(name) {
  return theme().series[name === "medial" ? 0 : 1];
}

function axisBase() {
  const { rule, quiet } = theme();
  return { gridcolor: rule, zerolinecolor: rule, linecolor: rule, tickcolor: rule, color: quiet, automargin: true };
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
  const { ink } = theme();
  return { ...axisBase(), title: { text: title === FLEXION && key !== null ? key : title, font: { size: 13, color: ink }, standoff: 8 }, ...more };
}

/** Three axes of a 3-D scene. */
export function scene(x, y, z, more = {}) {
  const { quiet, ink, rule } = theme();
  const of = (title) => ({ title: { text: title, font: { size: 12, color: ink } }, color: quiet, gridcolor: rule, zerolinecolor: rule, tickfont: { size: 10 }, showbackground: false });
  return { xaxis: of(x), yaxis: of(y), zaxis: of(z), ...more };
}

function layoutBase() {
  const { ink, quiet, panel, rule } = theme();
  return {
    autosize: true,
    margin: { l: 58, r: 16, t: 12, b: 48 },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: "system-ui, 'Segoe UI', 'Noto Sans', 'DejaVu Sans', sans-serif", size: 12, color: ink },
    hoverlabel: { bgcolor: panel, bordercolor: rule, font: { color: ink } },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: quiet, activecolor: ink },
    legend: { orientation: "h", x: 0, y: -0.22, yanchor: "top" },
    showlegend: false,
  };
}

const CONFIG = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["lasso2d", "select2d"], showLink: false };

function draw(entry) {
  const { data, layout } = entry.make();
  return window.Plotly.react(entry.node, data, { ...layoutBase(), ...layout }, CONFIG);
}

/**
 * A figure with a plot. `make()` returns { data, layout }; it is called again when colours or selections change.
 * The returned element has `redraw()` and `plotNode`.
 */
export function figure({ title, caption, size = "", make }) {
  const node = el("div", { class: `drawing ${size}`, role: "img", "aria-label": `${title}. ${caption}` });
  const entry = { node, make };
  drawn.push(entry);
  const result = el("figure", {}, el("h3", {}, title), node, el("figcaption", {}, caption));
  result.redraw = () => draw(entry);
  result.plotNode = node;
  return result;
}

/** Draws all figures that are in the document. */
export function drawAll() {
  return Promise.all(drawn.filter((entry) => entry.node.isConnected).map(draw));
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

function swatch(index, isPoints) {
  const style = { ...lineStyle(index), color: cssColor(index) };
  const dash = { solid: "", dash: "7 4", dot: "2 3", dashdot: "7 3 2 3", longdash: "11 4" }[style.dash];
  const ns = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(ns, "svg");
  svg.setAttribute("width", "30");
  svg.setAttribute("height", "12");
  svg.setAttribute("aria-hidden", "true");
  const shape = document.createElementNS(ns, isPoints ? "circle" : "line");
  const attributes = isPoints ? { cx: 15, cy: 6, r: 3.5, style: `fill: ${style.color}` }
    : { x1: 1, y1: 6, x2: 29, y2: 6, style: `stroke: ${style.color}`, "stroke-width": 2.5, "stroke-dasharray": dash };
  for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
  svg.append(shape);
  return svg;
}

/** True if flexion is not monotonic: the frames of a measured cycle are drawn as points, not as a line. */
export function isCycle(flexion) {
  return flexion.some((value, k) => k > 0 && value < flexion[k - 1]);
}

function curveTrace(curve, key, style, unit, offset) {
  const y = curve[key].map((value) => (value === null ? null : value - offset));
  const appearance = curve.isPoints ? { mode: "markers", marker: { color: style.color, size: 5, opacity: 0.65 } }
    : { mode: "lines", line: { color: style.color, dash: style.dash, width: curve.width ?? 2 } };
  return { type: "scatter", x: curve.flexion, y, name: curve.label, ...appearance, hovertemplate: `%{y:.2f} ${unit} at ${abscissaText("%{x:.1f}")}<extra>${curve.hover}</extra>` };
}

// Fills the area between the low and the high end of a band.
function bandTraces(curve, style) {
  const line = { width: 0 }, common = { type: "scatter", mode: "lines", line, hoverinfo: "skip", showlegend: false };
  return [{ ...common, x: curve.flexion, y: curve.band.low },
    { ...common, x: curve.flexion, y: curve.band.high, fill: "tonexty", fillcolor: `${style.color}26` }];
}

// Offset that makes curves agree at their first common flexion.
function startOf(curve, key, flexion) {
  let nearest = null;
  curve.flexion.forEach((value, k) => {
    if (curve[key][k] === null) return;
    if (nearest === null || Math.abs(value - flexion) < Math.abs(curve.flexion[nearest] - flexion)) nearest = k;
  });
  return nearest === null ? 0 : curve[key][nearest];
}

function firstCommonFlexion(curves) {
  return Math.max(...curves.map((curve) => Math.min(...curve.flexion)));
}

function tracesOf(state, quantity) {
  const shown = state.curves.filter((curve) => !curve.isOff && curve[quantity.key]);
  const start = state.isZeroed && shown.length > 0 ? firstCommonFlexion(shown) : null;
  return shown.flatMap((curve) => {
    const style = lineStyle(curve.index);
    const offset = start === null ? 0 : startOf(curve, quantity.key, start);
    const band = curve.band && quantity.key === "internal" && start === null ? bandTraces(curve, style) : [];
    return [...band, curveTrace(curve, quantity.key, style, quantity.unit, offset)];
  });
}

function legend(state, redraw) {
  const list = el("ul", { class: "legend", "aria-label": "Curves shown" });
  state.curves.forEach((curve) => {
    const box = el("input", { type: "checkbox" });
    box.checked = !curve.isOff;
    box.addEventListener("change", () => { curve.isOff = !box.checked; redraw(); });
    list.append(el("li", {}, el("label", {}, box, swatch(curve.index, curve.isPoints), curve.label)));
  });
  return list;
}

function escaped(text) {
  return text.replace(/[<>&]/g, (c) => ({ "<": "&lt;", ">": "&gt;", "&": "&amp;" })[c]);
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
  // plotly interprets HTML in names, so they are escaped.
  // Visible curves come first: they get the most distinct colours.
  const ordered = [...curves].sort((a, b) => Boolean(a.isOff) - Boolean(b.isOff));
  const state = { curves: ordered.map((curve, index) => ({ ...curve, index, hover: escaped(curve.label) })), isZeroed: false };
  const figures = quantities.map((quantity) => figure({
    title: quantity.title ?? quantity.name,
    caption: quantity.caption,
    size,
    make: () => ({ data: tracesOf(state, quantity), layout: { xaxis: axis(over), yaxis: axis(`${quantity.name}, ${quantity.unit}`), hovermode: "closest" } }),
  }));
  const redraw = () => figures.forEach((one) => one.redraw());
  const result = el("div", {}, state.curves.length > 1 ? legend(state, redraw) : null,
    ...inRows(quantities, figures));
  result.redraw = redraw;
  result.state = state;
  return result;
}
