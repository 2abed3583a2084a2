// The panel in space: a slider for flexion, buttons, and problems. Sizes in metres; drawn on a canvas.
import { CanvasTexture, DoubleSide, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace } from "three";

export const widthM = 0.36, heightM = 0.24;
const width = 1080, height = 720, margin = 36, buttonTop = 210, buttonHeight = 108, columns = 3, gap = 18;
const sliderTop = 452, sliderHeight = 96, ink = "#eef2f6", quiet = "#aab6c4", amber = "#ffb74a", accent = "#4aa3df";

export class XrPanel {
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
  draw({ title, note, marks, share, ends, buttons }) {
    const key = JSON.stringify([title, note, marks, share.toFixed(3), ends, buttons]);
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
