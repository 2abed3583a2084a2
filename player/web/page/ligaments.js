// Ligament fibres: reading them from the file, and their strain at any pose; as pipeline/ligament.
import { refuse } from "./model_error.js";
import { cross, difference, dot, normalised, product, scaled, sum, transposed, turned } from "./frames.js";

const cylinder = 0;
/// Links of a wrapped fibre; compared with the library on a real knee: strain error 0.0016, variation between poses 0.0002.
const nLinks = 24;
/// Relaxation sweeps from a straight line, and from the path at the previous pose.
const coldSweeps = 400, warmSweeps = 30;
const powers = 60;  // directions need no more
const overRelaxation = 1.5;  // between 1 and 2

function wrapsOf(file) {
  const shapes = file.numbers("/ligaments/wrap_shape", [null], "int8"), n = shapes.length;
  const bodies = file.numbers("/ligaments/wrap_body", [n], "int8");
  const poses = file.numbers("/ligaments/X_body_wrap", [n, 4, 4]), radii = file.numbers("/ligaments/wrap_radii", [n, 3]);
  if (!poses.every(Number.isFinite)) refuse("/ligaments/X_body_wrap", "a pose that is not finite", "finite numbers");
  if (!radii.every((r) => r > 0 && Number.isFinite(r))) refuse("/ligaments/wrap_radii", "an invalid radius", "numbers above 0");
  return Array.from(shapes, (shape, k) => {
    const row = (r) => poses.subarray(16 * k + 4 * r, 16 * k + 4 * r + 4);
    const R = [0, 1, 2].map((r) => Array.from(row(r).subarray(0, 3))), t = [0, 1, 2].map((r) => row(r)[3]);
    return { shape, isOnMoving: bodies[k] === 1, R, t, radii: Array.from(radii.subarray(3 * k, 3 * k + 3)) };
  });
}

/// { fibres, wraps, strain: [flexion, varus, fibre] }, or undefined if the model has no ligaments. mm.
export function readLigaments(file, nCells) {
  if (!file.hasGroup("/ligaments")) return undefined;
  const names = file.texts("/ligaments/name"), bundles = file.texts("/ligaments/bundle"), n = names.length;
  const reference = file.numbers("/ligaments/reference", [n, 3]), moving = file.numbers("/ligaments/moving", [n, 3]);
  const slackLengths = file.numbers("/ligaments/slack_length", [n]), wrap = file.numbers("/ligaments/wrap", [n], "int32");
  const strain = file.numbers("/ligaments/strain", [...nCells, n]);
  const wraps = wrapsOf(file);
  if (!reference.every(Number.isFinite) || !moving.every(Number.isFinite)) refuse("/ligaments/reference", "an attachment that is not finite", "finite numbers");
  if (!slackLengths.every((length) => length > 0)) refuse("/ligaments/slack_length", "an invalid length", "numbers above 0");
  if (!wrap.every((row) => row >= -1 && row < wraps.length)) refuse("/ligaments/wrap", "an invalid row", `-1 to ${wraps.length - 1}`);
  const point = (table, k) => Array.from(table.subarray(3 * k, 3 * k + 3));
  const fibres = names.map((name, k) => ({
    name, bundle: bundles[k] ?? "", reference: point(reference, k), moving: point(moving, k), slackLength: slackLengths[k], wrap: wraps[wrap[k]],
  }));
  return { fibres, wraps, strain };
}

/// Level function of the surface (above 1 outside) and its gradient.
function level(wrap, p) {
  const own = p.map((x, k) => (wrap.shape === cylinder && k === 2 ? 0 : x / wrap.radii[k]));
  const value = Math.sqrt(dot(own, own));
  return { value, gradient: own.map((x, k) => x / (wrap.radii[k] * value)) };
}

/// Projects a point inside the surface onto it, by Newton steps.
function projected(wrap, p) {
  let out = p;
  for (let step = 0; step < 3; ++step) {
    const { value, gradient } = level(wrap, out);
    if (!(value < 1)) break;
    out = sum(out, scaled(gradient, (1 - value) / dot(gradient, gradient)));
  }
  return out;
}

function isBlocked(wrap, from, to) {
  for (let k = 1; k < nLinks; ++k) {
    const p = sum(from, scaled(difference(to, from), k / nLinks));
    if (!(level(wrap, p).value < 1)) continue;
    if (wrap.shape !== cylinder || Math.abs(p[2]) <= wrap.radii[2]) return true;
  }
  return false;
}

