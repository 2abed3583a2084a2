// The 3-D view, and the joint as a file for phones.
import { Box3, BufferAttribute, BufferGeometry, Color, DepthStencilFormat, DepthTexture, Group, MathUtils, Mesh, MeshBasicMaterial, MeshStandardMaterial, MOUSE, NoBlending, OrthographicCamera, PerspectiveCamera, PlaneGeometry, Raycaster, Scene, SRGBColorSpace, UnsignedInt248Type, Vector2, Vector3, Vector4, WebGLRenderer, WebGLRenderTarget } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { USDZExporter } from "three/examples/jsm/exporters/USDZExporter.js";
import { unnamed } from "./labels.js";
import { capMaterial, colourOf, drawCap, drawNumbers, drawSheetCut, drawTranslucent, isRemoved, setSection, translucentLayer } from "./material.js";
import { mmPerM } from "./placement.js";

// The 3-D view: camera, trackball, named views. Renders only after changes.

const fieldOfViewDeg = 22;  // as in vrda-player
const filled = 0.92;
const clearance = 10;  // mm, as in the window
const capMm = 1000;
// While something moves: as many pixels as a frame of this time allows; what moved is drawn sharp when so many frames passed without change.
const fastMs = 30, slowMs = 60, leastSharpness = 0.35, stillFrames = 3;
const stillPx = 5, fingerPx = 12, mousePx = 4;
const flatCamera = new OrthographicCamera(-1, 1, 1, -1, -1, 1);
const X = new Vector3(1, 0, 0), Y = new Vector3(0, 1, 0), Z = new Vector3(0, 0, 1);

/// Directions from the joint to the camera in canonical axes, as in player/view/camera.
export const views = {
  oblique: (lateral) => X.clone().addScaledVector(lateral, 0.75).addScaledVector(Y, 0.45),
  front: () => X.clone(),
  back: () => X.clone().negate(),
  medial: (lateral) => lateral.clone().negate(),
  lateral: (lateral) => lateral.clone(),
  top: () => Y.clone().addScaledVector(X, -1e-3),  // slightly tilted, since "up" is undefined for a vertical view
};

/// Axes of a camera without a roll.
function uprightAxes(eye, target) {
  const back = eye.clone().sub(target).normalize(), right = Y.clone().cross(back);
  if (right.length() > 1e-6) right.normalize();
  else right.copy(Z);
  return { right, up: back.cross(right) };
}

