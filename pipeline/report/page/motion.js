// The motion of the joint: clinical curves, comparison with other curves, surfaces over the grid, repair.
import { cssOn, rangeOf, scaleBar, SCALES } from "./chart.js";
import { absent, choice, decimal, el, folded, gridTitle, length, motionName, number, PARAMETERS, parameterTitle, section, setName, table, wordOf } from "./page.js";
import { abscissaName, axis, curve, curvePlots, figure, isCycle, lineStyle } from "./plot.js";
import { viewFrom } from "./space.js";

// Clinical curves of one model: screw-home and translations.

// Of the smoothed sets only the recommended or the first (highest) one is visible initially, and the two-sided motion only as the default.
function shownCurves(model) {
  const smoothed = model.curves.filter((curve) => curve.name.startsWith("degree_"));
  const shown = smoothed.find((curve) => curve.name === `degree_${model.comparison?.recommended}`) ?? smoothed[0];
  return model.curves.map((curve) => ({
    ...curve,
    label: motionName(curve.name),
    isOff: (smoothed.includes(curve) && curve !== shown) || (curve.name === "two_sided" && model.default_motion !== "two_sided"),
    width: ["raw", "bones_alone"].includes(curve.name) ? 1.4 : 2.4,
    band: curve.name === "raw" ? bandOf(model) : undefined,
  }));
}

function bandOf(model) {
  const spine = model.spine;
  return spine && spine.band_moment_nmm > 0 ? { low: spine.internal_low, high: spine.internal_high } : undefined;
}

function numbersTable(model) {
  const curve = model.curves.find(({ name }) => name === model.default_motion) ?? model.curves[0];
  const keys = ["internal", "varus", "anterior", "proximal", "lateral"];
  const rows = curve.flexion.map((flexion, k) => [decimal(flexion, model.key_name ? 3 : 1), ...keys.map((key) => decimal(curve[key][k], 2))]);
  const headings = [model.key_name ? abscissaName() : `${wordOf(model, "flexion")}, °`, "internal rotation, °", `${wordOf(model, "varus")}, °`, "anterior, mm", "proximal, mm", "lateral, mm"];
  return folded("Values of these curves", table(`Clinical numbers, ${motionName(curve.name)}`, headings, rows));
}

function bandText(model) {
  const band = bandOf(model);
  return band ? ` The shaded band is rotation under an extra moment of ±${decimal(model.spine.band_moment_nmm / 1000, 2)} N m about Δ.` : "";
}

export function rotationSection(model) {
  const isKnee = model.joint === "knee";
  const varus = wordOf(model, "varus"), Varus = varus[0].toUpperCase() + varus.slice(1);
  const quantities = [
    { key: "internal", name: "internal rotation", unit: "degrees", title: isKnee ? "Screw-home: internal rotation" : "Rotation about the moving body’s long axis",
      caption: `Rotation of the ${model.moving.name} about its long axis, internal +, Grood-Suntay.${bandText(model)}` },
    { key: "varus", name: varus, unit: "degrees", title: `${Varus} along the motion`, caption: `${model.words ? Varus : "Varus (adduction +)"} of the motion${model.is_varus_free ? "" : "; on the raw spine it changes in steps of the grid"}.` },
  ];
  return section("rotation", isKnee ? "Screw-home" : "Rotation", curvePlots(shownCurves(model), quantities));
}

export function translationsSection(model) {
  const of = { anterior: "forward +", proximal: "towards the reference +, distraction −", lateral: "away from the body’s midline + on both sides" };
  const quantities = Object.entries(of).map(([key, sign]) => ({ key, name: key, unit: "mm", caption: `${key[0].toUpperCase()}${key.slice(1)}: ${sign}.` }));
  const text = `Translations of the ${model.moving.name} along the Grood-Suntay axes, of its point that is at the rotation centre in the zero pose; mm over ${model.key_name ?? "degrees of flexion"}.`;
  return section("translations", "Translations", el("p", {}, text), curvePlots(shownCurves(model), quantities), numbersTable(model));
}

// Compares several motions with measured and published curves on the same axes.

const COMPARED = [
  { key: "internal", name: "internal rotation", short: "internal, °", unit: "degrees", caption: "Internal rotation +." },
  { key: "varus", name: "varus", short: "varus, °", unit: "degrees", caption: "Varus (adduction) +." },
  { key: "anterior", name: "anterior", short: "anterior, mm", unit: "mm", caption: "Along the Grood-Suntay axes, anterior +." },
  { key: "proximal", name: "proximal", short: "proximal, mm", unit: "mm", caption: "The same, proximal +, distraction −." },
  { key: "lateral", name: "lateral", short: "lateral, mm", unit: "mm", caption: "The same, lateral + on both sides." },
];
// Only for curve files whose translations of the mesh origin cannot be those of another point.
const OF_ORIGIN = ["anterior", "proximal", "lateral"].map((name) => ({ key: `origin_${name}`, name: `${name}, mesh origin`, short: `${name}, origin, mm`, unit: "mm",
  caption: "Origin of the moving meshes along the reference’s axes." }));

