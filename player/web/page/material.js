// Materials, lights and shader; values as in pipeline/model/mesh and player/view.
// Colours are linear RGB on [0, 1].
import { AlwaysStencilFunc, BackSide, BufferAttribute, BufferGeometry, Color, Data3DTexture, DecrementWrapStencilOp, DoubleSide, EqualDepth, FrontSide, IncrementWrapStencilOp, LessDepth, LessEqualDepth, LinearFilter, Mesh, MeshBasicMaterial, NoBlending, NotEqualStencilFunc, RedFormat, RepeatWrapping, ShaderMaterial, Vector3, Vector4 } from "three";

const materials = {
  bone: { colour: [0.839, 0.745, 0.591], specular: 0.1, shininess: 24, mottling: 0.13 },
  cartilage: { colour: [0.617, 0.73, 0.776], specular: 0.3, shininess: 60, mottling: 0.03 },
  meniscus: { colour: [0.617, 0.231, 0.168], specular: 0.22, shininess: 24, mottling: 0.09 },
  other: { colour: [0.402, 0.456, 0.503], specular: 0.12, shininess: 30, mottling: 0 },
};
// Markers, as marker_material of player/view/scene.
const marker = { colour: [1, 1, 1], specular: 0.18, shininess: 40, mottling: 0 };

const parametersOf = (name) => materials[name] ?? materials.other;
export const colourOf = (name) => parametersOf(name).colour;

const sky = [0.19, 0.21, 0.25], ground = [0.075, 0.065, 0.06];
// Directions to the lights in camera axes: key, fill, rim.
const lights = [
  { direction: [-0.5, 0.7, 0.7], colour: [0.8, 0.775, 0.72] },
  { direction: [0.85, 0.05, 0.5], colour: [0.19, 0.22, 0.27] },
  { direction: [0.25, 0.55, -0.8], colour: [0.4, 0.42, 0.46] },
];

const cutBrightness = 0.8;

const vertexShader = `
varying vec3 p_surface;  // mesh frame, mm: the mottling moves with the bone
varying vec3 p_world;
varying vec3 p_camera;
varying vec3 n_camera;
varying vec3 up_camera;
#ifdef USE_COLOR
varying vec3 colour_surface;
#endif
void main() {
#ifdef USE_COLOR
  colour_surface = color;
#endif
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  p_surface = position;
  p_world = (modelMatrix * vec4(position, 1.0)).xyz;
  p_camera = p.xyz;
  n_camera = normalMatrix * normal;
  up_camera = mat3(viewMatrix) * vec3(0.0, 1.0, 0.0);
  gl_Position = projectionMatrix * p;
}`;

