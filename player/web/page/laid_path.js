// Paths over bone, as pipeline/geometry/laid_path: the taut string over bodies.
import { RayTree, cross, difference, dot, scaled, sum } from "./geometry.js";

// Beyond the margin around a body no distance is known, and a path is not close to it.
const marginMm = 6, deepestMm = 20, mostNodes = 2e7;
// A point in front of a sharp edge may be behind one of its faces, but never along the normal.
const leastCosine = 0.5;

/// A component of a part with the normals of its vertices; its rim has none.
class Surface {
  constructor({ vertices, triangles }) {
    this.tree = new RayTree({ vertices, triangles });
    this.normals = new Float32Array(vertices.length);
    const edges = new Map();
    for (let t = 0; t < triangles.length; t += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => vertices.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3));
      const area = cross(difference(b, a), difference(c, a));
      for (let k = 0; k < 3; ++k) {
        const v = triangles[t + k], w = triangles[t + ((k + 1) % 3)], edge = v < w ? v * 2 ** 26 + w : w * 2 ** 26 + v;
        for (let axis = 0; axis < 3; ++axis) this.normals[3 * v + axis] += area[axis];
        edges.set(edge, (edges.get(edge) ?? 0) + 1);
      }
    }
    for (const [edge, n] of edges) if (n === 1) for (const v of [Math.floor(edge / 2 ** 26), edge % 2 ** 26]) this.normals.fill(0, 3 * v, 3 * v + 3);
  }

  /// Negative inside; at most `limit`. Behind a rim is outside.
  distance(p, limit) {
    const { distance, triangle, point } = this.tree.nearest(p, limit);
    if (triangle < 0) return limit;
    let normal = [0, 0, 0], isAtRim = false;
    for (let k = 0; k < 3; ++k) {
      const v = 3 * this.tree.triangles[3 * triangle + k], own = this.normals.subarray(v, v + 3), length = Math.hypot(...own);
      isAtRim ||= length === 0;
      // Nearer corners count more.
      const off = difference(point, this.tree.vertices.subarray(v, v + 3));
      normal = sum(normal, scaled(own, 1 / ((1e-3 + dot(off, off)) * (length || 1))));
    }
    const isBehind = !isAtRim && dot(difference(p, point), normal) < -leastCosine * distance * Math.hypot(...normal);
    return isBehind ? -distance : distance;
  }
}

/// Signed distance to all surfaces of a body on a grid of 3 mm (coarser for a body larger than any bone), whose nodes are
/// computed when they are first needed.
export class LazyDistance {
  constructor({ parts }) {
    this.surfaces = [];
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { vertices, triangles, component } of parts) {
      for (const c of new Set(component)) {
        this.surfaces.push(new Surface({ vertices, triangles: triangles.filter((_, k) => component[Math.floor(k / 3)] === c) }));
      }
      vertices.forEach((x, k) => { low[k % 3] = Math.min(low[k % 3], x); high[k % 3] = Math.max(high[k % 3], x); });
    }
    this.first = low.map((x) => x - marginMm);
    this.cellMm = 3;
    const nodes = () => low.map((x, k) => Math.max(0, Math.ceil((high[k] - x + 2 * marginMm) / this.cellMm) + 1));
    while (nodes().reduce((product, n) => product * n, 1) > mostNodes) this.cellMm *= 2;
    this.n = nodes();
    this.values = new Float32Array(this.surfaces.length > 0 ? this.n[0] * this.n[1] * this.n[2] : 0).fill(NaN);
  }

  #node(i, j, k) {
    const row = (k * this.n[1] + j) * this.n[0] + i;
    if (Number.isNaN(this.values[row])) {
      const p = [i, j, k].map((at, axis) => this.first[axis] + this.cellMm * at);
      this.values[row] = Math.min(...this.surfaces.map((surface) => surface.distance(p, deepestMm)));
    }
    return this.values[row];
  }

  /// Distance and gradient, in `out`, at a point in the body's frame; trilinear.
  sample(x, y, z, out) {
    const ax = (x - this.first[0]) / this.cellMm, ay = (y - this.first[1]) / this.cellMm, az = (z - this.first[2]) / this.cellMm;
    const i = Math.floor(ax), j = Math.floor(ay), k = Math.floor(az), [nx, ny, nz] = this.n;
    out.fill(0);
    out[0] = marginMm;
    if (this.values.length === 0 || i < 0 || j < 0 || k < 0 || i + 1 >= nx || j + 1 >= ny || k + 1 >= nz) return;
    const u = ax - i, v = ay - j, w = az - k;
    out[0] = 0;
    for (let corner = 0; corner < 8; ++corner) {
      const a = corner & 1, b = (corner >> 1) & 1, c = corner >> 2, value = this.#node(i + a, j + b, k + c);
      const p = a ? u : 1 - u, q = b ? v : 1 - v, r = c ? w : 1 - w;
      out[0] += p * q * r * value;
      out[1] += ((2 * a - 1) * q * r * value) / this.cellMm;
      out[2] += ((2 * b - 1) * p * r * value) / this.cellMm;
      out[3] += ((2 * c - 1) * p * q * value) / this.cellMm;
    }
  }
}

