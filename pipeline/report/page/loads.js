// Contact forces by compartment and fibre strain and tension by bundle.
import { absent, el, section } from "./dom.js";
import { axis, compartmentColor, figure, lineStyle, theme } from "./plot.js";
import { gridTitle } from "./format.js";

function share(part, forces, k) {
  const sum = forces.medial_n[k] + forces.lateral_n[k] + forces.none_n[k];
  return forces.medial_n[k] === null || sum === 0 ? null : (100 * part[k]) / sum;
}

function area(model, forces, key, name, color) {
  return { type: "scatter", mode: "lines", stackgroup: "share", name, x: model.flexion, y: model.flexion.map((_, k) => share(forces[key], forces, k)), line: { color, width: 1 }, fillcolor: `${color}99`,
    hovertemplate: `${name}: %{y:.1f} % at %{x}°<extra></extra>` };
}

function shareFigure(model) {
  const { forces } = model;
  const hasOther = forces.none_n.some((value) => value > 0);
  return figure({
    title: "Share of the load",
    caption: "Contact force along Δ carried by each compartment, per cent of the total contact force along the spine.",
    make: () => ({
      data: [area(model, forces, "medial_n", "medial", compartmentColor("medial")), area(model, forces, "lateral_n", "lateral", compartmentColor("lateral")),
        ...(hasOther ? [area(model, forces, "none_n", "neither", theme().quiet)] : [])],
      layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis("per cent", { range: [0, 100] }) },
    }),
  });
}

function forceFigure(model) {
  const line = (key, name) => ({ type: "scatter", mode: "lines", name, x: model.flexion, y: model.forces[key], line: { color: compartmentColor(name), width: 2 }, hovertemplate: `${name}: %{y:.1f} N at %{x}°<extra></extra>` });
  return figure({
    title: "Contact force", caption: "Force along Δ in each compartment, N; with fibres it exceeds the push, since their tension adds to it.",
    make: () => ({ data: [line("medial_n", "medial"), line("lateral_n", "lateral")], layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis("N", { rangemode: "tozero" }) } }),
  });
}

function bundleFigure(model, { key, scale, title, caption, unit }) {
  return figure({
    title, caption, size: "tall",
    make: () => ({
      data: model.fibres.map((bundle, k) => ({ type: "scatter", mode: "lines", name: `${bundle.name} (${bundle.n_fibres})`, x: model.flexion, y: bundle[key].map((v) => (v === null ? null : scale * v)), line: { ...lineStyle(k), width: 2 },
        hovertemplate: `${bundle.name}: %{y:.2f} ${unit} at %{x}°<extra></extra>` })),
      layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(unit), margin: { l: 58, r: 16, t: 12, b: 90 } },
    }),
  });
}

export function forcesSection(model) {
  if (!model.forces) return section("forces", "Load on the compartments", absent("The stability search computes contacts but no forces; method = \"equilibrium\" computes both."));
  if (!model.has_compartments) return section("forces", "Load on the compartments", absent("This joint has no compartments."));
  return section("forces", "Load on the compartments", el("div", { class: "columns" }, shareFigure(model), forceFigure(model)));
}

export function fibresSection(model) {
  if (!model.fibres) return section("fibres", "Ligaments", absent("The job has no ligament fibres."));
  return section("fibres", "Ligaments", el("p", {}, "By bundle along the spine, with the number of fibres in brackets. A fibre with negative strain is slack and has no tension."),
    el("div", { class: "columns" },
      bundleFigure(model, { key: "largest_strain", scale: 100, title: "Strain", unit: "per cent", caption: "Largest fibre strain in each bundle, per cent of the slack length." }),
      bundleFigure(model, { key: "tension_n", scale: 1, title: "Tension", unit: "N", caption: "Total tension of the fibres of a bundle, N." })));
}