const fragmentShader = `
varying vec3 p_surface;
varying vec3 p_world;
varying vec3 p_camera;
varying vec3 n_camera;
varying vec3 up_camera;
uniform vec3 colour;
uniform float opacity;
uniform float specular;
uniform float shininess;
uniform float mottling;
uniform vec3 sky;
uniform vec3 ground;
uniform vec3 light_direction[3];
uniform vec3 light_colour[3];
uniform float highlight;
uniform vec4 section;  // what is removed: dot(section.xyz, p_world) > section.w
#ifdef USE_COLOR
varying vec3 colour_surface;
#endif
uniform highp sampler3D lattice;
#ifdef TRANSLUCENT
uniform sampler2D solid_depth;
uniform bool is_behind_solid;  // whether surfaces behind solid_depth are hidden
#endif

float value_noise(vec3 p) {
  vec3 whole = floor(p), s = p - whole;
  return texture(lattice, (whole + s * s * (3.0 - 2.0 * s) + 0.5) / float(textureSize(lattice, 0).x)).r;
}

// Mean zero; patches of 11 mm and grain of 2 mm.
float mottle(vec3 p_mm) {
  return 1.2 * (value_noise(p_mm * 0.09) - 0.5) + 0.5 * (value_noise(p_mm * 0.5 + 17.0) - 0.5);
}

void main() {
  // Only where they are needed: with a discard the hidden pixels are shaded, too.
#ifdef CUT
  if (dot(section.xyz, p_world) > section.w) discard;
#endif
#ifdef TRANSLUCENT
  if (is_behind_solid && gl_FragCoord.z > texelFetch(solid_depth, ivec2(gl_FragCoord.xy), 0).r + 1e-6) discard;
#endif
  vec3 n = normalize(n_camera);
  if (!gl_FrontFacing) n = -n;
  vec3 to_eye = normalize(-p_camera);
  vec3 diffuse = mix(ground, sky, 0.5 + 0.5 * dot(n, up_camera));
  vec3 shine = vec3(0.0);
  for (int i = 0; i < 3; ++i) {
    float facing = dot(n, light_direction[i]);
    if (facing <= 0.0) continue;
    diffuse += facing * light_colour[i];
    vec3 half_way = normalize(light_direction[i] + to_eye);
    shine += light_colour[i] * pow(max(dot(n, half_way), 0.0), shininess);
  }
  vec3 base = colour;
#ifdef USE_COLOR
  base = colour_surface;
#endif
  // Darker patches are warmer: blue falls more than red.
  if (mottling > 0.0) base *= vec3(1.0) + mottling * mottle(p_surface) * vec3(0.8, 1.1, 1.6);
  vec3 lit = base * diffuse + specular * shine;
  // Of a cut solid the inner sides are seen through the section, which fill its outline with a flat colour.
#ifdef FILLED
  if (!gl_FrontFacing && section.xyz != vec3(0.0)) lit = ${cutBrightness} * base;
#endif
  // A highlighted structure glows, most along its outline.
  lit += highlight * vec3(0.0, 0.35, 0.6) * (0.25 + pow(1.0 - abs(dot(n, to_eye)), 2.0));
  gl_FragColor = vec4(lit, opacity);
  #include <colorspace_fragment>
}`;

const uniform = (value) => ({ value });

/// The hash of the window's shaders (Jarzynski and Olano 2020, pcg3d) at lattice points, which repeat after 32.
function latticeTexture() {
  const n = 32, values = new Uint8Array(n ** 3), { imul } = Math;
  for (let k = 0; k < n ** 3; ++k) {
    let [x, y, z] = [k % n, Math.floor(k / n) % n, Math.floor(k / n ** 2)].map((c) => imul(c, 1664525) + 1013904223);
    x += imul(y, z); y += imul(z, x); z += imul(x, y);
    [x, y, z] = [x, y, z].map((c) => c ^ (c >>> 16));
    values[k] = (x + imul(y, z)) >>> 24;
  }
  const made = new Data3DTexture(values, n, n, n);
  Object.assign(made, { format: RedFormat, minFilter: LinearFilter, magFilter: LinearFilter, wrapS: RepeatWrapping, wrapT: RepeatWrapping, wrapR: RepeatWrapping, needsUpdate: true });
  return made;
}
const lattice = uniform(latticeTexture());

/// The material of that name; grey if unknown.
export const materialOf = (name) => shaded(parametersOf(name), false);
/// The same with linear vertex colours instead of its colour.
export const colouredMaterialOf = (name) => shaded({ ...parametersOf(name), mottling: 0 }, true);
export const markerMaterial = () => shaded(marker, true);

/// Translucent, and hidden by surfaces that are less than `depthOffsetMm` behind it: nearly coincident ones would show as patches.
export function ghostMaterial(colour, opacity, depthOffsetMm) {
  const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity, depthWrite: false });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace("#include <project_vertex>", `#include <project_vertex>
  vec4 behind = projectionMatrix * (mvPosition - vec4(0.0, 0.0, ${depthOffsetMm.toFixed(1)} * length(modelViewMatrix[0].xyz), 0.0));
  gl_Position.z = behind.z / behind.w * gl_Position.w;`);
  };
  return material;
}

const noSection = new Vector4(0, 0, 0, 1), section = uniform(noSection.clone());

