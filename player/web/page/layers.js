// Layers of the joint: gaps and ligaments, with their palettes.
import { Box3, BufferAttribute, BufferGeometry, Color, Group, Mesh, SRGBColorSpace } from "three";
import { cross, difference, dot, drawMesh, normalised, product, RayTree, scaled, sum, transposed, turned } from "./geometry.js";
import { evenly, laidOver } from "./laid_path.js";
import { colouredMaterialOf, colourOf, markerMaterial } from "./material.js";
import { gapStructure } from "./structures.js";

// Palettes of the joint's layers, as player/view/scene. Stops in sRGB, evenly spaced.

const stops = (text) => text.split(" ").map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
/// "plasma" of matplotlib (Smith and van der Walt, CC0), reversed.
export const gapPalette = stops("F0F921 FCCE25 FCA636 F2844B E16462 CC4778 B12A90 8F0DA4 6A00A8 41049D 0D0887");
/// "OrRd" of ColorBrewer (Brewer, Apache 2.0) without its palest colours, at 11 places; then the colour beyond the end of the scale.
export const strainPalette = stops("FDD49E FDC58E FDB27B FC9662 F77D52 EF6548 E1452F D02619 BA0A06 9E0000 7F0000");
const beyondColour = [84, 22, 140];
/// The strain at the end of the scale, the same for every model.
export const highestStrain = 0.08;

const interpolated = (a, b, part) => a.map((x, k) => x + part * (b[k] - x));

/// sRGB colour at `position` on [0, 1], clamped.
function colourAt(palette, position) {
  const at = Math.min(Math.max(position, 0), 1) * (palette.length - 1), k = Math.min(Math.floor(at), palette.length - 2);
  return interpolated(palette[k], palette[k + 1], at - k);
}

const colour = new Color();
/// Writes an sRGB colour to an array of linear colours for the shader.
function setLinear(array, at, rgb) {
  colour.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, SRGBColorSpace);
  colour.toArray(array, at);
}

/// Converts linear RGB to sRGB.
function srgbFromLinear(linear) {
  return new Color(...linear).getRGB(new Color(), SRGBColorSpace).toArray().map((x) => 255 * x);
}

export const gradientOf = (palette) => `linear-gradient(to right, ${palette.map((rgb) => `rgb(${rgb})`).join(", ")})`;

/// The bodies' names for the user; a knee's bones do not depend on the names in the file.
export const bodyNames = (model) => (model.joint === "knee" ? { reference: "femur", moving: "tibia" } : { reference: model.bodies.reference.name, moving: model.bodies.moving.name });

/// The box of a body's contact parts.
export function boxOf(body) {
  const { min, max } = new Box3().setFromArray(body.parts[0].vertices);
  return { low: min.toArray(), high: max.toArray() };
}

// Directional gaps from the moving body's upward faces to the reference, as colours. Constants as in player/view/layers.

const rangeMm = 6;
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
  mesh.userData = { structure: gapStructure };
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

/// Colours of the gap on the moving body's contact sheets; only triangles near the reference are drawn.
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
    }
  }
}

// Ligament fibres: their paths and strain at any pose; as pipeline/model/ligaments.

const cylinder = 0;
/// Links of a wrapped fibre; compared with the library on a real knee: strain error 0.0016, variation between poses 0.0002.
const nLinks = 24;
/// Relaxation sweeps from a straight line, and from the path at the previous pose, of ends no further away.
const coldSweeps = 400, warmSweeps = 30, nearMm = 6;
const powers = 60;  // directions need no more
const overRelaxation = 1.5;  // between 1 and 2

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
    return { points, isLine: fibre.isLine, strain: fibre.isLine ? 0 : pathLength(points) / fibre.slackLength - 1 };
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
    const before = this.chains.get(k), isNear = before && [before[0], before[nLinks]].every((p, n) => Math.hypot(...difference(p, own[n])) < nearMm);
    const chain = shortestChain(wrap, ...own, isNear ? before : undefined);
    this.chains.set(k, chain);
    return chain.map((p) => sum(turned(R, p), t));
  }
}

/// Two directions normal to a path at each of its points: of the width of a band, which is interpolated between both ends,
/// and of its thickness. Where a width is zero or along the path, the cross section turns as little as possible.
function crossSections(points, acrossFirst, acrossLast) {
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
/// player/view/layers: the first principal component of both attachments together.
function arrangementOf(fibres, bundle) {
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

// Ligaments as flat bands: narrow and grey if slack, otherwise coloured by strain. Constants as in player/view/layers.

// Half sizes; neighbouring bands overlap a little, and are wider at their footprints.
const thicknessMm = 0.45, narrowestMm = 1, widestMm = 2.4, overlap = 1.2, flare = 0.35, slackPart = 0.7, highlightedPart = 1.6, nSides = 6;
// Points of a band, and its height over bone.
const nPoints = 24, aboveBoneMm = 0.7;
// A slack fibre is drawn as long as it is, in waves, unless they are higher than this.
const nWaves = 3, highestWaveMm = 1.5;

function waved(points, strain, across, scale) {
  const chord = difference(points[points.length - 1], points[0]), length = Math.hypot(...chord);
  const wanted = cross(cross(chord, across), chord), other = cross(chord, Math.abs(chord[0]) < 0.9 * length ? [1, 0, 0] : [0, 1, 0]);
  const aside = normalised(dot(wanted, wanted) > 0 ? wanted : other);
  const height = Math.min(scale * highestWaveMm, (length * Math.sqrt(-strain / (1 + strain))) / (Math.PI * nWaves));
  return points.map((p, k) => sum(p, scaled(aside, height * Math.sin((2 * Math.PI * nWaves * k) / (points.length - 1)))));
}
const slackColour = [205, 203, 196], lineColour = [170, 74, 68];

/// The tension law of schemas/ligaments.md, N.
function tensionOf(strain, { stiffness, constantTension }, transition) {
  if (constantTension > 0) return constantTension;
  return strain <= 0 ? 0 : strain < transition ? (stiffness * strain * strain) / (2 * transition) : stiffness * (strain - transition / 2);
}

function geometryOf(nFibres) {
  const indices = [];
  for (let fibre = 0; fibre < nFibres; ++fibre) {
    for (let k = 0; k + 1 < nPoints; ++k) {
      for (let side = 0; side < nSides; ++side) {
        const ring = (fibre * nPoints + k) * nSides, a = ring + side, b = ring + ((side + 1) % nSides);
        indices.push(a, b, a + nSides, b, b + nSides, a + nSides);
      }
    }
  }
  const geometry = new BufferGeometry();
  for (const name of ["position", "normal", "color"]) geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * nFibres * nPoints * nSides), 3));
  geometry.setIndex(indices);
  return geometry;
}