function comparedIn(data) {
  return data.shows_origin ? [...COMPARED, ...OF_ORIGIN] : COMPARED;
}

function pointText(data) {
  const points = data.models.map((model) => `(${model.point_mm.map((mm) => decimal(mm, 1)).join(", ")})`);
  const isOne = points.every((point) => point === points[0]);
  return isOne ? `at ${points[0]} mm` : `at ${data.models.map((model, k) => `${points[k]} mm in ${model.name}`).join(", ")}: other points, so offsets of translations mean nothing`;
}


function modelCurves(data) {
  const isAlone = data.models.length === 1;
  return data.models.flatMap((model) => model.curves.map((curve, k) => ({
    ...curve, label: isAlone ? motionName(curve.name) : `${model.name}: ${motionName(curve.name)}`, isOff: k > 0, width: 2.4,
    band: k === 0 && curve.name === "raw" && model.spine?.band_moment_nmm > 0 ? { low: model.spine.internal_low, high: model.spine.internal_high } : undefined })));
}

function fileCurves(data) {
  return data.against.map((curve) => ({ ...curve, label: curve.name, isPoints: isCycle(curve.flexion), width: 1.6 }));
}

function zeroControl(plots) {
  const box = el("input", { type: "checkbox" });
  box.addEventListener("change", () => { plots.state.isZeroed = box.checked; plots.redraw(); });
  return el("div", { class: "controls" }, el("label", {}, box, "subtract each curve’s value at the first common flexion (translations depend on the tracked point)"));
}

function cellText(d) {
  return d ? `${decimal(d.rms, 2)} (${decimal(d.largest, 2)})` : "–";
}

function differencesTable(data, against) {
  const rows = data.differences.filter((d) => d.against === against).map((d) => {
    const name = data.models.length === 1 ? motionName(d.curve) : `${d.model}: ${motionName(d.curve)}`;
    const n = Object.values(d.by_quantity)[0]?.n ?? 0;
    return [name, String(n), ...comparedIn(data).map((q) => cellText(d.by_quantity[q.key]))];
  });
  return table(`Against ${against}: RMS and, in brackets, the largest difference, at its flexions within the range of both`, ["motion", "points", ...comparedIn(data).map((q) => q.short)], rows);
}

function offsetsTable(data, against) {
  const text = (d) => (d ? `${decimal(d.mean, 2)} / ${decimal(d.rms_about_mean, 2)}` : "–");
  const rows = data.differences.filter((d) => d.against === against).map((d) => [`${d.model}: ${motionName(d.curve)}`, ...comparedIn(data).map((q) => text(d.by_quantity[q.key]))]);
  return table(`Against ${against}: mean difference (motion minus curve) / RMS about that mean`, ["motion", ...comparedIn(data).map((q) => q.short)], rows);
}

function notesOf(data) {
  const items = data.against.map((curve) => el("li", {}, el("strong", {}, `${curve.name}: `), curve.notes.join("; ") || "no notes in the file"));
  return items.length > 0 ? folded("Comments in the curve files", el("ul", {}, items)) : null;
}

export function comparisonSection(data) {
  const plots = curvePlots([...modelCurves(data), ...fileCurves(data)], comparedIn(data));
  const names = [...new Set(data.differences.map((d) => d.against))];
  const text = `Clinical numbers over flexion, on the same axes: the moving body in the reference’s frame. Translations are those of the moving point ${pointText(data)} (canonical coordinates; the rotation centre), also of curve files that give those of the mesh origin with all three angles. Points are the frames of a measured cycle.`;
  return section("comparison", data.against.length > 0 && data.models.length === 1 ? "Against measured and published curves" : "Curves over flexion",
    el("p", {}, text), plots, zeroControl(plots), ...names.map((name) => differencesTable(data, name)),
    names.length > 0 ? folded("Differences without offsets", ...names.map((name) => offsetsTable(data, name))) : null, notesOf(data));
}

// Raw next to smoothed surfaces, as in figure 16 of the thesis.

function difference(a, b) {
  return a.map((row, i) => row.map((value, j) => (value === null || b[i][j] === null ? null : value - b[i][j])));
}

function widened([low, high]) {
  return low < high ? [low, high] : [low - 1, low + 1];
}

function placeText(model, i, j) {
  return `flexion ${model.flexion[i]}°, varus ${model.varus[j]}°`;
}

