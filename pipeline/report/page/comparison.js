// Compares several motions with measured and published curves on the same axes.
import { el, folded, section, table } from "./dom.js";
import { curvePlots, isCycle } from "./curves.js";
import { decimal, motionName } from "./format.js";

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
