// The joint in augmented and virtual reality (WebXR).
import { BufferGeometry, CanvasTexture, DoubleSide, Group, Line, LineBasicMaterial, Matrix4, Mesh, MeshBasicMaterial, PerspectiveCamera, PlaneGeometry, Raycaster, RingGeometry, Scene, SphereGeometry, SRGBColorSpace, Vector3 } from "three";
import { product, rotationWorldSolver, transposed } from "./geometry.js";
import { translucentLayer } from "./material.js";
import { SpaceLabels } from "./labels.js";
import { composed, fitLandmarks, FitRefusal, inverse, leastPoints, matrixOf, mmPerM, poseOf, standing, tracked } from "./placement.js";
import { clinicalOf, formatNumber } from "./readings.js";
import { leastOpacity } from "./structures.js";

// Controllers, hands and taps of a session: rays, touching tips, and whether they are tracked. Metres, in the reference space.

const rayM = 1.5, tipM = 0.003;

/// A pose as a matrix; null if it is missing, not finite, or only estimated.
function trackedMatrix(pose) {
  if (!pose || pose.emulatedPosition || !pose.transform.matrix.every(Number.isFinite)) return null;
  return new Matrix4().fromArray(pose.transform.matrix);
}

function trackedPose(frame, space, reference) {
  return trackedMatrix(space && frame.getPose(space, reference));
}

/// The point that touches: the tip of the index finger, or of the controller. A pinch moves its own hand, so that the other
/// hand's finger touches if it is seen.
function touchingPoint(frame, source, sources, reference) {
  const finger = (hand) => {
    const joint = hand?.get("index-finger-tip"), matrix = trackedMatrix(joint && frame.getJointPose?.(joint, reference));
    return matrix && new Vector3().setFromMatrixPosition(matrix);
  };
  if (source.hand) {
    const other = [...sources].find((one) => one.hand && one !== source);
    return (other && finger(other.hand)) ?? finger(source.hand);
  }
  const pose = trackedPose(frame, source.targetRaySpace, reference);
  return pose && new Vector3().setFromMatrixPosition(pose);
}

function rayOf(frame, source, reference) {
  const pose = frame.getPose(source.targetRaySpace, reference);
  if (!pose || !pose.transform.matrix.every(Number.isFinite)) return null;
  const matrix = new Matrix4().fromArray(pose.transform.matrix), origin = new Vector3().setFromMatrixPosition(matrix);
  return { origin, direction: new Vector3(0, 0, -1).transformDirection(matrix), matrix };
}

/// Where a ray meets a mesh: texture coordinates, or those of the mesh's plane.
function meets(ray, mesh) {
  const caster = new Raycaster(ray.origin, ray.direction);
  return caster.intersectObject(mesh, false)[0]?.uv;
}

/// Rays and tips of the tracked sources.
class Pointers {
  constructor() {
    this.group = new Group();
    this.drawn = [];
  }

  update(frame, sources, reference) {
    const tracked = [...sources].filter((source) => source.targetRayMode === "tracked-pointer");
    while (this.drawn.length < tracked.length) this.#add();
    this.drawn.forEach((one, k) => {
      const ray = tracked[k] && rayOf(frame, tracked[k], reference);
      one.visible = Boolean(ray);
      if (ray) one.matrix.copy(ray.matrix);
    });
  }

  #add() {
    const one = new Group();
    one.matrixAutoUpdate = false;
    const ray = new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 0, -rayM)]);
    one.add(new Line(ray, new LineBasicMaterial({ color: "#4aa3df", transparent: true, opacity: 0.6 })), new Mesh(new SphereGeometry(tipM, 12, 8), new MeshBasicMaterial({ color: "#ffb74a" })));
    this.drawn.push(one);
    this.group.add(one);
  }

  dispose() {
    this.group.traverse((object) => { object.geometry?.dispose(); object.material?.dispose(); });
  }
}

// The panel in space: a slider for flexion, buttons, and problems. Sizes in metres; drawn on a canvas.