/// The canvas: camera, controls and the joint shown.
export class Viewer {
  constructor(canvas) {
    this.canvas = canvas;
    // Without WebGL the page still has numbers and plots.
    const hasWebGl = Boolean(document.createElement("canvas").getContext("webgl2"));
    this.renderer = hasWebGl ? new WebGLRenderer({ canvas, antialias: true, alpha: true, stencil: true }) : null;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(fieldOfViewDeg, 1, 1, 10000);
    this.ray = new Raycaster();
    this.ray.layers.enable(translucentLayer);
    const depthTexture = new DepthTexture(1, 1, UnsignedInt248Type);
    depthTexture.format = DepthStencilFormat;
    this.solid = new WebGLRenderTarget(1, 1, { depthTexture, stencilBuffer: true });
    // Without smoothed edges, which take most of the time without a graphics card.
    this.quick = new WebGLRenderTarget(1, 1, { stencilBuffer: true, colorSpace: SRGBColorSpace });
    this.numbers = new WebGLRenderTarget(1, 1);
    this.copy = new Mesh(new PlaneGeometry(2, 2), new MeshBasicMaterial({ map: this.quick.texture, blending: NoBlending }));
    this.cap = new Mesh(new PlaneGeometry(2 * capMm, 2 * capMm), capMaterial());
    this.controls = new OrbitControls(this.camera, canvas);
    // As in the window: left turns, right moves in the image plane, middle and wheel move in depth.
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    this.onDrawn = () => {};
    this.onStill = () => {};
    this.framesLeft = 0;  // in which a change belongs to a motion
    this.section = null;  // { normal, at }, as in setSection
    this.onLost = () => {};  // (isLost)
    this.onTouch = () => {};  // ({ x, y, reachPx }) of a click or tap, in pixels of the picture
    this.onTurned = () => {};  // the user moved the camera
    // The renderer makes its objects again before this listener draws them.
    for (const [event, isLost] of [["webglcontextlost", true], ["webglcontextrestored", false]]) {
      canvas.addEventListener(event, () => {
        this.onLost(isLost);
        this.redraw();
      });
    }
    // Before the controls move the camera: not into what is in the middle of the picture.
    canvas.addEventListener("wheel", () => this.#stopAtSurface(), { capture: true });
    canvas.addEventListener("pointermove", ({ buttons, pointerType }) => { if (buttons === 4 || pointerType === "touch") this.#stopAtSurface(); }, { capture: true });
    this.controls.addEventListener("change", () => this.redraw());
    this.#watchTouch();
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
  }

  /// A press that is released where it began is a touch; one that moves turns the joint.
  #watchTouch() {
    const { canvas } = this;
    let from = null;
    canvas.addEventListener("pointerdown", ({ clientX, clientY, button, isPrimary }) => { from = button === 0 && isPrimary ? [clientX, clientY] : null; });
    canvas.addEventListener("pointermove", ({ clientX, clientY }) => { if (from && Math.hypot(clientX - from[0], clientY - from[1]) > stillPx) from = null; });
    canvas.addEventListener("pointerup", ({ clientX, clientY, pointerType }) => {
      const box = canvas.getBoundingClientRect();
      if (from && this.joint && !this.isLent) this.onTouch({ x: clientX - box.left, y: clientY - box.top, reachPx: pointerType === "touch" ? fingerPx : mousePx });
      from = null;
    });
    // The controls report a start at every press: only a moved camera counts.
    let place = "";
    this.controls.addEventListener("start", () => { place = JSON.stringify(this.place); });
    this.controls.addEventListener("end", () => { if (place !== JSON.stringify(this.place)) this.onTurned(); });
  }

  show(joint) {
    this.joint?.dispose();
    if (this.joint) this.scene.remove(this.joint.group);
    this.joint = joint;
    this.scene.add(joint.group);
    this.lateral = joint.model.side === "left" ? Z.clone().negate() : Z.clone();
  }

  /// A second joint, or null: beside the first, in the right half, or over it.
  showOther(joint, isSide) {
    if (this.other) this.scene.remove(this.other.group);
    if (joint) this.scene.add(joint.group);
    [this.other, this.isSide] = [joint, isSide];
    this.#resize();
  }

  /// The joints of each pane, from left to right.
  get #panes() {
    if (!this.other) return [this.joint ? [this.joint] : []];
    return this.isSide ? [[this.joint], [this.other]] : [[this.joint, this.other]];
  }

  /// The joint is drawn in another space until takeBack().
  lend() {
    this.isLent = true;
    setSection(null);
    this.scene.remove(this.joint.group);
  }

  takeBack() {
    this.isLent = false;
    if (this.joint) this.scene.add(this.joint.group);
    this.#resize();
  }

  #resize() {
    if (this.isLent) return;
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer?.setSize(clientWidth, clientHeight, false);
    this.#sharpen(1);
    this.camera.aspect = clientWidth / this.#panes.length / clientHeight;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  /// Points of the meshes at the present placement: within the sphere around the joint, or all.
  #points(isWhole) {
    const box = (name) => this.joint.bodies[name].children.filter((m) => m.isMesh && m.userData.hasContact)
      .reduce((all, mesh) => all.union(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrixWorld)), new Box3());
    const reference = box("reference"), moving = box("moving");
    // If the boxes are separate along an axis, low exceeds high and their mean is the centre of the gap.
    const low = reference.min.clone().max(moving.min), high = reference.max.clone().min(moving.max);
    const centre = low.clone().add(high).multiplyScalar(0.5);
    const radius = isWhole ? Infinity : 0.85 * Math.max(high.x - low.x, high.z - low.z, 1);
    const points = [], p = new Vector3();
    for (const mesh of this.joint.meshes) {
      const position = mesh.geometry.getAttribute("position");
      for (let k = 0; k < position.count; ++k) {
        p.fromBufferAttribute(position, k).applyMatrix4(mesh.matrixWorld);
        if (p.distanceTo(centre) <= radius) points.push(p.clone());
      }
    }
    return { points, centre };
  }

  /// Fits the camera to the joint at all poses of `placeEach`.
  fitCamera(name, isWhole, placeEach) {
    const from = views[name](this.lateral).normalize();
    const right = new Vector3().crossVectors(name === "top" ? X : Y, from).normalize(), up = new Vector3().crossVectors(from, right);
    const ty = filled * Math.tan((fieldOfViewDeg * Math.PI) / 360), tx = ty * this.camera.aspect;
    const wide = [Infinity, -Infinity], tall = [Infinity, -Infinity], depth = [Infinity, -Infinity], middle = new Vector3();
    let nPoses = 0;
    const widen = (wedge, low, high) => { wedge[0] = Math.min(wedge[0], low); wedge[1] = Math.max(wedge[1], high); };
    placeEach(() => {
      const { points, centre } = this.#points(isWhole);
      middle.add(centre);
      ++nPoses;
      for (const p of points) {
        const x = p.dot(right), y = p.dot(up), z = p.dot(from);
        // Inside for a camera at c when |p_x - c_x| <= t (c_z - p_z); the same for y.
        widen(wide, x - tx * z, x + tx * z);
        widen(tall, y - ty * z, y + ty * z);
        widen(depth, z, z);
      }
    });
    middle.divideScalar(nPoses);
    const distance = Math.max((wide[1] - wide[0]) / (2 * tx), (tall[1] - tall[0]) / (2 * ty));
    const eye = new Vector3().addScaledVector(right, (wide[0] + wide[1]) / 2).addScaledVector(up, (tall[0] + tall[1]) / 2).addScaledVector(from, distance);
    this.controls.target.copy(eye).addScaledVector(from, middle.dot(from) - distance);
    this.camera.position.copy(eye);
    this.#setUp(Y);
    this.controls.minDistance = 0;
    const size = depth[1] - depth[0] + distance;
    this.camera.near = size / 200;
    this.camera.far = 5 * size;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.redraw();
  }

  /// Depth of the nearest surface about the middle of the picture, mm.
  seen() {
    const meshes = this.joint.meshes.filter((mesh) => mesh.visible && mesh.parent.visible), camera = this.camera;
    return Math.min(...[[0, 0], [-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]].map((at) => {
      this.ray.setFromCamera(new Vector2(...at), camera);
      const [hit] = this.ray.intersectObjects(meshes, false);
      return hit ? -hit.point.applyMatrix4(camera.matrixWorldInverse).z : Infinity;
    }));
  }

  /// The camera may come as near to the target as leaves `clearance` in front of that surface.
  #stopAtSurface() {
    if (!this.joint || this.isLent) return;
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.controls.minDistance = Math.min(distance, Math.max(0, distance - this.seen() + Math.max(clearance, 1.1 * this.camera.near)));
  }

  /// The structure at a place of the picture in pixels: [{ mesh, point }] of the nearest one that is at least half opaque, else of the
  /// nearest. `reachPx`: a thin structure counts when it is so near, for fingers.
  pick(x, y, reachPx) {
    const panes = this.#panes, { clientHeight } = this.canvas, width = this.canvas.clientWidth / panes.length, pane = Math.min(Math.floor(x / width), panes.length - 1);
    const meshes = panes[pane].flatMap((joint) => joint.pickable());
    const at = (dx, dy) => {
      this.ray.setFromCamera(new Vector2((2 * (x - pane * width + dx)) / width - 1, 1 - (2 * (y + dy)) / clientHeight), this.camera);
      const hits = this.ray.intersectObjects(meshes, false).filter(({ point }) => !this.isCut(point));
      return hits.find(({ object }) => object.material.uniforms.opacity.value >= 0.5) ?? hits[0];
    };
    const hit = at(0, 0), isThin = (one) => one?.object.userData.isThin;
    const around = isThin(hit) ? hit : [[-1, 0], [1, 0], [0, -1], [0, 1]].map(([dx, dy]) => at(dx * reachPx, dy * reachPx)).find(isThin) ?? hit;
    return around && { structure: around.object.userData.structure, mesh: around.object, point: around.point };
  }

  /// { ids, columns, rows }: the number numberOf(structure) of what is seen at every `step` pixels of the picture; `unnamed` if that is negative, `nothing` beside
  /// the joint. Faded structures hide nothing.
  seenIds(numberOf, step, joint = this.joint) {
    const { renderer, camera, numbers } = this, columns = Math.ceil(this.canvas.clientWidth / this.#panes.length / step), rows = Math.ceil(this.canvas.clientHeight / step);
    const bytes = new Uint8Array(4 * columns * rows), colour = renderer.getClearColor(new Color()), alpha = renderer.getClearAlpha();
    const number = ({ userData }) => { const k = numberOf(userData.structure); return k < 0 ? unnamed : k; };
    numbers.setSize(columns, rows);
    renderer.setRenderTarget(numbers);
    renderer.setClearColor(new Color().setRGB(1, 1, 1), 1);
    renderer.clear();
    renderer.autoClear = false;
    camera.layers.enable(translucentLayer);
    const meshes = joint?.pickable() ?? [], isFaded = ({ material }) => material.uniforms.opacity.value < 0.5;
    for (const [own, isOver] of [[meshes.filter(isFaded), false], [meshes.filter((mesh) => !isFaded(mesh)), true]]) {
      if (isOver) renderer.clearDepth();
      drawNumbers(own, number, (mesh) => renderer.render(mesh, camera));
    }
    renderer.readRenderTargetPixels(numbers, 0, 0, columns, rows, bytes);
    camera.layers.set(0);
    renderer.autoClear = true;
    renderer.setClearColor(colour, alpha);
    renderer.setRenderTarget(null);
    return { ids: bytes.filter((_, k) => k % 4 === 0), columns, rows };
  }

  /// Whether the section removes a point; mm, drawn axes.
  isCut(point) {
    return this.section !== null && isRemoved(this.section, point, this.camera.position);
  }

  /// Where the camera is and looks, mm, in the frame of the picture, and its roll about that line, degrees (schemas/view-state.md).
  get place() {
    const { camera, controls } = this, { right, up } = uprightAxes(camera.position, controls.target), own = X.clone().applyQuaternion(camera.quaternion);
    return { eye_mm: camera.position.toArray(), target_mm: controls.target.toArray(), roll: MathUtils.radToDeg(Math.atan2(own.dot(up), own.dot(right))) };
  }

  set place({ eye_mm: eye, target_mm: target, roll = 0 }) {
    this.camera.position.set(...eye);
    this.controls.target.set(...target);
    const { right, up } = uprightAxes(this.camera.position, this.controls.target), angle = MathUtils.degToRad(roll);
    this.#setUp(roll === 0 ? Y : up.multiplyScalar(Math.cos(angle)).addScaledVector(right, -Math.sin(angle)));
    this.controls.update();
  }

  /// The trackball turns about `up`, which only a state with a roll tilts.
  #setUp(up) {
    this.camera.up.copy(up);
    this.controls._quat.setFromUnitVectors(up, Y);  // the controls read it when they are made only
    this.controls._quatInverse.copy(this.controls._quat).invert();
  }

  #draw() {
    const { renderer, quick, copy } = this;
    setSection(this.section, this.camera.position);
    if (this.sharpness === 1) return this.#drawTo(null);
    quick.setSize(...renderer.getDrawingBufferSize(new Vector2()).toArray());
    this.#drawTo(quick);
    renderer.setRenderTarget(null);
    renderer.render(copy, flatCamera);
  }

  #drawTo(target) {
    const panes = this.#panes, size = this.renderer.getDrawingBufferSize(new Vector2()), all = [this.joint, this.other].filter(Boolean);
    panes.forEach((joints, k) => {
      for (const joint of all) joint.group.visible = joints.includes(joint);
      this.#drawPane(target, joints, new Vector4((k * size.x) / panes.length, 0, size.x / panes.length, size.y), panes.length > 1);
    });
    for (const joint of all) joint.group.visible = true;
    this.#aim(null, new Vector4(0, 0, size.x, size.y), false);
  }

  /// Draws to a part of a target, or of the screen.
  #aim(target, box, isPart) {
    const { renderer } = this;
    if (target) {
      for (const own of [target.viewport, target.scissor]) own.copy(box);
      target.scissorTest = isPart;
    } else {
      const own = box.clone().divideScalar(renderer.getPixelRatio());
      renderer.setViewport(own);
      renderer.setScissor(own);
      renderer.setScissorTest(isPart);
    }
    renderer.setRenderTarget(target);
  }

  #drawPane(target, joints, box, isPart) {
    const { renderer, camera, solid } = this;
    this.#aim(target, box, isPart);
    this.#drawSolids(joints);
    const translucent = joints.flatMap((joint) => joint.translucent(camera.position)).sort(([a], [b]) => b - a);
    if (translucent.length === 0) return;
    solid.setSize(...renderer.getDrawingBufferSize(new Vector2()).toArray());
    this.#aim(solid, box, isPart);
    this.#drawSolids(joints);
    this.#aim(target, box, isPart);
    renderer.autoClear = false;
    camera.layers.set(translucentLayer);
    for (const [, meshes] of translucent) {
      renderer.clearDepth();
      drawTranslucent(meshes, solid.depthTexture, (mesh) => renderer.render(mesh, camera));
    }
    camera.layers.set(0);
    renderer.autoClear = true;
  }

  /// What is opaque, and the cuts of the section.
  #drawSolids(joints) {
    const { renderer, scene, camera, cap, section } = this;
    renderer.render(scene, camera);
    if (!section) return;
    const normal = new Vector3(...section.normal);
    cap.quaternion.setFromUnitVectors(Z, normal);
    cap.position.copy(normal).multiplyScalar(section.at / normal.lengthSq());
    renderer.autoClear = false;
    for (const meshes of joints.flatMap((joint) => joint.cuttable(false))) {
      renderer.clear(false, false, true);
      drawCap(meshes, cap, (mesh) => renderer.render(mesh, camera));
    }
    for (const meshes of joints.flatMap((joint) => joint.cuttable(true))) drawSheetCut(meshes, section, (mesh) => renderer.render(mesh, camera));
    renderer.autoClear = true;
  }

  /// Pixels of the canvas a pixel of the screen, by side.
  #sharpen(sharpness) {
    if (this.sharpness !== sharpness) this.renderer?.setPixelRatio(sharpness * Math.min(window.devicePixelRatio, 2));
    this.sharpness = sharpness;
  }

  /// Fewer pixels if the frames of a motion are slow, more if they are fast.
  #adapt(now) {
    const ms = now - this.drawnAt, isMoving = this.framesLeft > 0;
    this.drawnAt = now;
    if (!isMoving) return;
    const wanted = ms > slowMs ? this.sharpness * Math.sqrt(slowMs / ms) : ms < fastMs ? 1.25 * this.sharpness : this.sharpness;
    this.#sharpen(Math.min(1, Math.max(leastSharpness, wanted)));
  }

  redraw() {
    if (this.isScheduled || this.isLent) return;
    this.isScheduled = true;
    requestAnimationFrame((now) => {
      this.isScheduled = false;
      if (this.isLent) return;
      this.#adapt(now);
      if (this.renderer) this.#draw();
      this.onDrawn(this.camera);
      if (!this.framesLeft) this.#countDown();
      this.framesLeft = stillFrames;
    });
  }

  /// Counts frames without change; then the picture is still, and sharp.
  #countDown() {
    requestAnimationFrame(() => {
      if (this.isScheduled || --this.framesLeft > 0) return this.#countDown();
      this.framesLeft = 0;
      if (this.isLent) return;
      if (this.sharpness === 1) return this.onStill(this.camera);
      this.#sharpen(1);
      this.redraw();
    });
  }

  get isStill() { return !this.isScheduled && !this.framesLeft; }
}

