// Directional gaps from the moving body's upward faces to the reference, as colours. Constants as in player/scene/gap_layer.
import { BufferAttribute, BufferGeometry, Group, Mesh } from "three";
import { drawMesh } from "./draw_mesh.js";
import { cross, difference, dot, scaled, sum, turned } from "./frames.js";
import { colouredMaterialOf, colourOf } from "./material.js";
import { RayTree } from "./ray_tree.js";
import { colourAt, gapPalette, interpolated, setLinear, srgbFromLinear } from "./palettes.js";

export const rangeMm = 6;
const deepestMm = 3, aboveMm = 0.05, leastUpward = 0.3, fadesFrom = 0.7;

/// Corners of the triangles oriented along `delta`.
function upwardCorners(positions, delta) {
  const corners = [];
  for (let at = 0; at < positions.length; at += 9) {
    const [a, b, c] = [0, 3, 6].map((by) => positions.subarray(at + by, at + by + 3));
    const n = cross(difference(b, a), difference(c, a));
    if (dot(n, delta) > leastUpward * Math.hypot(...n)) corners.push(at / 3, at / 3 + 1, at / 3 + 2);
  }
  return corners;
}

function sheetOf(part, component, { material }, model, scale) {
  const { positions, normals, vertices } = drawMesh(part, component, model.rotationCentre, model.bodies.moving.components[component].material);
  const corners = upwardCorners(positions, model.delta);
  if (corners.length === 0) return null;
  const geometry = new BufferGeometry(), lifted = new Float32Array(3 * corners.length), own = new Float32Array(3 * corners.length);
  corners.forEach((corner, c) => {
    for (let k = 0; k < 3; ++k) {
      own[3 * c + k] = normals[3 * corner + k];
      lifted[3 * c + k] = positions[3 * corner + k] + scale * aboveMm * own[3 * c + k];
    }
  });
  geometry.setAttribute("position", new BufferAttribute(lifted, 3));
  geometry.setAttribute("normal", new BufferAttribute(own, 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * corners.length), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(corners.length), 1));
  const mesh = new Mesh(geometry, colouredMaterialOf(material));
  // Corners that share a vertex share its ray.
  const rowOf = new Map();
  const rows = corners.map((corner) => {
    const vertex = vertices[corner];
    if (!rowOf.has(vertex)) rowOf.set(vertex, rowOf.size);
    return rowOf.get(vertex);
  });
  const points = [...rowOf.keys()].map((vertex) => Array.from(part.vertices.subarray(3 * vertex, 3 * vertex + 3)));
  return { mesh, rows, points, gaps: new Float64Array(points.length), bone: srgbFromLinear(colourOf(material)) };
}

export class GapLayer {
  constructor(model, scale) {
    this.tree = new RayTree(model.bodies.reference.parts[0]);
    const { components, parts } = model.bodies.moving;
    this.sheets = components.map((component, k) => sheetOf(parts[0], k, component, model, scale)).filter(Boolean);
    this.group = new Group();
    this.group.add(...this.sheets.map(({ mesh }) => mesh));
  }

  /// Gap in mm from a point of the moving body along Delta to the reference; negative for overlap.
  gap(point, X, delta) {
    const direction = turned(X.R, delta), from = difference(sum(turned(X.R, point), X.t), scaled(direction, deepestMm));
    return this.tree.travel(from, direction, deepestMm + rangeMm) - deepestMm;
  }

  /// `X` maps moving to reference; `delta` has the same coordinates in the moving body, since theta rotates about it.
  update(X, delta) {
    for (const { mesh, rows, points, gaps, bone } of this.sheets) {
      points.forEach((point, row) => { gaps[row] = this.gap(point, X, delta); });
      const colour = mesh.geometry.getAttribute("color"), index = mesh.geometry.index;
      let n = 0;
      for (let c = 0; c < rows.length; c += 3) {
        const isNear = [0, 1, 2].some((k) => gaps[rows[c + k]] < rangeMm);
        for (let k = 0; k < 3 && isNear; ++k) index.array[n++] = c + k;
      }
      rows.forEach((row, c) => {
        const position = Math.min(gaps[row], rangeMm) / rangeMm, fading = (position - fadesFrom) / (1 - fadesFrom);
        setLinear(colour.array, 3 * c, interpolated(colourAt(gapPalette, position), bone, Math.min(Math.max(fading, 0), 1)));
      });
      mesh.geometry.setDrawRange(0, n);
      colour.needsUpdate = index.needsUpdate = true;
      mesh.visible = n > 0;
    }
  }
}