const widthM = 0.36, heightM = 0.24;
const width = 1080, height = 720, margin = 36, buttonTop = 210, buttonHeight = 108, columns = 3, gap = 18;
const sliderTop = 452, sliderHeight = 96, ink = "#eef2f6", quiet = "#aab6c4", amber = "#ffb74a", accent = "#4aa3df";

class XrPanel {
  constructor() {
    this.canvas = Object.assign(document.createElement("canvas"), { width, height });
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    this.mesh = new Mesh(new PlaneGeometry(widthM, heightM), new MeshBasicMaterial({ map: this.texture, side: DoubleSide, transparent: true }));
    this.buttons = [];
    this.slider = { x: margin + 20, y: sliderTop, w: width - 2 * margin - 40, h: sliderHeight };
  }

  /// The button's name, or { share } of the slider, at texture coordinates; undefined elsewhere.
  at({ x, y }, isGrabbed = false) {
    const [px, py] = [x * width, (1 - y) * height], { slider } = this;
    if (isGrabbed || (py >= slider.y && py <= slider.y + slider.h)) return { share: Math.min(Math.max((px - slider.x) / slider.w, 0), 1) };
    return this.buttons.find((b) => !b.isOff && px >= b.x && px <= b.x + b.w && py >= b.y && py <= b.y + b.h)?.name;
  }

  /// Texture coordinates of a share of the slider or of a button: for tests and pointers.
  placeOf(target) {
    const box = typeof target === "number" ? { x: this.slider.x + target * this.slider.w, y: this.slider.y, w: 0, h: this.slider.h } : this.buttons.find(({ name }) => name === target);
    return { x: (box.x + box.w / 2) / width, y: 1 - (box.y + box.h / 2) / height };
  }

  /// Draws again when something changed. `buttons`: [{ name, label, isPressed, isOff }]; `share` of the slider; `ends`: its texts.
  draw({ title, note, detail, marks, share, ends, buttons }) {
    const key = JSON.stringify([title, note, detail, marks, share.toFixed(3), ends, buttons]);
    if (key === this.drawn) return;
    this.drawn = key;
    const w = (width - 2 * margin - (columns - 1) * gap) / columns;
    this.buttons = buttons.map((button, k) => ({ ...button, x: margin + (k % columns) * (w + gap), y: buttonTop + Math.floor(k / columns) * (buttonHeight + gap), w, h: buttonHeight }));
    const c = this.canvas.getContext("2d");
    c.clearRect(0, 0, width, height);
    c.fillStyle = "rgb(20 26 34 / 90%)";
    c.beginPath();
    c.roundRect(0, 0, width, height, 40);
    c.fill();
    this.#text(c, title, margin, 82, 52, ink, width - 2 * margin);
    this.#lines(c, note, 138, quiet);
    for (const { label, isPressed, isOff, x, y, w: wide, h } of this.buttons) {
      c.fillStyle = isPressed ? accent : "#334252";
      c.globalAlpha = isOff ? 0.4 : 1;
      c.beginPath();
      c.roundRect(x, y, wide, h, 18);
      c.fill();
      c.textAlign = "center";
      this.#text(c, label, x + wide / 2, y + h / 2 + 14, 40, isPressed ? "#04121d" : ink, wide - 16);
      c.textAlign = "left";
      c.globalAlpha = 1;
    }
    this.#slider(c, share, ends);
    this.#text(c, detail, margin, marks.length > 1 ? height : marks.length > 0 ? 690 : 640, 36, ink, width - 2 * margin);
    marks.slice(0, 2).forEach((mark, k) => this.#text(c, `⚠ ${mark}`, margin, 640 + 50 * k, 36, amber, width - 2 * margin));
    this.texture.needsUpdate = true;
  }

  #slider(c, share, [low, high]) {
    const { x, y, w, h } = this.slider, middle = y + h / 2;
    c.fillStyle = "#4a5a6c";
    c.fillRect(x, middle - 7, w, 14);
    c.fillStyle = accent;
    c.fillRect(x, middle - 7, share * w, 14);
    c.beginPath();
    c.arc(x + share * w, middle, 34, 0, 2 * Math.PI);
    c.fill();
    this.#text(c, low, x - 20, y + h + 20, 30, quiet, 200);
    c.textAlign = "right";
    this.#text(c, high, x + w + 20, y + h + 20, 30, quiet, 200);
    c.textAlign = "left";
  }

