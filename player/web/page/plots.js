// Plots: maps over the attitudes, curves over flexion, contact paths on the plateau.
import { Chart, cssOn, rangeOf, scaleBar, SCALES } from "../../../pipeline/report/page/chart.js";
import { degree } from "./geometry.js";
import { boxOf } from "./layers.js";
import { stable } from "./motion.js";
import { formatNumber, plausibilities } from "./readings.js";

const darkScheme = matchMedia("(prefers-color-scheme: dark)");
/// Colours of charts; `lines`: of the raw poses, and of the set shown.
export const inkNow = () => (darkScheme.matches ? { text: "#e6ebf1", quiet: "#a9b4c0", rule: "#333d49", lines: ["#f0a35e", "#5fb4ea"] } : { text: "#1a222c", quiet: "#4a5563", rule: "#e2e6ea", lines: ["#c2500a", "#0b6aa8"] });

/// Calls `onSeen` when the element comes into view, and says whether it is there: charts out of view are not drawn.
class Sight {
  constructor(element, onSeen) {
    this.isSeen = false;
    new IntersectionObserver((entries) => {
      this.isSeen = entries.at(-1).isIntersecting;
      if (this.isSeen) onSeen();
    }).observe(element);
  }
}

/// The statuses of attitudes in the order of their codes.
const statuses = [
  { code: -1, label: "pending", colour: [190, 196, 203] },
  { code: 0, label: "solved", colour: [55, 140, 98] },
  { code: 1, label: "no contact", colour: [230, 159, 0] },
  { code: 2, label: "no clearance", colour: [204, 121, 167] },
  { code: 3, label: "iteration limit", colour: [213, 94, 0] },
  { code: 4, label: "unbounded", colour: [86, 95, 180] },
];
/// Colour of a cell without a value.
const empty = "rgb(222 225 229)";

// Maps over flexion and varus: raw, the chosen set, their difference, and the status of each attitude.

/// The quantity at every node, NaN without a pose.
function valuesAt(model, motion, quantity) {
  const values = new Float64Array(model.flexion.length * model.varus.length);
  let k = 0;
  for (const flexion of model.flexion) {
    for (const varus of model.varus) {
      const pose = motion.at({ flexion: flexion * degree, varus: varus * degree });
      values[k++] = pose.isSolved ? quantity.of(pose) : NaN;
    }
  }
  return values;
}

/// Maps over flexion and varus: a quantity in the raw poses and in a set, their difference, and the status of each attitude.
export class Maps {
  constructor(container, onSelect) {
    this.panels = Object.fromEntries(["raw", "set", "difference", "status"].map((name) => [name, this.#panel(container, onSelect)]));
  }

  #panel(container, onSelect) {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const place = Object.assign(document.createElement("div"), { className: "map" }), key = document.createElement("div");
    figure.append(caption, place, key);
    container.append(figure);
    const chart = new Chart(place);
    return { figure, caption, key, onSelect, chart, sight: new Sight(figure, () => chart.redraw()), mark: { kind: "ring", x: 0, y: 0 } };
  }

  /// `of(k)`: colour and text of node k.
  #show({ chart, mark, onSelect }, model, of) {
    const [x, y] = [model.flexion, model.varus].map((axis) => Array.from(axis));
    const node = (i, j) => of(i * y.length + j);
    chart.show({
      ink: inkNow(), onSelect, x: {}, y: { isPlain: y.length === 1 },
      layers: [{ kind: "cells", x, y, colourOf: (i, j) => node(i, j).colour, text: (i, j) => `flexion ${x[i]}°, varus ${y[j]}°: ${node(i, j).text}` }, mark],
    });
  }

  #fill(panel, model, caption, values, range, scale) {
    panel.caption.textContent = caption;
    this.#show(panel, model, (k) => (Number.isFinite(values[k]) ? { colour: cssOn(scale, values[k], range), text: formatNumber(values[k]) } : { colour: empty, text: "no pose" }));
    panel.key.replaceChildren(scaleBar(scale, formatNumber(range[0]), formatNumber(range[1])));
  }

