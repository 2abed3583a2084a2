// Distance along a ray to a mesh; as pipeline/proximity/ray_travel.

const mostInLeaf = 4;

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
}
