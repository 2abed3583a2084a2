// A mesh for graphics hardware with normals by crease angle; as pipeline/core/draw_mesh.

const leastCosine = Math.cos(80 / 180 * Math.PI);  // edges with a larger angle stay sharp
// At vertices with more faces all faces are averaged, since the comparison is quadratic.
const mostFacesCompared = 1000;

/// Area normal (length: twice the area) and unit normal of each non-degenerate triangle.
function facesOf(part, component) {
  const { vertices: p, triangles } = part, faces = [];
  for (let t = 0; t < triangles.length / 3; ++t) {
    if (part.component[t] !== component) continue;
    const vertex = triangles.subarray(3 * t, 3 * t + 3);
    const [a, b, c] = [3 * vertex[0], 3 * vertex[1], 3 * vertex[2]];
    const u = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]], v = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length > 0) faces.push({ vertex, area: n, unit: [n[0] / length, n[1] / length, n[2] / length] });
  }
  return faces;
}

function facesAround(faces, nVertices) {
  const around = Array.from({ length: nVertices }, () => []);
  for (const face of faces) for (const v of face.vertex) around[v].push(face);
  return around;
}

function cornerNormal(own, around) {
  let x = 0, y = 0, z = 0;
  for (const { unit, area } of around) {
    const isSmooth = around.length > mostFacesCompared || unit[0] * own.unit[0] + unit[1] * own.unit[1] + unit[2] * own.unit[2] >= leastCosine;
    if (isSmooth) [x, y, z] = [x + area[0], y + area[1], z + area[2]];
  }
  const length = Math.sqrt(x * x + y * y + z * z);
  return length > 0 ? [x / length, y / length, z / length] : own.unit;
}

/// The corners of one component's triangles: positions relative to `origin` (for single precision), normals, and vertex
/// indices.
export function drawMesh(part, component, origin) {
  const faces = facesOf(part, component), around = facesAround(faces, part.vertices.length / 3);
  const positions = new Float32Array(9 * faces.length), normals = new Float32Array(9 * faces.length), vertices = new Int32Array(3 * faces.length);
  faces.forEach((face, f) => face.vertex.forEach((v, corner) => {
    const at = 9 * f + 3 * corner;
    vertices[3 * f + corner] = v;
    for (let k = 0; k < 3; ++k) positions[at + k] = part.vertices[3 * v + k] - origin[k];
    normals.set(cornerNormal(face, around[v]), at);
  }));
  return { positions, normals, vertices };
}
