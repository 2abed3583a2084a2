// Names of bones, ligaments and sides over the picture, with lines to what they name.
import { BufferGeometry, CanvasTexture, Group, Line, LineBasicMaterial, Sprite, SpriteMaterial, SRGBColorSpace, Vector3 } from "three";
import { bodyNames, boxOf } from "./layers.js";
import { bodyPath, structureOf } from "./structures.js";

const femurHeightMm = 38, tibiaDepthMm = 62, sideDistanceMm = 7;  // on a knee

const ligamentOf = (bundle) => ["ACL", "PCL", "MCL", "LCL"].find((known) => bundle.startsWith(known)) ?? bundle;

/// [{ text, points: [{ body, point }], isOf, isSide }]: a label is of the structures for which isOf(id) holds; one of a side is at its point, and in space
/// all are at the mean of their points; mm from the rotation centre.
export function labelsOf(model, scale) {
  const names = bodyNames(model), centre = model.rotationCentre, relative = (p) => p.map((x, k) => x - centre[k]);
  // The bone of that name, or the bones.
  const isPartOf = (body, text) => {
    const { components } = model.bodies[body], all = components.map((_, k) => structureOf(components, k)), bones = all.filter((_, k) => components[k].material === "bone");
    const own = all.includes(text) ? [text] : bones.length > 0 ? bones : all;
    return (id) => own.some((name) => id === `${bodyPath(body)}/${name}`);
  };
  const heights = { reference: scale * femurHeightMm, moving: -scale * tibiaDepthMm };
  const labels = ["reference", "moving"].map((body) => {
    const { low, high } = boxOf(model.bodies[body]);
    return { text: names[body], isOf: isPartOf(body, names[body]), points: [{ body, point: model.joint === "knee" ? [0, heights[body], 0] : relative(low.map((x, k) => (x + high[k]) / 2)) }] };
  });
  for (const { name, body, centre: own } of model.followers ?? []) labels.push({ text: body.name ?? name, isOf: isPartOf(name, name), points: [{ body: name, point: relative(own) }] });
  const ligaments = new Map();
  for (const { bundle, reference, moving } of model.ligaments?.fibres ?? []) {
    const text = ligamentOf(bundle);
    if (!text) continue;
    if (!ligaments.has(text)) ligaments.set(text, []);
    ligaments.get(text).push({ body: "reference", point: relative(reference) }, { body: "moving", point: relative(moving) });
  }
  for (const [text, points] of ligaments) labels.push({ text, points, isOf: (id) => id.startsWith("ligaments/") && ligamentOf(id.slice(10)) === text });
  if (!model.contactPaths) return labels;
  const { low, high } = boxOf(model.bodies.moving);
  const lateral = model.side === "right" ? 1 : -1, half = (high[2] - low[2]) / 2 + scale * sideDistanceMm;
  for (const [text, side] of [["medial", -lateral], ["lateral", lateral]]) {
    labels.push({ text, isSide: true, isOf: isPartOf("moving", names.moving), points: [{ body: "moving", point: relative([(low[0] + high[0]) / 2, high[1], (low[2] + high[2]) / 2 + side * half]) }] });
  }
  return labels;
}

/// Where in the picture each of `n` labels may point: the pixel of its structure nearest to the middle of those seen, inside rather than at an outline; null
/// for what is hidden. `ids`: number of the label of each pixel, 255 for none, rows upwards. `step`: pixels of the picture a pixel of `ids`.
export function anchorsOf(ids, columns, rows, n, step) {
  const found = Array.from({ length: n }, () => []);
  ids.forEach((id, k) => { if (id < n) found[id].push(k); });
  return found.map((own, id) => {
    if (own.length === 0) return null;
    const inside = own.filter((k) => [k - 1, k + 1, k - columns, k + columns].every((other) => ids[other] === id)), from = inside.length > 0 ? inside : own;
    const [x, y] = [(k) => k % columns, (k) => Math.floor(k / columns)].map((of) => from.reduce((sum, k) => sum + of(k), 0) / from.length);
    const away = (k) => Math.hypot((k % columns) - x, Math.floor(k / columns) - y), best = from.reduce((a, b) => (away(b) < away(a) ? b : a));
    return { x: ((best % columns) + 0.5) * step, y: (rows - Math.floor(best / columns) - 0.5) * step };
  });
}

const edgePx = 4, nearestPx = 26, farthestPx = 200, nAngles = 16, coveredPx = 90, crossedPx = 120, movedPx = 25;