  #text(c, text, x, y, px, colour, widest) {
    c.font = `${px}px system-ui, "DejaVu Sans", sans-serif`;
    c.fillStyle = colour;
    c.fillText(text, x, y, widest);
  }

  /// A note on up to two lines.
  #lines(c, note, y, colour) {
    c.font = '36px system-ui, "DejaVu Sans", sans-serif';
    const lines = [""];
    for (const word of note.split(" ")) {
      if (c.measureText(`${lines.at(-1)} ${word}`).width > width - 2 * margin && lines.length < 2) lines.push("");
      lines[lines.length - 1] += `${lines.at(-1) ? " " : ""}${word}`;
    }
    lines.forEach((line, k) => this.#text(c, line, margin, y + 42 * k, 36, colour, width - 2 * margin));
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}

// The joint in augmented and virtual reality (WebXR): placed on a surface or on a leg by touched points, moved by a slider in space,
// by a controller on the shank, or by the bench. Space in metres. While a source is not tracked, the last pose is kept and marked.

const nearM = 0.01, farM = 30, aheadM = 0.7, belowM = 0.25, panelAsideM = 0.3, panelAboveM = 0.12;
const dotMm = 2.5, dotColour = "#4aa3df", nextColour = "#ffb74a";
const features = ["local-floor", "hit-test", "hand-tracking"];
const xrModes = ["immersive-ar", "immersive-vr"];

/// The xrModes that this browser offers; none without a secure context.
async function offeredModes() {
  const offers = xrModes.map((mode) => navigator.xr?.isSessionSupported(mode).catch(() => false) ?? false);
  const isOffered = await Promise.all(offers);
  return xrModes.filter((_, k) => isOffered[k]);
}

const up = new Vector3(0, 1, 0);
const millimetres = (v) => [v.x * mmPerM, v.y * mmPerM, v.z * mmPerM];
const metres = (p) => new Vector3(...p).divideScalar(mmPerM);

class XrView {
  /// `host`: joint, model, flexion, range and marks of the page as functions, `setFlexion(deg)`, `advance(now)`, `togglePlay()`,
  /// `looks()` of the structures, `labels()` the box that shows them, `readingOf(structure)` what the card says of a bundle, `redraw()`, `isPlaying()`, `live()`, `setFollowing(on)`, `isFollowing()`, `landmarks()`, `onStart()`, `onEnd()`.
  constructor(viewer, host) {
    Object.assign(this, { viewer, host, session: null });
  }

