// The clinical numbers of schemas/clinical.md, computed from X_reference_moving and the rotation centre.
import { degree, difference, sum, turned } from "./frames.js";

/// Name, unit and meaning, in the order of the tables.
export const clinicalNumbers = [
  { name: "flexion", label: "Flexion", unit: "°" },
  { name: "varus", label: "Varus", unit: "°", note: "adduction +" },
  { name: "internal", label: "Internal rotation", unit: "°" },
  { name: "anterior", label: "Anterior", unit: "mm" },
  { name: "proximal", label: "Proximal", unit: "mm", note: "distraction −" },
  { name: "lateral", label: "Lateral", unit: "mm" },
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