  #fillStatus(model) {
    const { caption, key } = this.panels.status, rgb = (colour) => `rgb(${colour.join(" ")})`;
    const known = new Map(statuses.map(({ code, label, colour }) => [code, { colour: rgb(colour), text: label }]));
    const doubtful = new Map(plausibilities.map(({ code, name, colour }) => [code, { colour: rgb(colour), text: name }]));
    caption.textContent = "Status of each attitude";
    this.#show(this.panels.status, model, (k) => doubtful.get(model.plausibility?.[k]) ?? known.get(model.status[k]) ?? { colour: empty, text: "" });
    key.className = "legend";
    const countOf = (code, values) => values.reduce((count, found) => count + (found === code), 0);
    const doubts = plausibilities.map(({ code, name, colour }) => ({ label: name, colour, count: countOf(code, model.plausibility ?? []) }));
    const kinds = statuses.map(({ code, label, colour }) => ({ label, colour, count: countOf(code, model.status) - (code === stable ? doubts.reduce((sum, { count }) => sum + count, 0) : 0) }));
    key.replaceChildren(...[...kinds, ...doubts].filter(({ count }) => count > 0).map(({ label, colour, count }) => {
      const item = document.createElement("span");
      item.style.setProperty("--c", rgb(colour));
      item.textContent = `${label}: ${count}`;
      return item;
    }));
  }

  /// `motion` belongs to the set `name`. A set that determines the varus has no maps.
  setModel(model, raw, motion, name, quantity) {
    const isGrid = model.varus.length > 1 && model.flexion.length > 1;
    const hasOwn = isGrid && name !== "raw" && !motion.isVarusFree;
    this.panels.raw.figure.hidden = !isGrid;
    this.panels.set.figure.hidden = this.panels.difference.figure.hidden = !hasOwn;
    this.#fillStatus(model);
    if (!isGrid) return;
    const rawValues = valuesAt(model, raw, quantity), what = `${quantity.label}, ${quantity.unit}`;
    const values = hasOwn ? valuesAt(model, motion, quantity) : rawValues, range = rangeOf(rawValues, values);
    this.#fill(this.panels.raw, model, `${what}: raw`, rawValues, range, SCALES.viridis);
    if (!hasOwn) return;
    this.#fill(this.panels.set, model, `${what}: ${name}`, values, range, SCALES.viridis);
    const difference = values.map((x, k) => x - rawValues[k]);
    const most = Math.max(...rangeOf(difference).map(Math.abs));
    this.#fill(this.panels.difference, model, `${what}: ${name} minus raw`, difference, [-most, most], SCALES.difference);
  }

  /// Marks the attitude; degrees.
  draw(flexion, varus) {
    for (const { sight, chart, mark } of Object.values(this.panels)) {
      Object.assign(mark, { x: flexion, y: varus });
      if (sight.isSeen) chart.redraw();
    }
  }
}

// Curves over flexion at the current varus, with the current attitude.

const mostPoints = 181;
const sampleBand = "bands: between the poses of the samples at 5 % and 95 % of internal rotation";
const bandInk = "#8fb3cc", bandFill = "#0b6aa822";
/// Of lines of one kind, colour-blind safe (Okabe and Ito 2008); the second round is dashed.
const lineColours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#56b4e9", "#7f7f7f"];
export const lineStyle = (k) => ({ colour: lineColours[k % lineColours.length], dash: k < lineColours.length ? undefined : [5, 3] });

/// Linear between the model's flexions; null where an end is missing.
function between(axis, values, x) {
  const above = axis.findIndex((a) => a >= x);
  if (above <= 0) return Number.isFinite(values[Math.max(above, 0)]) ? values[Math.max(above, 0)] : null;
  const s = (x - axis[above - 1]) / (axis[above] - axis[above - 1]), value = s === 1 ? values[above] : (1 - s) * values[above - 1] + s * values[above];
  return Number.isFinite(value) ? value : null;
}

/// Sampled flexions in degrees over the grid's range; includes the nodes.
export function sampledFlexion(model) {
  const { flexion } = model;
  if (flexion.length >= 46 || flexion.length === 1) return Array.from(flexion);
  const n = Math.min(mostPoints, 4 * (flexion.length - 1) + 1);
  return Array.from({ length: n }, (_, k) => flexion[0] + (k / (n - 1)) * (flexion.at(-1) - flexion[0]));
}

/// { x, low, high } of values over flexion at several motions: `valuesAt(k)` of each at x[k].
export function bandOf(x, valuesAt) {
  const all = x.map((_, k) => valuesAt(k).filter((value) => value !== null));
  const end = (of) => all.map((values) => (values.length > 0 ? of(...values) : null));
  return { x, low: end(Math.min), high: end(Math.max) };
}

/// A quantity at flexions in degrees, null without a pose; `varusOf(flexion)` in radians.
export function valuesOf(motion, flexion, varusOf, quantity) {
  return flexion.map((f) => {
    const pose = motion.at({ flexion: f * degree, varus: varusOf(f * degree) });
    return pose.isSolved ? quantity.of(pose) : null;
  });
}

