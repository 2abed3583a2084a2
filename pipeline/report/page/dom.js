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
