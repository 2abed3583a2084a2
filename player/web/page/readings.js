// What the page says of a pose: clinical numbers, quantities of the plots, doubts.
import { degree, difference, sum, turned } from "./geometry.js";
import { stable } from "./motion.js";

// The clinical numbers of schemas/clinical.md, computed from X_reference_moving and the rotation centre.

/// Name, unit and meaning, in the order of the tables.
export const clinicalNumbers = [
  { name: "flexion", label: "Flexion", unit: "°" },
  { name: "varus", label: "Varus", unit: "°", note: "adduction +" },
  { name: "internal", label: "Internal rotation", unit: "°" },
  { name: "anterior", label: "Anterior translation", unit: "mm" },
  { name: "proximal", label: "Proximal translation", unit: "mm", note: "distraction −" },
  { name: "lateral", label: "Lateral translation", unit: "mm" },
];

/// Degrees and mm.
export function clinicalOf({ R, t }, centre, side) {
  const s = side === "left" ? -1 : 1;
  const c = difference(sum(turned(R, centre), t), centre);
  const across = Math.sqrt(R[0][1] ** 2 + R[1][1] ** 2);
  return {
    flexion: Math.atan2(R[0][1], R[1][1]) / degree,
    varus: Math.asin(Math.min(1, Math.max(-1, s * R[2][1]))) / degree,
    internal: Math.atan2(-s * R[2][0], R[2][2]) / degree,
    anterior: (R[1][1] * c[0] - R[0][1] * c[1]) / across,
    proximal: R[0][1] * c[0] + R[1][1] * c[1] + R[2][1] * c[2],
    lateral: s * c[2],
  };
}

// Quantities of a pose for the plots: names, units and values.

/// Positions of the file's surfaces; `hasTurnedAxes`: the push is not along the second axis.
const surfacesOf = ({ hasTurnedAxes }) => [
  { name: "tx", label: "Position forwards", unit: "mm", of: (pose) => pose.translation[0] },
  { name: "ty", label: hasTurnedAxes ? "Position upwards" : "Position along the push", unit: "mm", of: (pose) => pose.translation[1] },
  { name: "tz", label: "Position to the right", unit: "mm", of: (pose) => pose.translation[2] },
  { name: "theta", label: "Rotation about the push", unit: "°", of: (pose) => pose.theta / degree },
];

/// The quantities of a model, those that most readers look for first: the clinical numbers, the solved varus if it was free, and the surfaces.
export function quantitiesOf(model, isVarusFree) {
  const found = { name: "varus_found", label: "Solved varus", unit: "°", of: (pose) => pose.attitude.varus / degree };
  const order = ["internal", "varus", "anterior", "proximal", "lateral", "flexion"];
  const clinical = order.map((name) => clinicalNumbers.find((one) => one.name === name)).map(({ name, label, unit, note }) => ({
    name: `clinical_${name}`, label: note ? `${label} (${note})` : label, unit, isClinical: true,
    of: (pose) => clinicalOf(pose.referenceMoving, model.rotationCentre, model.side)[name],
  }));
  return [...clinical, ...(isVarusFree ? [found] : []), ...surfacesOf(model)];
}

/// [label, text] of the surfaces of a pose.
export const surfaceRows = (model, pose) => surfacesOf(model).map(({ label, unit, of }) => [label, `${formatNumber(pose.isSolved ? of(pose) : NaN)} ${unit}`]);

/// Formats a number for the page; NaN as a dash.
export const formatNumber = (x, digits = 2) => (Number.isFinite(x) ? x.toFixed(digits).replace(/^-(0\.?0*)$/, "$1").replace("-", "−") : "–");

// What a motion model says against its poses, as player/view/player_state: plausibility and missing poses of the attitudes
// around a pose, spans over flexion, and the warnings about the job. Degrees.

