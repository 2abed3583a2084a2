// A measured motion and its repair over the frames: gap, overlap, distance, six coordinates.
import { el, section, table } from "./dom.js";
import { length, number } from "./format.js";
import { axis, figure, lineStyle } from "./plot.js";

const STATUSES = ["unchanged", "repaired", "not_converged", "nothing_ahead"];

const COORDINATES = [
  ["flexion", "degrees"], ["varus", "degrees"], ["internal", "degrees"],
  ["anterior", "mm"], ["proximal", "mm"], ["lateral", "mm"],
];

function largest(values) {
  return values.reduce((most, value) => (value !== null && value > most ? value : most), 0);
}

function plot(repair, { title, caption, unit, series }) {
  const make = () => ({
    data: series.map(([name, values], k) => ({ x: repair.key, y: values, name, mode: "lines", line: { ...lineStyle(k), width: 2 } })),
    layout: { xaxis: axis(repair.key_name), yaxis: axis(unit), showlegend: series.length > 1 },
  });
  return figure({ title, caption, make });
}

function bothMotions(repair, key) {
  return [["measured", repair.before[key]], ["repaired", repair.after[key]]];
}

function numbersTable(repair) {
  const row = (name, motion) => [name, String(motion.penetration.filter((mm) => mm > 0).length), length(largest(motion.penetration)), length(largest(motion.gap))];
  return table("Measured and repaired motion", ["motion", "frames that overlap", "largest overlap", "largest gap along Δ"], [row("measured", repair.before), row("repaired", repair.after)]);
}

function noiseText(repair) {
  const rms = Math.sqrt(repair.distance.reduce((sum, d) => sum + d * d, 0) / repair.distance.length);
  const counts = STATUSES.map((name, code) => [name, repair.status.filter((s) => s === code).length]).filter(([, n]) => n > 0);
  const limits = repair.gap_limit.map((mm) => (mm === null ? "none" : length(mm))).join(" and ");
  return `${counts.map(([name, n]) => `${n} ${name}`).join(", ")}${repair.converged ? "" : "; limit of iterations reached"}. Standard deviations of the measurement about and along X, Y, Z: ${repair.noise_deg.map((v) => number(v)).join(", ")} degrees, ${repair.noise_mm.map((v) => number(v)).join(", ")} mm. Distance of the repaired from the measured poses in these: ${number(rms)} (root mean square), at most ${number(largest(repair.distance))}. Limit of the gap: ${limits}.`;
}

/** Before and after of a repaired measurement. */
export function repairSection(model) {
  const { repair } = model;
  const plots = [
    plot(repair, { title: "Overlap", caption: "Travel opposite to Δ out of the overlap.", unit: "mm", series: bothMotions(repair, "penetration") }),
    plot(repair, { title: "Gap", caption: "Travel along Δ to the next contact; interrupted where the bodies overlap.", unit: "mm", series: bothMotions(repair, "gap") }),
    plot(repair, { title: "Distance from the measurement", caption: "Mahalanobis distance, in standard deviations of the measurement.", unit: "standard deviations", series: [["distance", repair.distance]] }),
    ...COORDINATES.map(([key, unit]) => plot(repair, { title: `${key[0].toUpperCase()}${key.slice(1)}`, caption: `Grood-Suntay ${key}, measured and repaired.`, unit, series: bothMotions(repair, key) })),
  ];
  return section("repair", "Repair of the measurement", el("p", {}, noiseText(repair)), numbersTable(repair), el("div", { class: "figures" }, plots));
}