// `grid[i][j]` as a surface over both axes.
function surfacePicture(model, { parameter }, grid, range) {
  return {
    size: [1.1, 1.25, 0.75], axes: [{ title: gridTitle(model, "varus", "°"), range: widened(rangeOf(model.varus)) }, { title: gridTitle(model, "flexion", "°"), range: widened(rangeOf(model.flexion)) },
      { title: PARAMETERS[parameter].unit, range }],
    surface: { x: model.varus, y: model.flexion, z: grid, colourOf: (value) => cssOn(SCALES.viridis, value, range), text: (i, j) => `${placeText(model, i, j)}: ${decimal(grid[i][j], 3)}` },
  };
}

function heatChart(model, grid, range, scale) {
  return {
    x: axis(gridTitle(model, "flexion")), y: axis(`${gridTitle(model, "varus")}${model.words ? "" : " (adduction +)"}`), key: [scaleBar(scale, number(range[0]), number(range[1]))],
    layers: [{ kind: "cells", x: model.flexion, y: model.varus, colourOf: (i, j) => (grid[i][j] === null ? null : cssOn(scale, grid[i][j], range)),
      text: (i, j) => (grid[i][j] === null ? "" : `${placeText(model, i, j)}: ${decimal(grid[i][j], 3)}`) }],
  };
}

// The same grid as a surface and as a map, of which one is shown; both surfaces turn together.
function panel(model, state, isRaw) {
  const shown = () => {
    const both = [model.surfaces[0], state.set].map((set) => set[state.parameter]);
    return { grid: both[isRaw ? 0 : 1], range: widened(rangeOf(both.flat(2))) };
  };
  const facts = { title: isRaw ? "Raw" : "Smoothed", size: "tall",
    caption: isRaw ? "The solver's result at each attitude; holes are attitudes without a pose."
      : "The least-squares polynomial with the same axes and colours; set and parameter are selected above." };
  const pictures = {
    surface: figure({ ...facts, view: state.seen, make: () => { const { grid, range } = shown(); return surfacePicture(model, state, grid, range); } }),
    map: figure({ ...facts, make: () => { const { grid, range } = shown(); return heatChart(model, grid, range, SCALES.viridis); } }),
  };
  const place = el("div", {}, pictures.surface);
  place.redraw = () => { place.replaceChildren(pictures[state.view]); pictures[state.view].redraw(); };
  return place;
}

function residualPanel(model, state) {
  return figure({
    title: "Smoothed minus raw", size: "low",
    caption: "Change by smoothing at each attitude, in the unit of the parameter; pale is no change. Changes above 0.145 mm or 0.27 degrees are perceptible on the bench.",
    make: () => {
      const grid = difference(state.set[state.parameter], model.surfaces[0][state.parameter]);
      const most = Math.max(...rangeOf(grid.flat()).map(Math.abs), 1e-9);
      return heatChart(model, grid, [-most, most], SCALES.difference);
    },
  });
}

function controls(model, state, redraw) {
  const parameters = Object.keys(PARAMETERS).filter((key) => model.surfaces[0][key]);
  const smoothed = model.surfaces.slice(1);
  const items = [choice("Parameter", parameters.map((key) => [key, parameterTitle(key)]), state.parameter, (value) => { state.parameter = value; redraw(); })];
  if (smoothed.length > 1) {
    items.push(choice("Smoothed set", smoothed.map((set) => [set.name, setName(set.name)]), state.set.name, (value) => { state.set = smoothed.find((set) => set.name === value); redraw(); }));
  }
  items.push(choice("View", [["surface", "surface"], ["map", "map"]], state.view, (value) => { state.view = value; redraw(); }));
  return el("div", { class: "controls" }, items);
}

// The recommended degree if it is in the file, else the highest.
function preferred(model) {
  const smoothed = model.surfaces.slice(1);
  return smoothed.find((set) => set.name === `degree_${model.comparison?.recommended}`) ?? smoothed.at(-1) ?? model.surfaces[0];
}

function gridParts(model) {
  const state = { parameter: "tx", set: preferred(model), view: "surface", seen: viewFrom(-0.75, 0.5) };
  const hasSmoothed = model.surfaces.length > 1;
  const panels = (hasSmoothed ? [true, false] : [true]).map((isRaw) => panel(model, state, isRaw));
  const residual = hasSmoothed ? residualPanel(model, state) : null;
  const redraw = () => [...panels, residual].filter(Boolean).forEach((one) => one.redraw());
  return [controls(model, state, redraw), hasSmoothed ? el("div", { class: "columns" }, panels) : panels, residual];
}

