// Rotations, poses, meshes for graphics hardware, and rays to meshes.

// Rotations and poses, as pipeline/model/frames: 3 x 3 matrices are arrays of rows, a pose is { R, t } in mm.

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

export const composed = (A, B) => ({ R: product(A.R, B.R), t: sum(turned(A.R, B.t), A.t) });
export const inverse = ({ R, t }) => ({ R: transposed(R), t: scaled(turned(transposed(R), t), -1) });
export const still = { R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], t: [0, 0, 0] };

/// Pose of a body that follows the joint, by its six coordinates (schemas/followers.md), rad and mm.
export function followerPose([flexion, rotation, tilt, ...shift], side, centre) {
  const own = [1, 1, side === "left" ? -1 : 1];
  const right = product(product(rotationZ(-flexion), rotationX(rotation)), rotationY(tilt));
  const R = right.map((row, r) => row.map((x, c) => own[r] * x * own[c]));
  return { R, t: difference(sum(centre, shift.map((x, k) => own[k] * x)), turned(R, centre)) };
}

/// Sixteen numbers in row-major order, as `X_reference_moving` in the file.
export function rows({ R, t }) {
  return [...R[0], t[0], ...R[1], t[1], ...R[2], t[2], 0, 0, 0, 1];
}

// A mesh for graphics hardware with normals by crease angle; as pipeline/model/mesh.

// Edges with a larger angle stay sharp; a meniscus is soft tissue.
const leastCosineOf = (material) => Math.cos((material === "meniscus" ? 150 : 80) / 180 * Math.PI);
// At vertices with more faces all faces are averaged, since the comparison is quadratic.
const mostFacesCompared = 1000;

/// Null for a vector of length 0.
function unitOf(v) {
  const length = Math.sqrt(dot(v, v));
  return length > 0 ? v.map((x) => x / length) : null;
}

/// Area normal (length: twice the area) and unit normal of each non-degenerate triangle.
function facesOf(part, component) {
  const { vertices: p, triangles } = part, faces = [];
  for (let t = 0; t < triangles.length / 3; ++t) {
    if (part.component[t] !== component) continue;
    const vertex = triangles.subarray(3 * t, 3 * t + 3);
    const [a, b, c] = Array.from(vertex, (v) => p.subarray(3 * v, 3 * v + 3));
    const area = cross(difference(b, a), difference(c, a)), unit = unitOf(area);
    if (unit) faces.push({ vertex, area, unit });
  }
  return faces;
}

function facesAround(faces, nVertices) {
  const around = Array.from({ length: nVertices }, () => []);
  for (const face of faces) for (const v of face.vertex) around[v].push(face);
  return around;
}

function cornerNormal(own, around, leastCosine) {
  const isSmooth = ({ unit }) => around.length > mostFacesCompared || dot(unit, own.unit) >= leastCosine;
  return unitOf(around.reduce((normal, face) => (isSmooth(face) ? sum(normal, face.area) : normal), [0, 0, 0])) ?? own.unit;
}

/// The corners of the triangles of one component of a material: positions relative to `origin` (for single precision),
/// normals, and vertex indices.
export function drawMesh(part, component, origin, material) {
  const leastCosine = leastCosineOf(material);
  const faces = facesOf(part, component), around = facesAround(faces, part.vertices.length / 3);
  const positions = new Float32Array(9 * faces.length), normals = new Float32Array(9 * faces.length), vertices = new Int32Array(3 * faces.length);
  faces.forEach((face, f) => face.vertex.forEach((v, corner) => {
    const at = 9 * f + 3 * corner;
    vertices[3 * f + corner] = v;
    for (let k = 0; k < 3; ++k) positions[at + k] = part.vertices[3 * v + k] - origin[k];
    normals.set(cornerNormal(face, around[v], leastCosine), at);
  }));
  return { positions, normals, vertices };
}

