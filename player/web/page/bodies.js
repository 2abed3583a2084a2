// The meshes of a body: contact and visual parts.
import { refuse } from "./model_error.js";

function checkIndices(field, indices, count) {
  for (const index of indices) {
    if (index < 0 || index >= count) refuse(field, `row ${index}`, `0 to ${count - 1}`);
  }
}

function part(file, group, nComponents) {
  const vertices = file.numbers(`${group}/vertices`, [null, 3]);
  const triangles = file.numbers(`${group}/triangles`, [null, 3], "int32");
  const component = file.numbers(`${group}/component`, [triangles.length / 3], "int32");
  if (!vertices.every(Number.isFinite)) refuse(`${group}/vertices`, "a coordinate that is not a finite number", "finite numbers");
  checkIndices(`${group}/triangles`, triangles, vertices.length / 3);
  checkIndices(`${group}/component`, component, nComponents);
  return { vertices, triangles, component };
}

/// { components: [{ name, material }], parts: [{ vertices, triangles, component }] }; mm, canonical.
export function readBodies(file, name) {
  const group = `/bodies/${name}`;
  const names = file.texts(`${group}/component_name`), materials = file.texts(`${group}/component_material`);
  if (names.length !== materials.length) refuse(`${group}/component_material`, `${materials.length} materials`, `${names.length}`);
  const parts = [part(file, group, names.length)];
  if (file.hasGroup(`${group}/visual`)) parts.push(part(file, `${group}/visual`, names.length));
  return { name: file.attribute("name", group)?.[0] ?? name, components: names.map((own, k) => ({ name: own, material: materials[k] })), parts };
}
