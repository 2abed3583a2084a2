// What a motion model says against its poses, as navigation/doubts of the window: plausibility and missing poses of the attitudes
// around a pose, spans over flexion, and the warnings about the job. Degrees.
import { degree } from "./frames.js";
import { stable } from "./motion.js";

/// Codes, names and meanings of core/plausibility that make a pose doubtful, the gravest first.
export const plausibilities = [
  { code: 3, name: "dislocated", colour: [178, 58, 72], meaning: "further from the start pose in contact than half the joint's smallest width, or rotated by more than 45 degrees (a knee) or 90; add ligaments, check side, axes and frame.origin, or narrow the grid" },
  { code: 4, name: "border contact", colour: [217, 138, 31], meaning: "a contact at an edge where the mesh ends; use a mesh that covers more of the joint, or narrow the grid" },
  { code: 5, name: "overstrained", colour: [150, 80, 160], meaning: "a fibre's strain above 0.44 or a bundle's tension above 1730 N, where ligaments fail; check attachments and slack lengths, or narrow the grid" },
  { code: 1, name: "nothing ahead", colour: [120, 120, 40], meaning: "no surface along Delta within the contact resolution, here or displaced sideways by it" },
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

/// { plausibility: one of `plausibilities` or undefined, isBesideHole } of the attitudes around a pose.
export function doubtOf(model, pose) {
  const n = model.varus.length, cells = [];
  for (const i of around(model.flexion, pose.attitude.flexion / degree)) {
    for (const j of n > 1 ? around(model.varus, pose.attitude.varus / degree) : [0]) cells.push(i * n + j);
  }
  return { plausibility: plausibilities.find(({ code }) => cells.some((cell) => model.plausibility?.[cell] === code)),
    isBesideHole: !pose.isSolved || cells.some((cell) => model.status[cell] !== stable) };
}

/// As one line; `drawn` is the name of the body that is drawn without a pose. Empty: nothing to say.
export function doubtText(model, pose, drawn) {
  const { plausibility, isBesideHole } = doubtOf(model, pose);
  if (!pose.isSolved) return `no pose at ${Number((pose.attitude.flexion / degree).toFixed(3))} degrees: a neighbouring attitude is unsolved; only the ${drawn} is drawn`;
  if (plausibility) return `${plausibility.name}: ${plausibility.meaning.split(";")[0]}`;
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
  const holes = model.status.filter((status) => status !== stable).length, poses = model.status.length - holes;
  const counts = plausibilities.map((one) => [one, model.plausibility?.filter((code) => code === one.code).length ?? 0]).filter(([, n]) => n > 0);
  return [...counts.map(([{ name, meaning }, n]) => `${n} of ${poses} poses: ${name}: ${meaning}`),
    ...(holes > 0 ? [`${holes} of ${model.status.length} attitudes have no pose`] : []), ...model.warnings];
}
