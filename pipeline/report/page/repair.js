// A measured motion and its repair over the frames: overlap, gap, six coordinates, distance.
import { curvePlots } from "./curves.js";
import { el, section, table } from "./dom.js";
import { length, number } from "./format.js";
import { axis, figure, lineStyle } from "./plot.js";

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

function numbersTable({ before, after }) {
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
    make: () => ({ data: [{ x: repair.key, y: repair.distance, mode: "lines", line: { ...lineStyle(0), width: 2 } }], layout: { xaxis: axis(repair.key_name), yaxis: axis("standard deviations") } }),
  });
  return section("repair", "Repair of the measurement", el("p", {}, noiseText(repair)), numbersTable(repair), curvePlots(curves, QUANTITIES, { over: repair.key_name }), distance);
}
