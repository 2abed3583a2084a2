// Images of the joint.
import { absent, el, section } from "./dom.js";

function still(one) {
  const label = `${one.view}, ${one.label}`;
  return el("figure", {}, el("img", { src: `data:image/png;base64,${one.png}`, alt: `The joint, ${label}`, loading: "eager" }), el("figcaption", {}, label));
}

// One row per view; with fewer than three images a row has four columns, which keeps them small.
function perRow(stills) {
  const n = stills.filter((one) => one.view === stills[0].view).length;
  return n < 3 ? 4 : n;
}

export function stillsSection(model) {
  const { stills, note } = model.stills;
  return section("stills", "The joint", note ? absent(note) : null, stills.length > 0 ? el("div", { class: "stills", style: `--per-row: ${perRow(stills)}` }, stills.map(still)) : null);
}
