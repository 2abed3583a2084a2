// Curves over flexion at the current varus (uPlot): raw, the chosen set, and the current attitude.
import uPlot from "uplot";
import { degree } from "./frames.js";

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
