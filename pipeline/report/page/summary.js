// Summary: warnings, key numbers, statuses.
import { el, section, table } from "./dom.js";
import { decimal, length, motionName, number, percent, wordOf } from "./format.js";

function card(value, label) {
  return el("div", { class: "card" }, el("span", { class: "value" }, value), el("span", { class: "label" }, label));
}

function axisText(values, name) {
  if (values.length === 1) return `${number(values[0])}° ${name}`;
  return `${number(values[0])}° to ${number(values[values.length - 1])}° of ${name} in ${values.length} values`;
}

/** Describes the grid. */
export function gridText(model) {
  if (model.key_name) return `${model.flexion.length} frames over ${model.key_name} from ${number(model.flexion[0])} to ${number(model.flexion.at(-1))}`;
  const varus = model.is_varus_free ? `${wordOf(model, "varus")} solved by the equilibrium` : axisText(model.varus, wordOf(model, "varus"));
  return `${axisText(model.flexion, wordOf(model, "flexion"))}, ${varus}`;
}

const METHODS = { "stability-search": "stability search", equilibrium: "equilibrium", import: "measurement" };

export function methodName(model) {
  return METHODS[model.method] ?? model.method;
}

// Where attitude and joint have different angles.
function axesText(model) {
  if (!model.axes_are_turned) return "";
  return " Δ is not proximal: flexion and varus of the attitude and θ are about axes turned with Δ; the clinical curves have the joint’s own angles (Grood-Suntay), over its own flexion.";
}

/** The line below the title. */
export function leadText(model) {
  return `${model.side} ${model.joint === "knee" ? "knee" : "joint"}, ${model.moving.name} on ${model.reference.name}, by ${methodName(model)}; ${gridText(model)}. Default motion: ${motionName(model.default_motion)}.${axesText(model)}`;
}

/** A box with the warnings, or with "No warnings". */
export function warningBox(warnings, title = "Read this first") {
  if (warnings.length === 0) return el("div", { class: "box good" }, el("strong", {}, "No warnings"), "Every attitude is solved, and no gap or penetration is perceptible.");
  return el("div", { class: "box warning", role: "note" }, el("strong", {}, title), el("ul", {}, warnings.map((text) => el("li", {}, text))));
}

function equilibriumCards(n) {
  if (n.push_n === null) return [];
  return [
    card(`${number(n.balance_residual_n, 2)} N`, `largest residual of the force balance, for a push of ${number(n.push_n)} N`),
    card(String(n.several_optima), `flexions with several equilibria${n.several_optima > 0 ? `, up to ${number(n.optima_spread_deg)}° apart` : ""}`),
  ];
}

// A part of a report is without audits.
function twoSidedCard(model) {
  const f = model.audits?.find((audit) => audit.name === "two_sided")?.two_sided;
  if (!f) return [];
  const sides = ["medial", "lateral"].map((side) => `${side} gap ${length(f[`largest_gap_${side}_mm`])}, overlap ${length(f[`largest_overlap_${side}_mm`])}`);
  return [card(`${f.both_in_contact} of ${f.poses}`, `flexions of the two-sided motion with both compartments in contact; at most ${sides.join("; ")}`)];
}

function signed(value, digits = 1) {
  return value === null ? "–" : `${value < 0 ? "−" : "+"}${decimal(Math.abs(value), digits)}°`;
}

// Net rotation along the spine, its peak and its largest change.
function rotationCard(model) {
  const r = model.numbers.rotation, name = model.joint === "knee" ? "screw-home: net internal" : "net axial";
  const change = r.change_deg === null ? "" : `; largest change ${signed(r.change_deg)} per 5° of flexion, from ${number(r.change_from_deg)}° to ${number(r.change_to_deg)}°`;
  return card(signed(r.net_deg), r.net_deg === null ? `${name} rotation along the spine` : `${name} rotation along the spine from ${number(r.first_deg)}° to ${number(r.last_deg)}° of flexion; peak ${signed(r.peak_deg)} at ${number(r.peak_at_deg)}°${change}`);
}

function cards(model) {
  const n = model.numbers;
  const fibres = n.fibres > 0 ? [card(`${number(100 * n.largest_strain)} %`, `largest strain of ${n.fibres} fibres, any attitude`)] : [];
  return el("div", { class: "cards" },
    card(`${n.stable} of ${n.cells}`, "attitudes solved"),
    card(length(n.largest_penetration_mm), `largest penetration; ${n.overlapping} attitudes overlap`),
    card(n.largest_gap_mm === null ? "unbounded" : length(n.largest_gap_mm), "largest gap along Δ"),
    card(percent(n.theta_undetermined_share), "of the solved attitudes have undetermined rotation"),
    rotationCard(model),
    ...twoSidedCard(model), ...equilibriumCards(n), ...fibres);
}

function statusTable(model) {
  const rows = model.statuses.filter((status) => status.cells > 0).map((s) => [s.name, String(s.cells), s.meaning]);
  return table("Attitudes by status", ["status", "attitudes", "meaning"], rows, { kinds: ["", "", "text"] });
}

/** Top of a report on one model. */
export function summarySection(model) {
  return section("summary", "Summary", warningBox(model.warnings), cards(model), statusTable(model));
}

/** Top of a comparison. */
export function summariesSection(models) {
  const rows = models.map((model) => {
    const n = model.numbers;
    return [model.name, model.title, methodName(model), model.side, `${n.stable} of ${n.cells}`, number(n.largest_penetration_mm), number(n.largest_gap_mm), decimal(n.rotation.net_deg, 1), percent(n.theta_undetermined_share)];
  });
  const headings = ["file", "title", "method", "side", "attitudes solved", "largest penetration, mm", "largest gap, mm", "net internal rotation, °", "rotation undetermined"];
  const boxes = models.filter((model) => model.warnings.length > 0).map((model) => warningBox(model.warnings, model.name));
  return section("summary", "Summary", ...(boxes.length > 0 ? boxes : [warningBox([])]),
    table("The motion models, raw motion", headings, rows, { kinds: ["", "text", "word", "word"] }));
}