/// What is removed of all meshes: the side of the plane dot(normal, p) = at on which `eye` is; mm, drawn axes. Null: nothing.
export function setSection(plane, eye) {
  if (!plane) return section.value.copy(noSection);
  const side = isAbove(plane, eye) ? 1 : -1;
  return section.value.set(...plane.normal.map((x) => side * x), side * plane.at);
}

const isAbove = ({ normal, at }, p) => normal[0] * p.x + normal[1] * p.y + normal[2] * p.z > at;

/// Whether a point is on the removed side: that of the eye.
export const isRemoved = (plane, point, eye) => isAbove(plane, point) === isAbove(plane, eye);

/// Opacity and highlight of a mesh, and whether its inner sides are drawn; a thin one keeps its colour, which has a meaning. Materials without a shader of this page are blended as usual.
export function setLook({ material, layers, userData }, { opacity, isHighlighted, isCut }) {
  const isSolid = opacity === 1, { uniforms } = material;
  if (!uniforms) return Object.assign(material, { opacity, transparent: !isSolid });
  uniforms.opacity.value = opacity;
  const { isSheet, isThin } = userData, side = isCut || isThin || isSheet ? DoubleSide : FrontSide;
  const defines = { ...(isCut && { CUT: 1 }), ...(isCut && !isSheet && { FILLED: 1 }), ...(!isSolid && { TRANSLUCENT: 1 }) };
  if (material.side !== side || Object.keys(defines).join() !== Object.keys(material.defines).join()) Object.assign(material, { side, defines, needsUpdate: true });
  uniforms.highlight.value = isHighlighted ? (isThin ? 0.1 : 1) : 0;
  if (isSolid === material.transparent) {
    Object.assign(material, { transparent: !isSolid, depthWrite: isSolid });
    layers.set(isSolid ? 0 : translucentLayer);
  }
}

/// Layer of translucent meshes, which are drawn after the solid ones: 1 and 2 are those of a headset's eyes.
export const translucentLayer = 3;

/// Draws one translucent structure by `draw(mesh)`: first the depth of its nearest surfaces, then only these, so that its parts do not
/// show through each other. `solidDepth`: the texture of the depth of the solid surfaces. The depth buffer must be clear.
export function drawTranslucent(meshes, solidDepth, draw) {
  for (const isColour of [false, true]) {
    for (const mesh of meshes) {
      const { material } = mesh, { solid_depth: depth, is_behind_solid: isBehind } = material.uniforms;
      [depth.value, isBehind.value] = [solidDepth, true];
      Object.assign(material, { colorWrite: isColour, depthWrite: !isColour, depthFunc: isColour ? EqualDepth : LessDepth });
      draw(mesh);
      Object.assign(material, { colorWrite: true, depthWrite: false, depthFunc: LessEqualDepth });
      [depth.value, isBehind.value] = [null, false];  // a texture that is drawn into must not be read
    }
  }
}

/// Draws meshes in the colour of the number numberOf(mesh).
export function drawNumbers(meshes, numberOf, draw) {
  for (const mesh of meshes) {
    const { material } = mesh;
    mesh.material = numberMaterial;
    numberMaterial.uniforms.number.value = numberOf(mesh) / 255;
    numberMaterial.uniformsNeedUpdate = true;
    draw(mesh);
    mesh.material = material;
  }
}

// Caps of cut solids: back faces minus front faces of what remains is above 0 where the section is inside the solid.
const flat = {
  vertexShader: "varying vec3 p_world; void main() { vec4 p = modelMatrix * vec4(position, 1.0); p_world = p.xyz; gl_Position = projectionMatrix * viewMatrix * p; }",
  fragmentShader: "varying vec3 p_world; uniform vec4 section; uniform float number; void main() { if (dot(section.xyz, p_world) > section.w) discard; gl_FragColor = vec4(number); }",
};
const numberMaterial = new ShaderMaterial({ ...flat, uniforms: { section, number: uniform(0) }, side: DoubleSide, blending: NoBlending });
const counter = (side, stencilZPass) => new ShaderMaterial({
  ...flat, uniforms: { section, number: uniform(1) }, side, colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true, stencilFunc: AlwaysStencilFunc, stencilZPass,
});
const counters = [counter(BackSide, IncrementWrapStencilOp), counter(FrontSide, DecrementWrapStencilOp)];
export const capMaterial = () => new MeshBasicMaterial({ side: DoubleSide, stencilWrite: true, stencilFunc: NotEqualStencilFunc, stencilRef: 0 });