/// Lines against flexion, with a mark at the present pose.
export class CurvePlot {
  constructor(container, onSelect) {
    const place = container.appendChild(Object.assign(document.createElement("div"), { className: "curve" }));
    this.key = container.appendChild(Object.assign(document.createElement("p"), { className: "legend" }));
    this.chart = new Chart(place);
    this.onSelect = onSelect;
    this.marks = [{ kind: "upright", x: 0, width: 1 }, { kind: "points", x: [], y: [], size: 9 }];
    this.sight = new Sight(container, () => this.#draw());
  }

  /// `make()`, called when the plot is in view or `isNow`, gives { title, unit, lines: [{ name, y, colour, dash, width, x, band: { x, low, high } of the samples' motions, which bandText explains }],
  /// where x is sampledFlexion unless given, band: of the
  /// samples of an uncertain job, at the model's flexions, spans: of doubtful flexions, amber, and of those without a pose, red }.
  setCurves(model, make, isNow = false) {
    Object.assign(this, { model, make });
    if (this.sight.isSeen || isNow) this.#draw();
  }

  #draw() {
    if (!this.make) return this.chart.redraw();
    const { title, unit, lines, band, spans, bandText = sampleBand } = this.make(), { model } = this, ink = inkNow();
    this.make = null;
    this.spans = spans;
    const x = sampledFlexion(model), text = (label, at, y) => (k) => `${label}: ${formatNumber(y[k])} ${unit} at ${formatNumber(at[k])}°`;
    const line = ({ name, colour, dash, width = 2, y, x: own = x }) => ({ kind: "line", name, x: own, y, colour, dash, width, text: text(name, own, y) });
    this.lines = lines.map(line);
    const ends = band ? ["high", "low"].map((end) => line({ name: end === "high" ? "95 % of the samples" : "5 %", colour: bandInk, width: 1, y: x.map((f) => between(model.flexion, band[end], f)) })) : [];
    this.band = band ? [{ kind: "band", x, low: ends[1].y, high: ends[0].y, colour: bandFill }, ...ends] : [];
    const ofLines = lines.filter((one) => one.band).map((one) => ({ kind: "band", ...one.band, colour: `${one.colour}33` }));
    this.band.push(...ofLines);
    for (const mark of this.marks) mark.colour = ink.text;
    this.chart.show({
      ink, onSelect: this.onSelect, x: { title: "flexion, °" }, y: { title: `${title}, ${unit}` },
      layers: [{ kind: "spans", spans: spans.map((span) => ({ ...span, colour: span.hasPose ? "#ffb02e55" : "#eb5a3c55" })) }, ...this.band, ...this.lines, ...this.marks],
    });
    this.key.replaceChildren(...[...this.lines, ...ends].map(({ name, colour, dash }) => {
      const item = Object.assign(document.createElement("span"), { textContent: name, className: dash ? "dashed" : "" });
      item.style.setProperty("--c", colour);
      return item;
    }), ...(ofLines.length > 0 ? [bandText] : []));
  }

  /// Marks the current flexion in degrees and, of one quantity, its value (NaN if unknown).
  setMark(flexion, value = NaN) {
    Object.assign(this.marks[0], { x: flexion });
    Object.assign(this.marks[1], { x: [flexion], y: [value] });
    if (this.sight.isSeen) this.chart.redraw();
  }
}

// Contact points of the compartments over flexion at one varus, and their plot seen from above the moving body.

/// Colour-blind safe, after Okabe and Ito (2008).
export const compartmentColours = { medial: "#0b6aa8", lateral: "#c2500a" };

// Larger steps between neighbouring flexions are jumps to another facet or horn, not rolling or sliding.
const longestStepMm = 4;

/// For each flexion the grid column with the nearest varus; `varusAt(flexion)` in degrees.
export function columnsAlong(model, varusAt) {
  return Array.from(model.flexion, (flexion) => {
    const wanted = varusAt(flexion);
    let best = 0;
    model.varus.forEach((varus, j) => { if (Math.abs(varus - wanted) < Math.abs(model.varus[best] - wanted)) best = j; });
    return best;
  });
}

/// Cells in contact, at most one per flexion: [{ flexion, point mm, isAt }]; isAt(flexion) is true if this cell is the nearest.
export function pathAlong(model, name, columns) {
  const table = model.contactPaths[name], n = model.varus.length, path = [];
  for (let i = 0; i < model.flexion.length; ++i) {
    const at = 3 * (i * n + columns[i]), point = Array.from(table.subarray(at, at + 3));
    if (!point.every(Number.isFinite)) continue;
    const low = i > 0 ? (model.flexion[i - 1] + model.flexion[i]) / 2 : -Infinity;
    const high = i + 1 < model.flexion.length ? (model.flexion[i] + model.flexion[i + 1]) / 2 : Infinity;
    path.push({ flexion: model.flexion[i], point, isAt: (flexion) => flexion >= low && flexion < high });
  }
  return path;
}

