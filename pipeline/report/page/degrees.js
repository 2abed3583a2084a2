// What each degree of smoothing costs and breaks.
import { absent, el, section, table } from "./dom.js";
import { axis, figure, lineStyle } from "./plot.js";
import { number, PARAMETERS, setName } from "./words.js";

function statisticsTable(model) {
  const rows = model.degrees.flatMap((set) => set.surfaces.map((s) => [
    `degree ${set.degree}${set.is_robust ? ", robust" : ""}`, PARAMETERS[s.name]?.name ?? s.name, PARAMETERS[s.name]?.unit ?? "", String(s.cells), number(s.rms), number(s.largest_residual), number(s.leave_one_out_rms), number(s.condition_number)]));
  return table("Sets stored in the file: residuals against the raw motion", ["set", "parameter", "unit", "cells", "RMS", "largest", "leave-one-out RMS", "condition number"], rows, { kinds: ["", "word", "word"] });
}

function auditTable(model) {
  const rows = model.audits.map((a) => [setName(a.name), String(a.refine), String(a.attitudes), String(a.overlapping), number(a.largest_penetration_mm), number(a.largest_gap_mm), String(a.nothing_ahead), String(a.no_pose)]);
  return table("Audits stored in the file: meshes measured again at each attitude of the audit’s grid", ["motion", "refinement", "attitudes", "overlapping", "largest penetration, mm", "largest gap, mm", "nothing ahead", "no pose"], rows);
}

function errorTraces(model, unit) {
  const keys = Object.keys(PARAMETERS).filter((key) => PARAMETERS[key].unit === unit);
  const value = (set, key, field) => set.surfaces.find((s) => s.name === key)?.[field] ?? null;
  return keys.flatMap((key, k) => [["leave_one_out_rms", "leave-one-out", "solid"], ["rms", "RMS", "dot"]].map(([field, name, dash]) => ({
    type: "scatter", mode: "lines+markers", name: `${PARAMETERS[key].name.split(",")[0]}, ${name}`, x: model.degrees.map((set) => set.degree), y: model.degrees.map((set) => value(set, key, field)), line: { color: lineStyle(k).color, dash, width: 2 } })))
    .filter((one) => one.y.some((v) => v !== null));
}

function errorFigure(model, unit) {
  return figure({
    title: `Error by degree, ${unit}`,
    caption: "RMS of the residuals (dotted) and leave-one-out error (solid): the first only falls with the degree, the second rises again where the polynomial follows the jitter.",
    make: () => ({ data: errorTraces(model, unit), layout: { showlegend: true, xaxis: axis("degree", { dtick: 1 }), yaxis: axis(unit, { rangemode: "tozero" }) } }),
  });
}

export function degreesSection(model) {
  const parts = [];
  if (model.degrees.length > 0) parts.push(statisticsTable(model));
  if (model.degrees.length > 1) parts.push(el("div", { class: "columns" }, errorFigure(model, "mm"), errorFigure(model, "degrees")));
  if (model.audits.length > 0) parts.push(auditTable(model));
  if (model.degrees.length === 0) parts.push(absent("No smoothed set stands in the file; vrda smooth FILE --degree N adds one, vrda compare FILE tells which."));
  if (model.audits.length === 0) parts.push(absent("No audit of the smoothed motion stands in the file; vrda audit FILE adds it."));
  return section("degrees", "Degrees of smoothing", ...parts);
}