/// Whether a mesh, given by the vertices of its triangles, has an inside: at most this part of its edges is open (as in the window).
const mostOpen = 1e-3;
export function isSolid(vertices, nVertices) {
  const open = new Set();
  vertices.forEach((from, k) => {
    const to = vertices[k % 3 === 2 ? k - 2 : k + 1];
    if (!open.delete(to * nVertices + from)) open.add(from * nVertices + to);
  });
  return open.size <= 0.5 * mostOpen * vertices.length;
}

// Distance along a ray to a mesh; as pipeline/geometry/box_tree.

const mostInLeaf = 4;

/// Ericson (2005), Real-Time Collision Detection, 5.1.5: weights of b and c, in `out`. The corners are relative to the point.
function nearestInTriangle([ax, ay, az, bx, by, bz, cx, cy, cz], out) {
  const ux = bx - ax, uy = by - ay, uz = bz - az, vx = cx - ax, vy = cy - ay, vz = cz - az;
  const d1 = -(ux * ax + uy * ay + uz * az), d2 = -(vx * ax + vy * ay + vz * az);
  const d3 = -(ux * bx + uy * by + uz * bz), d4 = -(vx * bx + vy * by + vz * bz);
  const d5 = -(ux * cx + uy * cy + uz * cz), d6 = -(vx * cx + vy * cy + vz * cz);
  const va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (d1 <= 0 && d2 <= 0) [out[0], out[1]] = [0, 0];
  else if (d3 >= 0 && d4 <= d3) [out[0], out[1]] = [1, 0];
  else if (vc <= 0 && d1 >= 0 && d3 <= 0) [out[0], out[1]] = [d1 / (d1 - d3), 0];
  else if (d6 >= 0 && d5 <= d6) [out[0], out[1]] = [0, 1];
  else if (vb <= 0 && d2 >= 0 && d6 <= 0) [out[0], out[1]] = [0, d2 / (d2 - d6)];
  else if (va <= 0 && d4 >= d3 && d5 >= d6) {
    out[1] = (d4 - d3) / (d4 - d3 + d5 - d6);
    out[0] = 1 - out[1];
  } else [out[0], out[1]] = [vb / (va + vb + vc), vc / (va + vb + vc)];
}

/// A bounding-box hierarchy of triangles, split at the median.
export class RayTree {
  constructor({ vertices, triangles }) {
    this.vertices = vertices;
    this.triangles = triangles;
    this.order = Array.from({ length: triangles.length / 3 }, (_, t) => t);
    this.nodes = [];
    if (this.order.length > 0) this.#add(0, this.order.length);
  }

