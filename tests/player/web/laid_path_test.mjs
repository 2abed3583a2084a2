// Paths over bone in the page: the taut string over a ball, its side; clear paths. As tests/geometry/laid_path_test.
import assert from "node:assert/strict";
import { LazyDistance, evenly, laidOver } from "../../../player/web/page/laid_path.js";

const radius = 20, clearance = 1, still = { R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], t: [0, 0, 0] };
const sampled = 0.25;  // trilinear between nodes 3 mm apart on a ball of 20 mm: 3^2 / 40

function ball(n) {
  const vertices = [], triangles = [];
  for (let i = 0; i <= n; ++i) {
    for (let j = 0; j < n; ++j) {
      const a = (Math.PI * i) / n, b = (2 * Math.PI * j) / n;
      vertices.push(radius * Math.sin(a) * Math.cos(b), radius * Math.cos(a), radius * Math.sin(a) * Math.sin(b));
    }
  }
  for (let i = 0; i < n; ++i) {
    for (let j = 0; j < n; ++j) {
      const row = (ring, at) => ring * n + (ring > 0 && ring < n ? at % n : 0);  // a pole is one vertex
      const [a, b, c, d] = [row(i, j), row(i, j + 1), row(i + 1, j), row(i + 1, j + 1)];
      if (i > 0) triangles.push(a, b, c);
      if (i + 1 < n) triangles.push(b, d, c);
    }
  }
  return { vertices: Float64Array.from(vertices), triangles: Int32Array.from(triangles), component: new Int32Array(triangles.length / 3) };
}

const beside = [{ field: new LazyDistance({ parts: [ball(64)] }), X: still }], norm = (p) => Math.hypot(...p);
for (const off of [-12, -4, 4, 12]) {
  const from = [-35, off, 0], to = [35, off, 0], path = laidOver(evenly([from, to], 24), beside, clearance);
  assert.deepEqual([path[0], path[23]], [from, to]);
  for (const p of path) {
    assert.ok(norm(p) > radius + clearance - sampled, `${off}: ${p}`);
    assert.ok(p[1] * off > 0, `${off}: ${p}`);
  }
  // Two tangents and the arc between them.
  const high = radius + clearance, arc = Math.acos((off * off - 35 * 35) / (off * off + 35 * 35)) - 2 * Math.acos(high / norm(from));
  const length = path.slice(1).reduce((sum, p, k) => sum + Math.hypot(...p.map((x, axis) => x - path[k][axis])), 0);
  assert.ok(Math.abs(length - 2 * Math.sqrt(norm(from) ** 2 - high ** 2) - high * arc) < 0.01 * norm(from), `${off}: ${length}`);
}
const clear = evenly([[-35, 24, 0], [0, 24, 10], [35, 24, 0]], 24);
assert.deepEqual(laidOver(clear, beside, clearance), clear);
const links = clear.slice(1).map((p, k) => Math.hypot(...p.map((x, axis) => x - clear[k][axis])));
assert.ok(Math.max(...links) - Math.min(...links) < 0.2);  // evenly spaced but for the corner
