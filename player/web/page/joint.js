// The joint as three.js objects: two groups of meshes at the poses of their bodies; contact paths and gaps are attached to the
// moving body, ligaments to the reference.
import { BufferAttribute, BufferGeometry, CatmullRomCurve3, Group, Matrix4, Mesh, MeshBasicMaterial, SphereGeometry, TubeGeometry, Vector3 } from "three";
import { composed, drawMesh, inverse, rows, still as atRest, sum, transposed, turned } from "./geometry.js";
import { GapLayer, labelsOf, LigamentLayer } from "./layers.js";
import { ghostMaterial, materialOf } from "./material.js";
import { Motion } from "./motion.js";
import { compartmentColours, pathAlong, unbroken } from "./plots.js";

const tubeRadiusMm = 0.7, dotRadiusMm = 1.6;
/// The ends of the band of an uncertain job, as in the window.
const bandEnds = { quantile_5: "#4682dc", quantile_95: "#eb8732", bones_alone: "#969696" }, ghostOpacity = 0.5, ghostDepthOffsetMm = 10;

function meshesOf(body, origin) {
  const meshes = [];
  body.parts.forEach((part, k) => body.components.forEach(({ name, material }, component) => {
    const { positions, normals } = drawMesh(part, component, origin, material);
    if (positions.length === 0) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(normals, 3));
    geometry.computeBoundingBox();
    const mesh = new Mesh(geometry, materialOf(material));
    mesh.name = name;
    mesh.userData = { material, hasContact: k === 0 };
    meshes.push(mesh);
  }));
  return meshes;
}

/// The pose of a body in the other one's frame.
function relative(referenceMoving, name) {
  if (name === "moving") return referenceMoving;
  const R = transposed(referenceMoving.R);
  return { R, t: turned(R, referenceMoving.t).map((x) => -x) };
}

/// The joint as a group of three.js: both bodies with what is drawn on them; `model` as read by model_file.js.
export class Joint {
  constructor(model) {
    this.model = model;
    this.group = new Group();
    // Meshes are relative to the rotation centre; `place` adds it.
    this.bodies = {};
    this.followers = model.followers ?? [];
    for (const name of Object.keys(model.bodies)) {
      const group = this.bodies[name] = new Group();
      group.matrixAutoUpdate = false;
      group.add(...meshesOf(model.bodies[name], model.rotationCentre));
      this.group.add(group);
    }
    this.scale = this.#scale();
    this.labels = labelsOf(model, this.scale);
    this.paths = new Group();
    this.bodies.moving.add(this.paths);
    this.gapGroup = new Group();
    this.bodies.moving.add(this.gapGroup);
    this.ligamentGroup = new Group();
    this.bodies.reference.add(this.ligamentGroup);
    this.#makeGhosts();
    // The joint's fibres, then those of its followers by the body of their first ends.
    this.ligaments = [];
    const add = (ligaments, from, to) => {
      const layer = new LigamentLayer(model, this.scale, ligaments);
      this.ligaments.push({ layer, from, to });
      this.ligamentGroup.add(layer.mesh);
    };
    if (model.ligaments) add(model.ligaments, null, null);
    const named = (index) => this.followers.find((follower) => follower.index === index)?.name ?? null;
    for (const { name, ligaments } of this.followers) {
      for (const from of new Set(ligaments?.fibres.map((fibre) => fibre.from))) add({ ...ligaments, fibres: ligaments.fibres.filter((fibre) => fibre.from === from) }, from < 2 ? from : named(from), name);
    }
  }

