// A picture in space that turns under the pointer: a surface over a grid, or lines, in a box with numbered edges.

const FONT = "11px system-ui, 'Segoe UI', 'Noto Sans', 'DejaVu Sans', sans-serif";
const NEAR_PX = 14;

/** A step of 1, 2 or 5 that gives at most `most` round numbers in the range; these numbers. */
function ticks([low, high], most = 5) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough);
  const found = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9 * step; x += step) found.push(Number(x.toPrecision(10)));
  return found;
}

/** From where a picture is seen: angles in radians. Several pictures may share one. */
export function viewFrom(azimuth, elevation) {
  return { azimuth, elevation, pictures: [] };
}

/**
 * Fills `container`. `show()` draws
 *   axes: three of { title, range }, the third upwards; size: three lengths of the box
 *   surface: { x, y, z: [j][i] at x[i] and y[j] or null, colourOf(z), text(i, j) }
 *   lines: [{ points: [[x, y, z], ...], colour }]
 *   ink: { text, quiet, rule } colours
 */
export class Space {
  constructor(container, view) {
    this.container = container;
    this.view = view;
    this.canvas = container.appendChild(document.createElement("canvas"));
    this.tip = container.appendChild(Object.assign(document.createElement("div"), { className: "tip", hidden: true }));
    view.pictures.push(this);
    new ResizeObserver(() => this.redraw()).observe(container);
    this.canvas.addEventListener("pointerdown", (event) => this.canvas.setPointerCapture(event.pointerId));
    this.canvas.addEventListener("pointermove", (event) => this.#moved(event));
    this.canvas.addEventListener("pointerleave", () => { this.tip.hidden = true; });
  }

  show(what) {
    this.what = what;
    this.redraw();
  }

  #moved(event) {
    if (event.buttons !== 1) return this.#read(event.offsetX, event.offsetY);
    this.view.azimuth -= 0.008 * event.movementX;
    this.view.elevation = Math.min(1.55, Math.max(-1.55, this.view.elevation + 0.008 * event.movementY));
    this.tip.hidden = true;
    for (const picture of this.view.pictures) picture.redraw();
    return undefined;
  }