const isCrossed = ([a, b], [c, d]) => {
  const side = (p, q, r) => (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
};

/// Boxes { left, top } of labels [{ x, y, width, height, before, isSide }] at anchors x, y: in the picture { left, top, right, bottom }, not over each other and
/// not over anchors, near, rather on the background, where `isCovered(x, y)` is false, and where they were `before`. Null where no place is free.
export function layOut(labels, picture, isCovered) {
  const boxes = [], lines = [];
  const isFree = ({ left, top, right, bottom }) => left >= picture.left && right <= picture.right && top >= picture.top && bottom <= picture.bottom
    && boxes.every((other) => right + edgePx <= other.left || left >= other.right + edgePx || bottom + edgePx <= other.top || top >= other.bottom + edgePx)
    && labels.every(({ x, y, isSide }) => isSide || x < left - edgePx || x > right + edgePx || y < top - edgePx || y > bottom + edgePx);
  const candidates = function* ({ x, y, isSide }) {
    if (isSide) yield [0, 0];
    for (let way = nearestPx; way <= farthestPx; way *= 1.4) {
      for (let k = 0; k < nAngles; ++k) yield [way * Math.cos((2 * Math.PI * k) / nAngles), way * Math.sin((2 * Math.PI * k) / nAngles)];
    }
  };
  return labels.map((label) => {
    const { x, y, width, height, before, isSide } = label;
    let best = null, least = Infinity;
    for (const [dx, dy] of candidates(label)) {
      // The side of the box that faces the anchor is at the offset.
      const left = x + dx - (width / 2) * (1 - (isSide ? 0 : Math.sign(Math.round(dx)))), top = y + dy - height / 2;
      const box = { left, top, right: left + width, bottom: top + height };
      if (!isFree(box)) continue;
      const line = [{ x, y }, { x: x + dx, y: y + dy }], points = [0.05, 0.5, 0.95].flatMap((s) => [0.1, 0.9].map((t) => isCovered(left + s * width, top + t * height)));
      const cost = Math.hypot(dx, dy) + (coveredPx * points.filter(Boolean).length) / points.length + crossedPx * lines.filter((other) => isCrossed(line, other)).length
        + (before && Math.hypot(dx - before[0], dy - before[1]) > 1 ? movedPx : 0);
      if (cost < least) [least, best] = [cost, { ...box, offset: [dx, dy], line }];
    }
    if (!best) return null;
    boxes.push(best);
    lines.push(best.line);
    return best;
  });
}

// Sides are named where the line between them is seen at this part of its length or more.
const leastSide = 0.35, idStep = 5, shownPx = 34, belowTransportPx = 8;

/// The spans of a joint's labels, and their lines; children of `parent`.
export class Labels {
  constructor(parent) {
    this.parent = parent;
    this.transport = parent.parentElement.querySelector(".transport");
    this.svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  }

  show(joint) {
    this.joint = joint;
    this.spans = joint.labels.map(({ text }) => Object.assign(document.createElement("span"), { textContent: text }));
    this.before = joint.labels.map(() => null);
    this.parent.replaceChildren(this.svg, ...this.spans);
  }

  /// Where the sides are in the picture; null if the picture is along them, and of a side that is cut away.
  #sides(camera, isCut) {
    const { clientWidth: width, clientHeight: height } = this.parent, sides = this.joint.labels.filter(({ isSide }) => isSide);
    const [a, b] = sides.map(({ points: [{ body, point }] }) => new Vector3(...point).applyMatrix4(this.joint.bodies[body].matrixWorld));
    if (!a || !this.joint.bodies.moving.visible) return [null, null];
    const across = b.clone().sub(a), sight = a.clone().add(b).multiplyScalar(0.5).sub(camera.position).normalize();
    if (across.clone().addScaledVector(sight, -across.dot(sight)).length() < leastSide * across.length()) return [null, null];
    return [a, b].map((p) => {
      if (isCut(p)) return null;
      const { x, y } = p.project(camera);
      return { x: (width * (1 + x)) / 2, y: (height * (1 - y)) / 2 };
    });
  }

  /// Places the spans of a still picture, where they are whatever was before.
  settle(...how) {
    this.before?.fill(null);
    if (this.hasHistory) this.place(...how);
    this.before?.fill(null);
  }

  /// Places the spans. `seen(numberOf, step)`: { ids, columns, rows } of the picture, as in anchorsOf, of the labels numberOf(structure).
  /// `isCut(point)`: whether a section removes it.
  place(camera, seen, isCut) {
    if (this.parent.hidden || !this.joint) return;
    const { clientWidth, clientHeight } = this.parent, { labels } = this.joint, step = idStep;
    const { ids, columns, rows } = seen((structure) => labels.findIndex(({ isOf, isSide }) => !isSide && isOf(structure)), step);
    const sides = this.#sides(camera, isCut), anchors = anchorsOf(ids, columns, rows, labels.length, step).map((own, k) => (labels[k].isSide ? sides.shift() : own));
    const shown = labels.map((label, k) => ({ ...label, ...anchors[k], k })).filter(({ k }) => anchors[k]);
    const measured = shown.map(({ x, y, k, isSide }) => ({ x, y, isSide, width: this.spans[k].offsetWidth, height: this.spans[k].offsetHeight, before: this.before[k] }));
    const isCovered = (x, y) => (ids[columns * (rows - 1 - Math.floor(y / step)) + Math.floor(x / step)] ?? nothing) !== nothing;
    const bottom = clientHeight - this.transport.offsetHeight - belowTransportPx - edgePx;
    const boxes = layOut(measured, { left: edgePx, top: shownPx, right: clientWidth - edgePx, bottom }, isCovered);
    for (const span of this.spans) span.style.visibility = "hidden";
    this.hasHistory = this.before.some((offset) => offset !== null);
    this.before.fill(null);
    this.svg.innerHTML = boxes.map((box, n) => {
      const { k, x, y, isSide } = shown[n];
      if (!box) return "";
      this.spans[k].style.visibility = "visible";
      this.spans[k].style.transform = `translate(${Math.round(box.left)}px, ${Math.round(box.top)}px)`;
      this.before[k] = box.offset;
      if (isSide) return "";
      const [toX, toY] = [[x + box.offset[0], box.left, box.right], [y + box.offset[1], box.top, box.bottom]].map(([at, low, high]) => Math.min(Math.max(at, low), high));
      return `<g data-of="${k}"><path class="halo" d="M${x} ${y}L${toX} ${toY}"/><path d="M${x} ${y}L${toX} ${toY}"/><circle cx="${x}" cy="${y}" r="3"/></g>`;
    }).join("");
  }
}