// A single axis: curves of each parameter, raw as points, smoothed as lines; only the preferred set is shown at first.
function overOneAxis(model) {
  const isFlexion = model.flexion.length >= model.varus.length;
  const keys = Object.keys(PARAMETERS).filter((key) => model.surfaces[0][key]);
  const values = (set, key) => (isFlexion ? set[key].map((row) => row[0]) : set[key][0]);
  const shown = preferred(model).name.replace("_recontacted", "");
  const curves = model.surfaces.map((set) => ({
    label: setName(set.name), flexion: isFlexion ? model.flexion : model.varus, isPoints: set.name === "raw", isOff: !["raw", shown, `${shown}_recontacted`].includes(set.name),
    ...Object.fromEntries(keys.filter((key) => set[key]).map((key) => [key, values(set, key)])) }));
  const caption = (key) => `Raw as points, smoothed as lines; ${PARAMETERS[key].unit}, in world axes (θ and varus with right-knee signs).`;
  return [curvePlots(curves, keys.map((key) => ({ key, ...PARAMETERS[key], caption: caption(key) })), { over: gridTitle(model, isFlexion ? "flexion" : "varus") })];
}

export function surfacesSection(model) {
  const isGrid = model.flexion.length > 1 && model.varus.length > 1;
  const intro = isGrid ? "Each parameter of the pose over flexion and varus, solved and smoothed by polynomials. Drag to rotate both views."
    : "Each parameter of the pose over the only axis of this model.";
  const missing = model.surfaces.length > 1 || model.key_name ? null : absent("The file has no smoothed set; vrda smooth FILE --degree 6 adds one.");
  return section("surfaces", "Raw and smoothed motion", el("p", {}, intro), missing, ...(isGrid ? gridParts(model) : overOneAxis(model)));
}

// A measured motion and its repair over the frames: overlap, gap, six coordinates, distance.

const STATUSES = ["unchanged", "repaired", "not_converged", "nothing_ahead"];

const QUANTITIES = [
  { key: "penetration", name: "overlap", unit: "mm", caption: "Travel opposite to Δ out of the overlap." },
  { key: "gap", name: "gap", unit: "mm", caption: "Travel along Δ to the next contact; interrupted where the bodies overlap." },
  { key: "anterior", name: "anterior", unit: "mm", caption: "Grood-Suntay translation, forward +." },
  { key: "proximal", name: "proximal", unit: "mm", caption: "Grood-Suntay translation, towards the reference +." },
  { key: "lateral", name: "lateral", unit: "mm", caption: "Grood-Suntay translation, lateral +." },
  { key: "joint_flexion", name: "joint flexion", unit: "degrees", caption: "Grood-Suntay flexion." },
  { key: "varus", name: "varus", unit: "degrees", caption: "Grood-Suntay varus, adduction +." },
  { key: "internal", name: "internal rotation", unit: "degrees", caption: "Grood-Suntay internal rotation +." },
];

function largest(values) {
  return values.reduce((most, value) => Math.max(most, value ?? 0), 0);
}

function repairedTable({ before, after }) {
  const row = (name, motion) => [name, String(motion.penetration.filter((mm) => mm > 0).length), length(largest(motion.penetration)), length(largest(motion.gap))];
  return table("Measured and repaired motion", ["motion", "frames that overlap", "largest overlap", "largest gap along Δ"], [row("measured", before), row("repaired", after)]);
}

function noiseText(repair) {
  const rms = Math.sqrt(repair.distance.reduce((sum, d) => sum + d * d, 0) / repair.distance.length);
  const counts = STATUSES.map((name, code) => [name, repair.status.filter((one) => one === code).length]).filter(([, n]) => n > 0);
  const limits = repair.gap_limit.map((mm) => (mm === null ? "none" : length(mm))).join(" and ");
  const list = (values) => values.map((value) => number(value)).join(", ");
  return `${counts.map(([name, n]) => `${n} ${name}`).join(", ")}${repair.converged ? "" : "; limit of iterations reached"}. Standard deviations of the measurement about and along X, Y, Z: ${list(repair.noise_deg)} degrees, ${list(repair.noise_mm)} mm. Mahalanobis distance of the repaired from the measured poses: ${number(rms)} (root mean square), at most ${number(largest(repair.distance))}. Largest permitted gap: ${limits}.`;
}

/** Before and after of a repaired measurement. */
export function repairSection({ repair }) {
  const curves = [["measured", repair.before], ["repaired", repair.after]].map(([label, motion]) => ({ ...motion, label, joint_flexion: motion.flexion, flexion: repair.key })); // flexion: the abscissa
  const distance = figure({
    title: "distance from the measurement", caption: "Mahalanobis distance of each frame, in standard deviations of the measurement.",
    make: () => ({ x: axis(repair.key_name), y: axis("standard deviations"), layers: [curve("distance", repair.key, repair.distance, "standard deviations", lineStyle(0))] }),
  });
  return section("repair", "Repair of the measurement", el("p", {}, noiseText(repair)), repairedTable(repair), curvePlots(curves, QUANTITIES, { over: repair.key_name }), distance);
}
