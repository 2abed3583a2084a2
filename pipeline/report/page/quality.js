// How far the motion is to be trusted: map of the grid, degrees of smoothing, bands of samples.
import { absent, choice, decimal, el, gridTitle, number, PARAMETERS, percent, section, setName, table, wordOf } from "./page.js";
import { axis, curve, dashNamed, figure, lineStyle, theme } from "./plot.js";

// Maps of status, plausibility and contacts of each attitude.

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

/** Cells coloured by their kind; `codes[i][j]` at x[i] and y[j], of one of the `kinds` ({ code, name, color }); `place(x, y)` as text. */
export function kindCells(x, y, codes, kinds, place = (a, b) => `${a}°, ${b}°`) {
  const of = new Map(kinds.map((kind) => [kind.code, kind]));
  return { kind: "cells", x, y, colourOf: (i, j) => of.get(codes[i][j])?.color, text: (i, j) => `${place(x[i], y[j])}: ${of.get(codes[i][j])?.name ?? ""}` };
}

/** What the colours of kinds mean. */
export function kindsLegend(kinds) {
  return el("ul", { class: "legend" }, kinds.map(({ color, name }) => el("li", {}, el("span", { class: "swatch", style: `background: ${color}` }), name)));
}

export function statusSection(model) {
  const all = maps(model);
  const state = { map: all[0][2] };
  const plot = figure({
    title: "The grid", size: model.varus.length > 1 ? "" : "low",
    caption: "One cell per attitude: flexion to the right, varus (adduction +) upwards. The table in the summary has the counts.",
    make: () => ({ x: axis(gridTitle(model, "flexion")), y: model.is_varus_free ? axis("", { isPlain: true }) : axis(gridTitle(model, "varus")), key: [kindsLegend(state.map.kinds)],
      layers: [kindCells(model.flexion, model.varus, state.map.grid, state.map.kinds, (flexion, varus) => `flexion ${flexion}°, varus ${varus}°`)] }),
  });
  const pick = choice("Show", all.map(([key, name]) => [key, name]), all[0][0], (value) => { state.map = all.find(([key]) => key === value)[2]; plot.redraw(); });
  return section("grid", "Map of the grid", el("div", { class: "controls" }, pick), plot);
}

// Errors, gaps and penetrations of each smoothing degree.

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

// A line with its points over the degree of smoothing.
function overDegree(name, degrees, y, k, dash) {
  const style = { name, x: degrees, y, colour: lineStyle(k).colour };
  return [{ kind: "line", dash: dashNamed(dash), ...style }, { kind: "points", size: 5, text: (row) => `${name}: ${number(y[row])} at degree ${degrees[row]}`, ...style }];
}

function errorLayers(model, unit) {
  const keys = Object.keys(PARAMETERS).filter((key) => PARAMETERS[key].unit === unit), degrees = model.degrees.map((set) => set.degree);
  const values = (key, field) => model.degrees.map((set) => set.surfaces.find((s) => s.name === key)?.[field] ?? null);
  return keys.flatMap((key, k) => ERRORS.flatMap(([field, , name, dash]) => overDegree(`${PARAMETERS[key].name.split(",")[0]}, ${name}`, degrees, values(key, field), k, dash)))
    .filter((one) => one.y.some((v) => v !== null));
}

// Keys of a stored set and of a comparison, name and dash.
const ERRORS = [["leave_one_out_rms", "leave_one_out", "leave-one-out", "solid"], ["rms", "rms", "RMS", "dot"]];
const ERROR_CAPTION = "RMS of the residuals (dotted) and leave-one-out error (solid): the RMS always decreases with the degree, the leave-one-out error increases again when the polynomial fits the jitter.";

function errorFigure(model, unit) {
  return figure({ title: `Error by degree, ${unit}`, caption: ERROR_CAPTION, make: () => ({ x: axis("degree", { step: 1 }), y: axis(unit, { fromZero: true }), layers: errorLayers(model, unit) }) });
}

const COMPARED_ERRORS = { translation: ["translation", "mm"], theta: ["θ", "degrees"], varus: ["varus", "degrees"] };

const MEASURES = [["rms", "RMS"], ["largest", "largest"], ["leave_one_out", "leave-one-out"], ["roughness", "roughness"]];

// `of` are the rows with the errors of the joint, or of a follower.
function errorsTable(of, caption, recommended) {
  const names = of[0].errors.map((one) => one.name);
  const headings = names.flatMap((name) => MEASURES.map(([, text], k) => (k === 0 ? `${COMPARED_ERRORS[name]?.join(", ") ?? name}: ${text}` : text)));
  const cells = (row) => row.errors.flatMap((one) => MEASURES.map(([key]) => number(one[key])));
  return table(`${caption} Roughness is the RMS second derivative, per degree²; the recommended degree is highlighted.`,
    ["degree", ...headings], of.map((row) => [String(row.degree), ...cells(row)]), { kinds: Array(headings.length + 1).fill("tight"), chosen: (r) => of[r].degree === recommended });
}

function errorTables({ rows, recommended }) {
  const ofFollower = (name) => rows.flatMap(({ degree, followers }) => followers.filter((one) => one.name === name).map(({ errors }) => ({ degree, errors })));
  return [errorsTable(rows, "Each degree fitted to the raw motion.", recommended),
    ...rows[0].followers.map(({ name }) => errorsTable(ofFollower(name), `Each degree fitted to the solved coordinates of ${name}.`, recommended))];
}