  async start(mode) {
    const { xr } = this.viewer.renderer;
    const session = await navigator.xr.requestSession(mode, { optionalFeatures: features });
    Object.assign(this, { session, xrMode: mode, task: "place", placement: null, follow: null, touches: [], note: "", grab: null, pin: null, hit: null, hitSource: null, hitSpace: null, lastPressed: null, hasHitTest: mode === "immersive-ar", isPanelPlaced: false });
    session.addEventListener("end", () => this.#end());
    try {
      const isFloor = await session.requestReferenceSpace("local-floor").then(() => true, () => false);
      xr.enabled = true;
      xr.setReferenceSpaceType(isFloor ? "local-floor" : "local");
      this.viewerSpace = await session.requestReferenceSpace("viewer");
      await xr.setSession(session);
    } catch (error) {
      await session.end().catch(() => {});
      throw error;
    }
    if (this.session !== session) return;
    this.#build();
    session.addEventListener("selectstart", (event) => this.#press(event));
    session.addEventListener("selectend", ({ inputSource }) => { if (this.grab === inputSource) this.grab = null; });
    this.host.onStart();
    this.viewer.renderer.setAnimationLoop((now, frame) => { if (frame && this.session) this.#frame(now, frame); });
  }

  leave() { return this.session?.end(); }

  #build() {
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(50, 1, nearM, farM);
    this.camera.layers.enable(translucentLayer);
    this.anchor = new Group();
    this.anchor.matrixAutoUpdate = false;
    this.anchor.visible = false;
    this.joint = this.host.joint();
    this.viewer.lend();
    this.dots = new Group();
    this.labels = new SpaceLabels(this.joint);
    this.anchor.add(this.joint.group, this.dots, this.labels.group);
    this.panel = new XrPanel();
    this.pointers = new Pointers();
    this.reticle = new Mesh(new RingGeometry(0.035, 0.045, 40).rotateX(-Math.PI / 2), new MeshBasicMaterial({ color: nextColour }));
    this.reticle.matrixAutoUpdate = false;
    this.reticle.visible = false;
    this.scene.add(this.anchor, this.panel.mesh, this.pointers.group, this.reticle);
  }

  #end() {
    this.session = null;
    this.viewer.renderer.setAnimationLoop(null);
    this.viewer.renderer.xr.enabled = false;
    if (this.scene) {
      this.panel.dispose();
      this.pointers.dispose();
      this.#clearDots();
      this.labels.dispose();
      this.reticle.geometry.dispose();
      this.reticle.material.dispose();
      this.anchor.remove(this.joint.group);
      this.scene = null;
    }
    this.viewer.takeBack();
    this.host.onEnd();
  }

  #frame(now, frame) {
    const reference = this.viewer.renderer.xr.getReferenceSpace();
    this.now = now;
    this.host.advance(now);
    const head = frame.getViewerPose(reference)?.transform.matrix;
    if (head?.every(Number.isFinite)) this.head = new Matrix4().fromArray(head);
    if (this.head && !this.isPanelPlaced) this.#placePanel();
    if (!this.placement && this.head && this.xrMode === "immersive-vr") this.#placeAhead(this.#headRay());
    this.#findSurface(frame, reference);
    this.#movePinned(frame, reference);
    this.#moveGrabbed(frame, reference);
    this.#follow();
    this.labels.group.visible = this.host.labels().checked;
    if (this.labels.group.visible) this.labels.update((isOf) => this.host.looks().structures.some(({ id }) => isOf(id) && this.host.looks().of(id).visible));
    this.pointers.update(frame, this.session.inputSources, reference);
    if (this.placement) this.anchor.matrix.copy(matrixOf(this.placement));
    this.anchor.visible = this.placement !== null;
    this.anchor.updateMatrixWorld(true);
    this.#drawPanel();
    this.viewer.renderer.render(this.scene, this.camera);
  }

  #headRay() {
    return { origin: new Vector3().setFromMatrixPosition(this.head), direction: new Vector3(0, 0, -1).transformDirection(this.head) };
  }

  // Placing

  #scale() { return this.placement?.scale ?? this.host.live()?.bench?.scale ?? 1; }

