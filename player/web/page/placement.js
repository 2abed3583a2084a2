// Placement of the joint in an external space, by hand or by touched points.
import { Matrix4 } from "three";
import { composed, cross, difference, dot, inverse, normalised, product, scaled, sum, transposed, turned } from "./geometry.js";
import { bodyNames } from "./layers.js";

// Placement of the joint in an external space: { R, t, scale } maps points g of the joint (mm, the reference's axes, from the rotation
// centre) to R (scale g) + t, in mm. Poses { R, t } are rigid.

export const mmPerM = 1000;

export { composed, inverse };

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

// Placement of a model by touched points, as player/calibration/fiducial_fit: scale from distances, then a rigid fit in closed form
// (Horn 1987: the rotation is the eigenvector of a 4 x 4 matrix). Lengths in mm, poses { R, t } map the model to where it was touched.

export const leastPoints = 3;
const leastSpreadMm = 5, leastScale = 0.5, mostScale = 2;
const mirrorFactor = 1.5, outlierMm = 5, outlierSd = 5;
// As on the bench: one scale does not fit distances that require scales 5 % apart, with a residual above 2 mm.
const unevenRatio = 1.05, unevenRmsMm = 2;

/// Touched points that place no model; its text is for the user.
export class FitRefusal extends Error {}

const mean = (points) => points.reduce((total, p) => sum(total, p), [0, 0, 0]).map((x) => x / points.length);
const rms = (lengths) => Math.sqrt(lengths.reduce((total, x) => total + x * x, 0) / lengths.length);
const length = (v) => Math.hypot(...v);

/// Eigenvalues, largest first, and eigenvectors of a symmetric matrix, by Jacobi rotations.
function eigen(matrix) {
  const n = matrix.length, a = matrix.map((row) => [...row]);
  const v = a.map((_, i) => a.map((_, j) => (i === j ? 1 : 0)));
  for (let sweep = 0; sweep < 50; ++sweep) {
    let off = 0, whole = 0;
    for (let i = 0; i < n; ++i) for (let j = 0; j < n; ++j) { whole += a[i][j] ** 2; if (i !== j) off += a[i][j] ** 2; }
    if (off <= 1e-32 * whole) break;
    for (let p = 0; p < n; ++p) {
      for (let q = p + 1; q < n; ++q) {
        if (a[p][q] === 0) continue;
        const ratio = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const t = (ratio < 0 ? -1 : 1) / (Math.abs(ratio) + Math.hypot(ratio, 1)), c = 1 / Math.hypot(t, 1), s = t * c;
        for (let k = 0; k < n; ++k) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
        for (let k = 0; k < n; ++k) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
        for (let k = 0; k < n; ++k) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
      }
    }
  }
  const order = a.map((_, k) => k).sort((i, j) => a[j][j] - a[i][i]);
  return { values: order.map((k) => a[k][k]), vectors: order.map((k) => v.map((row) => row[k])) };
}