/// The path split at jumps.
export function unbroken(path) {
  const pieces = [];
  path.forEach((cell, k) => {
    const before = path[k - 1]?.point, { point } = cell;
    const isNear = before && Math.hypot(point[0] - before[0], point[1] - before[1], point[2] - before[2]) <= longestStepMm;
    if (isNear) pieces.at(-1).push(cell);
    else pieces.push([cell]);
  });
  return pieces;
}

/// Draws the moving body's contact parts from above (anterior up, the subject's right to the right) and both paths.
export class PlateauPlot {
  constructor(canvas) {
    this.canvas = canvas;
  }

  setModel(model) {
    this.model = model;
    this.part = model.bodies.moving.parts[0];
    this.bounds = boxOf(model.bodies.moving);
    this.underlay = null;
  }

  #scale() {
    const { low, high } = this.bounds, { width, height } = this.canvas;
    const mm = Math.min(width / (1.12 * (high[2] - low[2])), height / (1.12 * (high[0] - low[0])));
    return (p) => [width / 2 + mm * (p[2] - (low[2] + high[2]) / 2), height / 2 - mm * (p[0] - (low[0] + high[0]) / 2)];
  }

  #drawUnderlay(place) {
    const { width, height } = this.canvas;
    this.underlay = Object.assign(document.createElement("canvas"), { width, height });
    const pen = this.underlay.getContext("2d"), { vertices, triangles, component } = this.part;
    const corner = (t, k) => vertices.subarray(3 * triangles[3 * t + k], 3 * triangles[3 * t + k] + 3);
    const depth = Array.from(component, (_, t) => corner(t, 0)[1] + corner(t, 1)[1] + corner(t, 2)[1]);
    for (const t of depth.map((_, t) => t).sort((a, b) => depth[a] - depth[b])) {
      const [a, b, c] = [0, 1, 2].map((k) => corner(t, k));
      const u = b.map((x, k) => x - a[k]), v = c.map((x, k) => x - a[k]);
      const up = u[2] * v[0] - u[0] * v[2], length = Math.hypot(u[1] * v[2] - u[2] * v[1], up, u[0] * v[1] - u[1] * v[0]);
      if (!(up > 0)) continue;
      const isMeniscus = this.model.bodies.moving.components[component[t]].material === "meniscus";
      const light = 0.55 + 0.42 * (up / length);
      pen.fillStyle = pen.strokeStyle = isMeniscus ? `rgb(${235 * light} ${196 * light} ${188 * light})` : `rgb(${252 * light} ${246 * light} ${232 * light})`;
      pen.beginPath();
      for (const p of [a, b, c]) pen.lineTo(...place(p));
      pen.closePath();
      pen.fill();
      pen.stroke();  // covers seams between neighbouring triangles
    }
  }

  draw(columns, flexionDeg) {
    const pen = this.canvas.getContext("2d"), place = this.#scale(), { width, height } = this.canvas;
    if (this.underlay?.width !== width || this.underlay.height !== height) this.#drawUnderlay(place);
    pen.clearRect(0, 0, width, height);
    pen.drawImage(this.underlay, 0, 0);
    if (!this.model.contactPaths) return;
    for (const compartment of ["medial", "lateral"]) {
      this.#drawPath(pen, place, pathAlong(this.model, `${compartment}_moving`, columns), compartmentColours[compartment], flexionDeg);
    }
  }

  #drawPath(pen, place, path, colour, flexionDeg) {
    const px = this.canvas.width / Math.max(1, this.canvas.clientWidth);
    const line = (cells, width, dash) => {
      pen.lineWidth = width * px;
      pen.setLineDash(dash);
      pen.beginPath();
      for (const { point } of cells) pen.lineTo(...place(point));
      pen.stroke();
    };
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineCap = "round";
    line(path, 0.8, [2 * px, 3 * px]);  // dashed across the jumps
    for (const piece of unbroken(path)) line(piece.length > 1 ? piece : [piece[0], piece[0]], 2.2, []);
    const here = path.find(({ isAt }) => isAt(flexionDeg));
    if (!here) return;
    pen.beginPath();
    pen.arc(...place(here.point), 5 * px, 0, 2 * Math.PI);
    pen.fill();
    pen.strokeStyle = "#ffffff";
    pen.stroke();
  }
}
