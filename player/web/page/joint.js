// The joint as three.js sees it: two groups of meshes, each under the pose of its body, and the contact paths on the moving one.
import { BufferAttribute, BufferGeometry, CatmullRomCurve3, Group, Mesh, MeshBasicMaterial, SphereGeometry, TubeGeometry, Vector3 } from "three";
import { compartmentColours, pathAlong, unbroken } from "./contact_paths.js";
import { drawMesh } from "./draw_mesh.js";
import { transposed, turned } from "./frames.js";
import { materialOf } from "./material.js";

const tubeRadiusMm = 0.5, dotRadiusMm = 1.6;

function meshesOf(body, origin) {
  const meshes = [];
  body.parts.forEach((part, k) => body.components.forEach(({ name, material }, component) => {
    const { positions, normals } = drawMesh(part, component, origin);
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

export class Joint {
  constructor(model) {
    this.model = model;
    this.group = new Group();
    // Meshes are kept relative to the rotation centre; `place` adds it back.
    this.bodies = {};
    for (const name of ["reference", "moving"]) {
      const group = this.bodies[name] = new Group();
      group.matrixAutoUpdate = false;
      group.add(...meshesOf(model.bodies[name], model.rotationCentre));
      this.group.add(group);
    }
    this.paths = new Group();
    this.bodies.moving.add(this.paths);
  }

  get meshes() { return [...this.bodies.reference.children, ...this.bodies.moving.children].filter((child) => child.isMesh); }

  /// `held`: the body that stands still on screen.
  place(pose, held) {
    const back = held === "reference" ? transposed(pose.reference.R) : null;
    for (const name of ["reference", "moving"]) {
      const { R, t } = pose[name], c = this.model.rotationCentre;
      const shift = turned(R, c).map((x, k) => x + t[k]);
      const [Q, s] = back ? [R.map((_, r) => [0, 1, 2].map((k) => back[r][0] * R[0][k] + back[r][1] * R[1][k] + back[r][2] * R[2][k])), turned(back, shift)] : [R, shift];
      this.bodies[name].matrix.set(...Q[0], s[0], ...Q[1], s[1], ...Q[2], s[2], 0, 0, 0, 1);
    }
    this.group.updateMatrixWorld(true);
  }

  /// Contact paths on the moving body, one column of varus a flexion, and a dot where it bears now.
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
      const material = new MeshBasicMaterial({ color: compartmentColours[compartment], depthTest: false, transparent: true });
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
    mesh.renderOrder = 10;  // over everything: bones and menisci would hide them
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
