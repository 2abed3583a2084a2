// What moves and holds the joint, along the spine: contact paths, axes, equilibria, loads, coordinates.
import { absent, decimal, el, extent, gridTitle, section, table, wordOf } from "./page.js";
import { abscissaName, abscissaText, axis, compartmentColor, figure, lineStyle, scene, theme } from "./plot.js";

// Contact points of each compartment on both bodies.

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
        coloraxis: { colorscale: "Cividis", colorbar: { thickness: 10, len: 0.8, outlinewidth: 0, title: { text: abscissaName() === "flexion" ? gridTitle(model, "flexion", "°") : abscissaName(), side: "right" } } },
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

// Finite helical axes, instant centres, rolling and sliding.

const HALF_LENGTH_MM = 50;

function midFlexion(model) {
  return model.flexion.slice(1).map((value, k) => 0.5 * (value + model.flexion[k]));
}

// Each axis is a segment around its crossing with the sagittal plane of the rotation centre, or around its own point.
function axisSegments(model) {
  const segments = { x: [], y: [], z: [], color: [] };
  const flexion = midFlexion(model);
  model.axes.point_mm.forEach((point, k) => {
    const direction = model.axes.direction[k];
    if (point[0] === null || direction[0] === null) return;
    const middle = Math.abs(direction[2]) > 0.5 ? -point[2] / direction[2] : 0;
    for (const t of [middle - HALF_LENGTH_MM, middle + HALF_LENGTH_MM]) {
      segments.x.push(point[0] + t * direction[0]);
      segments.y.push(point[1] + t * direction[1]);
      segments.z.push(point[2] + t * direction[2]);
      segments.color.push(flexion[k]);
    }
    for (const key of ["x", "y", "z"]) segments[key].push(null);
    segments.color.push(flexion[k]);
  });
  return segments;
}

// plotly draws its third axis upwards: canonical Y, proximal.
function helicalFigure(model) {
  return figure({
    title: "Finite helical axes", size: "tall",
    caption: "The rotation axis of the moving body from one flexion to the next, as segments of 100 mm in the axes of the reference body, mm from the rotation centre. Colour is flexion.",
    make: () => {
      const s = axisSegments(model);
      const line = { color: s.color, colorscale: "Cividis", width: 4, showscale: true, colorbar: { thickness: 10, len: 0.7, outlinewidth: 0, title: { text: gridTitle(model, "flexion", "°"), side: "right" } } };
      // A cube around the rotation centre keeps lengths and directions true and every title visible.
      const half = 1.05 * Math.max(...extent([...s.x, ...s.y, ...s.z]).map(Math.abs));
      const axes = scene("right, mm", "anterior, mm", "proximal, mm", { aspectmode: "cube", camera: { eye: { x: 1.6, y: 1.6, z: 0.9 }, center: { x: 0.14, y: -0.14, z: -0.1 } } });
      for (const one of [axes.xaxis, axes.yaxis, axes.zaxis]) one.range = [-half, half];
      return {
        data: [{ type: "scatter3d", mode: "lines", x: s.z, y: s.x, z: s.y, line, hoverinfo: "skip" }],
        layout: { scene: axes, margin: { l: 0, r: 0, t: 0, b: 0 } },
      };
    },
  });
}

function centreFigure(model) {
  const centres = model.axes.instant_centre_mm;
  return figure({
    title: "Instant centres in the sagittal plane", size: "tall",
    caption: "Intersection of the helical axis with the sagittal plane of the reference body, anterior to the right; mm from the rotation centre. Colour is flexion.",
    make: () => ({
      data: [{ type: "scatter", mode: "lines+markers", x: centres.map((p) => p[0]), y: centres.map((p) => p[1]), customdata: midFlexion(model),
        line: { color: theme().rule, width: 1.2 }, marker: { size: 7, color: midFlexion(model), coloraxis: "coloraxis" },
        hovertemplate: "flexion %{customdata}°: anterior %{x:.1f}, proximal %{y:.1f} mm<extra></extra>" }],
      layout: { xaxis: axis("anterior, mm"), yaxis: axis("proximal, mm", { scaleanchor: "x" }), coloraxis: { colorscale: "Cividis", colorbar: { thickness: 10, len: 0.7, outlinewidth: 0, title: { text: gridTitle(model, "flexion", "°"), side: "right" } } } },
    }),
  });
}

function rollingFigure(model) {
  const flexion = midFlexion(model);
  const series = ["medial", "lateral"].flatMap((name) => [["rolling", "solid"], ["sliding", "dot"]].map(([kind, dash]) => ({
    type: "scatter", mode: "lines", name: `${name}, ${kind}`, x: flexion, y: model.axes[`${name}_${kind}_mm`], line: { color: compartmentColor(name), dash, width: 2 },
    hovertemplate: `${name}, ${kind}: %{y:.2f} mm at %{x}°<extra></extra>` })));
  return figure({
    title: "Rolling and sliding",
    caption: "Contact travel from one flexion to the next: the part common to both surfaces (rolling) and their difference (sliding), mm per step. In a flexing knee the reference rolls backwards (−) and slides forwards (+); schemas/clinical.md has the formulas.",
    make: () => ({ data: series, layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis("mm per step") } }),
  });
}