  /** Page pixels and depth (larger is nearer) of a point of the axes. */
  #place(point) {
    const { axes, size } = this.what, { azimuth, elevation } = this.view;
    const [x, y, z] = point.map((value, k) => size[k] * ((value - axes[k].range[0]) / (axes[k].range[1] - axes[k].range[0]) - 0.5));
    const across = x * Math.cos(azimuth) + y * Math.sin(azimuth), away = y * Math.cos(azimuth) - x * Math.sin(azimuth);
    return [this.middle[0] + this.unit * across, this.middle[1] - this.unit * (z * Math.cos(elevation) + away * Math.sin(elevation)), z * Math.sin(elevation) - away * Math.cos(elevation)];
  }

  redraw() {
    const { clientWidth: width, clientHeight: height } = this.container, px = window.devicePixelRatio;
    if (!this.what || width === 0) return;
    Object.assign(this.canvas, { width: width * px, height: height * px });
    this.canvas.style.cssText = `width: ${width}px; height: ${height}px; touch-action: none; cursor: grab`;
    this.pen = this.canvas.getContext("2d");
    this.pen.scale(px, px);
    this.middle = [width / 2, height / 2];
    this.unit = Math.min(width, height) / (1.22 * Math.hypot(...this.what.size));
    this.#drawBox();
    if (this.what.surface) this.#drawSurface(this.what.surface);
    for (const { points, colour } of this.what.lines ?? []) this.#stroke(points, colour, 3);
  }

  #stroke(points, colour, width) {
    this.pen.strokeStyle = colour;
    this.pen.lineWidth = width;
    this.pen.lineCap = "round";
    this.pen.beginPath();
    for (const point of points) this.pen.lineTo(...this.#place(point).slice(0, 2));
    this.pen.stroke();
  }

  /** The three faces behind the contents with a line a number; the numbers and titles at edges in front. */
  #drawBox() {
    const { axes, ink } = this.what, ends = axes.map(({ range }) => range);
    const depth = (k, end) => this.#place(ends.map((range, axis) => (axis === k ? range[end] : (range[0] + range[1]) / 2)))[2];
    const far = [0, 1, 2].map((k) => ends[k][depth(k, 0) < depth(k, 1) ? 0 : 1]), near = far.map((value, k) => ends[k][value === ends[k][0] ? 1 : 0]);
    this.pen.font = FONT;
    this.pen.textBaseline = "middle";
    for (const k of [0, 1, 2]) {
      const others = [0, 1, 2].filter((axis) => axis !== k);
      for (const tick of [...ticks(ends[k]), ...ends[k]]) {
        for (const axis of others) {
          const corner = (value) => { const point = [...far]; point[k] = tick; point[axis] = value; return point; };
          this.#stroke(ends[axis].map(corner), ink.rule, 1);
        }
      }
      // Numbers where the face behind ends: below for the ground's axes, aside for the upright one.
      const edge = (value) => (k === 2 ? [near[0], far[1], value] : [0, 1, 2].map((axis) => (axis === k ? value : axis === 2 ? ends[2][0] : near[axis])));
      const [from, to] = ends[k].map((value) => this.#place(edge(value))), isLeft = (from[0] + to[0]) / 2 < this.middle[0];
      this.pen.textAlign = isLeft ? "right" : "left";
      this.pen.fillStyle = ink.quiet;
      const aside = isLeft ? -6 : 6, below = k === 2 ? 0 : 8;
      for (const tick of ticks(ends[k])) {
        const [x, y] = this.#place(edge(tick));
        this.pen.fillText(String(tick).replace("-", "−"), x + aside, y + below);
      }
      this.pen.fillStyle = ink.text;
      const title = k === 2 ? this.#place(edge(ends[2][1])) : [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
      this.pen.fillText(axes[k].title, title[0] + (k === 2 ? aside : 5 * aside), title[1] + (k === 2 ? -14 : 24));
    }
  }

  #drawSurface({ x, y, z, colourOf }) {
    const placed = z.map((row, j) => row.map((value, i) => (value === null ? null : this.#place([x[i], y[j], value]))));
    const facets = [];
    for (let j = 0; j + 1 < y.length; ++j) {
      for (let i = 0; i + 1 < x.length; ++i) {
        const corners = [[j, i], [j, i + 1], [j + 1, i + 1], [j + 1, i]].map(([a, b]) => placed[a][b]);
        if (corners.includes(null)) continue;
        const value = (z[j][i] + z[j][i + 1] + z[j + 1][i + 1] + z[j + 1][i]) / 4;
        facets.push({ corners, colour: colourOf(value), depth: corners.reduce((sum, corner) => sum + corner[2], 0) });
      }
    }
    this.pen.lineWidth = 0.7;
    for (const { corners, colour } of facets.sort((a, b) => a.depth - b.depth)) {
      this.pen.beginPath();
      for (const corner of corners) this.pen.lineTo(corner[0], corner[1]);
      this.pen.closePath();
      this.pen.fillStyle = colour;
      this.pen.fill();
      this.pen.strokeStyle = x.length * y.length > 2500 ? colour : "rgba(255, 255, 255, .4)";
      this.pen.stroke();
    }
  }

  /** The reading at the node of the surface under the pointer; of several the nearest to the viewer. */
  #read(left, top) {
    const surface = this.what.surface;
    let best = null;
    surface?.z.forEach((row, j) => row.forEach((value, i) => {
      if (value === null) return;
      const [x, y, depth] = this.#place([surface.x[i], surface.y[j], value]);
      if (Math.hypot(x - left, y - top) < NEAR_PX && !(best?.depth > depth)) best = { x, y, depth, text: surface.text(i, j) };
    }));
    this.tip.hidden = best === null;
    if (best === null) return;
    this.tip.textContent = best.text;
    this.tip.style.cssText = `left: ${best.x}px; top: ${best.y}px`;
  }
}
