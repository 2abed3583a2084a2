// The joint at the pose shown as USDZ (Apple phones): metres, Y up, standing on its lowest point.
import { BufferAttribute, BufferGeometry, Color, Group, Mesh, MeshStandardMaterial, Vector3 } from "three";
import { USDZExporter } from "three/examples/jsm/exporters/USDZExporter.js";
import { colourOf } from "./material.js";
import { mmPerM } from "./placement.js";

const roughness = 0.6;

const solid = (colour) => new MeshStandardMaterial({ color: new Color(...colour), roughness, metalness: 0 });

/// Each run of rings of the ligaments with one colour, as its own mesh: USDZ viewers show no colours of vertices.
function* fibresOf(mesh) {
  const { index } = mesh.geometry, colour = mesh.geometry.getAttribute("color");
  const keyOf = (k) => [0, 1, 2].map((c) => colour.array[3 * index.array[k] + c].toFixed(4)).join();
  const groups = new Map();
  for (let k = 0; k < index.count; k += 3) {
    const key = keyOf(k);
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(index.array[k], index.array[k + 1], index.array[k + 2]);
  }
  for (const [key, indices] of groups) {
    const used = [...new Set(indices)], places = new Map(used.map((vertex, k) => [vertex, k])), geometry = new BufferGeometry();
    for (const name of ["position", "normal"]) {
      const { array } = mesh.geometry.getAttribute(name);
      geometry.setAttribute(name, new BufferAttribute(new Float32Array(used.flatMap((vertex) => [...array.subarray(3 * vertex, 3 * vertex + 3)])), 3));
    }
    geometry.setIndex(indices.map((vertex) => places.get(vertex)));
    yield { geometry, colour: key.split(",").map(Number) };
  }
}

/// The bytes of the file.
export async function usdzOf(joint, hasLigaments) {
  const turned = new Group(), made = [], place = new Vector3();
  let lowest = Infinity;
  for (const [name, body] of Object.entries(joint.bodies)) {
    const group = new Group();
    group.name = name;
    group.matrixAutoUpdate = false;
    group.matrix.copy(body.matrix);
    for (const mesh of body.children.filter((child) => child.isMesh)) {
      const part = new Mesh(mesh.geometry, solid(colourOf(mesh.userData.material)));
      part.name = mesh.name;
      made.push(part.material);
      group.add(part);
      const position = mesh.geometry.getAttribute("position");
      for (let k = 0; k < position.count; ++k) lowest = Math.min(lowest, place.fromBufferAttribute(position, k).applyMatrix4(body.matrix).y);
    }
    if (name === "reference" && hasLigaments && joint.ligaments) {
      let k = 0;
      for (const { geometry, colour } of fibresOf(joint.ligaments.mesh)) {
        const part = new Mesh(geometry, solid(colour));
        part.name = `ligaments_${++k}`;
        made.push(part.material, geometry);
        group.add(part);
      }
    }
    turned.add(group);
  }
  // Anterior (X) becomes the viewer's side (Z), as in the .glb of vrda export.
  turned.rotation.y = -Math.PI / 2;
  turned.position.y = -lowest / mmPerM;
  turned.scale.setScalar(1 / mmPerM);
  const scene = new Group();
  scene.add(turned);
  scene.updateMatrixWorld(true);
  try {
    return await new USDZExporter().parseAsync(scene, { quickLookCompatible: true, onlyVisible: false });
  } finally {
    for (const one of made) one.dispose();
  }
}

export function save(bytes, name, type) {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  Object.assign(document.createElement("a"), { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}