function rotationOf([w, x, y, z]) {
  return [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
          [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
          [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]];
}

/// The proper rotation and shift that bring `model` closest to `touched`: { R, t, residuals, rms }.
function fitRigid(model, touched) {
  const from = mean(model), to = mean(touched);
  const S = [0, 1, 2].map((i) => [0, 1, 2].map((j) => model.reduce((total, p, k) => total + (p[i] - from[i]) * (touched[k][j] - to[j]), 0)));
  const N = [
    [S[0][0] + S[1][1] + S[2][2], S[1][2] - S[2][1], S[2][0] - S[0][2], S[0][1] - S[1][0]],
    [S[1][2] - S[2][1], S[0][0] - S[1][1] - S[2][2], S[0][1] + S[1][0], S[2][0] + S[0][2]],
    [S[2][0] - S[0][2], S[0][1] + S[1][0], S[1][1] - S[0][0] - S[2][2], S[1][2] + S[2][1]],
    [S[0][1] - S[1][0], S[2][0] + S[0][2], S[1][2] + S[2][1], S[2][2] - S[0][0] - S[1][1]]];
  const R = rotationOf(eigen(N).vectors[0]), t = difference(to, turned(R, from));
  const residuals = model.map((p, k) => length(difference(sum(turned(R, p), t), touched[k])));
  return { R, t, residuals, rms: rms(residuals) };
}

/// Centre, principal axes and singular values of the centred points.
function cloudOf(points) {
  const centre = mean(points);
  const scatter = [0, 1, 2].map((i) => [0, 1, 2].map((j) => points.reduce((total, p) => total + (p[i] - centre[i]) * (p[j] - centre[j]), 0)));
  const { values, vectors } = eigen(scatter);
  return { centre, axes: vectors, spread: values.map((x) => Math.sqrt(Math.max(0, x))) };
}

/// Least squares through the origin over the distances of all pairs: { scale, rms, isUneven }.
function fitScale(model, touched) {
  const pairs = [];
  for (let a = 0; a < model.length; ++a) for (let b = a + 1; b < model.length; ++b) pairs.push([length(difference(model[a], model[b])), length(difference(touched[a], touched[b]))]);
  const scale = pairs.reduce((total, [m, s]) => total + m * s, 0) / pairs.reduce((total, [m]) => total + m * m, 0);
  const own = rms(pairs.map(([m, s]) => s - scale * m)), scales = pairs.map(([m, s]) => s / m);
  return { scale, rms: own, isUneven: Math.max(...scales) > unevenRatio * Math.min(...scales) && own > unevenRmsMm };
}

/// The outlier, or -1: without it the fit is best, and it is 5 mm and 5 standard deviations from its position in that fit.
function outlierOf(model, touched) {
  let worst = { rms: Infinity, k: -1 };
  for (let k = 0; k < model.length; ++k) {
    const [m, s] = [model, touched].map((points) => points.filter((_, j) => j !== k));
    const fit = fitRigid(m, s), { centre, axes, spread } = cloudOf(m), n = m.length;
    if (fit.rms >= worst.rms || spread[1] < leastSpreadMm) continue;
    // Fitzpatrick (1998): the error at a point from the noise of a coordinate.
    const noise = fit.rms * Math.sqrt(n / (3 * n - 6)), from = difference(model[k], centre);
    let turns = 0;
    for (let axis = 0; axis < 3; ++axis) {
      const others = spread.reduce((total, x, j) => (j === axis ? total : total + x * x), 0);
      turns += (dot(from, from) - dot(from, axes[axis]) ** 2) / others;
    }
    const expected = noise * Math.sqrt(1 + 1 / n + turns / 3);
    const error = length(difference(sum(turned(fit.R, model[k]), fit.t), touched[k]));
    worst = { rms: fit.rms, k: error > outlierMm && error > outlierSd * expected ? k : -1 };
  }
  return worst.k;
}

/// `points`: [{ name, model, touched }]; `scale`: the subject's, where it is known, else it is fitted. Returns { scale, R, t, rms,
/// residuals, remarks }, where R (scale p) + t is the position of the model's point p. Throws FitRefusal.
export function fitLandmarks(points, scale) {
  if (points.length < leastPoints) throw new FitRefusal(`found ${points.length} points, wanted ${leastPoints} or more`);
  for (const { name, model, touched } of points) {
    if (![...model, ...touched].every(Number.isFinite)) throw new FitRefusal(`${name}: found a position that is not a number, wanted one in mm`);
  }
  const touched = points.map((p) => p.touched), own = points.map((p) => p.model), remarks = [];
  for (const [cloud, where] of [[cloudOf(own), "on the model"], [cloudOf(touched), "as touched"]]) {
    if (cloud.spread[1] < leastSpreadMm) throw new FitRefusal(`found points on a line ${where}, wanted one off the line`);
  }
  const sized = scale === undefined ? fitScale(own, touched) : { scale, isUneven: false };
  if (!(sized.scale >= leastScale && sized.scale <= mostScale)) throw new FitRefusal(`found a leg ${sized.scale.toFixed(2)} times as large as the model, wanted 0.5 to 2: touch the points in the order shown`);
  if (sized.isUneven) remarks.push("the distances require different sizes");
  const model = own.map((p) => p.map((x) => x * sized.scale)), fit = fitRigid(model, touched);
  const isPlane = cloudOf(model).spread[2] < leastSpreadMm;
  const mirrored = isPlane ? Infinity : fitRigid(model.map(([x, y, z]) => [x, y, -z]), touched).rms;
  if (fit.rms > mirrorFactor * mirrored) throw new FitRefusal("found a leg of the other side, or points in another order, wanted those shown");
  const outlier = points.length > 4 ? outlierOf(model, touched) : -1;
  if (outlier >= 0) throw new FitRefusal(`${points[outlier].name}: found ${fit.residuals[outlier].toFixed(1)} mm from its position by the other points: touch it again`);
  if (isPlane) remarks.push("points in one plane do not determine the side of the leg");
  return { scale: sized.scale, ...fit, remarks };
}

// Points to touch: those of the bench file, or the outermost points of both bones near the joint.

const reachMm = 68;  // about a knee's centre: the epicondyles and the tuberosity, not the ends of long bones

/// [{ name, body, point }], mm, relative to the rotation centre; `points`: of the bench, canonical axes.
export function landmarksOf(model, scale, points = []) {
  const relative = (p) => p.map((x, k) => x - model.rotationCentre[k]);
  if (points.length > 0) return points.map(({ name, body, point }) => ({ name, body, point: relative(point) }));
  const names = bodyNames(model), outward = model.side === "left" ? -1 : 1;
  const directions = [["medial", [0, 0, -outward]], ["lateral", [0, 0, outward]], ["front", [1, 0, 0]]];
  return ["reference", "moving"].flatMap((body) => directions.map(([word, direction]) => {
    const { vertices } = model.bodies[body].parts[0];
    let best = null, farthest = -Infinity;
    for (let at = 0; at < vertices.length; at += 3) {
      const p = relative(Array.from(vertices.subarray(at, at + 3))), along = p.reduce((total, x, k) => total + x * direction[k], 0);
      if (along > farthest && Math.hypot(...p) <= scale * reachMm) [best, farthest] = [p, along];
    }
    return best && { name: `${names[body]}, ${word}`, body, point: best };
  })).filter(Boolean);
}