// The cut of an open sheet, which has no inside: a dark line, as in the window.
const lineMm = 0.6, lineBrightness = 0.24;

/// The triangles of the cut of meshes on the plane through `height` normal to the unit vector `n`: corners, mm.
function cutOf(meshes, n, height) {
  const corners = [], p = [new Vector3(), new Vector3(), new Vector3()];
  for (const { geometry, matrixWorld } of meshes) {
    const position = geometry.getAttribute("position");
    for (let k = 0; k < position.count; k += 3) {
      const above = p.map((corner, i) => corner.fromBufferAttribute(position, k + i).applyMatrix4(matrixWorld).dot(n) - height);
      const ends = [0, 1, 2].filter((i) => above[i] > 0 !== above[(i + 1) % 3] > 0).map((i) => p[i].clone().lerp(p[(i + 1) % 3], above[i] / (above[i] - above[(i + 1) % 3])));
      if (ends.length === 0) continue;
      const [from, to] = ends, along = to.clone().sub(from).setLength(lineMm / 2), across = n.clone().cross(along);
      // Square ends, so that a bent line has no gaps.
      const [a, b] = [from.clone().sub(along), to.clone().add(along)], [c, d] = [a, b].map((end) => end.clone().add(across));
      for (const corner of [a.sub(across), b.sub(across), d, a, d, c]) corners.push(...corner);
    }
  }
  return corners;
}

/// Draws the cut of the meshes of one structure on the section's plane. It is kept, with the first mesh, until the plane or a mesh moves.
export function drawSheetCut(meshes, { normal, at }, draw) {
  const own = meshes[0].userData, length = Math.hypot(...normal);
  const key = [...normal, at, ...meshes.flatMap(({ matrixWorld }) => matrixWorld.elements)].join();
  own.cut ??= new Mesh(new BufferGeometry(), new MeshBasicMaterial({ side: DoubleSide }));
  const { geometry, material, userData } = own.cut;
  if (userData.key !== key) {
    userData.key = key;
    geometry.dispose();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(cutOf(meshes, new Vector3(...normal).divideScalar(length), at / length)), 3));
    geometry.boundingSphere = null;
  }
  material.color.copy(meshes[0].material.uniforms.colour.value).multiplyScalar(lineBrightness);
  draw(own.cut);
}

/// Draws the cap of one solid, given by its meshes, on the plane `cap`; the stencil buffer must be clear.
export function drawCap(meshes, cap, draw) {
  for (const count of counters) {
    for (const mesh of meshes) {
      const { material } = mesh;
      mesh.material = count;
      draw(mesh);
      mesh.material = material;
    }
  }
  cap.material.color.copy(meshes[0].material.uniforms.colour.value).multiplyScalar(cutBrightness);
  draw(cap);
}

function shaded(parameters, hasColours) {
  return new ShaderMaterial({
    vertexShader,
    fragmentShader,
    vertexColors: hasColours,
    // The tubes of markers have open ends.
    side: parameters === marker ? DoubleSide : FrontSide,
    uniforms: {
      colour: uniform(new Color(...parameters.colour)),
      opacity: uniform(1),
      highlight: uniform(0),
      solid_depth: uniform(null),
      is_behind_solid: uniform(false),
      section,
      lattice,
      specular: uniform(parameters.specular),
      shininess: uniform(parameters.shininess),
      mottling: uniform(parameters.mottling),
      sky: uniform(new Color(...sky)),
      ground: uniform(new Color(...ground)),
      light_direction: uniform(lights.map(({ direction }) => new Vector3(...direction).normalize())),
      light_colour: uniform(lights.map(({ colour }) => new Color(...colour))),
    },
  });
}