const found = new Float64Array(4);  // of the last sample: distance, and gradient in the path's frame

function sampleAt({ field, X: { R, t } }, x, y, z) {
  const [dx, dy, dz] = [x - t[0], y - t[1], z - t[2]], [a, b, c] = R;
  field.sample(a[0] * dx + b[0] * dy + c[0] * dz, a[1] * dx + b[1] * dy + c[1] * dz, a[2] * dx + b[2] * dy + c[2] * dz, found);
  const [, gx, gy, gz] = found;
  found[1] = a[0] * gx + a[1] * gy + a[2] * gz;
  found[2] = b[0] * gx + b[1] * gy + b[2] * gz;
  found[3] = c[0] * gx + c[1] * gy + c[2] * gz;
}

/// The points of `path` (evenly spaced) as a taut string over `bodies`, [{ field, X }] with poses in the path's frame: at least
/// `clearance` above them, less towards an end that is itself closer or inside.
export function laidOver(path, bodies, clearance) {
  const nSweeps = 30, relaxation = 1.5, leastSlope = 0.1, surfaceMm = 0.5, mostLiftMm = 40;
  const at = Float64Array.from(path.flat()), last = path.length - 1, first = path[0], final = path[last];
  const isNear = (body) => path.some((p) => { sampleAt(body, ...p); return found[0] < marginMm; });
  // A point deep inside is lifted to the side on which the ends are: its nearest surface may be another.
  let side = [0, 0, 0];
  const besides = bodies.filter(isNear).map((body) => ({ body, ends: [first, final].map((p) => {
    sampleAt(body, ...p);
    if (found[0] < marginMm) side = sum(side, [...found.subarray(1)]);
    return found[0];
  }) }));
  const lift = (i) => {
    let isLifted = false;
    for (const { body, ends } of besides) {
      const [x, y, z] = [at[3 * i], at[3 * i + 1], at[3 * i + 2]];
      sampleAt(body, x, y, z);
      if (found[0] >= clearance) continue;
      const wanted = Math.min(clearance, ends[0] + Math.hypot(x - first[0], y - first[1], z - first[2]), ends[1] + Math.hypot(x - final[0], y - final[1], z - final[2]));
      const slope = Math.hypot(found[1], found[2], found[3]);
      if (wanted <= found[0] || slope < leastSlope) continue;
      for (let axis = 0; axis < 3; ++axis) at[3 * i + axis] += ((wanted - found[0]) / slope) * found[1 + axis];
      isLifted = true;
    }
    return isLifted;
  };
  const chord = difference(final, first);
  side = difference(side, scaled(chord, dot(side, chord) / dot(chord, chord)));
  const hasSide = Math.hypot(...side) > 0.5;
  side = scaled(side, 1 / (Math.hypot(...side) || 1));
  let isMoved = false;
  for (let i = 1; i < last; ++i) {
    let deepest = 0;
    for (let way = 0; way < mostLiftMm && hasSide; way -= deepest) {
      deepest = 0;
      for (const { body } of besides) {
        sampleAt(body, at[3 * i], at[3 * i + 1], at[3 * i + 2]);
        deepest = Math.min(deepest, found[0]);
      }
      if (deepest > -surfaceMm) break;
      for (let axis = 0; axis < 3; ++axis) at[3 * i + axis] -= deepest * side[axis];
      isMoved = true;
    }
    isMoved = lift(i) || isMoved;
  }
  for (let sweep = 0; isMoved && sweep < nSweeps; ++sweep) {
    for (let k = 1; k < last; ++k) {
      const i = sweep % 2 === 0 ? k : last - k;
      for (let c = 3 * i; c < 3 * i + 3; ++c) at[c] += relaxation * ((at[c - 3] + at[c + 3]) / 2 - at[c]);
      lift(i);
    }
  }
  return path.map((_, k) => [at[3 * k], at[3 * k + 1], at[3 * k + 2]]);
}

/// The same line by `n` points that are equally far from each other.
export function evenly(points, n) {
  const lengths = points.slice(1).map((p, k) => Math.hypot(...difference(p, points[k]))), whole = lengths.reduce((a, b) => a + b, 0);
  let next = 0, before = 0;
  return Array.from({ length: n }, (_, k) => {
    const at = (whole * k) / (n - 1);
    while (before + lengths[next] < at && next + 1 < lengths.length) before += lengths[next++];
    const part = lengths[next] > 0 ? Math.min(1, (at - before) / lengths[next]) : 0;
    return sum(points[next], scaled(difference(points[next + 1], points[next]), part));
  });
}
