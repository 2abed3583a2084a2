// Clinical curves of one model: screw-home and translations.
import { el, folded, section, table } from "./dom.js";
import { curvePlots } from "./curves.js";
import { decimal, motionName, wordOf } from "./format.js";
import { abscissaName } from "./plot.js";

// Of the smoothed sets only the recommended or the first (highest) one is visible initially, and the two-sided motion only as the default.
function shownCurves(model) {
  const smoothed = model.curves.filter((curve) => curve.name.startsWith("degree_"));
  const shown = smoothed.find((curve) => curve.name === `degree_${model.comparison?.recommended}`) ?? smoothed[0];
  return model.curves.map((curve) => ({
    ...curve,
    label: motionName(curve.name),
    isOff: (smoothed.includes(curve) && curve !== shown) || (curve.name === "two_sided" && model.default_motion !== "two_sided"),
    width: curve.name === "raw" ? 1.4 : 2.4,
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