/// Bands of the bundles, coloured by strain: one mesh a bundle.
export class LigamentLayer {
  /// `scale`: the joint's size relative to a knee; `path`: of the ligaments in the file.
  constructor(model, scale, ligaments, path) {
    this.origin = model.rotationCentre;
    this.scale = scale;
    this.law = ligaments;
    this.fibres = new Fibres(ligaments);
    this.sampled = new Fibres(ligaments);  // along curves, whose paths would spoil those of the pose shown
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    this.bundles = [...new Set(ligaments.fibres.map(({ bundle }) => bundle))].map((bundle) => {
      const { reference, moving, spacing } = arrangementOf(ligaments.fibres, bundle), own = [...ligaments.fibres.keys()].filter((k) => ligaments.fibres[k].bundle === bundle);
      const mesh = new Mesh(geometryOf(own.length), markerMaterial());
      mesh.userData = { structure: `${path}/${bundle}`, isThin: true };
      mesh.frustumCulled = false;
      this.group.add(mesh);
      return { bundle, structure: mesh.userData.structure, fibres: own, mesh, reference, moving, halfWidth: Math.min(Math.max(0.5 * overlap * spacing, scale * narrowestMm), scale * widestMm) };
    });
  }

  /// How much each bundle is highlighted, hence widened.
  get highlights() { return this.bundles.map(({ mesh }) => mesh.material.uniforms.highlight.value); }

  strains(X) { return this.fibres.fibres.map((_, k) => this.fibres.at(k, X).strain); }

  /// The largest strain of a bundle's fibres, -1 if all are lines of constant tension, and their tension in N together, at one of successive poses.
  reading({ fibres }, X) {
    const all = fibres.map((k) => [this.sampled.at(k, X), this.sampled.fibres[k]]);
    return { strain: Math.max(...all.map(([{ strain, isLine }]) => (isLine ? -1 : strain))), tension: all.reduce((sum, [{ strain }, fibre]) => sum + tensionOf(strain, fibre, this.law.transitionStrain), 0) };
  }

  /// In the reference's frame; `X` maps moving to reference, `bodies` are those of laidOver.
  update(X, bodies) {
    for (const bundle of this.bundles) this.#updateBundle(bundle, X, bodies);
  }

  #updateBundle(bundle, X, bodies) {
    const { mesh } = bundle, moving = turned(X.R, bundle.moving), halfWidth = bundle.halfWidth * (mesh.material.uniforms.highlight.value > 0 ? highlightedPart : 1);
    bundle.fibres.forEach((k, own) => {
      const path = this.fibres.at(k, X);
      path.points = laidOver(evenly(path.points, nPoints), bodies, this.scale * aboveBoneMm);
      if (path.strain < 0) path.points = waved(path.points, path.strain, sum(bundle.reference, moving), this.scale);
      this.#setBand(mesh.geometry, own * nPoints, path, { ...bundle, halfWidth, moving });
    });
    for (const name of ["position", "normal", "color"]) mesh.geometry.getAttribute(name).needsUpdate = true;
    mesh.geometry.computeBoundingSphere();
  }

  #setBand(geometry, firstRing, { points, strain, isLine }, { reference, moving, halfWidth }) {
    const [position, normal, color] = ["position", "normal", "color"].map((name) => geometry.getAttribute(name).array);
    const part = strain < 0 ? slackPart : 1, thick = part * this.scale * thicknessMm;
    const rgb = isLine ? lineColour : strain < 0 ? slackColour : strain > highestStrain ? beyondColour : colourAt(strainPalette, strain / highestStrain);
    crossSections(points, reference, moving).forEach(([u, v], k) => {
      const wide = part * halfWidth * (1 + flare * Math.abs((2 * k) / (nPoints - 1) - 1) ** 3);
      for (let side = 0; side < nSides; ++side) {
        const angle = (2 * Math.PI * side) / nSides, at = 3 * ((firstRing + k) * nSides + side), [c, s] = [Math.cos(angle), Math.sin(angle)];
        const length = Math.hypot(thick * c, wide * s);  // of the ellipse's gradient
        for (let axis = 0; axis < 3; ++axis) {
          position[at + axis] = points[k][axis] - this.origin[axis] + wide * c * u[axis] + thick * s * v[axis];
          normal[at + axis] = (thick * c * u[axis] + wide * s * v[axis]) / length;
        }
        setLinear(color, at, rgb);
      }
    });
  }
}
