// Errors, gaps and penetrations of each smoothing degree.
import { absent, el, section, table } from "./dom.js";
import { axis, figure, lineStyle } from "./plot.js";
import { number, PARAMETERS, percent, setName } from "./format.js";

function statisticsTable(model) {
  const rows = model.degrees.flatMap((set) => set.surfaces.map((s) => [
    `degree ${set.degree}${set.is_robust ? ", robust" : ""}`, PARAMETERS[s.name]?.name ?? s.name, PARAMETERS[s.name]?.unit ?? "", String(s.cells), number(s.rms), number(s.largest_residual), number(s.leave_one_out_rms), number(s.condition_number)]));
  return table("Sets stored in the file: residuals against the raw motion", ["set", "parameter", "unit", "cells", "RMS", "largest", "leave-one-out RMS", "condition number"], rows, { kinds: ["", "word", "word"] });
}

function auditTable(model) {
  const audits = [...model.audits].sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
  const rows = audits.map((a) => [setName(a.name), String(a.refine), String(a.attitudes), String(a.overlapping), number(a.largest_penetration_mm), number(a.largest_gap_mm), String(a.nothing_ahead), String(a.no_pose)]);
  return table("Audits: gap and penetration of the meshes at each attitude; refinement is the number of subdivisions of a grid cell per axis", ["motion", "refinement", "attitudes", "overlapping", "largest penetration, mm", "largest gap, mm", "nothing ahead", "no pose"], rows);
}

function contactTable(model) {
  const audits = model.audits.filter((a) => a.two_sided);
  if (audits.length === 0) return [];
  const keys = ["largest_gap_medial_mm", "largest_overlap_medial_mm", "largest_gap_lateral_mm", "largest_overlap_lateral_mm"];
  const rows = audits.map(({ name, two_sided: f }) => [setName(name), `${f.both_in_contact} of ${f.poses}`, ...keys.map((key) => number(f[key]))]);
  return [table("Contact of both compartments: attitudes at which the gaps of both are within the perceptible 0.145 mm, and the largest gap and overlap of each side. Over a range of varus most attitudes lift one side off.",
    ["motion", "both in contact", "medial gap, mm", "medial overlap, mm", "lateral gap, mm", "lateral overlap, mm"], rows)];
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
    caption: "RMS of the residuals (dotted) and leave-one-out error (solid): the RMS always decreases with the degree, the leave-one-out error increases again when the polynomial fits the jitter.",
    make: () => ({ data: errorTraces(model, unit), layout: { showlegend: true, xaxis: axis("degree", { dtick: 1 }), yaxis: axis(unit, { rangemode: "tozero" }) } }),
  });
}

const COMPARED = { translation: ["translation", "mm"], theta: ["θ", "degrees"], varus: ["varus", "degrees"] };

const MEASURES = [["rms", "RMS"], ["largest", "largest"], ["leave_one_out", "leave-one-out"], ["roughness", "roughness"]];

function errorsTable({ rows, recommended }) {
  const names = rows[0].errors.map((one) => one.name);
  const headings = names.flatMap((name) => MEASURES.map(([, text], k) => (k === 0 ? `${COMPARED[name].join(", ")}: ${text}` : text)));
  const cells = (row) => row.errors.flatMap((one) => MEASURES.map(([key]) => number(one[key])));
  return table("Each degree fitted to the raw motion. Roughness is the RMS second derivative, per degree²; the recommended degree is highlighted.",
    ["degree", ...headings], rows.map((row) => [String(row.degree), ...cells(row)]), { kinds: Array(headings.length + 1).fill("tight"), chosen: (r) => rows[r].degree === recommended });
}

// Names of faults: pipeline/compare/recommend.hpp.
const FAULTS = { none: "", not_measurable: "not measurable", unpredicted: "less than half of the variance predicted", jump: "the raw motion jumps", no_contact: "poses without contact", overlap: "overlap", gap: "gap", rough: "rough" };

function judgementTable({ rows, recommended, left_out: block }) {
  const hasContact = rows.some((row) => row.contact);
  const sides = ["largest_gap_medial_mm", "largest_overlap_medial_mm", "largest_gap_lateral_mm", "largest_overlap_lateral_mm"];
  const hasSides = rows.some((row) => row.contact?.two_sided);
  const contactHeadings = !hasContact ? [] : hasSides ? ["medial gap, mm", "medial overlap, mm", "lateral gap, mm", "lateral overlap, mm"] : ["gap, mm", "overlap, mm"];
  const contactCells = ({ contact }) => (!hasContact ? [] : hasSides ? sides.map((key) => number(contact.two_sided?.[key])) : [number(contact.largest_gap_mm), number(contact.largest_overlap_mm)]);
  const n = block.flexions * block.varus_columns;
  const caption = `What the recommendation is based on. Left out: error of the pose at attitudes without which the polynomial was fitted, in multiples of the perceptible 0.145 mm and 0.27 degrees; ${n === 1 ? "each attitude is left out alone" : `blocks of ${block.flexions} flexions by ${block.varus_columns} varus columns are left out together, since neighbouring errors are correlated`}. Second difference: over one degree of flexion, in the same unit.${hasContact ? " Gap and overlap: after the motion was moved into contact." : ""}`;
  return table(caption, ["degree", "left out", "second difference", ...contactHeadings, "rejected because"],
    rows.map((row) => [String(row.degree), number(row.left_out), number(row.second_difference), ...contactCells(row), FAULTS[row.fault]]), { kinds: ["", "", "", ...contactHeadings.map(() => ""), "text"], chosen: (r) => rows[r].degree === recommended });
}

