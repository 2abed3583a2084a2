// The joint as three.js objects: two groups of meshes at the poses of their bodies; contact paths and gaps are attached to the
// moving body, ligaments to the reference.
import { BufferAttribute, BufferGeometry, CatmullRomCurve3, Group, Matrix4, Mesh, MeshBasicMaterial, SphereGeometry, TubeGeometry, Vector3 } from "three";
import { composed, drawMesh, inverse, isSolid, rows, still as atRest, sum, transposed, turned } from "./geometry.js";
import { LazyDistance } from "./laid_path.js";
import { labelsOf } from "./labels.js";
import { GapLayer, LigamentLayer } from "./layers.js";
import { ghostMaterial, materialOf, setLook, translucentLayer } from "./material.js";
import { Motion } from "./motion.js";
import { compartmentColours, pathAlong, unbroken } from "./plots.js";
import { bodyPath, pathsStructure, structureOf } from "./structures.js";

// About a contact, where it may be at the poses of samples; and how much farther than the closest point still counts.
const aboutMm = 12, closestMm = 0.2;
const tubeRadiusMm = 0.7, dotRadiusMm = 1.6;
/// The ends of the band of an uncertain job, as in the window.
export const bandEnds = { quantile_5: "#4682dc", quantile_95: "#eb8732", bones_alone: "#969696" }, ghostOpacity = 0.5, ghostDepthOffsetMm = 10;