/// Codes, names and meanings of pipeline/model/step_record that make a pose doubtful, the gravest first.
export const plausibilities = [
  { code: 3, name: "dislocated", colour: [178, 58, 72], meaning: "further from the start pose in contact than half the joint's smallest width, or rotated by more than 45 degrees (a knee) or 90; add ligaments, check side, axes and frame.origin, or narrow the grid" },
  { code: 4, name: "border contact", colour: [217, 138, 31], meaning: "a contact at an edge where the mesh ends; use a mesh that covers more of the joint, or narrow the grid" },
  { code: 5, name: "overstrained", colour: [150, 80, 160], meaning: "a fibre's strain above 0.44 or a bundle's tension above 1730 N, where ligaments fail; check attachments and slack lengths, or narrow the grid" },
  { code: 1, name: "nothing ahead", colour: [120, 120, 40], meaning: "no surface along the push within the contact resolution, here or displaced sideways by it" },
  { code: 2, name: "unstable balance", colour: [200, 170, 60], meaning: "the energy is lower one contact resolution away in both senses of one direction" },
];

const rounding = 1e-9;

/// The nodes of an axis around a value: one at a node, else two.
function around(axis, value) {
  const last = axis.length - 1;
  let row = 0;
  while (row < last && axis[row + 1] <= value + rounding) ++row;
  return row === last || value - axis[row] <= rounding ? [row] : [row, row + 1];
}

/// { plausibility: one of `plausibilities` or undefined, isBesideHole, follower: whose, if not the joint's } of the attitudes around a pose; a
/// follower has a doubt only if the joint has none.
function doubtOf(model, pose) {
  const n = model.varus.length, cells = [];
  for (const i of around(model.flexion, pose.attitude.flexion / degree)) {
    for (const j of n > 1 ? around(model.varus, pose.attitude.varus / degree) : [0]) cells.push(i * n + j);
  }
  const found = ({ status, plausibility }, follower) => ({ follower, plausibility: plausibilities.find(({ code }) => cells.some((cell) => plausibility?.[cell] === code)),
    isBesideHole: (!follower && !pose.isSolved) || cells.some((cell) => status[cell] !== stable) });
  const all = [found(model), ...(model.followers ?? []).map((one) => found(one, one.name))];
  return all.find(({ plausibility, isBesideHole }) => plausibility || isBesideHole) ?? all[0];
}

/// As one line; `drawn` is the name of the body that is drawn without a pose. Empty: nothing to say.
export function doubtText(model, pose, drawn) {
  const { plausibility, isBesideHole, follower } = doubtOf(model, pose);
  if (!pose.isSolved) return `no pose at ${Number((pose.attitude.flexion / degree).toFixed(3))} degrees: a neighbouring attitude is unsolved; only the ${drawn} is drawn`;
  if (plausibility) return `${follower ? `${follower}: ` : ""}${plausibility.name}: ${plausibility.meaning.split(";")[0]}`;
  if (follower && isBesideHole) return `${follower}: no pose at or beside this attitude`;
  return isBesideHole ? "beside an attitude without a pose: the smoothed motion is extrapolated here" : "";
}

/// [{ first, last, hasPose }] between neighbouring flexions; `poseAt(flexion)` in degrees.
export function doubtfulSpans(model, poseAt) {
  const spans = [];
  for (let k = 0; k + 1 < model.flexion.length; ++k) {
    const first = model.flexion[k], last = model.flexion[k + 1], pose = poseAt((first + last) / 2);
    if (!doubtText(model, pose, "")) continue;
    const before = spans.at(-1);
    if (before?.last === first && before.hasPose === pose.isSolved) before.last = last;
    else spans.push({ first, last, hasPose: pose.isSolved });
  }
  return spans;
}

/// The counts of doubtful and missing poses with their reasons, then the warnings about the job.
export function modelWarnings(model) {
  const holesOf = ({ status }) => status.filter((one) => one !== stable).length, holes = holesOf(model), poses = model.status.length - holes;
  const counts = (of, prefix) => plausibilities.map((one) => [one, of.plausibility?.filter((code) => code === one.code).length ?? 0]).filter(([, n]) => n > 0)
    .map(([{ name, meaning }, n]) => `${prefix}${n} of ${of.status.length - holesOf(of)} poses: ${name}: ${meaning}`);
  const ofFollowers = (model.followers ?? []).flatMap((one) => [...counts(one, `${one.name}: `),
    ...(holesOf(one) > holes ? [`${one.name}: no pose at ${holesOf(one) - holes} of ${poses} attitudes`] : [])]);
  return [...counts(model, ""), ...(holes > 0 ? [`${holes} of ${model.status.length} attitudes have no pose`] : []), ...ofFollowers, ...model.warnings];
}