  #middle(t, axis) {
    let sum = 0;
    for (let k = 0; k < 3; ++k) sum += this.vertices[3 * this.triangles[3 * t + k] + axis];
    return sum;
  }

  #add(first, last) {
    const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
    for (let i = first; i < last; ++i) {
      for (let k = 0; k < 9; ++k) {
        const axis = k % 3, x = this.vertices[3 * this.triangles[3 * this.order[i] + Math.floor(k / 3)] + axis];
        if (x < box[axis]) box[axis] = x;
        if (x > box[axis + 3]) box[axis + 3] = x;
      }
    }
    const node = { box, first, last, left: -1, right: -1 }, at = this.nodes.push(node) - 1;
    if (last - first <= mostInLeaf) return at;
    const sizes = [0, 1, 2].map((axis) => box[axis + 3] - box[axis]), axis = sizes.indexOf(Math.max(...sizes));
    const part = this.order.slice(first, last).map((t) => [this.#middle(t, axis), t]).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    part.forEach(([, t], k) => { this.order[first + k] = t; });
    const half = (first + last) >> 1;
    node.left = this.#add(first, half);
    node.right = this.#add(half, last);
    return at;
  }

  #intersects({ box }, from, inverse, longest) {
    let enter = 0, leave = longest;
    for (let axis = 0; axis < 3; ++axis) {
      const a = (box[axis] - 1e-9 - from[axis]) * inverse[axis], b = (box[axis + 3] + 1e-9 - from[axis]) * inverse[axis];
      enter = Math.max(enter, Math.min(a, b));
      leave = Math.min(leave, Math.max(a, b));
    }
    return enter <= leave;
  }

  /// Moeller and Trumbore (1997); only triangles that face the ray.
  #travel(t, from, d) {
    const p = this.vertices, [i, j, k] = [0, 1, 2].map((corner) => 3 * this.triangles[3 * t + corner]);
    const ax = p[j] - p[i], ay = p[j + 1] - p[i + 1], az = p[j + 2] - p[i + 2];
    const bx = p[k] - p[i], by = p[k + 1] - p[i + 1], bz = p[k + 2] - p[i + 2];
    const cx = d[1] * bz - d[2] * by, cy = d[2] * bx - d[0] * bz, cz = d[0] * by - d[1] * bx;
    const facing = ax * cx + ay * cy + az * cz;
    if (!(facing > 0)) return Infinity;
    const sx = from[0] - p[i], sy = from[1] - p[i + 1], sz = from[2] - p[i + 2];
    const u = sx * cx + sy * cy + sz * cz, least = -1e-12 * facing, most = (1 + 1e-12) * facing;
    if (u < least || u > most) return Infinity;
    const qx = sy * az - sz * ay, qy = sz * ax - sx * az, qz = sx * ay - sy * ax;
    const v = d[0] * qx + d[1] * qy + d[2] * qz;
    if (v < least || u + v > most) return Infinity;
    const travel = (bx * qx + by * qy + bz * qz) / facing;
    return travel >= 0 ? travel : Infinity;
  }

  /// Distance to the first facing triangle; infinite beyond `longest`. `direction` is a unit vector.
  travel(from, direction, longest) {
    if (this.nodes.length === 0) return Infinity;
    const inverse = direction.map((x) => 1 / (Math.abs(x) < 1e-300 ? 1e-300 : x)), stack = [0];
    let shortest = longest, isHit = false;
    while (stack.length > 0) {
      const node = this.nodes[stack.pop()];
      if (!this.#intersects(node, from, inverse, shortest)) continue;
      if (node.left >= 0) {
        stack.push(node.right, node.left);
        continue;
      }
      for (let i = node.first; i < node.last; ++i) {
        const travel = this.#travel(this.order[i], from, direction);
        if (travel > shortest) continue;
        [shortest, isHit] = [travel, true];
      }
    }
    return isHit ? shortest : Infinity;
  }

  /// { distance, triangle, point } of the nearest point of the mesh; triangle -1 if none is nearer than `limit`.
  nearest(p, limit = Infinity) {
    const d = new Float64Array(9), weight = new Float64Array(2), best = { distance: limit, triangle: -1, point: null };
    const away = ({ box }) => {
      let sum = 0;
      for (let axis = 0; axis < 3; ++axis) sum += Math.max(0, box[axis] - p[axis], p[axis] - box[axis + 3]) ** 2;
      return Math.sqrt(sum);
    };
    const visit = (node) => {
      if (node.left >= 0) {
        const left = this.nodes[node.left], right = this.nodes[node.right], toLeft = away(left), toRight = away(right);
        if (Math.min(toLeft, toRight) < best.distance) visit(toLeft <= toRight ? left : right);
        if (Math.max(toLeft, toRight) < best.distance) visit(toLeft <= toRight ? right : left);
        return;
      }
      for (let i = node.first; i < node.last; ++i) {
        const triangle = this.order[i];
        for (let k = 0; k < 9; ++k) d[k] = this.vertices[3 * this.triangles[3 * triangle + Math.floor(k / 3)] + (k % 3)] - p[k % 3];
        nearestInTriangle(d, weight);
        const [v, w] = weight, x = (1 - v - w) * d[0] + v * d[3] + w * d[6], y = (1 - v - w) * d[1] + v * d[4] + w * d[7], z = (1 - v - w) * d[2] + v * d[5] + w * d[8];
        const distance = Math.sqrt(x * x + y * y + z * z);
        if (distance < best.distance) [best.distance, best.triangle, best.point] = [distance, triangle, [p[0] + x, p[1] + y, p[2] + z]];
      }
    };
    if (this.nodes.length > 0 && away(this.nodes[0]) < limit) visit(this.nodes[0]);
    return best;
  }
}
