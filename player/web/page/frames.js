// Rotations and poses, as pipeline/core/frames: 3 x 3 matrices are arrays of rows, a pose is { R, t } in mm.

export const degree = Math.PI / 180;

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const scaled = (v, s) => [v[0] * s, v[1] * s, v[2] * s];
export const sum = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const difference = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const normalised = (v) => scaled(v, 1 / Math.sqrt(dot(v, v)));
export const turned = (R, v) => R.map((row) => dot(row, v));
export const transposed = (R) => [0, 1, 2].map((r) => [0, 1, 2].map((c) => R[c][r]));

export function product(A, B) {
  const columns = transposed(B);
  return A.map((row) => columns.map((column) => dot(row, column)));
}

const rotationX = (a) => [[1, 0, 0], [0, Math.cos(a), -Math.sin(a)], [0, Math.sin(a), Math.cos(a)]];
const rotationY = (a) => [[Math.cos(a), 0, Math.sin(a)], [0, 1, 0], [-Math.sin(a), 0, Math.cos(a)]];
const rotationZ = (a) => [[Math.cos(a), -Math.sin(a), 0], [Math.sin(a), Math.cos(a), 0], [0, 0, 1]];

function shortestRotationToY(from) {
  const c = from[1];
  if (c < -1 + 1e-12) {
    const trial = Math.abs(from[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1];
    const a = normalised(difference(trial, scaled(from, dot(trial, from))));
    return [0, 1, 2].map((r) => [0, 1, 2].map((k) => 2 * a[r] * a[k] - (r === k ? 1 : 0)));
  }
  const v = cross(from, [0, 1, 0]);
  const V = [[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]], VV = product(V, V);
  return V.map((row, r) => row.map((x, k) => (r === k ? 1 : 0) + x + VV[r][k] / (1 + c)));
}

/// Orthogonal matrix from the solver frame to world W; a reflection for a left joint. Both frames have the same origin.
export function rotationWorldSolver(side, delta) {
  const R = transposed(shortestRotationToY(side === "left" ? [delta[0], delta[1], -delta[2]] : delta));
  return side === "left" ? [R[0], R[1], scaled(R[2], -1)] : R;
}

const conjugated = (R, A) => product(product(R, A), transposed(R));

/// Rotation about the rotation centre, then translation: stored vertices to W.
const aboutCentre = (R, shift, centre) => ({ R, t: difference(shift, turned(R, centre)) });

/// Poses of both bodies in W, and of the moving body in the reference's frame. Radians; `translation` in W.
export function placed(frame, attitude, translation, theta) {
  const { worldSolver, centre } = frame;
  const attitudeTurn = product(rotationX(-attitude.varus), rotationZ(attitude.flexion));
  const reference = aboutCentre(conjugated(worldSolver, attitudeTurn), [0, 0, 0], centre);
  const moving = aboutCentre(conjugated(worldSolver, rotationY(theta)), translation, centre);
  const back = transposed(reference.R);
  return { reference, moving, referenceMoving: { R: product(back, moving.R), t: turned(back, difference(moving.t, reference.t)) } };
}

/// Sixteen numbers in row-major order, as `X_reference_moving` in the file.
export function rows({ R, t }) {
  return [...R[0], t[0], ...R[1], t[1], ...R[2], t[2], 0, 0, 0, 1];
}
