// Roles of the joint's six coordinates and the loads that hold them.
import { el, section, table } from "./dom.js";
import { gridTitle, wordOf } from "./format.js";
import { axis, figure, lineStyle } from "./plot.js";

const NAMES = { internal: "internal rotation" };
const ROTATIONS = ["flexion", "varus", "internal"];

function nameOf(model, coordinate) {
  return NAMES[coordinate.name] ?? wordOf(model, coordinate.name);
}

function holdingFigure(model, held, { title, unit, scale, caption }) {
  if (held.length === 0) return null;
  return figure({
    title, caption,
    make: () => ({
      data: held.map((one, k) => ({ type: "scatter", mode: "lines", name: nameOf(model, one), x: model.flexion, y: one.holding_load.map((v) => (v === null ? null : v * scale)), line: { ...lineStyle(k), width: 2 },
        hovertemplate: `${nameOf(model, one)}: %{y:.3f} ${unit} at %{x}<extra></extra>` })),
      layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(unit) },
    }),
  });
}

function determinedText(one) {
  if (one.role !== "free") return "";
  return one.determined === one.solved ? "yes" : `at ${one.determined} of ${one.solved}`;
}

/** Only for a model whose job gives roles to the coordinates. */
export function coordinatesSection(model) {
  const held = model.coordinates.filter((one) => one.role !== "free");
  const rows = model.coordinates.map((one) => [nameOf(model, one), one.role, determinedText(one)]);
  const sign = "along the coordinate, on the moving body; positive where it acts towards larger values.";
  return section("coordinates", "Driven, given and free coordinates",
    table("Grood-Suntay coordinates", ["coordinate", "role", "determined by contacts, fibres and loads"], rows),
    el("div", { class: "columns" },
      holdingFigure(model, held.filter((one) => ROTATIONS.includes(one.name)), { title: "Holding moments", unit: "N m", scale: 1e-3, caption: `Moment that holds each driven or given rotation, ${sign}` }),
      holdingFigure(model, held.filter((one) => !ROTATIONS.includes(one.name)), { title: "Holding forces", unit: "N", scale: 1, caption: `Force that holds each given translation, ${sign}` })));
}