function screwFigure(model) {
  return figure({
    title: "Rotation and translation along the axis",
    caption: "Rotation about the axis (degrees, left) and translation along it (mm, right) from one flexion to the next.",
    make: () => ({
      data: [
        { type: "scatter", mode: "lines", name: "rotation, degrees", x: midFlexion(model), y: model.axes.rotation_deg, line: { ...lineStyle(0), width: 2 } },
        { type: "scatter", mode: "lines", name: "translation, mm", x: midFlexion(model), y: model.axes.translation_mm, yaxis: "y2", line: { ...lineStyle(1), width: 2 } },
      ],
      layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis("degrees per step", { rangemode: "tozero" }), yaxis2: axis("mm per step", { overlaying: "y", side: "right", showgrid: false }) },
    }),
  });
}

export function axesSection(model) {
  if (!model.axes) return section("axes", "Axes of the motion", absent("The file has no flexion-only motion; vrda reduce FILE adds it, with helical axes, instant centres, rolling and sliding."));
  const hasRolling = model.axes.medial_rolling_mm.length > 0;
  return section("axes", "Axes of the motion", el("p", {}, "Zero-varus motion between neighbouring flexions; steps too small to determine an axis are omitted."),
    el("div", { class: "columns" }, helicalFigure(model), centreFigure(model)),
    el("div", { class: "columns" }, screwFigure(model), hasRolling ? rollingFigure(model) : null));
}

// The distinct equilibria of the free spine at each flexion, and which of them the motion uses.

const BRANCH_NAMES = { true: "chosen: lowest energy, the spine of the motion", false: "other equilibrium found" };

// Energy above the chosen equilibrium of the same flexion.
function excess({ flexion, energy, is_chosen: isChosen }) {
  const chosen = new Map(flexion.flatMap((f, k) => (isChosen[k] ? [[f, energy[k]]] : [])));
  return energy.map((value, k) => value - chosen.get(flexion[k]));
}

function branchTrace(branches, values, isChosen, unit) {
  const rows = branches.flexion.map((_, k) => k).filter((k) => (branches.is_chosen[k] === 1) === isChosen);
  const above = excess(branches);
  const { color } = lineStyle(isChosen ? 0 : 1);
  return { type: "scatter", mode: isChosen ? "lines+markers" : "markers", name: BRANCH_NAMES[isChosen], x: rows.map((k) => branches.flexion[k]), y: rows.map((k) => values[k]),
    marker: { color, size: isChosen ? 4 : 8, symbol: isChosen ? "circle" : "circle-open", line: { color, width: isChosen ? 0 : 1.5 } }, line: { color, width: 1.6 },
    customdata: rows.map((k) => decimal(above[k], 3)), hovertemplate: `flexion %{x}°: %{y:.2f} ${unit}, energy %{customdata} N mm above the chosen<extra></extra>` };
}

function branchFigure(model, { key, title, caption, label, unit }) {
  const { branches } = model.spine;
  return figure({ title, caption, make: () => ({
    data: [branchTrace(branches, branches[key], true, unit), branchTrace(branches, branches[key], false, unit)],
    layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(label) } }) });
}

export function branchesSection(model) {
  const title = "Equilibria with free varus";
  if (!model.spine) return section("branches", title, absent("The stability search has no energies; method = \"equilibrium\" computes them."));
  const { branches } = model.spine;
  const nOther = branches.is_chosen.filter((one) => one === 0).length;
  const nFlexions = model.spine.n_optima.filter((n) => n > 1).length;
  const text = `From different starts the joint comes to rest in different poses. The motion uses the one of lowest energy. ${nOther} other equilibria were found, at ${nFlexions} of ${model.flexion.length} flexions. Equilibria are distinct if they differ by more than 0.1 mm, or 0.1 degrees of rotation or varus.`;
  return section("branches", title, el("p", {}, text), el("div", { class: "columns" },
    branchFigure(model, { key: "energy", title: "Energy", label: "N mm", unit: "N mm", caption: "Energy of the ligaments minus the work of the loads, N mm." }),
    branchFigure(model, { key: "theta", title: "Rotation θ about Δ", label: "degrees", unit: "degrees", caption: "Rotation of each equilibrium, internal +, degrees." })));
}

// Contact forces by compartment and fibre strain and tension by bundle.

function share(part, forces, k) {
  const sum = forces.medial_n[k] + forces.lateral_n[k] + forces.none_n[k];
  return forces.medial_n[k] === null || sum === 0 ? null : (100 * part[k]) / sum;
}

function area(model, forces, key, name, color) {
  return { type: "scatter", mode: "lines", stackgroup: "share", name, x: model.flexion, y: model.flexion.map((_, k) => share(forces[key], forces, k)), line: { color, width: 1 }, fillcolor: `${color}99`,
    hovertemplate: `${name}: %{y:.1f} % at %{x}°<extra></extra>` };
}

