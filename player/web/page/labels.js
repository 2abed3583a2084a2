// Names of bones, ligaments and sides over the picture; points as in player/scene/labels.
import { Box3, Vector3 } from "three";

const femurHeightMm = 38, tibiaDepthMm = 62, sideDistanceMm = 7;  // on a knee

const ligamentOf = (bundle) => ["ACL", "PCL", "MCL", "LCL"].find((known) => bundle.startsWith(known)) ?? bundle;

export const bodyNames = (model) => (model.joint === "knee" ? { reference: "femur", moving: "tibia" } : { reference: model.bodies.reference.name, moving: model.bodies.moving.name });

/// The box of a body's contact parts.
export function boxOf(body) {
  const { min, max } = new Box3().setFromArray(body.parts[0].vertices);
  return { low: min.toArray(), high: max.toArray() };
}

/// [{ text, points: [{ body, point }] }]: a label is at the mean of its points; mm from the rotation centre.
export function labelsOf(model, scale) {
  const names = bodyNames(model), centre = model.rotationCentre, relative = (p) => p.map((x, k) => x - centre[k]);
  const heights = { reference: scale * femurHeightMm, moving: -scale * tibiaDepthMm };
  const labels = ["reference", "moving"].map((body) => {
    const { low, high } = boxOf(model.bodies[body]);
    return { text: names[body], points: [{ body, point: model.joint === "knee" ? [0, heights[body], 0] : relative(low.map((x, k) => (x + high[k]) / 2)) }] };
  });
  const ligaments = new Map();
  for (const { bundle, reference, moving } of model.ligaments?.fibres ?? []) {
    const text = ligamentOf(bundle);
    if (!text) continue;
    if (!ligaments.has(text)) ligaments.set(text, []);
    ligaments.get(text).push({ body: "reference", point: relative(reference) }, { body: "moving", point: relative(moving) });
  }
  for (const [text, points] of ligaments) labels.push({ text, points });
  if (!model.contactPaths) return labels;
  const { low, high } = boxOf(model.bodies.moving);
  const lateral = model.side === "right" ? 1 : -1, half = (high[2] - low[2]) / 2 + scale * sideDistanceMm;
  for (const [text, side] of [["medial", -lateral], ["lateral", lateral]]) {
    labels.push({ text, points: [{ body: "moving", point: relative([(low[0] + high[0]) / 2, high[1], (low[2] + high[2]) / 2 + side * half]) }] });
  }
  return labels;
}

/// The spans of a joint's labels, children of `parent`.
export class Labels {
  constructor(parent) {
    this.parent = parent;
  }

  show(joint) {
    this.joint = joint;
    this.spans = joint.labels.map(({ text }) => Object.assign(document.createElement("span"), { textContent: text }));
    this.parent.replaceChildren(...this.spans);
  }

  /// Places the spans; those that overlap move down.
  place(camera) {
    if (this.parent.hidden || !this.joint) return;
    const { clientWidth, clientHeight } = this.parent, taken = [];
    this.joint.labels.forEach(({ points }, k) => {
      const place = new Vector3();
      for (const { body, point } of points) place.add(new Vector3(...point).applyMatrix4(this.joint.bodies[body].matrixWorld));
      place.divideScalar(points.length).project(camera);
      const span = this.spans[k], isShown = Math.abs(place.x) <= 1 && Math.abs(place.y) <= 1 && place.z < 1;
      span.style.visibility = isShown ? "visible" : "hidden";
      if (!isShown) return;
      const { offsetWidth: width, offsetHeight: height } = span, left = (clientWidth * (1 + place.x) - width) / 2;
      let top = (clientHeight * (1 - place.y) - height) / 2;
      for (let tries = 0; tries < taken.length; ++tries) {
        for (const other of taken) if (left < other.right && left + width > other.left && top < other.bottom && top + height > other.top) top = other.bottom + 1;
      }
      taken.push({ left, right: left + width, top, bottom: top + height });
      span.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
    });
  }
}