/// The number of a pixel that has a structure without a label, and of one that has none.
export const unnamed = 254, nothing = 255;

// In space: at the mean of the points, with a line outwards to the text, which bones hide.

const outwardsMm = 60, tallMm = 16, textPx = 48;

export class SpaceLabels {
  constructor(joint) {
    this.joint = joint;
    this.group = new Group();
    this.drawn = joint.labels.map(({ text }) => {
      const canvas = document.createElement("canvas"), pen = canvas.getContext("2d"), font = `${textPx}px system-ui, "DejaVu Sans", sans-serif`;
      pen.font = font;
      [canvas.width, canvas.height] = [Math.ceil(pen.measureText(text).width) + textPx, 1.4 * textPx];
      Object.assign(pen, { font, fillStyle: "rgb(24 27 32 / 85%)" });
      pen.fillRect(0, 0, canvas.width, canvas.height);
      pen.fillStyle = "#f0f3f6";
      pen.fillText(text, textPx / 2, textPx);
      const map = new CanvasTexture(canvas), sprite = new Sprite(new SpriteMaterial({ map }));
      map.colorSpace = SRGBColorSpace;
      sprite.scale.set((joint.scale * tallMm * canvas.width) / canvas.height, joint.scale * tallMm, 1);
      const line = new Line(new BufferGeometry().setFromPoints([new Vector3(), new Vector3()]), new LineBasicMaterial({ color: "#f0f3f6" }));
      line.frustumCulled = false;
      this.group.add(sprite, line);
      return { sprite, line };
    });
  }

  /// `isShown(structure)`: whether it is visible.
  update(isShown) {
    this.joint.labels.forEach(({ points, isOf, isSide }, k) => {
      const { sprite, line } = this.drawn[k], at = new Vector3(), { bodies, scale } = this.joint;
      sprite.visible = line.visible = points.every(({ body }) => bodies[body].visible) && isShown(isOf);
      for (const { body, point } of points) at.addScaledVector(new Vector3(...point).applyMatrix4(bodies[body].matrix), 1 / points.length);
      const away = at.length() > scale ? at.clone().setY(0).normalize() : new Vector3(1, 0, 0);
      sprite.position.copy(at).addScaledVector(away, isSide ? 0 : scale * outwardsMm);
      line.geometry.attributes.position.copyArray([...at.toArray(), ...sprite.position.toArray()]).needsUpdate = true;
    });
  }

  dispose() {
    for (const { sprite, line } of this.drawn) {
      sprite.material.map.dispose();
      sprite.material.dispose();
      line.geometry.dispose();
      line.material.dispose();
    }
  }
}