  /// Translucent copies of the moving body's contact meshes, in the frame of the reference.
  #makeGhosts() {
    this.ghosts = (this.model.quantiles ?? []).filter(({ name }) => bandEnds[name]).map(({ name }) => {
      const group = new Group(), material = ghostMaterial(bandEnds[name], ghostOpacity, ghostDepthOffsetMm);
      group.matrixAutoUpdate = group.visible = false;
      group.add(...this.bodies.moving.children.filter((child) => child.userData.hasContact).map((child) => new Mesh(child.geometry, material)));
      this.bodies.reference.add(group);
      return { group, motion: new Motion(this.model, name) };
    });
  }

  get meshes() {
    const followers = this.followers.map(({ name }) => this.bodies[name]).filter(({ visible }) => visible);
    return [this.bodies.reference, this.bodies.moving, ...followers].flatMap(({ children }) => children).filter((child) => child.isMesh);
  }

  /// The joint's size relative to a knee, the scale factor for markers.
  #scale() {
    const widthOfKneeMm = 80, { vertices } = this.model.bodies.moving.parts[0];
    const widths = [0, 2].map((axis) => {
      let low = Infinity, high = -Infinity;
      for (let at = axis; at < vertices.length; at += 3) [low, high] = [Math.min(low, vertices[at]), Math.max(high, vertices[at])];
      return high - low;
    });
    const width = Math.max(...widths);
    return width > 0 ? width / widthOfKneeMm : 1;
  }

  /// Updates the layers at a pose. The gap layer is built on first use, since its tree takes time.
  showLayers(pose, motion, { hasLigaments, hasGaps, hasBand }) {
    for (const ghost of this.ghosts) {
      const at = hasBand ? ghost.motion.at(pose.attitude) : null;
      ghost.group.visible = Boolean(at?.isSolved);
      if (!ghost.group.visible) continue;
      // Meshes of both bodies are relative to the rotation centre.
      const { R, t } = at.referenceMoving, centre = this.model.rotationCentre;
      ghost.group.matrix.set(...rows({ R, t: sum(turned(R, centre), t).map((x, k) => x - centre[k]) }));
    }
    this.ligamentGroup.visible = hasLigaments && this.ligaments.length > 0;
    if (this.ligamentGroup.visible && pose.isSolved) this.#showLigaments(pose);
    this.gapGroup.visible = hasGaps;
    if (!hasGaps) return;
    if (!this.gaps) this.gapGroup.add((this.gaps = new GapLayer(this.model, this.scale)).group);
    this.gaps.update(pose.referenceMoving, motion.delta(pose.attitude.flexion));
  }

  #showLigaments({ referenceMoving, followers }) {
    const poseOf = (body) => (body === 0 ? atRest : body === 1 ? referenceMoving : followers[body]);
    for (const { layer, from, to } of this.ligaments) {
      const [first, second] = to === null ? [atRest, referenceMoving] : [poseOf(from), poseOf(to)];
      layer.mesh.visible = Boolean(first && second);
      if (!layer.mesh.visible) continue;
      layer.update(to === null ? second : composed(inverse(first), second));
      // Meshes are relative to the rotation centre.
      const centre = this.model.rotationCentre;
      layer.mesh.matrixAutoUpdate = false;
      layer.mesh.matrix.set(...rows({ R: first.R, t: sum(turned(first.R, centre), first.t).map((x, k) => x - centre[k]) }));
    }
  }

  /// `held`: what is fixed on screen. A fixed body, "reference" or "moving", has the same place at every pose, bit for bit; "push" is
  /// the world of the poses. Without a pose only the fixed body is drawn, or the reference.
  place(pose, held) {
    const still = held === "push" ? null : held, other = held === "moving" ? "reference" : "moving";
    for (const name of ["reference", "moving"]) {
      this.bodies[name].visible = pose.isSolved || name !== other;
      if (name === still) this.bodies[name].matrix.identity();
      else if (pose.isSolved) this.bodies[name].matrix.set(...rows(this.#aboutCentre(still ? relative(pose.referenceMoving, name) : pose[name], still)));
    }
    for (const { name } of this.followers) {
      const own = pose.isSolved ? pose.followers[name] : null, group = this.bodies[name];
      group.visible = Boolean(own);
      // In the frame of the reference, which has been placed.
      if (own) group.matrix.copy(this.bodies.reference.matrix).multiply(new Matrix4().set(...rows(this.#aboutCentre(own, true))));
    }
    // The layers between the bodies have no place without a pose.
    for (const group of [this.ligamentGroup, this.gapGroup, ...this.ghosts.map((ghost) => ghost.group)]) if (!pose.isSolved) group.visible = false;
    this.group.updateMatrixWorld(true);
  }

  /// Of meshes relative to the rotation centre, to the other body's meshes or to the world, which has its origin there.
  #aboutCentre({ R, t }, isToBody) {
    const centre = this.model.rotationCentre, shift = sum(turned(R, centre), t);
    return { R, t: isToBody ? shift.map((x, k) => x - centre[k]) : shift };
  }

  /// Shows the contact paths on the moving body (one varus column per flexion) and dots at the current contacts.
  showPaths(columns, flexionDeg) {
    if (!this.model.contactPaths) return;
    const key = columns.join();
    if (this.pathsKey !== key) this.#makePaths(columns);
    this.pathsKey = key;
    for (const { dot, path } of this.compartments) {
      const here = path.find(({ isAt }) => isAt(flexionDeg));
      dot.visible = Boolean(here);
      if (here) dot.position.copy(this.#drawn(here));
    }
  }

  #drawn({ point }) { return new Vector3(...point.map((x, k) => x - this.model.rotationCentre[k])); }

  #makePaths(columns) {
    for (const child of this.paths.children) child.geometry.dispose();
    this.paths.clear();
    this.compartments = ["medial", "lateral"].map((compartment) => {
      const path = pathAlong(this.model, `${compartment}_moving`, columns);
      const material = new MeshBasicMaterial({ color: compartmentColours[compartment] });
      for (const piece of unbroken(path)) {
        if (piece.length < 2) continue;
        const curve = new CatmullRomCurve3(piece.map((cell) => this.#drawn(cell)));
        this.#add(new TubeGeometry(curve, 4 * piece.length, tubeRadiusMm, 6), material);
      }
      return { path, dot: this.#add(new SphereGeometry(dotRadiusMm, 16, 12), material) };
    });
  }

  #add(geometry, material) {
    const mesh = new Mesh(geometry, material);
    this.paths.add(mesh);
    return mesh;
  }

  dispose() {
    this.group.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
  }
}
