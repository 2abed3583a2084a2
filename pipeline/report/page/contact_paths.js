// Contact points of each compartment on both bodies.
import { absent, el, section } from "./dom.js";
import { abscissaName, abscissaText, axis, compartmentColor, figure, theme } from "./plot.js";

// View along the long axis from above: the subject's right to the right (canonical Z), anterior up (canonical X).
function pathTrace(model, compartment, body) {
  const points = compartment[body];
  const color = compartmentColor(compartment.name);
  return {
    type: "scatter", mode: "lines+markers", name: compartment.name,
    x: points.map((p) => p[2]), y: points.map((p) => p[0]), customdata: model.flexion,
    line: { color, width: 3 },
    marker: { size: 6, color: model.flexion, coloraxis: "coloraxis", line: { color, width: 0.8 } },
    hovertemplate: `${compartment.name}, ${abscissaName()} ${abscissaText("%{customdata}")}: right %{x:.1f}, anterior %{y:.1f} mm<extra></extra>`,
  };
}

function outlineTrace(points) {
  const closed = [...points, points[0]];
  return { type: "scatter", mode: "lines", x: closed.map((p) => p[1]), y: closed.map((p) => p[0]), line: { color: theme().quiet, width: 1.3 }, hoverinfo: "skip" };
}

// Labels the first and the last point to show the direction of the path.
function endLabels(model, compartment, body) {
  const known = compartment[body].map((p, k) => [p, model.flexion[k]]).filter(([p]) => p[0] !== null);
  const ends = known.length > 1 ? [known[0], known.at(-1)] : known;
  return ends.map(([p, flexion]) => ({ x: p[2], y: p[0], text: abscissaText(flexion), showarrow: true, arrowhead: 0, arrowwidth: 0.8, arrowcolor: theme().quiet, ax: compartment.name === "medial" ? -26 : 26, ay: -16, font: { size: 11 } }));
}

function bodyFigure(model, body) {
  const paths = model.contact_paths;
  const outline = paths[`outline_${body}`];
  const name = model[body].name;
  return figure({
    title: `On the ${name}`, size: "tall",
    caption: `Contact points of each compartment, viewed along the ${name}’s long axis from above${outline.length > 0 ? ", with its outline" : ""}; mm, anterior upwards, the subject’s right to the right. Colour is ${abscissaName()}.`,
    make: () => ({
      data: [...(outline.length > 0 ? [outlineTrace(outline)] : []), ...paths.compartments.map((c) => pathTrace(model, c, body))],
      layout: {
        xaxis: axis("right, mm"), yaxis: axis("anterior, mm", { scaleanchor: "x", scaleratio: 1 }),
        annotations: paths.compartments.flatMap((c) => endLabels(model, c, body)),
        coloraxis: { colorscale: "Cividis", colorbar: { thickness: 10, len: 0.8, outlinewidth: 0, title: { text: abscissaName(), side: "right" } } },
      },
    }),
  });
}

export function contactPathsSection(model) {
  if (!model.contact_paths) return section("contact-paths", "Contact paths", absent("This joint has no compartments, hence no contact paths."));
  const source = model.axes ? "the zero-varus motion" : "the raw motion along the spine";
  return section("contact-paths", "Contact paths",
    el("p", {}, `Contact points of the medial (blue) and lateral (orange) compartments along ${source}: the force-weighted mean for the equilibrium, the mean of the contacts for the search.`),
    el("div", { class: "columns" }, bodyFigure(model, "moving"), bodyFigure(model, "reference")));
}