  #put(placement) {
    this.placement = placement;
    // The bench moves the joint from here on as it moves the leg.
    const pose = this.host.isFollowing() && this.host.live()?.pose;
    this.follow = pose ? { space: composed(placement, inverse(this.#trackedPose(pose, placement.scale))) } : null;
    this.#placePanel();
  }

  #trackedPose(pose, scale) { return tracked(pose.placement, this.host.model().rotationCentre, scale); }

  #follow() {
    const pose = this.host.isFollowing() && this.host.live()?.pose;
    if (!this.placement) return;
    if (!pose) { this.follow = null; return; }
    if (!this.follow) return this.#put(this.placement);
    this.placement = { ...composed(this.follow.space, this.#trackedPose(pose, this.placement.scale)), scale: this.placement.scale };
  }

  /// The lowest point of the joint at its present pose, mm.
  lowest() {
    const p = new Vector3();
    let lowest = Infinity;
    for (const body of Object.values(this.joint.bodies)) {
      for (const mesh of body.children) {
        if (!mesh.isMesh) continue;
        const position = mesh.geometry.getAttribute("position");
        for (let k = 0; k < position.count; ++k) lowest = Math.min(lowest, p.fromBufferAttribute(position, k).applyMatrix4(body.matrix).y);
      }
    }
    return lowest;
  }

  #placeAhead({ origin, direction }) {
    const point = origin.clone().addScaledVector(direction, aheadM).addScaledVector(up, -belowM), viewer = new Vector3().setFromMatrixPosition(this.head);
    this.#put({ ...standing(millimetres(point), millimetres(viewer), 0, this.#scale()) });
  }

  #placeOnSurface() {
    if (!this.hit) return this.#say("No surface found yet: move the device slowly over the place.");
    const viewer = new Vector3().setFromMatrixPosition(this.head ?? new Matrix4());
    this.#put(standing(millimetres(new Vector3().setFromMatrixPosition(this.hit)), millimetres(viewer), this.lowest(), this.#scale()));
    this.#say("Placed on the surface. Press again to move it.");
  }

  #findSurface(frame, reference) {
    this.reticle.visible = false;
    this.hit = null;
    if (!this.hasHitTest || this.task !== "place") return;
    this.#useHitSource(this.#pointer()?.targetRaySpace ?? this.viewerSpace);
    if (!this.hitSource) return;
    const matrix = frame.getHitTestResults(this.hitSource)[0]?.getPose(reference)?.transform.matrix;
    if (!matrix?.every(Number.isFinite)) return;
    this.hit = new Matrix4().fromArray(matrix);
    this.reticle.visible = true;
    this.reticle.matrix.copy(this.hit);
    this.reticle.updateMatrixWorld(true);
  }

