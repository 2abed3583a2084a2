// What every part of the page is made of: elements, numbers and names.

// Creates elements. Text is inserted as text nodes only: no string of a model is interpreted as HTML.

/** An element with attributes; children are elements or text. */
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

/** A section with a heading. */
export function section(id, title, ...children) {
  return el("section", { id, "aria-labelledby": `${id}-title` }, el("h2", { id: `${id}-title` }, title), ...children);
}

/** A box that reports missing content. */
export function absent(text) {
  return el("div", { class: "box absent" }, text);
}

/** A table; the first cell of a row is its heading. `kinds[k]`: class of column k. */
export function table(caption, headings, rows, { kinds = [], chosen = () => false } = {}) {
  const head = headings.map((text, k) => el("th", { scope: "col", class: kinds[k] }, text));
  const body = rows.map((row, r) => el("tr", { class: chosen(r) ? "chosen" : null },
    row.map((cell, k) => (k === 0 ? el("th", { scope: "row", class: kinds[k] }, cell) : el("td", { class: kinds[k] }, cell)))));
  return el("div", { class: "scroll", tabindex: "0" },
    el("table", {}, el("caption", {}, caption), el("thead", {}, el("tr", {}, head)), el("tbody", {}, body)));
}

/** A labelled select element; calls `changed` with the new value. */
export function choice(label, options, chosen, changed) {
  const select = el("select", {}, options.map(([value, text]) => el("option", { value, selected: value === chosen }, text)));
  select.addEventListener("change", () => changed(select.value));
  return el("label", {}, label, select);
}

/** A collapsed details element. */
export function folded(title, ...children) {
  return el("details", {}, el("summary", {}, title), ...children);
}

// Formats numbers and names for display.

/** Significant digits; a dash for a missing number. */
export function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const text = Math.abs(value) >= 1e-5 && Math.abs(value) < 1e6 ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1);
  return text.replace("-", "−");
}

/** A fixed number of decimals. */
export function decimal(value, digits = 2) {
  return value === null || value === undefined || !Number.isFinite(value) ? "–" : value.toFixed(digits).replace("-", "−");
}

/** A length in mm, small ones in micrometres. */
export function length(mm, digits = 3) {
  if (mm !== null && mm !== 0 && Math.abs(mm) < 0.01) return `${number(1000 * mm, digits)} µm`;
  return `${number(mm, digits)} mm`;
}

export function percent(share) {
  return share === null ? "–" : `${number(100 * share)} %`;
}

/** Display name of a set such as "degree_6_recontacted". */
export function motionName(set) {
  if (set === "raw") return "raw, along the spine";
  if (set === "two_sided") return "two-sided, both compartments in contact";
  if (set === "bones_alone") return "bones alone, without the prior";
  if (set === "zero_varus") return "zero varus, both compartments in contact";
  const found = /^degree_(\d+)(_recontacted)?$/.exec(set);
  return found ? `smoothed, degree ${found[1]}${found[2] ? ", recontacted" : ""}` : set;
}

/** Display name of a set over the whole grid. */
export function setName(set) {
  return set === "raw" ? "raw" : motionName(set);
}

/** A surface's name, sign and unit. */
export const PARAMETERS = {
  tx: { name: "x, anterior", unit: "mm" },
  ty: { name: "y, proximal", unit: "mm" },
  tz: { name: "z, to the subject’s right", unit: "mm" },
  theta: { name: "θ about Δ, internal +", unit: "degrees" },
  varus: { name: "solved varus, adduction +", unit: "degrees" },
  frame_flexion: { name: "flexion of the frame", unit: "degrees" },
};

export function parameterTitle(key) {
  return `${PARAMETERS[key].name}, ${PARAMETERS[key].unit}`;
}

/** What the joint's kind calls a rotation: "varus", or "adduction (abduction -)" of a hip. */
export function wordOf(model, rotation) {
  return (model.words?.[rotation] ?? rotation).replace("-", "−");
}

/** Title of an axis of the grid. If Delta is not proximal, its angles are about turned axes and not those of the joint. */
export function gridTitle(model, angle, unit = "degrees") {
  return `${wordOf(model, angle)}${model.axes_are_turned ? " of the attitude" : ""}, ${unit}`;
}
