// A map over flexion (right) and varus (up) with the current attitude marked. A click or drag selects an attitude.

const marginLeft = 34, marginBottom = 24, marginTop = 4, marginRight = 8;

/// Limits of the cell around node k of an axis: the midpoints to its neighbours.
function edges(at, k) {
  const step = at.length > 1 ? (at.at(-1) - at[0]) / (at.length - 1) : 1;
  const low = k > 0 ? (at[k - 1] + at[k]) / 2 : at[0] - step / 2;
  const high = k + 1 < at.length ? (at[k] + at[k + 1]) / 2 : at.at(-1) + step / 2;
  return [low, high];
}

/// At most `most` round numbers within the range.
function ticks(low, high, most) {
  const step = [0.5, 1, 2, 5, 10, 15, 30, 45, 90].find((s) => (high - low) / s <= most) ?? 180;
  const found = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9; x += step) found.push(x);
  return found;
}

export class AttitudeMap {
  constructor(canvas, onSelect) {
    this.canvas = canvas;
    const select = (event) => {
      if (!this.axes || (event.type === "pointermove" && event.buttons === 0)) return;
      if (event.type === "pointerdown") canvas.setPointerCapture(event.pointerId);
      const box = canvas.getBoundingClientRect();
      onSelect(...this.#attitudeAt(event.clientX - box.left, event.clientY - box.top));
    };
    canvas.addEventListener("pointerdown", select);
    canvas.addEventListener("pointermove", select);
  }

  /// `colourOf(i, j)` returns [r, g, b] of a node; axes in degrees.
  setCells(axes, colourOf) {
    this.axes = axes;
    this.range = { flexion: [edges(axes.flexion, 0)[0], edges(axes.flexion, axes.flexion.length - 1)[1]],
                   varus: [edges(axes.varus, 0)[0], edges(axes.varus, axes.varus.length - 1)[1]] };
    this.colourOf = colourOf;
    this.underlay = null;
  }

  #x(flexion, width) { return marginLeft + ((flexion - this.range.flexion[0]) / (this.range.flexion[1] - this.range.flexion[0])) * (width - marginLeft - marginRight); }
  #y(varus, height) { return height - marginBottom - ((varus - this.range.varus[0]) / (this.range.varus[1] - this.range.varus[0])) * (height - marginBottom - marginTop); }

  #attitudeAt(x, y) {
    const { clientWidth: width, clientHeight: height } = this.canvas, { flexion, varus } = this.range;
    return [flexion[0] + ((x - marginLeft) / (width - marginLeft - marginRight)) * (flexion[1] - flexion[0]),
            varus[0] + ((height - marginBottom - y) / (height - marginBottom - marginTop)) * (varus[1] - varus[0])];
  }

  #drawCells(width, height, px) {
    const { width: w, height: h } = this.canvas;
    this.underlay = Object.assign(document.createElement("canvas"), { width: w, height: h });
    const pen = this.underlay.getContext("2d"), { flexion, varus } = this.axes;
    for (let i = 0; i < flexion.length; ++i) {
      const [left, right] = edges(flexion, i).map((f) => Math.round(px * this.#x(f, width)));
      for (let j = 0; j < varus.length; ++j) {
        const [bottom, top] = edges(varus, j).map((v) => Math.round(px * this.#y(v, height)));
        pen.fillStyle = `rgb(${this.colourOf(i, j).join(" ")})`;
        pen.fillRect(left, top, Math.max(right - left, 1), Math.max(bottom - top, 1));
      }
    }
    pen.scale(px, px);
    this.#drawTicks(pen, width, height);
  }

  #drawTicks(pen, width, height) {
    pen.fillStyle = "#4a5563";
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    for (const f of ticks(...this.range.flexion, 7)) pen.fillText(`${f}°`, this.#x(f, width), height - 8);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const v of this.axes.varus.length > 1 ? ticks(...this.range.varus, 5) : []) pen.fillText(`${v}°`.replace("-", "−"), marginLeft - 5, this.#y(v, height));
  }

  /// Marks the attitude, in degrees.
  draw(flexion, varus) {
    const { canvas } = this, { clientWidth: width, clientHeight: height } = canvas;
    if (!this.axes || width === 0) return;
    const px = Math.min(window.devicePixelRatio, 2), w = Math.round(width * px), h = Math.round(height * px);
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height, this.underlay] = [w, h, null];
    if (!this.underlay) this.#drawCells(width, height, px);
    const pen = canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, w, h);
    pen.drawImage(this.underlay, 0, 0);
    pen.scale(px, px);
    const x = this.#x(flexion, width), y = this.axes.varus.length > 1 ? this.#y(varus, height) : (height - marginBottom + marginTop) / 2;
    for (const [colour, thick] of [["#ffffff", 4], ["#11161d", 1.6]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = thick;
      pen.beginPath();
      pen.arc(x, y, 6, 0, 2 * Math.PI);
      pen.stroke();
    }
  }
}