function shareFigure(model) {
  const { forces } = model;
  const hasOther = forces.none_n.some((value) => value > 0);
  return figure({
    title: "Share of the load",
    caption: "Contact force along Δ carried by each compartment, per cent of the total contact force along the spine.",
    make: () => ({
      data: [area(model, forces, "medial_n", "medial", compartmentColor("medial")), area(model, forces, "lateral_n", "lateral", compartmentColor("lateral")),
        ...(hasOther ? [area(model, forces, "none_n", "neither", theme().quiet)] : [])],
      layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis("per cent", { range: [0, 100] }) },
    }),
  });
}

// Curves by compartment, of names and values along the spine.
function compartmentFigure(model, { title, caption, unit, curves }) {
  const line = ({ name, values }) => ({ type: "scatter", mode: "lines", name, x: model.flexion, y: values, line: { color: compartmentColor(name), width: 2 },
    hovertemplate: `${name}: %{y:.1f} ${unit} at ${abscissaText("%{x}")}<extra></extra>` });
  return figure({ title, caption, make: () => ({ data: curves.map(line), layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(unit, { rangemode: "tozero" }) } }) });
}

function forceFigure(model) {
  return compartmentFigure(model, {
    title: "Contact force", caption: "Force along Δ in each compartment, N; with fibres it exceeds the push, since their tension adds to it.", unit: "N",
    curves: [{ name: "medial", values: model.forces.medial_n }, { name: "lateral", values: model.forces.lateral_n }],
  });
}

/** The groups of curves that the program computes along the spine. */
export function curvesSection(model) {
  return section("curves", "Curves along the spine", el("div", { class: "columns" }, ...model.flexion_curves.map((group) => compartmentFigure(model, group))));
}

function bundleFigure(model, { key, scale, title, caption, unit }) {
  return figure({
    title, caption, size: "tall",
    make: () => ({
      data: model.fibres.map((bundle, k) => ({ type: "scatter", mode: "lines", name: `${bundle.name} (${bundle.n_fibres})`, x: model.flexion, y: bundle[key].map((v) => (v === null ? null : scale * v)), line: { ...lineStyle(k), width: 2 },
        hovertemplate: `${bundle.name}: %{y:.2f} ${unit} at %{x}°<extra></extra>` })),
      layout: { showlegend: true, xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(unit), margin: { l: 58, r: 16, t: 12, b: 90 } },
    }),
  });
}

export function forcesSection(model) {
  if (!model.forces) return section("forces", "Load on the compartments", absent("The stability search computes contacts but no forces; method = \"equilibrium\" computes both."));
  if (!model.has_compartments) return section("forces", "Load on the compartments", absent("This joint has no compartments."));
  return section("forces", "Load on the compartments", el("div", { class: "columns" }, shareFigure(model), forceFigure(model)));
}

export function fibresSection(model) {
  if (!model.fibres) return section("fibres", "Ligaments", absent("The job has no ligament fibres."));
  return section("fibres", "Ligaments", el("p", {}, "By bundle along the spine, with the number of fibres in brackets. A fibre with negative strain is slack and has no tension."),
    el("div", { class: "columns" },
      bundleFigure(model, { key: "largest_strain", scale: 100, title: "Strain", unit: "per cent", caption: "Largest fibre strain in each bundle, per cent of the slack length." }),
      bundleFigure(model, { key: "tension_n", scale: 1, title: "Tension", unit: "N", caption: "Total tension of the fibres of a bundle, N." })));
}

// Roles of the joint's six coordinates and the loads that hold them.

const COORDINATE_NAMES = { internal: "internal rotation" };
const ROTATIONS = ["flexion", "varus", "internal"];

function coordinateName(model, coordinate) {
  return COORDINATE_NAMES[coordinate.name] ?? wordOf(model, coordinate.name);
}

function holdingFigure(model, held, { title, unit, scale, caption }) {
  if (held.length === 0) return null;
  return figure({
    title, caption,
    make: () => ({
      data: held.map((one, k) => ({ type: "scatter", mode: "lines", name: coordinateName(model, one), x: model.flexion, y: one.holding_load.map((v) => (v === null ? null : v * scale)), line: { ...lineStyle(k), width: 2 },
        hovertemplate: `${coordinateName(model, one)}: %{y:.3f} ${unit} at %{x}<extra></extra>` })),
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
  const rows = model.coordinates.map((one) => [coordinateName(model, one), one.role, determinedText(one)]);
  const sign = "along the coordinate, on the moving body; positive where it acts towards larger values.";
  return section("coordinates", "Driven, given and free coordinates",
    table("Grood-Suntay coordinates", ["coordinate", "role", "determined by contacts, fibres and loads"], rows),
    el("div", { class: "columns" },
      holdingFigure(model, held.filter((one) => ROTATIONS.includes(one.name)), { title: "Holding moments", unit: "N m", scale: 1e-3, caption: `Moment that holds each driven or given rotation, ${sign}` }),
      holdingFigure(model, held.filter((one) => !ROTATIONS.includes(one.name)), { title: "Holding forces", unit: "N", scale: 1, caption: `Force that holds each given translation, ${sign}` })));
}
