// Charts by uPlot, of the report and of the player's page: axes, zoom, and a reading under the pointer. What is drawn is a list of layers.
import uPlot from "uplot";

const FONT = "system-ui, 'Segoe UI', 'Noto Sans', 'DejaVu Sans', sans-serif";
const NEAR_PX = 22;  // of the pointer from what it reads

/** Colour scales: stops on [0, 1], interpolated linearly. Viridis and cividis: van der Walt and Smith (2015), Nuñez et al. (2018), both for colour-blind viewers and print. */
export const SCALES = {
  viridis: [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]],
  cividis: [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]],
  difference: [[11, 76, 140], [98, 160, 212], [246, 246, 244], [240, 164, 105], [170, 66, 6]],
};

/** [r, g, b] of a scale at `s`, clamped to [0, 1]. */
function colourOn(stops, s) {
  const at = Math.min(Math.max(s, 0), 1) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
  return stops[k].map((x, c) => Math.round(x + (at - k) * (stops[k + 1][c] - x)));
}

/** The same as CSS, of a value between the ends of a range. */
export function cssOn(stops, value, [low, high]) {
  return `rgb(${colourOn(stops, high > low ? (value - low) / (high - low) : 0.5).join(" ")})`;
}

/** A key of a scale: its ends and a gradient. */
export function scaleBar(stops, low, high) {
  const bar = document.createElement("i"), node = document.createElement("div");
  bar.style.background = `linear-gradient(to right, ${stops.map((stop) => `rgb(${stop.join(" ")})`).join(", ")})`;
  node.className = "scale";
  node.append(low, bar, high);
  return node;
}

/** Least and largest finite number of lists. */
export function rangeOf(...lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) {
    for (const x of list) {
      if (x === null || !Number.isFinite(x)) continue;
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
  }
  return low <= high ? [low, high] : [0, 0];
}

/** [low, high] of each cell along an axis: between its edges, or around its nodes to the midpoints between them. */
function cellsAlong(at, isEdges) {
  if (isEdges) return at.slice(1).map((edge, k) => [at[k], edge]);
  const half = at.length > 1 ? (at.at(-1) - at[0]) / (at.length - 1) / 2 : 0.5;
  return at.map((node, k) => [k > 0 ? (at[k - 1] + node) / 2 : node - half, k + 1 < at.length ? (node + at[k + 1]) / 2 : node + half]);
}

function isKnown(value) {
  return value !== null && value !== undefined && Number.isFinite(value);
}

/** Runs of indices without a missing value. */
function runs(n, isThere) {
  const all = [];
  for (let k = 0; k < n; ++k) {
    if (!isThere(k)) continue;
    if (k > 0 && isThere(k - 1)) all.at(-1).push(k);
    else all.push([k]);
  }
  return all;
}

