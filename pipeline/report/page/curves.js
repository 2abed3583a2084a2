// Curves of several quantities over flexion, with a common legend that switches them on and off.
import { el } from "./dom.js";
import { abscissaText, axis, cssColor, figure, lineStyle } from "./plot.js";

const FLEXION = "flexion, degrees";

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

function trace(curve, key, style, unit, offset) {
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
    return [...band, trace(curve, quantity.key, style, quantity.unit, offset)];
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