  /// The controller or hand that pressed last, at first the right one; undefined on a phone.
  #pointer() {
    const pointers = [...this.session.inputSources].filter((one) => one.targetRayMode === "tracked-pointer");
    return pointers.find((one) => one === this.lastPressed) ?? pointers.find(({ handedness }) => handedness === "right") ?? pointers[0];
  }

  #useHitSource(space) {
    if (this.hitSpace === space) return;
    this.hitSource?.cancel?.();
    Object.assign(this, { hitSpace: space, hitSource: null });
    const { session } = this;
    const request = session.requestHitTestSource?.({ space }) ?? Promise.reject(new Error("no hit test"));
    request.then((source) => { if (this.session === session && this.hitSpace === space) this.hitSource = source; else source.cancel?.(); },
      () => { if (this.session === session) this.hasHitTest = false; });
  }

  // Touching

  #startTouching() {
    Object.assign(this, { task: "touch", touches: [], next: 0, points: this.host.landmarks() });
    this.#say("");
    this.#drawDots();
  }

  #touch(frame, source, reference) {
    if (this.next >= this.points.length) return this.#say("All points are touched: press Fit.");
    const tip = touchingPoint(frame, source, this.session.inputSources, reference);
    if (!tip) return this.#say("This controller or hand is not tracked, its position is only estimated: touch again in view.");
    const { name, body, point } = this.points[this.next];
    // The leg is held at the flexion shown, so that points of both bones count.
    const model = new Vector3(...point).applyMatrix4(this.joint.bodies[body].matrix).toArray();
    this.touches.push({ name, model, touched: millimetres(tip) });
    this.#advance();
  }

  #advance() {
    ++this.next;
    if (this.next >= this.points.length && this.touches.length >= leastPoints) return this.#fit();
    this.#say("");
    this.#drawDots();
  }

  #fit() {
    try {
      const bench = this.host.live()?.bench;
      this.fit = fitLandmarks(this.touches, bench?.scale);
      this.#put({ R: this.fit.R, t: this.fit.t, scale: this.fit.scale });
      const remarks = this.fit.remarks.map((text) => `; ${text}`).join("");
      this.#finish(`Placed by ${this.touches.length} points to ${formatNumber(this.fit.rms, 1)} mm (rms), size ${formatNumber(100 * this.fit.scale, 0)} %${remarks}.`);
    } catch (error) {
      if (!(error instanceof FitRefusal)) throw error;
      this.#say(`Not placed: ${error.message}.`);
    }
  }

  #finish(note) {
    this.task = "place";
    this.#clearDots();
    this.#say(note);
  }

  #undo() {
    if (this.next > 0) --this.next;
    if (this.touches.at(-1)?.name === this.points[this.next].name) this.touches.pop();
    this.#say("");
    this.#drawDots();
  }

  #drawDots() {
    this.#clearDots();
    this.points.forEach(({ body, point }, k) => {
      const dot = new Mesh(new SphereGeometry(k === this.next ? 2 * dotMm : dotMm, 16, 12), new MeshBasicMaterial({ color: k === this.next ? nextColour : dotColour }));
      dot.position.copy(new Vector3(...point).applyMatrix4(this.joint.bodies[body].matrix));
      this.dots.add(dot);
    });
  }

  #clearDots() {
    for (const dot of this.dots.children) { dot.geometry.dispose(); dot.material.dispose(); }
    this.dots.clear();
  }

  // Flexion

  #setShare(share) {
    if (this.task === "structures") {
      this.host.looks().change([this.#structure().id], { opacity: Math.max(leastOpacity, share) });
      return this.host.redraw();
    }
    const [low, high] = this.host.range();
    this.host.setFlexion(low + share * (high - low));
  }

  #moveGrabbed(frame, reference) {
    const ray = this.grab && rayOf(frame, this.grab, reference), uv = ray && meets(ray, this.panel.mesh);
    if (uv) this.#setShare(this.panel.at(uv, true).share);
  }

  /// Fixes the controller to the shank at the flexion shown.
  #togglePin(frame, source, reference) {
    if (this.pin) { this.pin = null; return this.#say("The controller is free."); }
    const pose = trackedPose(frame, source.gripSpace ?? source.targetRaySpace, reference);
    if (!pose || !this.placement) return this.#say(pose ? "Place the joint first." : "This controller is not tracked: hold it in view.");
    const shank = product(this.placement.R, poseOf(this.joint.bodies.moving.matrix).R);
    this.pin = { source, offset: product(transposed(poseOf(pose).R), shank), seen: this.now, isLive: true };
    this.#say("The controller moves the shank. Hold it on the shin.");
  }

  #movePinned(frame, reference) {
    if (!this.pin) return;
    const { source, offset } = this.pin, isThere = [...this.session.inputSources].includes(source);
    const pose = isThere ? trackedPose(frame, source.gripSpace ?? source.targetRaySpace, reference) : null;
    this.pin.isLive = pose !== null;
    if (!pose) return;
    this.pin.seen = this.now;
    const R = product(transposed(this.placement.R), product(poseOf(pose).R, offset));
    const flexion = flexionOf(R, this.host.model(), this.host.delta());
    const [low, high] = this.host.range();
    this.pin.beyond = flexion < low - 1 || flexion > high + 1 ? `flexion ${formatNumber(flexion, 0)}°, model ${flexion > high ? "ends" : "begins"} at ${formatNumber(flexion > high ? high : low, 0)}°` : "";
    this.host.setFlexion(Math.min(Math.max(flexion, low), high));
  }

  // Structures

  #structure() {
    const { structures, highlighted } = this.host.looks();
    return structures.find(({ id }) => id === highlighted) ?? structures[0];
  }

  #highlight(id) {
    this.host.looks().highlighted = id;
    this.host.redraw();
  }

  #stepStructure(by) {
    const { structures } = this.host.looks();
    this.#highlight(structures.at((structures.indexOf(this.#structure()) + by) % structures.length).id);
  }

  /// A press at a structure chooses it.
  #pick({ origin, direction }) {
    const caster = new Raycaster(origin, direction);
    caster.layers.enable(translucentLayer);
    const hits = caster.intersectObjects(this.joint.pickable(), false), hit = hits.find(({ object }) => object.material.uniforms.opacity.value >= 0.5) ?? hits[0];
    if (hit) this.#highlight(hit.object.userData.structure);
  }

  #useStructures() {
    const looks = this.host.looks(), { id } = this.#structure(), isAll = looks.structures.every((one) => looks.of(one.id).visible || one.group === "Contact");
    return {
      previous: () => this.#stepStructure(-1), next: () => this.#stepStructure(1), shown: () => looks.change([id], { visible: !looks.of(id).visible }),
      isolate: () => (isAll ? looks.isolate(id) : looks.showAll()), labels: () => { this.host.labels().checked = !this.host.labels().checked; },
      back: () => { this.#highlight(null); this.#finish(""); },
    };
  }

  // The panel

  #say(note) { this.note = note; }

  #placePanel() {
    if (!this.head) return;
    this.isPanelPlaced = true;
    const eye = new Vector3().setFromMatrixPosition(this.head), { mesh } = this.panel;
    if (this.placement) {
      const at = metres(this.placement.t), side = new Vector3().subVectors(at, eye).cross(up).normalize();
      mesh.position.copy(at).addScaledVector(side, -panelAsideM).addScaledVector(up, panelAboveM);
    } else {
      const { direction } = this.#headRay();
      mesh.position.copy(eye).addScaledVector(direction, aheadM).addScaledVector(up, -belowM / 2);
    }
    mesh.lookAt(eye);
    mesh.updateMatrixWorld(true);
  }

  #marks() {
    const marks = [...this.host.marks()];
    if (this.pin && !this.pin.isLive) marks.unshift(`controller on the shank not tracked for ${((this.now - this.pin.seen) / 1000).toFixed(1)} s: the last flexion is shown`);
    else if (this.pin?.beyond) marks.unshift(this.pin.beyond);
    return marks;
  }

  #instruction() {
    if (this.task === "structures") return this.#structure().does;
    if (this.note) return this.note;
    if (this.task === "touch") return `Touch ${this.points[this.next]?.name ?? ""} (${this.next + 1} of ${this.points.length}), shown amber, and press. Three or more; bend the leg as shown.`;
    const word = this.placement ? "move" : "place";
    return this.hasHitTest ? `Point at a surface and press to ${word} the joint.` : `Press to ${word} the joint where the controller points.`;
  }

  #buttons() {
    if (this.task === "touch") return [{ name: "fit", label: "Fit", isOff: this.touches.length < leastPoints }, { name: "skip", label: "Skip point", isOff: this.next >= this.points.length }, { name: "undo", label: "Undo", isOff: this.next === 0 }, { name: "cancel", label: "Cancel" }];
    if (this.task === "structures") {
      const looks = this.host.looks(), isAll = looks.structures.every((one) => looks.of(one.id).visible || one.group === "Contact"), { visible } = looks.of(this.#structure().id);
      return [{ name: "previous", label: "Previous" }, { name: "next", label: "Next" }, { name: "shown", label: "Shown", isPressed: visible },
        { name: "isolate", label: isAll ? "Isolate" : "Show all" }, { name: "labels", label: "Labels", isPressed: this.host.labels().checked }, { name: "back", label: "Back" }];
    }
    return [{ name: "touch", label: "Touch points" }, { name: "pin", label: "Pin to shank", isPressed: Boolean(this.pin), isOff: !this.placement }, { name: "play", label: "Play", isPressed: this.host.isPlaying() },
      { name: "live", label: "Bench", isPressed: this.host.isFollowing(), isOff: !this.host.live() }, { name: "structures", label: "Structures" }, { name: "leave", label: "Leave" }];
  }

  #drawPanel() {
    const [low, high] = this.host.range(), flexion = this.host.flexion(), ofStructure = this.task === "structures" && this.#structure();
    const slider = ofStructure ? { title: ofStructure.name, share: this.host.looks().of(ofStructure.id).opacity, ends: ["faint", "opaque"] }
      : { title: this.host.title(), share: high > low ? (flexion - low) / (high - low) : 0, ends: [`${formatNumber(low, 0)}°`, `${formatNumber(high, 0)}°`] };
    this.panel.draw({ ...slider, note: this.#instruction(), detail: ofStructure ? this.host.readingOf(ofStructure) : "", marks: this.#marks(), buttons: this.#buttons() });
  }

  #press({ frame, inputSource }) {
    const reference = this.viewer.renderer.xr.getReferenceSpace(), ray = rayOf(frame, inputSource, reference);
    this.lastPressed = inputSource;
    const uv = ray && meets(ray, this.panel.mesh), target = uv && this.panel.at(uv);
    if (typeof target === "string") return this.#use(target, frame, inputSource, reference);
    if (target) { this.grab = inputSource; this.pin = null; return this.#setShare(target.share); }
    if (uv) return;
    if (this.task === "structures") return ray && this.#pick(ray);
    if (this.task === "touch") return this.#touch(frame, inputSource, reference);
    if (this.hasHitTest) return this.#placeOnSurface();
    if (ray) this.#placeAhead(ray);
  }

  #use(button, frame, source, reference) {
    const uses = {
      touch: () => this.#startTouching(), fit: () => this.#fit(), skip: () => this.#advance(), undo: () => this.#undo(), cancel: () => this.#finish(""),
      pin: () => this.#togglePin(frame, source, reference), play: () => this.host.togglePlay(), leave: () => this.leave(),
      live: () => this.host.setFollowing(!this.host.isFollowing()), structures: () => { this.task = "structures"; this.#highlight(this.#structure().id); }, ...this.#useStructures(),
    };
    uses[button]();
    this.host.redraw();
  }

  /// For tests: the state, and where in space to point at a button or a share of the slider.
  state() {
    if (!this.session || !this.scene) return { isPresenting: false };
    const { task, placement, touches, fit, note, xrMode, next } = this;
    return { isPresenting: true, task, placement, touches, fit, note, xrMode, next, instruction: this.#instruction(), marks: this.#marks(), drawnPanel: this.panel.drawn, lowest: this.lowest(), hit: this.hit?.elements ?? null, isPinned: Boolean(this.pin), points: this.points,
      drawn: this.anchor.visible ? [...this.anchor.matrix.elements] : null };
  }

  panelPoint(target) {
    const uv = this.panel.placeOf(target), { width, height } = this.panel.mesh.geometry.parameters;
    return this.panel.mesh.localToWorld(new Vector3((uv.x - 0.5) * width, (uv.y - 0.5) * height, 0)).toArray();
  }
}

