// Plots: maps over the attitudes, curves over flexion, contact paths on the plateau.
import uPlot from "uplot";
import { degree } from "./geometry.js";
import { boxOf } from "./layers.js";
import { stable } from "./motion.js";
import { formatNumber, plausibilities } from "./readings.js";

// Colour scales of the maps: stops on [0, 1], interpolated linearly.

/// Viridis (van der Walt and Smith 2015), nine stops: increasing lightness, safe for colour-blind viewers and print.
const viridis = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
/// Blue, white, orange: diverging, for differences about zero.
const diverging = [[11, 76, 140], [98, 160, 212], [246, 246, 244], [240, 164, 105], [170, 66, 6]];

function colourBetween(stops, s) {
  const at = Math.min(Math.max(s, 0), 1) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
  return stops[k].map((x, c) => Math.round(x + (at - k) * (stops[k + 1][c] - x)));
}

const scales = {
  value: (s) => colourBetween(viridis, s),
  difference: (s) => colourBetween(diverging, s),
};

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
const empty = [222, 225, 229];

// A map over flexion (right) and varus (up) with the current attitude marked. A click or drag selects an attitude.

const marginLeft = 34, marginBottom = 24, marginTop = 4, marginRight = 8;

/// Limits of the cell around node k of an axis: the midpoints to its neighbours.
function edges(at, k) {
  const step = at.length > 1 ? (at.at(-1) - at[0]) / (at.length - 1) : 1;
  const low = k > 0 ? (at[k - 1] + at[k]) / 2 : at[0] - step / 2;
  const high = k + 1 < at.length ? (at[k] + at[k + 1]) / 2 : at.at(-1) + step / 2;
  return [low, high];
}

/// At most `most` round numbers within the range.
function ticks(low, high, most) {
  const step = [0.5, 1, 2, 5, 10, 15, 30, 45, 90].find((s) => (high - low) / s <= most) ?? 180;
  const found = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9; x += step) found.push(x);
  return found;
}

class AttitudeMap {
  constructor(canvas, onSelect) {
    this.canvas = canvas;
    const select = (event) => {
      if (!this.axes || (event.type === "pointermove" && event.buttons === 0)) return;
      if (event.type === "pointerdown") canvas.setPointerCapture(event.pointerId);
      const box = canvas.getBoundingClientRect();
      onSelect(...this.#attitudeAt(event.clientX - box.left, event.clientY - box.top));
    };
    canvas.addEventListener("pointerdown", select);
    canvas.addEventListener("pointermove", select);
  }

  /// `colourOf(i, j)` returns [r, g, b] of a node; axes in degrees.
  setCells(axes, colourOf) {
    this.axes = axes;
    this.range = { flexion: [edges(axes.flexion, 0)[0], edges(axes.flexion, axes.flexion.length - 1)[1]],
                   varus: [edges(axes.varus, 0)[0], edges(axes.varus, axes.varus.length - 1)[1]] };
    this.colourOf = colourOf;
    this.underlay = null;
  }

  #x(flexion, width) { return marginLeft + ((flexion - this.range.flexion[0]) / (this.range.flexion[1] - this.range.flexion[0])) * (width - marginLeft - marginRight); }
  #y(varus, height) { return height - marginBottom - ((varus - this.range.varus[0]) / (this.range.varus[1] - this.range.varus[0])) * (height - marginBottom - marginTop); }

  #attitudeAt(x, y) {
    const { clientWidth: width, clientHeight: height } = this.canvas, { flexion, varus } = this.range;
    return [flexion[0] + ((x - marginLeft) / (width - marginLeft - marginRight)) * (flexion[1] - flexion[0]),
            varus[0] + ((height - marginBottom - y) / (height - marginBottom - marginTop)) * (varus[1] - varus[0])];
  }