// Names of faults: pipeline/analysis/compare.hpp.
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
  const names = rows[0].errors.map((one) => one.name).filter((name) => COMPARED_ERRORS[name][1] === unit), degrees = rows.map((row) => row.degree);
  return names.flatMap((name, k) => ERRORS.flatMap(([, key, text, dash]) =>
    overDegree(`${COMPARED_ERRORS[name][0]}, ${text}`, degrees, rows.map((row) => row.errors.find((one) => one.name === name)[key]), k, dash)));
}

function comparedFigure({ recommended }, title, caption, layers, unit) {
  const line = () => (recommended < 0 ? [] : [{ kind: "upright", x: recommended, colour: lineStyle(2).colour, dash: dashNamed("dash") }]);
  return figure({ title, caption, make: () => ({ x: axis("degree", { step: 1 }), y: axis(unit, { fromZero: true }), layers: [...line(), ...layers()] }) });
}

function faultLayers(rows) {
  return [["largest_penetration_mm", "largest penetration"], ["largest_gap_mm", "largest gap"]].flatMap(([key, name], k) =>
    overDegree(name, rows.map((row) => row.degree), rows.map((row) => row.faults[key]), k, "solid"));
}

// The comparison of `vrda compare`, computed with the report.
function comparedParts(comparison) {
  const { rows, recommended, reason } = comparison;
  const caption = `${ERROR_CAPTION}${recommended < 0 ? "" : " The dashed line is the recommended degree."}`;
  const figures = ["mm", "degrees"].map((unit) => comparedFigure(comparison, `Error by degree, ${unit}`, caption, () => comparedErrors(rows, unit), unit));
  if (rows[0].faults) figures.push(comparedFigure(comparison, "Penetration and gap by degree", "Largest penetration and gap along Δ of the smoothed motion at the attitudes of the grid, mm.", () => faultLayers(rows), "mm"));
  const box = recommended < 0 ? el("div", { class: "box warning" }, el("strong", {}, "No degree meets the criteria"), `${reason[0].toUpperCase()}${reason.slice(1)}.`) : el("div", { class: "box good" }, `Recommended: ${reason}.`);
  return [box, el("div", { class: `columns ${figures.length === 3 ? "three" : ""}` }, figures), judgementTable(comparison), ...errorTables(comparison), faultsTable(comparison)];
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

// Bands of an uncertain job over flexion, and the inputs that the spread comes from.

const BAND_NAMES = { internal: "internal rotation", contact_force: "contact force", contact_force_medial: "medial contact force", contact_force_lateral: "lateral contact force" };
const BAND_UNITS = { degree: "degrees", mm: "mm", N: "N" };
const KEYS = ["varus", "internal", "anterior", "proximal", "lateral"];

function bandName(model, one) {
  return BAND_NAMES[one.name] ?? wordOf(model, one.name);
}

/** Whether the quantity is more than rounding: flexion is mostly driven. */
function hasSpread(one) {
  return one.high.some((value, k) => value !== null && value - one.low[k] > 1e-6);
}

function bandFigure(model, one) {
  const name = bandName(model, one), unit = BAND_UNITS[one.unit];
  const job = KEYS.includes(one.name) ? model.curves.find((curve) => curve.name === "raw")?.[one.name] : undefined;
  return figure({
    title: name[0].toUpperCase() + name.slice(1),
    caption: "Shaded: 5 to 95 per cent of the samples; line: median; dotted: smallest and largest" + (job ? "; dashed: the job itself." : "."),
    make: () => {
      const { colour } = lineStyle(0), x = model.flexion, thin = { colour, width: 1, dash: dashNamed("dot"), name: "smallest, largest" };
      return {
        x: axis(gridTitle(model, "flexion")), y: axis(unit),
        layers: [
          { kind: "band", name: "5 to 95 %", x, low: one.low, high: one.high, colour: `${colour}33` },
          ...["low", "high"].map((key) => curve(key === "low" ? "5 %" : "95 %", x, one[key], unit, { colour: "transparent", name: "5 to 95 %" })),
          curve("median", x, one.median, unit, { colour, width: 2.4 }), curve("smallest", x, one.smallest, unit, thin), curve("largest", x, one.largest, unit, thin),
          ...(job ? [curve("the job", x, job, unit, { colour: theme().ink, width: 1.4, dash: dashNamed("dash") })] : []),
        ],
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
  const rows = shown.map((one) => [bandName(model, one), `${decimal(meanWidth(one), 2)} ${BAND_UNITS[one.unit]}`, el("ul", {}, one.shares.filter((share) => share.high >= 0.05).slice(0, 4).map((share) => el("li", {}, shareText(share))))]);
  return section("uncertainty", "Uncertainty",
    el("p", {}, `${of.samples} samples of ${of.draws} independent draws (${of.sequence === "sobol" ? "Sobol sequence" : "Latin hypercube"}, seed ${of.seed}); varus is free. ${failures}`),
    el("div", { class: "columns" }, shown.map((one) => bandFigure(model, one))),
    table("Width of the bands and where the spread comes from: first-order Sobol indices with 90 % intervals, means over flexion weighted by variance", ["quantity", "mean width, 5 to 95 %", "largest shares"], rows));
}