function faultsTable({ rows, recommended }) {
  const faults = rows[0].faults ? ["attitudes overlapping", "largest penetration, mm", "largest gap, mm"] : [];
  const cells = ({ faults: f }) => (f ? [`${f.overlapping} of ${f.attitudes}`, number(f.largest_penetration_mm), number(f.largest_gap_mm)] : []);
  return table("Perceptible errors of each degree: attitudes with an error above 0.145 mm or 0.27 degrees, and overlaps and gaps of the meshes at the attitudes of the grid.",
    ["degree", "attitudes with a perceptible error", ...faults], rows.map((row) => [String(row.degree), percent(row.perceptible_share), ...cells(row)]), { chosen: (r) => rows[r].degree === recommended });
}

function comparedErrors(rows, unit) {
  const names = rows[0].errors.map((one) => one.name).filter((name) => COMPARED[name][1] === unit);
  return names.flatMap((name, k) => [["leave_one_out", "leave-one-out", "solid"], ["rms", "RMS", "dot"]].map(([key, text, dash]) => ({
    type: "scatter", mode: "lines+markers", name: `${COMPARED[name][0]}, ${text}`, x: rows.map((row) => row.degree), y: rows.map((row) => row.errors.find((one) => one.name === name)[key]), line: { color: lineStyle(k).color, dash, width: 2 } })));
}

function recommendedLine(recommended) {
  return recommended < 0 ? [] : [{ type: "line", xref: "x", yref: "paper", x0: recommended, x1: recommended, y0: 0, y1: 1, line: { color: lineStyle(2).color, width: 1.5, dash: "dash" } }];
}

function comparedFigure({ rows, recommended }, title, caption, data, unit) {
  return figure({ title, caption, make: () => ({ data: data(), layout: { showlegend: true, shapes: recommendedLine(recommended), xaxis: axis("degree", { dtick: 1 }), yaxis: axis(unit, { rangemode: "tozero" }) } }) });
}

function faultTraces(rows) {
  return [["largest_penetration_mm", "largest penetration"], ["largest_gap_mm", "largest gap"]].map(([key, name], k) => ({
    type: "scatter", mode: "lines+markers", name, x: rows.map((row) => row.degree), y: rows.map((row) => row.faults[key]), line: { color: lineStyle(k).color, width: 2 } }));
}

// The comparison of `vrda compare`, computed with the report.
function comparedParts(comparison) {
  const { rows, recommended, reason } = comparison;
  const caption = `RMS of the residuals (dotted) and leave-one-out error (solid): the RMS always decreases with the degree, the leave-one-out error increases again when the polynomial fits the jitter.${recommended < 0 ? "" : " The dashed line is the recommended degree."}`;
  const figures = ["mm", "degrees"].map((unit) => comparedFigure(comparison, `Error by degree, ${unit}`, caption, () => comparedErrors(rows, unit), unit));
  if (rows[0].faults) figures.push(comparedFigure(comparison, "Penetration and gap by degree", "Largest penetration and gap along Δ of the smoothed motion at the attitudes of the grid, mm.", () => faultTraces(rows), "mm"));
  const box = recommended < 0 ? el("div", { class: "box warning" }, el("strong", {}, "No degree meets the criteria"), `${reason[0].toUpperCase()}${reason.slice(1)}.`) : el("div", { class: "box good" }, `Recommended: ${reason}.`);
  return [box, el("div", { class: `columns ${figures.length === 3 ? "three" : ""}` }, figures), judgementTable(comparison), errorsTable(comparison), faultsTable(comparison)];
}

export function degreesSection(model) {
  const isCompared = model.comparison && model.comparison.rows.length > 0;
  const parts = isCompared ? comparedParts(model.comparison) : [];
  if (model.degrees.length > 0) parts.push(statisticsTable(model));
  if (!isCompared && model.degrees.length > 1) parts.push(el("div", { class: "columns" }, errorFigure(model, "mm"), errorFigure(model, "degrees")));
  if (model.audits.length > 0) parts.push(auditTable(model), ...contactTable(model));
  if (model.degrees.length === 0) parts.push(absent("The file has no smoothed set; vrda smooth FILE --degree N adds one."));
  if (model.audits.length === 0) parts.push(absent("The file has no audit of the smoothed motion; vrda audit FILE adds it."));
  return section("degrees", "Degrees of smoothing", ...parts);
}