/// The shortest chain between both ends outside the surface, by relaxation. In the surface's frame.
function shortestChain(wrap, from, to, before) {
  const along = (k) => sum(from, scaled(difference(to, from), k / nLinks));
  const chain = before ?? Array.from({ length: nLinks + 1 }, (_, k) => projected(wrap, along(k)));
  [chain[0], chain[nLinks]] = [from, to];
  for (let sweep = before ? warmSweeps : coldSweeps; sweep > 0; --sweep) {
    for (let k = 1; k < nLinks; ++k) {
      const middle = scaled(sum(chain[k - 1], chain[k + 1]), 0.5);
      chain[k] = projected(wrap, sum(chain[k], scaled(difference(middle, chain[k]), overRelaxation)));
    }
  }
  return chain;
}

const pathLength = (points) => points.slice(1).reduce((length, p, k) => length + Math.hypot(...difference(p, points[k])), 0);

/// The fibres' paths in the reference's canonical axes, for successive poses.
export class Fibres {
  constructor({ fibres }) {
    this.fibres = fibres;
    this.chains = new Map();
  }

  /// { points, strain } of fibre `k`; `X`, { R, t }, maps moving to reference.
  at(k, X) {
    const fibre = this.fibres[k], { wrap } = fibre;
    const ends = [fibre.reference, sum(turned(X.R, fibre.moving), X.t)];
    let points = ends;
    if (wrap) points = this.#over(k, wrap, ends, X);
    return { points, strain: pathLength(points) / fibre.slackLength - 1 };
  }

  #over(k, wrap, ends, X) {
    // Pose of the surface: pose of its body times its pose in that body.
    const R = wrap.isOnMoving ? product(X.R, wrap.R) : wrap.R;
    const t = wrap.isOnMoving ? sum(turned(X.R, wrap.t), X.t) : wrap.t;
    const own = ends.map((p) => turned(transposed(R), difference(p, t)));
    const isInside = own.some((p) => level(wrap, p).value < 1);
    if (isInside || !isBlocked(wrap, ...own)) {
      this.chains.delete(k);
      return ends;
    }
    const chain = shortestChain(wrap, ...own, this.chains.get(k));
    this.chains.set(k, chain);
    return chain.map((p) => sum(turned(R, p), t));
  }
}

/// Two directions normal to a path at each of its points: of the width of a band, which is interpolated between both ends,
/// and of its thickness. Where a width is zero or along the path, the cross section turns as little as possible.
export function crossSections(points, acrossFirst, acrossLast) {
  let u = null;
  return points.map((_, k) => {
    const along = normalised(difference(points[Math.min(k + 1, points.length - 1)], points[Math.max(k - 1, 0)]));
    const part = k / (points.length - 1), across = sum(scaled(acrossFirst, 1 - part), scaled(acrossLast, part));
    const wanted = difference(across, scaled(along, dot(across, along)));
    if (dot(wanted, wanted) > 0.01 * dot(across, across)) u = wanted;
    if (u === null) {
      const least = along.map(Math.abs).indexOf(Math.min(...along.map(Math.abs)));
      u = [0, 1, 2].map((axis) => (axis === least ? 1 : 0));
    }
    u = normalised(difference(u, scaled(along, dot(u, along))));
    return [u, cross(along, u)];
  });
}

/// The direction in which the fibres of a bundle lie side by side at both ends, and the distance of neighbours; as in
/// player/scene/ligament_layer: the first principal component of both attachments together.
export function arrangementOf(fibres, bundle) {
  const ends = fibres.filter((fibre) => fibre.bundle === bundle).map(({ reference, moving }) => [...reference, ...moving]), n = ends.length;
  const none = { reference: [0, 0, 0], moving: [0, 0, 0], spacing: 0 };
  if (n < 2) return none;
  const mean = ends[0].map((_, k) => ends.reduce((total, row) => total + row[k], 0) / n);
  const rows = ends.map((row) => row.map((x, k) => x - mean[k]));
  const inner = (a, b) => a.reduce((total, x, k) => total + x * b[k], 0);
  // Powers of the covariance, from its longest row.
  let first = rows.reduce((a, b) => (inner(a, a) >= inner(b, b) ? a : b));
  for (let step = 0; step < powers; ++step) {
    const next = mean.map((_, k) => rows.reduce((total, row) => total + row[k] * inner(row, first), 0)), length = Math.sqrt(inner(next, next));
    if (!(length > 0)) return none;
    first = next.map((x) => x / length);
  }
  const along = rows.map((row) => inner(row, first));
  return { reference: first.slice(0, 3), moving: first.slice(3), spacing: (Math.max(...along) - Math.min(...along)) / Math.SQRT2 / (n - 1) };
}
