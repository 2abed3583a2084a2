// Contact points of the compartments over flexion at one varus, and their plot seen from above the moving body.
import { boxOf } from "./labels.js";

/// Colour-blind safe, after Okabe and Ito (2008).
export const compartmentColours = { medial: "#0b6aa8", lateral: "#c2500a" };

// Larger steps between neighbouring flexions are jumps to another facet or horn, not rolling or sliding.
const longestStepMm = 4;

/// For each flexion the grid column with the nearest varus; `varusAt(flexion)` in degrees.
export function columnsAlong(model, varusAt) {
  return Array.from(model.flexion, (flexion) => {
    const wanted = varusAt(flexion);
    let best = 0;
    model.varus.forEach((varus, j) => { if (Math.abs(varus - wanted) < Math.abs(model.varus[best] - wanted)) best = j; });
    return best;
  });
}

/// Cells in contact, at most one per flexion: [{ flexion, point mm, isAt }]; isAt(flexion) is true if this cell is the nearest.
export function pathAlong(model, name, columns) {
  const table = model.contactPaths[name], n = model.varus.length, path = [];
  for (let i = 0; i < model.flexion.length; ++i) {
    const at = 3 * (i * n + columns[i]), point = Array.from(table.subarray(at, at + 3));
    if (!point.every(Number.isFinite)) continue;
    const low = i > 0 ? (model.flexion[i - 1] + model.flexion[i]) / 2 : -Infinity;
    const high = i + 1 < model.flexion.length ? (model.flexion[i] + model.flexion[i + 1]) / 2 : Infinity;
    path.push({ flexion: model.flexion[i], point, isAt: (flexion) => flexion >= low && flexion < high });
  }
  return path;
}

/// The path split at jumps.
export function unbroken(path) {
  const pieces = [];
  path.forEach((cell, k) => {
    const before = path[k - 1]?.point, { point } = cell;
    const isNear = before && Math.hypot(point[0] - before[0], point[1] - before[1], point[2] - before[2]) <= longestStepMm;
    if (isNear) pieces.at(-1).push(cell);
    else pieces.push([cell]);
  });
  return pieces;
}

/// Draws the moving body's contact parts from above (anterior up, the subject's right to the right) and both paths.
export class PlateauPlot {
  constructor(canvas) {
    this.canvas = canvas;
  }

  setModel(model) {
    this.model = model;
    this.part = model.bodies.moving.parts[0];
    this.bounds = boxOf(model.bodies.moving);
    this.underlay = null;
  }

  #scale() {
    const { low, high } = this.bounds, { width, height } = this.canvas;
    const mm = Math.min(width / (1.12 * (high[2] - low[2])), height / (1.12 * (high[0] - low[0])));
    return (p) => [width / 2 + mm * (p[2] - (low[2] + high[2]) / 2), height / 2 - mm * (p[0] - (low[0] + high[0]) / 2)];
  }

  #drawUnderlay(place) {
    const { width, height } = this.canvas;
    this.underlay = Object.assign(document.createElement("canvas"), { width, height });
    const pen = this.underlay.getContext("2d"), { vertices, triangles, component } = this.part;
    const corner = (t, k) => vertices.subarray(3 * triangles[3 * t + k], 3 * triangles[3 * t + k] + 3);
    const depth = Array.from(component, (_, t) => corner(t, 0)[1] + corner(t, 1)[1] + corner(t, 2)[1]);
    for (const t of depth.map((_, t) => t).sort((a, b) => depth[a] - depth[b])) {
      const [a, b, c] = [0, 1, 2].map((k) => corner(t, k));
      const u = b.map((x, k) => x - a[k]), v = c.map((x, k) => x - a[k]);
      const up = u[2] * v[0] - u[0] * v[2], length = Math.hypot(u[1] * v[2] - u[2] * v[1], up, u[0] * v[1] - u[1] * v[0]);
      if (!(up > 0)) continue;
      const isMeniscus = this.model.bodies.moving.components[component[t]].material === "meniscus";
      const light = 0.55 + 0.42 * (up / length);
      pen.fillStyle = pen.strokeStyle = isMeniscus ? `rgb(${235 * light} ${196 * light} ${188 * light})` : `rgb(${252 * light} ${246 * light} ${232 * light})`;
      pen.beginPath();
      for (const p of [a, b, c]) pen.lineTo(...place(p));
      pen.closePath();
      pen.fill();
      pen.stroke();  // covers seams between neighbouring triangles
    }
  }

  draw(columns, flexionDeg) {
    const pen = this.canvas.getContext("2d"), place = this.#scale(), { width, height } = this.canvas;
    if (this.underlay?.width !== width || this.underlay.height !== height) this.#drawUnderlay(place);
    pen.clearRect(0, 0, width, height);
    pen.drawImage(this.underlay, 0, 0);
    if (!this.model.contactPaths) return;
    for (const compartment of ["medial", "lateral"]) {
      this.#drawPath(pen, place, pathAlong(this.model, `${compartment}_moving`, columns), compartmentColours[compartment], flexionDeg);
    }
  }

  #drawPath(pen, place, path, colour, flexionDeg) {
    const px = this.canvas.width / Math.max(1, this.canvas.clientWidth);
    const line = (cells, width, dash) => {
      pen.lineWidth = width * px;
      pen.setLineDash(dash);
      pen.beginPath();
      for (const { point } of cells) pen.lineTo(...place(point));
      pen.stroke();
    };
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineCap = "round";
    line(path, 0.8, [2 * px, 3 * px]);  // dashed across the jumps
    for (const piece of unbroken(path)) line(piece.length > 1 ? piece : [piece[0], piece[0]], 2.2, []);
    const here = path.find(({ isAt }) => isAt(flexionDeg));
    if (!here) return;
    pen.beginPath();
    pen.arc(...place(here.point), 5 * px, 0, 2 * Math.PI);
    pen.fill();
    pen.strokeStyle = "#ffffff";
    pen.stroke();
  }
}
