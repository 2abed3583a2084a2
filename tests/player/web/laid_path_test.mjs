// Paths over bone in the page: the taut string over a ball, its side; clear paths. As tests/geometry/laid_path_test.
import assert from "node:assert/strict";
import { Fibres } from "../../../player/web/page/layers.js";
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

// A fibre around a cylinder: two tangents and the arc between them. One around an ellipsoid: the same whatever pose was before.
const fibreOver = (shape, radii) => ({ reference: [-35, 4, 0], moving: [35, 4, 0], slackLength: 1, wrap: { ...still, shape, radii, isOnMoving: false } });
const fibres = new Fibres({ fibres: [fibreOver(0, [radius, radius, 100]), fibreOver(1, [30, 8, 20])] });
const lengthAt = (k, degrees) => {
  const [c, s] = [Math.cos(degrees * Math.PI / 180), Math.sin(degrees * Math.PI / 180)];
  return fibres.at(k, { R: [[c, -s, 0], [s, c, 0], [0, 0, 1]], t: [0, 0, 0] }).strain + 1;
};
const end = norm([35, 4]), wide = Math.PI - 2 * Math.atan(4 / 35), chords = 0.002;  // 24 links along the path
for (const degrees of [0, 60]) {
  const around = 2 * Math.sqrt(end ** 2 - radius ** 2) + radius * (wide - degrees * Math.PI / 180 - 2 * Math.acos(radius / end));
  assert.ok(Math.abs(lengthAt(0, degrees) / around - 1) < chords, `${degrees}: ${lengthAt(0, degrees)}, ${around}`);
}
const found = [0, -20, 0, -20].map((degrees) => lengthAt(1, degrees));
assert.deepEqual(found.slice(2), found.slice(0, 2));
