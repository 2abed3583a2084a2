// Bands of an uncertain job over flexion, and the inputs that the spread comes from.
import { el, section, table } from "./dom.js";
import { decimal, gridTitle, wordOf } from "./format.js";
import { axis, figure, theme } from "./plot.js";

const NAMES = { internal: "internal rotation", contact_force: "contact force", contact_force_medial: "medial contact force", contact_force_lateral: "lateral contact force" };
const UNITS = { degree: "degrees", mm: "mm", N: "N" };
const KEYS = ["varus", "internal", "anterior", "proximal", "lateral"];

function nameOf(model, one) {
  return NAMES[one.name] ?? wordOf(model, one.name);
}

/** Whether the quantity is more than rounding: flexion is mostly driven. */
function hasSpread(one) {
  return one.high.some((value, k) => value !== null && value - one.low[k] > 1e-6);
}

function bandFigure(model, one) {
  const name = nameOf(model, one), unit = UNITS[one.unit];
  const job = KEYS.includes(one.name) ? model.curves.find((curve) => curve.name === "raw")?.[one.name] : undefined;
  return figure({
    title: name[0].toUpperCase() + name.slice(1),
    caption: "Shaded: 5 to 95 per cent of the samples; line: median; dotted: smallest and largest" + (job ? "; dashed: the job itself." : "."),
    make: () => {
      const colour = theme().series[0];
      const trace = (key, label, line, more = {}) => ({ type: "scatter", mode: "lines", name: label, x: model.flexion, y: one[key], line, ...more, hovertemplate: `${label}: %{y:.2f} ${unit} at %{x}<extra></extra>` });
      const thin = { color: colour, width: 1, dash: "dot" };
      return {
        data: [
          trace("low", "5 %", { width: 0, color: colour }, { showlegend: false }),
          trace("high", "5 to 95 %", { width: 0, color: colour }, { fill: "tonexty", fillcolor: `${colour}33` }),
          trace("median", "median", { color: colour, width: 2.4 }),
          trace("smallest", "smallest, largest", thin),
          trace("largest", "largest", thin, { showlegend: false }),
          ...(job ? [{ type: "scatter", mode: "lines", name: "the job", x: model.flexion, y: job, line: { color: theme().ink, width: 1.4, dash: "dash" }, hovertemplate: `job: %{y:.2f} ${unit} at %{x}<extra></extra>` }] : []),
        ],
        layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(unit) },
      };
    },
  });
}

function meanWidth(one) {
  const widths = one.high.map((value, k) => (value === null ? null : value - one.low[k])).filter((value) => value !== null);
  return widths.reduce((sum, value) => sum + value, 0) / widths.length;
}

function shareText(share) {
  return `${share.draw}: ${decimal(100 * share.index, 0)} % (${decimal(100 * share.low, 0)} to ${decimal(100 * share.high, 0)}), ${share.rank_correlation < 0 ? "falls" : "rises"} with it`;
}

/** Only for a model whose job has [uncertainty]. */
export function uncertaintySection(model) {
  const of = model.uncertainty;
  const shown = of.quantities.filter(hasSpread);
  const unsolved = of.solved.map((n) => of.samples - n).reduce((sum, n) => sum + n, 0);
  const failures = unsolved === 0 ? "All have a stable pose at every flexion." : `${unsolved} of ${of.samples * of.solved.length} sampled poses are not stable and left out.`;
  const rows = shown.map((one) => [nameOf(model, one), `${decimal(meanWidth(one), 2)} ${UNITS[one.unit]}`, el("ul", {}, one.shares.filter((share) => share.high >= 0.05).slice(0, 4).map((share) => el("li", {}, shareText(share))))]);
  return section("uncertainty", "Uncertainty",
    el("p", {}, `${of.samples} samples of ${of.draws} independent draws (${of.sequence === "sobol" ? "Sobol sequence" : "Latin hypercube"}, seed ${of.seed}); varus is free. ${failures}`),
    el("div", { class: "columns" }, shown.map((one) => bandFigure(model, one))),
    table("Width of the bands and where the spread comes from: first-order Sobol indices with 90 % intervals, means over flexion weighted by variance", ["quantity", "mean width, 5 to 95 %", "largest shares"], rows));
}
