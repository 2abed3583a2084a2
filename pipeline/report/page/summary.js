// What a report says without plots: summary, images of the joint, provenance.
import { absent, decimal, el, folded, length, motionName, number, percent, section, table, wordOf } from "./page.js";

// Summary: warnings, key numbers, statuses.

function card(value, label) {
  return el("div", { class: "card" }, el("span", { class: "value" }, value), el("span", { class: "label" }, label));
}

function axisText(values, name) {
  if (values.length === 1) return `${number(values[0])}° ${name}`;
  return `${number(values[0])}° to ${number(values[values.length - 1])}° of ${name} in ${values.length} values`;
}

/** Describes the grid. */
function gridText(model) {
  if (model.key_name) return `${model.flexion.length} frames over ${model.key_name} from ${number(model.flexion[0])} to ${number(model.flexion.at(-1))}`;
  const varus = model.is_varus_free ? `${wordOf(model, "varus")} solved by the equilibrium` : axisText(model.varus, wordOf(model, "varus"));
  return `${axisText(model.flexion, wordOf(model, "flexion"))}, ${varus}`;
}

const METHODS = { "stability-search": "stability search", equilibrium: "equilibrium", import: "measurement" };

function methodName(model) {
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
function warningBox(warnings, title = "Read this first") {
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

// Verdict on a knee: its measures beside published ones.

// Where a published range is not measured but assumed, the cell says so.
function rangeText({ low, high, is_spread_assumed: isAssumed }) {
  if (low === null && high === null) return "–";
  const range = low === null ? `at most ${decimal(high, 1)}` : high === null ? `at least ${decimal(low, 1)}` : `${decimal(low, 1)} to ${decimal(high, 1)}`;
  return isAssumed ? `${range} (assumed)` : range;
}

const run = (from, to) => (from === to ? `${number(from)}°` : `${number(from)} to ${number(to)}°`);
const runsText = (runs) => `at ${runs.from_deg.map((from, k) => run(from, runs.to_deg[k])).join(", ")}`;

function liftOffText(sides) {
  if (!sides) return "Lift-off: the gaps of this motion are not known.";
  const lifted = sides.filter((side) => side.from_deg.length > 0).map((side) => `${side.compartment} ${runsText(side)}`);
  return `Lift-off, a gap above 0.145 mm: ${lifted.length > 0 ? lifted.join("; ") : "at no flexion"}.`;
}

const isBeyond = (m) => ["below", "above"].includes(m.standing);

/** Table and sentence at the top of a report on a knee. */
export function verdictSection(model) {
  const v = model.verdict;
  const isOutside = v.measures.length === 0 || v.measures.some(isBeyond) || v.followers.length > 0;
  const box = el("div", { class: `box ${isOutside ? "warning" : "good"}` }, el("strong", {}, `The motion: ${motionName(v.set)}`), v.sentence);
  if (v.measures.length === 0) return section("verdict", "Verdict", box);
  const at = (value, flexion) => `${decimal(value, 1)}${value === null || flexion === null ? "" : ` at ${number(flexion)}°`}`;
  const standing = (m) => (isBeyond(m) ? el("strong", {}, m.standing) : m.standing.replace("_", " "));
  const rows = v.measures.map((m) => [`${m.label}, ${m.unit}`, at(m.value, m.flexion_deg), at(m.published_mean, m.published_flexion_deg), rangeText(m), standing(m), m.source]);
  const headings = ["measure", "this knee", "published mean", "published range", "result", "source"];
  const contacts = v.contacts_of && v.contacts_of !== v.set ? ` The contacts are those of the solved poses (${motionName(v.contacts_of)}).` : "";
  return section("verdict", "Verdict", box,
    table("Rotation of the tibia from the first flexion, internal positive; travel of points of the femur on the tibia, anterior positive; “at”: degrees of flexion; assumed: the spread is not published", headings, rows, { kinds: ["", "", "", "word", "word", "text"] }),
    el("p", {}, `${liftOffText(v.lift_off)}${contacts}`),
    ...v.followers.map((one) => el("p", {}, `${one.follower}: ${one.finding} ${runsText(one)}.`)));
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

// Images of the joint.

function still(one) {
  const label = `${one.view}, ${one.label}`;
  return el("figure", {}, el("img", { src: `data:image/png;base64,${one.png}`, alt: `The joint, ${label}`, loading: "eager" }), el("figcaption", {}, label));
}

// One row per view; with fewer than three images a row has four columns, which keeps them small.
function perRow(stills) {
  const n = stills.filter((one) => one.view === stills[0].view).length;
  return n < 3 ? 4 : n;
}

export function stillsSection(model) {
  const { stills, note } = model.stills;
  return section("stills", "The joint", note ? absent(note) : null, stills.length > 0 ? el("div", { class: "stills", style: `--per-row: ${perRow(stills)}` }, stills.map(still)) : null);
}

// Provenance: inputs, bodies, scaling, job.

function inputsTable(inputs) {
  return table("SHA-256 of every input file, or of the bytes of a generated mesh", ["input", "SHA-256"], inputs.map((input) => [input.name, input.sha256]), { kinds: ["", "hash"] });
}

function bodiesTable(model) {
  const rows = [model.reference, model.moving].flatMap((body, k) => [[
    body.name, k === 0 ? "reference" : "moving", body.components.map((c) => `${c.name} (${c.material})`).join(", "), String(body.contact_triangles), String(body.visual_triangles)]]);
  return table("Bodies", ["body", "role", "components", "contact triangles", "visual triangles"], rows, { kinds: ["", "word", "text"] });
}

// Scaling of the joint to its subject and fit of the landmarks.
function scaled(scaling) {
  if (!scaling) return [];
  const [x, y, z] = scaling.factor;
  const by = x === y && y === z ? String(x) : `${x} (anterior), ${y} (proximal), ${z} (right)`;
  const steps = scaling.keeps_steps ? "steps solved at factor 1, then scaled" : "steps solved at this size";
  if (scaling.landmarks.length === 0) return [el("p", {}, `The meshes are scaled by ${by}; ${steps}.`)];
  const error = scaling.standard_error === null ? "unknown" : String(scaling.standard_error);
  const rows = scaling.landmarks.map((name, i) => [name, scaling.model_mm[i], scaling.subject_mm[i], scaling.residual_mm[i]].map(String));
  return [
    el("p", {}, `The meshes are scaled by ${by} (standard error ${error}), fitted to distances between landmarks with a residual of ${scaling.residual_rms_mm} mm (root mean square); ${steps}.`),
    table("Landmarks, mm", ["pair", "model", "subject", "residual"], rows)];
}

function ofModel(model) {
  const p = model.provenance;
  return [bodiesTable(model), ...scaled(p.scaling), inputsTable(p.inputs),
    folded("Job file", el("pre", {}, p.job)),
    folded("Job with all keys and values", el("pre", {}, p.resolved))];
}

export function provenanceSection(data) {
  const parts = data.models.length === 1 ? ofModel(data.models[0])
    : data.models.map((model) => folded(`${model.name}: ${model.title}`, ...ofModel(model)));
  const versions = `Made by ${data.program} from motion models of format ${data.models[0].provenance.format_version}; plots by uPlot (MIT licence). The page contains no time or host: the same files give the same page.`;
  return section("provenance", "Provenance", el("p", {}, versions), ...parts);
}
