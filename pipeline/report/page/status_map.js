// Maps of status, plausibility and contacts of each attitude.
import { choice, el, section } from "./dom.js";
import { axis, figure } from "./plot.js";
import { gridTitle } from "./format.js";

const STATUS_COLORS = { "-1": "#9aa3ad", 0: "#3f8f72", 1: "#d98a1f", 2: "#b23a48", 3: "#7b4fa3", 4: "#274690", 5: "#8a5a2b" };
const PLAUSIBILITY_COLORS = { "-1": "#9aa3ad", 0: "#3f8f72", 1: "#b23a48", 2: "#d98a1f" };

function plausibilityKinds(model) {
  return model.plausibilities.map((p) => ({ code: p.code, name: p.name, color: PLAUSIBILITY_COLORS[p.code] ?? "#000000" }));
}
function statusKinds(model) {
  return model.statuses.filter((s) => s.cells > 0).map((s) => ({ code: s.code, name: s.name, color: STATUS_COLORS[s.code] ?? "#000000" }));
}
const CONTACT_KINDS = [
  { code: -1, name: "no pose", color: "#9aa3ad" }, { code: 0, name: "neither", color: "#b23a48" }, { code: 1, name: "medial only", color: "#0b6aa8" },
  { code: 2, name: "lateral only", color: "#d98a1f" }, { code: 3, name: "both", color: "#3f8f72" }];
const ROTATION_KINDS = [{ code: -1, name: "no pose", color: "#9aa3ad" }, { code: 0, name: "not determined", color: "#d98a1f" }, { code: 1, name: "determined", color: "#3f8f72" }];

function maps(model) {
  const list = [["status", "status", { grid: model.status_grid, kinds: statusKinds(model) }]];
  list.push(["plausibility", "plausibility of stable poses", { grid: model.plausibility_grid, kinds: plausibilityKinds(model) }]);
  if (model.contact_grid) list.push(["contact", "compartments in contact", { grid: model.contact_grid, kinds: CONTACT_KINDS }]);
  list.push(["rotation", "rotation determined by contact", { grid: model.theta_determined_grid, kinds: ROTATION_KINDS }]);
  return list;
}

// Steps of equal width, one per kind.
function stepScale(kinds) {
  return kinds.flatMap((kind, k) => [[k / kinds.length, kind.color], [(k + 1) / kinds.length, kind.color]]);
}

function mapTrace(model, { grid, kinds }) {
  const index = new Map(kinds.map((kind, k) => [kind.code, k]));
  const z = model.varus.map((_, j) => model.flexion.map((_, i) => index.get(grid[i][j])));
  const gap = model.flexion.length > 45 ? 0 : 1;  // gaps would dominate a fine grid
  const text = z.map((row) => row.map((k) => kinds[k]?.name ?? ""));
  return { type: "heatmap", x: model.flexion, y: model.varus, z, text, zmin: -0.5, zmax: kinds.length - 0.5, colorscale: stepScale(kinds), xgap: gap, ygap: gap,
    colorbar: { thickness: 14, outlinewidth: 0, tickvals: kinds.map((_, k) => k), ticktext: kinds.map((kind) => kind.name) },
    hovertemplate: "flexion %{x}°, varus %{y}°: %{text}<extra></extra>" };
}

export function statusSection(model) {
  const all = maps(model);
  const state = { map: all[0][2] };
  const plot = figure({
    title: "The grid", size: model.varus.length > 1 ? "" : "low",
    caption: "One cell per attitude: flexion to the right, varus (adduction +) upwards. The table in the summary has the counts.",
    make: () => ({ data: [mapTrace(model, state.map)], layout: { xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(gridTitle(model, "varus"), model.is_varus_free ? { showticklabels: false, title: { text: "" } } : {}) } }),
  });
  const pick = choice("Show", all.map(([key, name]) => [key, name]), all[0][0], (value) => { state.map = all.find(([key]) => key === value)[2]; plot.redraw(); });
  return section("grid", "Map of the grid", el("div", { class: "controls" }, pick), plot);
}