// How each kind of layer is drawn. `at(x, y)`: its pixels; `px`: pixels of the canvas a pixel of the page.
const PAINTERS = {
  line({ pen, px, at }, { x, y, colour, width = 2, dash = [] }) {
    pen.strokeStyle = colour;
    pen.lineWidth = width * px;
    pen.setLineDash(dash.map((part) => part * px));
    for (const run of runs(x.length, (k) => isKnown(x[k]) && isKnown(y[k]))) {
      pen.beginPath();
      for (const k of run.length > 1 ? run : [run[0], run[0]]) pen.lineTo(...at(x[k], y[k]));
      pen.stroke();
    }
  },
  points({ pen, px, at }, { x, y, colour, colours, size = 6, isOpen = false, error }) {
    pen.lineWidth = 1.5 * px;
    x.forEach((value, k) => {
      if (!isKnown(value) || !isKnown(y[k])) return;
      pen.strokeStyle = pen.fillStyle = colours?.[k] ?? colour;
      pen.beginPath();
      pen.arc(...at(value, y[k]), (size / 2) * px, 0, 2 * Math.PI);
      if (isOpen) pen.stroke();
      else pen.fill();
      if (!error?.[k]) return;
      pen.beginPath();
      for (const end of [-1, 1]) pen.lineTo(...at(value, y[k] + end * error[k]));
      pen.stroke();
    });
  },
  /** The area between `low` and `high`. */
  band({ pen, at }, { x, low, high, colour }) {
    pen.fillStyle = colour;
    for (const run of runs(x.length, (k) => isKnown(low[k]) && isKnown(high[k]))) {
      pen.beginPath();
      for (const k of run) pen.lineTo(...at(x[k], low[k]));
      for (const k of run.toReversed()) pen.lineTo(...at(x[k], high[k]));
      pen.fill();
    }
  },
  /** A cell around each node of `x` and `y`, or between them if they are edges. */
  cells({ pen, at }, { x, y, isEdges, colourOf }) {
    const gap = x.length > 45 ? 0 : 1;  // gaps would dominate a fine grid
    const columns = cellsAlong(x, isEdges), rows = cellsAlong(y, isEdges);
    columns.forEach(([left, right], i) => rows.forEach(([bottom, top], j) => {
      const from = at(left, top).map(Math.round), to = at(right, bottom).map(Math.round);
      const colour = colourOf(i, j);
      if (!colour) return;
      pen.fillStyle = colour;
      pen.fillRect(...from, Math.max(to[0] - from[0] - gap, 1), Math.max(to[1] - from[1] - gap, 1));
    }));
  },
  /** Upright stripes from `first` to `last`. */
  spans({ pen, at, box }, { spans }) {
    for (const { first, last, colour } of spans) {
      const [from] = at(first, 0), [to] = at(last, 0);
      pen.fillStyle = colour;
      pen.fillRect(from, box.top, to - from, box.height);
    }
  },
  upright({ pen, px, at, box }, { x, colour, width = 1.5, dash = [] }) {
    const [left] = at(x, 0);
    pen.strokeStyle = colour;
    pen.lineWidth = width * px;
    pen.setLineDash(dash.map((part) => part * px));
    pen.beginPath();
    pen.moveTo(left, box.top);
    pen.lineTo(left, box.top + box.height);
    pen.stroke();
  },
  texts({ pen, px, at }, { texts, colour }) {
    pen.font = `${11 * px}px ${FONT}`;
    pen.fillStyle = colour;
    for (const { x, y, text, isLeft } of texts) {
      const [left, top] = at(x, y);
      pen.textAlign = isLeft ? "right" : "left";
      pen.fillText(text, left + (isLeft ? -8 : 8) * px, top - 8 * px);
    }
  },
  /** A white ring around a dark one, on any colour. */
  ring({ pen, px, at }, { x, y }) {
    for (const [colour, thick] of [["#ffffff", 4], ["#11161d", 1.6]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = thick * px;
      pen.beginPath();
      pen.arc(...at(x, y), 6 * px, 0, 2 * Math.PI);
      pen.stroke();
    }
  },
};

/** The numbers along an axis that a layer has; none of those that only mark a place. */
function along(layer, axis) {
  if (layer.kind === "cells") return cellsAlong(layer[axis], layer.isEdges).flat();
  if (layer.kind === "band") return axis === "x" ? layer.x : [...layer.low, ...layer.high];
  if (layer.kind !== "line" && layer.kind !== "points") return [];
  return axis === "y" && layer.error ? layer.y.flatMap((y, k) => [y - layer.error[k], y + layer.error[k]]) : layer[axis];
}

/**
 * A chart in the element `container`, which it fills. `show()` draws
 *   x, y, right: { title, range: [low, high], fromZero, isPlain (without numbers), step (least between numbers) } of the axes; right: only with layers of `scale: "right"`
 *   layers: [{ kind, name, text: (k) => reading of point k, or (i, j) of a cell, ... }], from behind; kinds and their members as in PAINTERS
 *   ink: { text, quiet, rule } colours; isEqual: a unit is as long on both axes; onSelect(x, y): a click or drag chooses a place instead of a zoom
 */
export class Chart {
  constructor(container) {
    this.container = container;
    this.tip = Object.assign(document.createElement("div"), { className: "tip", hidden: true });
    new ResizeObserver(() => this.plot?.setSize(this.#size())).observe(container);
  }

  #size() {
    return { width: Math.max(this.container.clientWidth, 80), height: Math.max(this.container.clientHeight, 80) };
  }

  show(what) {
    this.what = what;
    const shape = JSON.stringify([what.x, what.y, what.right, what.ink]);
    if (this.plot && this.shape === shape) {
      this.plot.setData(this.#data());
      return;
    }
    this.shape = shape;
    this.#make();
  }

  /** Draws the layers again, on the same axes. */
  redraw() {
    this.plot?.redraw(false, false);
  }

  // uPlot gets the ends of the scales only; the layers are drawn by hand, so that their x may go to and fro.
  #data() {
    const ends = (axis, scale) => rangeOf(...this.what.layers.filter((layer) => (layer.scale ?? "y") === scale || axis === "x").map((layer) => along(layer, axis)));
    this.ends = { x: ends("x", "y"), y: ends("y", "y"), right: ends("y", "right") };
    return [[0, 1], [0, 1], ...(this.what.right ? [[0, 1]] : [])];
  }

  #range(plot, name) {
    const axis = this.what[name], hasCells = this.what.layers.some((layer) => layer.kind === "cells");
    const own = (key) => {
      const [low, high] = this.ends[key], pad = (hasCells ? 0 : key === "x" ? 0.02 : 0.06) * (high - low) || (high > low ? 0 : 0.5);
      return [this.what[key].fromZero ? Math.min(0, low) : low - pad, high + pad];
    };
    if (axis.range) return axis.range;
    if (!this.what.isEqual) return own(name);
    // The shorter of both axes gets more room.
    const [x, y] = [own("x"), own("y")], shape = plot.bbox.width / plot.bbox.height || 1;
    const width = Math.max(x[1] - x[0], (y[1] - y[0]) * shape), [low, high] = name === "x" ? x : y;
    const half = (name === "x" ? width : width / shape) / 2;
    return [(low + high) / 2 - half, (low + high) / 2 + half];
  }

  #axis(name) {
    const { title, isPlain, step } = this.what[name], { quiet, rule } = this.what.ink;
    const line = { stroke: rule, width: 1 };
    return {
      scale: name, label: title, labelSize: 20, labelFont: `12px ${FONT}`, font: `11px ${FONT}`, stroke: quiet, grid: { ...line, show: name !== "right" }, ticks: { ...line, size: 5 },
      side: { x: 2, y: 3, right: 1 }[name], ...(step ? { incrs: [1, 2, 5, 10, 20, 50].map((k) => k * step) } : {}),
      values: (_, ticks) => ticks.map((tick) => (isPlain ? "" : String(Number(tick.toPrecision(10))).replace("-", "−"))),
      size: (plot, texts, k, cycle) => {
        if (name === "x") return 32;
        if (cycle > 1) return plot.axes[k]._size;
        plot.ctx.font = plot.axes[k].font[0];
        return Math.ceil(12 + Math.max(8, ...(texts ?? []).map((text) => plot.ctx.measureText(text).width / window.devicePixelRatio)));
      },
    };
  }

  #make() {
    this.plot?.destroy();
    const { right, onSelect } = this.what, names = right ? ["x", "y", "right"] : ["x", "y"];
    const silent = (scale) => ({ scale, points: { show: false }, paths: () => null });
    this.plot = new uPlot({
      ...this.#size(), legend: { show: false },
      cursor: { x: false, y: false, points: { show: false }, drag: { x: !onSelect, y: !onSelect, uni: 20 } },
      scales: Object.fromEntries(names.map((name) => [name, { time: false, range: (plot) => this.#range(plot, name) }])),
      axes: names.map((name) => this.#axis(name)),
      series: [{}, ...names.slice(1).map(silent)],
      hooks: { draw: [(plot) => this.#draw(plot)] },
    }, this.#data(), this.container);
    const { over } = this.plot;
    over.append(this.tip);
    const read = (event) => {
      const box = over.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      if (this.what.onSelect && event.buttons === 1) this.what.onSelect(this.plot.posToVal(x, "x"), this.plot.posToVal(y, "y"));
      this.#read(x, y);
    };
    for (const kind of ["pointerdown", "pointermove"]) over.addEventListener(kind, read);
    over.addEventListener("pointerleave", () => { this.tip.hidden = true; });
  }

  #draw(plot) {
    const { ctx: pen, bbox: box } = plot, px = window.devicePixelRatio;
    pen.save();
    pen.beginPath();
    pen.rect(box.left, box.top, box.width, box.height);
    pen.clip();
    pen.lineJoin = pen.lineCap = "round";
    for (const layer of this.what.layers) {
      const at = (x, y) => [plot.valToPos(x, "x", true), plot.valToPos(y, layer.scale ?? "y", true)];
      pen.setLineDash([]);
      PAINTERS[layer.kind]({ pen, px, at, box }, layer);
    }
    pen.restore();
  }

  /** The reading at a place, in pixels of the page: the nearest point, else the cell. */
  #read(left, top) {
    let nearest = NEAR_PX, text = "", place = [left, top];
    for (const layer of this.what.layers.filter((one) => one.text)) {
      if (layer.kind === "cells") {
        const [i, j] = [["x", left], ["y", top]].map(([axis, at]) => {
          const value = this.plot.posToVal(at, axis);
          return cellsAlong(layer[axis], layer.isEdges).findIndex(([low, high]) => value >= low && value < high);
        });
        if (i >= 0 && j >= 0) text = layer.text(i, j);
        continue;
      }
      layer.x.forEach((x, k) => {
        if (!isKnown(x) || !isKnown(layer.y[k])) return;
        const at = [this.plot.valToPos(x, "x"), this.plot.valToPos(layer.y[k], layer.scale ?? "y")];
        const far = Math.hypot(at[0] - left, at[1] - top);
        if (far < nearest) [nearest, text, place] = [far, layer.text(k), at];
      });
    }
    this.tip.hidden = text === "";
    this.tip.textContent = text;
    const isRight = place[0] > this.plot.over.clientWidth / 2;
    this.tip.style.cssText = `top: ${place[1]}px; ${isRight ? "right" : "left"}: ${isRight ? this.plot.over.clientWidth - place[0] : place[0]}px`;
  }
}
