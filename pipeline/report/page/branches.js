// The distinct equilibria of the free spine at each flexion, and which of them the motion uses.
import { absent, el, section } from "./dom.js";
import { axis, figure, lineStyle } from "./plot.js";
import { decimal, gridTitle } from "./format.js";

const NAMES = { true: "chosen: lowest energy, the spine of the motion", false: "other equilibrium found" };

// Energy above the chosen equilibrium of the same flexion.
function excess({ flexion, energy, is_chosen: isChosen }) {
  const chosen = new Map(flexion.flatMap((f, k) => (isChosen[k] ? [[f, energy[k]]] : [])));
  return energy.map((value, k) => value - chosen.get(flexion[k]));
}

function trace(branches, values, isChosen, unit) {
  const rows = branches.flexion.map((_, k) => k).filter((k) => (branches.is_chosen[k] === 1) === isChosen);
  const above = excess(branches);
  const { color } = lineStyle(isChosen ? 0 : 1);
  return { type: "scatter", mode: isChosen ? "lines+markers" : "markers", name: NAMES[isChosen], x: rows.map((k) => branches.flexion[k]), y: rows.map((k) => values[k]),
    marker: { color, size: isChosen ? 4 : 8, symbol: isChosen ? "circle" : "circle-open", line: { color, width: isChosen ? 0 : 1.5 } }, line: { color, width: 1.6 },
    customdata: rows.map((k) => decimal(above[k], 3)), hovertemplate: `flexion %{x}°: %{y:.2f} ${unit}, energy %{customdata} N mm above the chosen<extra></extra>` };
}

function branchFigure(model, { key, title, caption, label, unit }) {
  const { branches } = model.spine;
  return figure({ title, caption, make: () => ({
    data: [trace(branches, branches[key], true, unit), trace(branches, branches[key], false, unit)],
    layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(label) } }) });
}

export function branchesSection(model) {
  const title = "Equilibria with free varus";
  if (!model.spine) return section("branches", title, absent("The stability search has no energies; method = \"equilibrium\" computes them."));
  const { branches } = model.spine;
  const nOther = branches.is_chosen.filter((one) => one === 0).length;
  const nFlexions = model.spine.n_optima.filter((n) => n > 1).length;
  const text = `From different starts the joint comes to rest in different poses. The motion uses the one of lowest energy. ${nOther} other equilibria were found, at ${nFlexions} of ${model.flexion.length} flexions. Equilibria are distinct if they differ by more than 0.1 mm, or 0.1 degrees of rotation or varus.`;
  return section("branches", title, el("p", {}, text), el("div", { class: "columns" },
    branchFigure(model, { key: "energy", title: "Energy", label: "N mm", unit: "N mm", caption: "Energy of the ligaments minus the work of the loads, N mm." }),
    branchFigure(model, { key: "theta", title: "Rotation θ about Δ", label: "degrees", unit: "degrees", caption: "Rotation of each equilibrium, internal +, degrees." })));
}