  #drawCells(width, height, px) {
    const { width: w, height: h } = this.canvas;
    this.underlay = Object.assign(document.createElement("canvas"), { width: w, height: h });
    const pen = this.underlay.getContext("2d"), { flexion, varus } = this.axes;
    for (let i = 0; i < flexion.length; ++i) {
      const [left, right] = edges(flexion, i).map((f) => Math.round(px * this.#x(f, width)));
      for (let j = 0; j < varus.length; ++j) {
        const [bottom, top] = edges(varus, j).map((v) => Math.round(px * this.#y(v, height)));
        pen.fillStyle = `rgb(${this.colourOf(i, j).join(" ")})`;
        pen.fillRect(left, top, Math.max(right - left, 1), Math.max(bottom - top, 1));
      }
    }
    pen.scale(px, px);
    this.#drawTicks(pen, width, height);
  }

  #drawTicks(pen, width, height) {
    pen.fillStyle = "#4a5563";
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    for (const f of ticks(...this.range.flexion, 7)) pen.fillText(`${f}°`, this.#x(f, width), height - 8);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const v of this.axes.varus.length > 1 ? ticks(...this.range.varus, 5) : []) pen.fillText(`${v}°`.replace("-", "−"), marginLeft - 5, this.#y(v, height));
  }

  /// Marks the attitude, in degrees.
  draw(flexion, varus) {
    const { canvas } = this, { clientWidth: width, clientHeight: height } = canvas;
    if (!this.axes || width === 0) return;
    const px = Math.min(window.devicePixelRatio, 2), w = Math.round(width * px), h = Math.round(height * px);
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height, this.underlay] = [w, h, null];
    if (!this.underlay) this.#drawCells(width, height, px);
    const pen = canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, w, h);
    pen.drawImage(this.underlay, 0, 0);
    pen.scale(px, px);
    const x = this.#x(flexion, width), y = this.axes.varus.length > 1 ? this.#y(varus, height) : (height - marginBottom + marginTop) / 2;
    for (const [colour, thick] of [["#ffffff", 4], ["#11161d", 1.6]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = thick;
      pen.beginPath();
      pen.arc(x, y, 6, 0, 2 * Math.PI);
      pen.stroke();
    }
  }
}

// Maps over flexion and varus: raw, the chosen set, their difference, and the status of each attitude.

const barStops = 9;

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

function rangeOf(...columns) {
  let low = Infinity, high = -Infinity;
  for (const column of columns) {
    for (const x of column) {
      if (!Number.isFinite(x)) continue;
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
  }
  return low <= high ? [low, high] : [0, 0];
}

/// Maps over flexion and varus: a quantity in the raw poses and in a set, their difference, and the status of each attitude.
export class Maps {
  constructor(container, onSelect) {
    this.panels = Object.fromEntries(["raw", "set", "difference", "status"].map((name) => [name, this.#panel(container, onSelect)]));
  }

  #panel(container, onSelect) {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const canvas = document.createElement("canvas"), key = document.createElement("div");
    figure.append(caption, canvas, key);
    container.append(figure);
    return { figure, caption, key, map: new AttitudeMap(canvas, onSelect) };
  }

  #fill(panel, model, caption, values, range, scale) {
    const n = model.varus.length, width = range[1] - range[0];
    panel.caption.textContent = caption;
    panel.map.setCells(model, (i, j) => {
      const x = values[i * n + j];
      return Number.isFinite(x) ? scale(width > 0 ? (x - range[0]) / width : 0.5) : empty;
    });
    const stops = Array.from({ length: barStops }, (_, k) => `rgb(${scale(k / (barStops - 1)).join(" ")})`);
    const bar = document.createElement("i");
    bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    panel.key.className = "scale";
    panel.key.replaceChildren(formatNumber(range[0]), bar, formatNumber(range[1]));
  }

  #fillStatus(model) {
    const { caption, key, map } = this.panels.status, n = model.varus.length;
    const known = new Map(statuses.map((status) => [status.code, status]));
    const doubtful = new Map(plausibilities.map((one) => [one.code, one]));
    caption.textContent = "Status of each attitude";
    map.setCells(model, (i, j) => doubtful.get(model.plausibility?.[i * n + j])?.colour ?? known.get(model.status[i * n + j])?.colour ?? empty);
    key.className = "legend";
    const countOf = (code, values) => values.reduce((count, found) => count + (found === code), 0);
    const doubts = plausibilities.map(({ code, name, colour }) => ({ label: name, colour, count: countOf(code, model.plausibility ?? []) }));
    const kinds = statuses.map(({ code, label, colour }) => ({ label, colour, count: countOf(code, model.status) - (code === stable ? doubts.reduce((sum, { count }) => sum + count, 0) : 0) }));
    key.replaceChildren(...[...kinds, ...doubts].filter(({ count }) => count > 0).map(({ label, colour, count }) => {
      const item = document.createElement("span");
      item.style.setProperty("--c", `rgb(${colour.join(" ")})`);
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
    this.#fill(this.panels.raw, model, `${what}: raw`, rawValues, range, scales.value);
    if (!hasOwn) return;
    this.#fill(this.panels.set, model, `${what}: ${name}`, values, range, scales.value);
    const difference = values.map((x, k) => x - rawValues[k]);
    const most = Math.max(...rangeOf(difference).map(Math.abs));
    this.#fill(this.panels.difference, model, `${what}: ${name} minus raw`, difference, [-most, most], scales.difference);
  }

  /// Degrees.
  draw(flexion, varus) {
    for (const { figure, map } of Object.values(this.panels)) if (!figure.hidden) map.draw(flexion, varus);
  }
}

// Curves over flexion at the current varus (uPlot): raw, the chosen set, and the current attitude.

const mostPoints = 181;
const ink = "#4a5563", rule = "#e2e6ea", bandInk = "#8fb3cc", bandFill = "#0b6aa822";

/// Linear between the model's flexions; null where an end is missing.
function between(axis, values, x) {
  const above = axis.findIndex((a) => a >= x);
  if (above <= 0) return Number.isFinite(values[Math.max(above, 0)]) ? values[Math.max(above, 0)] : null;
  const s = (x - axis[above - 1]) / (axis[above] - axis[above - 1]), value = s === 1 ? values[above] : (1 - s) * values[above - 1] + s * values[above];
  return Number.isFinite(value) ? value : null;
}

/// Sampled flexions in degrees over the grid's range; includes the nodes.
function sampledFlexion(model) {
  const { flexion } = model;
  if (flexion.length >= 46 || flexion.length === 1) return Array.from(flexion);
  const n = Math.min(mostPoints, 4 * (flexion.length - 1) + 1);
  return Array.from({ length: n }, (_, k) => flexion[0] + (k / (n - 1)) * (flexion.at(-1) - flexion[0]));
}

function valuesOf(motion, flexion, varusOf, quantity) {
  return flexion.map((f) => {
    const pose = motion.at({ flexion: f * degree, varus: varusOf(f * degree) });
    return pose.isSolved ? quantity.of(pose) : null;
  });
}

/// A quantity against flexion, with a mark at the present pose.
export class CurvePlot {
  constructor(container, onSelect) {
    this.container = container;
    this.onSelect = onSelect;
    new ResizeObserver(() => this.plot?.setSize(this.#size())).observe(container);
  }

  #size() { return { width: Math.max(this.container.clientWidth, 100), height: 230 }; }

  /// `curves`: [{ label, motion, colour, dash }]; `varusOf(flexion)` in radians; `band`: of the samples of an uncertain job, at the model's flexions;
  /// `spans`: of doubtful flexions.
  setCurves(model, curves, varusOf, quantity, band, spans) {
    this.spans = spans;
    const flexion = sampledFlexion(model);
    const ends = band ? [band.high, band.low].map((values) => flexion.map((f) => between(model.flexion, values, f))) : [];
    const data = [flexion, ...curves.map(({ motion }) => valuesOf(motion, flexion, varusOf, quantity)), ...ends];
    const shape = JSON.stringify([quantity.name, curves.map((c) => c.label), ends.length]);
    if (this.plot && this.shape === shape) this.plot.setData(data);
    else this.#make(data, curves, quantity, ends.length > 0);
    this.shape = shape;
  }

  #make(data, curves, quantity, hasBand) {
    this.plot?.destroy();
    const axis = (label) => ({ label, labelSize: 18, labelFont: "12px system-ui, sans-serif", font: "11px system-ui, sans-serif", stroke: ink, grid: { stroke: rule, width: 1 }, ticks: { stroke: rule, width: 1 }, size: 44 });
    const hasFewPoints = data[0].length < 3;
    this.plot = new uPlot({
      ...this.#size(),
      legend: { live: false },
      cursor: { drag: { x: false, y: false }, y: false, points: { show: false } },
      scales: { x: { time: false } },
      axes: [axis("flexion, °"), axis(`${quantity.label}, ${quantity.unit}`)],
      series: [{ label: "flexion" }, ...curves.map(({ label, colour, dash }) => ({ label, stroke: colour, dash, width: 2, points: { show: hasFewPoints } })),
        ...(hasBand ? ["95 % of the samples", "5 %"].map((label) => ({ label, stroke: bandInk, width: 1, points: { show: false } })) : [])],
      bands: hasBand ? [{ series: [curves.length + 1, curves.length + 2], fill: bandFill }] : [],
      hooks: { drawClear: [(plot) => this.#drawSpans(plot)], draw: [(plot) => this.#drawMark(plot)] },
    }, data, this.container);
    const select = (event) => { if (event.buttons === 1) this.onSelect(this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, "x")); };
    this.plot.over.addEventListener("pointerdown", select);
    this.plot.over.addEventListener("pointermove", select);
  }

  /// Doubtful flexions in amber, those without a pose in red, behind the curves.
  #drawSpans(plot) {
    const { ctx, bbox } = plot;
    for (const { first, last, hasPose } of this.spans ?? []) {
      const from = plot.valToPos(first, "x", true), to = plot.valToPos(last, "x", true);
      ctx.fillStyle = hasPose ? "#ffb02e55" : "#eb5a3c55";
      ctx.fillRect(from, bbox.top, to - from, bbox.height);
    }
  }

  #drawMark(plot) {
    if (this.mark === undefined) return;
    const { ctx, bbox } = plot, px = window.devicePixelRatio;
    const x = plot.valToPos(this.mark.flexion, "x", true), y = plot.valToPos(this.mark.value, "y", true);
    ctx.save();
    ctx.strokeStyle = "#11161d";
    ctx.lineWidth = px;
    ctx.setLineDash([]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    if (Number.isFinite(y)) {
      ctx.fillStyle = "#11161d";
      ctx.beginPath();
      ctx.arc(x, y, 4.5 * px, 0, 2 * Math.PI);
      ctx.fill();
    }
    ctx.restore();
  }

  /// Marks the current flexion in degrees and the quantity (NaN if unknown).
  setMark(flexion, value) {
    this.mark = { flexion, value };
    this.plot?.redraw(false, false);
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
