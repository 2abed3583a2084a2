// A mesh for graphics hardware with normals by crease angle; as pipeline/core/draw_mesh.
import { cross, difference, dot, sum } from "./frames.js";

// Edges with a larger angle stay sharp; a meniscus is soft tissue.
const leastCosineOf = (material) => Math.cos((material === "meniscus" ? 150 : 80) / 180 * Math.PI);
// At vertices with more faces all faces are averaged, since the comparison is quadratic.
const mostFacesCompared = 1000;

/// Null for a vector of length 0.
function unitOf(v) {
  const length = Math.sqrt(dot(v, v));
  return length > 0 ? v.map((x) => x / length) : null;
}

/// Area normal (length: twice the area) and unit normal of each non-degenerate triangle.
function facesOf(part, component) {
  const { vertices: p, triangles } = part, faces = [];
  for (let t = 0; t < triangles.length / 3; ++t) {
    if (part.component[t] !== component) continue;
    const vertex = triangles.subarray(3 * t, 3 * t + 3);
    const [a, b, c] = Array.from(vertex, (v) => p.subarray(3 * v, 3 * v + 3));
    const area = cross(difference(b, a), difference(c, a)), unit = unitOf(area);
    if (unit) faces.push({ vertex, area, unit });
  }
  return faces;
}

function facesAround(faces, nVertices) {
  const around = Array.from({ length: nVertices }, () => []);
  for (const face of faces) for (const v of face.vertex) around[v].push(face);
  return around;
}

function cornerNormal(own, around, leastCosine) {
  const isSmooth = ({ unit }) => around.length > mostFacesCompared || dot(unit, own.unit) >= leastCosine;
  return unitOf(around.reduce((normal, face) => (isSmooth(face) ? sum(normal, face.area) : normal), [0, 0, 0])) ?? own.unit;
}

/// The corners of the triangles of one component of a material: positions relative to `origin` (for single precision),
/// normals, and vertex indices.
export function drawMesh(part, component, origin, material) {
  const leastCosine = leastCosineOf(material);
  const faces = facesOf(part, component), around = facesAround(faces, part.vertices.length / 3);
  const positions = new Float32Array(9 * faces.length), normals = new Float32Array(9 * faces.length), vertices = new Int32Array(3 * faces.length);
  faces.forEach((face, f) => face.vertex.forEach((v, corner) => {
    const at = 9 * f + 3 * corner;
    vertices[3 * f + corner] = v;
    for (let k = 0; k < 3; ++k) positions[at + k] = part.vertices[3 * v + k] - origin[k];
    normals.set(cornerNormal(face, around[v], leastCosine), at);
  }));
  return { positions, normals, vertices };
}