// The joint at the pose shown as USDZ (Apple phones): metres, Y up, standing on its lowest point.

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
    if (!body.visible) continue;
    const group = new Group();
    group.name = name;
    group.matrixAutoUpdate = false;
    group.matrix.copy(body.matrix);
    for (const mesh of body.children.filter((child) => child.isMesh && child.visible)) {
      const part = new Mesh(mesh.geometry, solid(colourOf(mesh.userData.material)));
      part.name = mesh.name;
      made.push(part.material);
      group.add(part);
      const position = mesh.geometry.getAttribute("position");
      for (let k = 0; k < position.count; ++k) lowest = Math.min(lowest, place.fromBufferAttribute(position, k).applyMatrix4(body.matrix).y);
    }
    if (name === "reference" && hasLigaments) {
      let k = 0;
      for (const { layer } of joint.ligaments) {
        if (!layer.group.visible) continue;
        const own = new Group();
        own.matrixAutoUpdate = false;
        own.matrix.copy(layer.group.matrix);
        for (const { geometry, colour } of layer.group.children.filter((mesh) => mesh.visible).flatMap((mesh) => [...fibresOf(mesh)])) {
          const part = new Mesh(geometry, solid(colour));
          part.name = `ligaments_${++k}`;
          made.push(part.material, geometry);
          own.add(part);
        }
        group.add(own);
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

/// Has the browser download `bytes` as the file `name`; `type` is their media type.
export function save(bytes, name, type) {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  Object.assign(document.createElement("a"), { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}