/// Flexion in degrees of the moving body's rotation in the reference's frame, in the motion's frame; as player/bench.
function flexionOf(R, model, delta) {
  const S = rotationWorldSolver(model.side, delta);
  return clinicalOf({ R: product(product(transposed(S), R), S), t: [0, 0, 0] }, [0, 0, 0], "right").flexion;
}

// The buttons that start augmented and virtual reality, or the reason why they are missing.

const labels = { "immersive-ar": "View in the room", "immersive-vr": "View in VR" };

/// Returns the XrView. `host` as there; `showError(text)`.
export function connectXr(byId, viewer, host, showError) {
  const view = new XrView(viewer, host);
  if (!viewer.renderer) return view;
  if (!window.isSecureContext) byId("xr-note").hidden = false;
  const offer = async () => {
    const modes = await offeredModes();
    byId("xr-buttons").replaceChildren(...modes.map((mode) => {
      const button = Object.assign(document.createElement("button"), { type: "button", value: mode, textContent: labels[mode] });
      button.addEventListener("click", () => {
        button.disabled = true;
        view.start(mode).catch((error) => showError(`${labels[mode]}: ${error.message}`)).finally(() => { button.disabled = false; });
      });
      return button;
    }));
  };
  offer();
  navigator.xr?.addEventListener?.("devicechange", offer);
  return view;
}
