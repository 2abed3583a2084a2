// Ligaments as flat bands: narrow and grey if slack, otherwise coloured by strain. Constants as in player/scene/ligament_layer.
import { BufferAttribute, BufferGeometry, Mesh } from "three";
import { turned } from "./frames.js";
import { arrangementOf, crossSections, Fibres } from "./ligaments.js";
import { markerMaterial } from "./material.js";
import { stable } from "./motion.js";
import { colourAt, setLinear, strainPalette } from "./palettes.js";

// Half sizes; neighbouring bands overlap a little.
const thicknessMm = 0.45, narrowestMm = 1, widestMm = 2.4, overlap = 1.2, slackPart = 0.7, nSides = 10;
export const slackColour = [205, 203, 196];

/// Strain at the end of the scale: the 95 % quantile of positive strains, rounded up to steps of 2 %.
export function highestStrain(model) {
  const step = 0.02, most = 0.95, { strain, fibres } = model.ligaments, taut = [];
  const solved = [...model.status.keys()].filter((cell) => model.status[cell] === stable);
  const spine = solved.filter((cell) => model.isSpine[cell] === 1);
  for (const cell of spine.length ? spine : solved) {
    for (let k = 0; k < fibres.length; ++k) {
      const own = strain[cell * fibres.length + k];
      if (own > 0) taut.push(own);
    }
  }
  if (taut.length === 0) return step;
  taut.sort((a, b) => a - b);
  return Math.max(step, step * Math.ceil(taut[Math.trunc(most * (taut.length - 1))] / step - 1e-9));
}

function geometryOf(paths) {
  const nRings = paths.reduce((n, { points }) => n + points.length, 0), indices = [];
  let ring = 0;
  for (const { points } of paths) {
    for (let k = 0; k + 1 < points.length; ++k) {
      for (let side = 0; side < nSides; ++side) {
        const a = (ring + k) * nSides + side, b = (ring + k) * nSides + ((side + 1) % nSides);
        indices.push(a, b, a + nSides, b, b + nSides, a + nSides);
      }
    }
    ring += points.length;
  }
  const geometry = new BufferGeometry();
  for (const name of ["position", "normal", "color"]) geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * nRings * nSides), 3));
  geometry.setIndex(indices);
  return geometry;
}

export class LigamentLayer {
  /// `scale`: the joint's size relative to a knee.
  constructor(model, scale) {
    this.origin = model.rotationCentre;
    this.scale = scale;
    this.fibres = new Fibres(model.ligaments);
    this.bands = this.fibres.fibres.map(({ bundle }) => {
      const { reference, moving, spacing } = arrangementOf(this.fibres.fibres, bundle);
      return { reference, moving, halfWidth: Math.min(Math.max(0.5 * overlap * spacing, scale * narrowestMm), scale * widestMm) };
    });
    this.highest = highestStrain(model);
    this.mesh = new Mesh(new BufferGeometry(), markerMaterial());
    this.mesh.frustumCulled = false;
  }

  strains(X) { return this.fibres.fibres.map((_, k) => this.fibres.at(k, X).strain); }

  /// In the reference's frame; `X` maps moving to reference.
  update(X) {
    const paths = this.fibres.fibres.map((_, k) => this.fibres.at(k, X));
    // The number of points changes when a fibre starts or stops wrapping.
    const sizes = paths.map(({ points }) => points.length).join();
    if (sizes !== this.sizes) {
      this.mesh.geometry.dispose();
      this.mesh.geometry = geometryOf(paths);
      this.sizes = sizes;
    }
    let ring = 0;
    paths.forEach((path, k) => { ring = this.#setBand(ring, path, { ...this.bands[k], moving: turned(X.R, this.bands[k].moving) }); });
    for (const name of ["position", "normal", "color"]) this.mesh.geometry.getAttribute(name).needsUpdate = true;
  }

  #setBand(firstRing, { points, strain }, { reference, moving, halfWidth }) {
    const [position, normal, color] = ["position", "normal", "color"].map((name) => this.mesh.geometry.getAttribute(name).array);
    const part = strain < 0 ? slackPart : 1, wide = part * halfWidth, thick = part * this.scale * thicknessMm;
    const rgb = strain < 0 ? slackColour : colourAt(strainPalette, strain / this.highest);
    crossSections(points, reference, moving).forEach(([u, v], k) => {
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
    return firstRing + points.length;
  }
}
