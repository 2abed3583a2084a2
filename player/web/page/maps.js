// Maps over flexion and varus: raw, the chosen set, their difference, and the status of each attitude.
import { AttitudeMap } from "./attitude_map.js";
import { empty, scales, statuses } from "./colours.js";
import { plausibilities } from "./doubts.js";
import { degree } from "./frames.js";
import { stable } from "./motion.js";
import { formatNumber } from "./quantities.js";

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
