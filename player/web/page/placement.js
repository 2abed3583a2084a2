// Placement of the joint in an external space: { R, t, scale } maps points g of the joint (mm, the reference's axes, from the rotation
// centre) to R (scale g) + t, in mm. Poses { R, t } are rigid.
import { Matrix4 } from "three";
import { cross, difference, normalised, product, scaled, sum, transposed, turned } from "./frames.js";

export const mmPerM = 1000;

export const composed = (A, B) => ({ R: product(A.R, B.R), t: sum(turned(A.R, B.t), A.t) });
export const inverse = ({ R, t }) => ({ R: transposed(R), t: scaled(turned(transposed(R), t), -1) });

/// A pose of the space in mm, from a matrix in metres.
export function poseOf(matrix) {
  const e = matrix.elements, row = (k) => [e[k], e[4 + k], e[8 + k]];
  return { R: [row(0), row(1), row(2)], t: [e[12], e[13], e[14]].map((x) => x * mmPerM) };
}

/// The joint's matrix in metres.
export function matrixOf({ R, t, scale }) {
  const s = scale / mmPerM, [a, b, c] = R.map((row, k) => [...row.map((x) => x * s), t[k] / mmPerM]);
  return new Matrix4().set(...a, ...b, ...c, 0, 0, 0, 1);
}

/// The joint upright on a surface: its lowest point at the point's height, its front towards `viewer`; all in mm.
export function standing(point, viewer, lowest, scale) {
  const up = [0, 1, 0], away = difference(viewer, point), across = [away[0], 0, away[2]];
  const front = Math.hypot(...across) > 1 ? normalised(across) : [0, 0, 1], right = cross(front, up);
  return { R: [0, 1, 2].map((k) => [front[k], up[k], right[k]]), t: sum(point, [0, -scale * lowest, 0]), scale };
}

/// The streamed pose of the joint in the tracker's space; the stream places stored vertices.
export function tracked({ R, t }, centre, scale) {
  return { R, t: sum(t, turned(R, scaled(centre, scale))) };
}
