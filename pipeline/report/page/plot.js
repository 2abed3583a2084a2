// Plots in the page's colours, redrawn when these change.
import { el } from "./dom.js";

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
export function cssColor(k) {
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