/// `path`: of the body in the file.
function meshesOf(body, origin, path) {
  const meshes = [];
  body.parts.forEach((part, k) => body.components.forEach(({ name, material }, component) => {
    const { positions, normals, vertices } = drawMesh(part, component, origin, material);
    if (positions.length === 0) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new BufferAttribute(normals, 3));
    geometry.computeBoundingBox();
    const mesh = new Mesh(geometry, materialOf(material));
    mesh.name = name;
    mesh.userData = { material, hasContact: k === 0, isSheet: !isSolid(vertices, part.vertices.length / 3), structure: `${path}/${structureOf(body.components, component)}` };
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
      group.add(...meshesOf(model.bodies[name], model.rotationCentre, bodyPath(name)));
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
    const add = (ligaments, from, to, path) => {
      const layer = new LigamentLayer(model, this.scale, ligaments, path);
      this.ligaments.push({ layer, from, to });
      this.ligamentGroup.add(layer.group);
    };
    if (model.ligaments) add(model.ligaments, null, null, "ligaments");
    const named = (index) => this.followers.find((follower) => follower.index === index)?.name ?? null;
    for (const { name, ligaments } of this.followers) {
      for (const from of new Set(ligaments?.fibres.map((fibre) => fibre.from))) add({ ...ligaments, fibres: ligaments.fibres.filter((fibre) => fibre.from === from) }, from < 2 ? from : named(from), name, `followers/${name}/ligaments`);
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
  showLayers(pose, motion, { hasGaps, hasBand }) {
    for (const ghost of this.ghosts) {
      const at = hasBand ? ghost.motion.at(pose.attitude) : null;
      ghost.group.visible = Boolean(at?.isSolved);
      if (!ghost.group.visible) continue;
      // Meshes of both bodies are relative to the rotation centre.
      const { R, t } = at.referenceMoving, centre = this.model.rotationCentre;
      ghost.group.matrix.set(...rows({ R, t: sum(turned(R, centre), t).map((x, k) => x - centre[k]) }));
    }
    this.ligamentGroup.visible = this.ligaments.length > 0;
    if (this.ligamentGroup.visible && pose.isSolved) this.#showLigaments(pose);
    this.gapGroup.visible = hasGaps;
    if (!hasGaps) return;
    this.#gapLayer().update(pose.referenceMoving, motion.delta(pose.attitude.flexion));
  }

  #gapLayer() {
    if (!this.gaps) this.gapGroup.add((this.gaps = new GapLayer(this.model, this.scale)).group);
    return this.gaps;
  }

  /// Where a contact that is at `near` in the motion shown is at another pose, in the moving body's frame: the mean of the points about it that are closest along
  /// the push; null without a pose.
  contactAbout(near, pose, motion) {
    if (!pose.isSolved) return null;
    const layer = this.#gapLayer(), delta = motion.delta(pose.attitude.flexion), away = (p) => Math.hypot(...p.map((x, k) => x - near[k]));
    const points = layer.sheets.flatMap((sheet) => sheet.points).filter((p) => away(p) <= aboutMm * this.scale);
    const gaps = points.map((p) => layer.gap(p, pose.referenceMoving, delta)), least = Math.min(...gaps);
    const closest = points.filter((_, k) => gaps[k] <= least + closestMm);
    return Number.isFinite(least) ? [0, 1, 2].map((axis) => closest.reduce((total, p) => total + p[axis], 0) / closest.length) : null;
  }

  /// The pose of a layer's first bodies in the reference and that of its second ones relative to them, or null.
  #between({ from, to }, { referenceMoving, followers }) {
    const poseOf = (body) => (body === 0 ? atRest : body === 1 ? referenceMoving : followers[body]);
    const [first, second] = to === null ? [atRest, referenceMoving] : [poseOf(from), poseOf(to)];
    return first && second ? { first, X: to === null ? second : composed(inverse(first), second) } : null;
  }

  #fieldOf(name) {
    this.fields ??= {};
    return (this.fields[name] ??= new LazyDistance(this.model.bodies[name]));
  }

  #showLigaments(pose) {
    // Laying the bands over bone takes longer than to draw them.
    const key = JSON.stringify([pose.referenceMoving, pose.followers, this.ligaments.map(({ layer }) => layer.highlights)]);
    if (key === this.laid) return;
    this.laid = key;
    const beside = Object.entries({ reference: atRest, moving: pose.referenceMoving, ...pose.followers }).filter(([, X]) => X);
    for (const one of this.ligaments) {
      const found = this.#between(one, pose), { group } = one.layer;
      group.visible = Boolean(found);
      if (!found) continue;
      const back = inverse(found.first);
      one.layer.update(found.X, beside.map(([name, X]) => ({ field: this.#fieldOf(name), X: composed(back, X) })));
      // Meshes are relative to the rotation centre.
      const centre = this.model.rotationCentre, { R, t } = found.first;
      group.matrix.set(...rows({ R, t: sum(turned(R, centre), t).map((x, k) => x - centre[k]) }));
    }
  }

  /// Strain and tension of a bundle, by its structure, at one of successive poses; null without a pose.
  bundleReading(structure, pose) {
    if (!pose.isSolved) return null;
    const found = this.ligaments.flatMap((one) => {
      const bundle = one.layer.bundles.find((own) => own.structure === structure), between = bundle && this.#between(one, pose);
      return between ? [one.layer.reading(bundle, between.X)] : [];
    });
    return found.length === 0 ? null : { strain: Math.max(...found.map(({ strain }) => strain)), tension: found.reduce((total, { tension }) => total + tension, 0) };
  }

  /// Visibility, opacity and highlight of every mesh; `lookOf(structure)`: { visible, opacity, isHighlighted }; `isCut` by a section.
  applyLooks(lookOf, isCut) {
    this.group.traverse((mesh) => {
      const { structure } = mesh.userData;
      if (!structure) return;
      const look = lookOf(structure);
      mesh.visible = look.visible;
      setLook(mesh, { ...look, isCut });
    });
  }

  /// The meshes of structures that are drawn by the page's shader, hence seen and touched.
  pickable() {
    const found = [];
    this.group.traverseVisible((mesh) => { if (mesh.userData.structure && mesh.material.uniforms) found.push(mesh); });
    return found;
  }

  /// The visible meshes of each structure that are translucent, or opaque.
  #byStructure(isTranslucent) {
    const found = new Map();
    for (const mesh of this.pickable().filter(({ layers }) => (layers.mask === 1 << translucentLayer) === isTranslucent)) {
      const { structure } = mesh.userData;
      found.set(structure, [...(found.get(structure) ?? []), mesh]);
    }
    return [...found.values()];
  }

  /// The opaque solid meshes of each part of a body, or the open sheets.
  cuttable(isSheet) { return this.#byStructure(false).map((meshes) => meshes.filter(({ userData }) => userData.isSheet === isSheet)).filter(({ length }) => length > 0); }

  /// [distance, meshes]: the translucent meshes of each structure and their distance from `eye`.
  translucent(eye) {
    const distance = (meshes) => Math.min(...meshes.map((mesh) => {
      if (!mesh.geometry.boundingSphere) mesh.geometry.computeBoundingSphere();
      return mesh.geometry.boundingSphere.center.clone().applyMatrix4(mesh.matrixWorld).distanceTo(eye);
    }));
    return this.#byStructure(true).map((meshes) => [distance(meshes), meshes]);
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
      dot.scale.setScalar(here ? 1 : 0);
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
      const tube = (cells, radius) => { if (cells.length > 1) this.#add(new TubeGeometry(new CatmullRomCurve3(cells.map((cell) => this.#drawn(cell))), 4 * cells.length, radius, 6), material); };
      const pieces = unbroken(path);
      pieces.forEach((piece, k) => {
        tube(piece, tubeRadiusMm);
        // A thin line across a jump to the next piece.
        if (pieces[k + 1]) tube([piece.at(-1), pieces[k + 1][0]], tubeRadiusMm / 3);
      });
      return { path, dot: this.#add(new SphereGeometry(dotRadiusMm, 16, 12), material) };
    });
  }

  #add(geometry, material) {
    const mesh = new Mesh(geometry, material);
    mesh.userData.structure = pathsStructure;
    this.paths.add(mesh);
    return mesh;
  }

  dispose() {
    this.group.traverse((object) => {
      for (const one of [object, object.userData.cut]) {
        one?.geometry?.dispose();
        one?.material?.dispose();
      }
    });
  }
}
