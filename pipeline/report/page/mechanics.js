// What moves and holds the joint, along the spine: contact paths, axes, equilibria, loads, coordinates.
import { cssOn, rangeOf, scaleBar, SCALES } from "./chart.js";
import { absent, decimal, el, gridTitle, section, table, wordOf } from "./page.js";
import { abscissaName, abscissaText, axis, compartmentColor, curve, dashNamed, figure, lineStyle, theme } from "./plot.js";
import { viewFrom } from "./space.js";

// Contact points of each compartment on both bodies.

// Colours of values over flexion, and their key below the plot.
function overFlexion(flexion) {
  const range = rangeOf(flexion);
  const name = abscissaName() === "flexion" ? "flexion, °" : abscissaName();
  return { colours: flexion.map((value) => cssOn(SCALES.cividis, value, range)), key: [scaleBar(SCALES.cividis, `${name}: ${decimal(range[0], 0)}`, decimal(range[1], 0))] };
}

// View along the long axis from above: the subject's right to the right (canonical Z), anterior up (canonical X). The first and the last point are labelled to show
// the direction of the path.
function pathLayers(model, { name, ...of }, body) {
  const points = of[body], x = points.map((p) => p[2]), y = points.map((p) => p[0]);
  const known = points.flatMap((p, k) => (p[0] === null ? [] : [k])), ends = known.length > 1 ? [known[0], known.at(-1)] : known;
  return [{ kind: "line", x, y, colour: compartmentColor(name), width: 3 },
    { kind: "points", x, y, colours: overFlexion(model.flexion).colours,
      text: (k) => `${name}, ${abscissaName()} ${abscissaText(model.flexion[k])}: right ${decimal(x[k], 1)}, anterior ${decimal(y[k], 1)} mm` },
    { kind: "texts", colour: theme().ink, texts: ends.map((k) => ({ x: x[k], y: y[k], text: abscissaText(model.flexion[k]), isLeft: name === "medial" })) }];
}

function outlineLayer(points) {
  const closed = [...points, points[0]];
  return { kind: "line", x: closed.map((p) => p[1]), y: closed.map((p) => p[0]), colour: theme().quiet, width: 1.3 };
}

function bodyFigure(model, body) {
  const paths = model.contact_paths;
  const outline = paths[`outline_${body}`];
  const name = model[body].name;
  return figure({
    title: `On the ${name}`, size: "tall",
    caption: `Contact points of each compartment, viewed along the ${name}’s long axis from above${outline.length > 0 ? ", with its outline" : ""}; mm, anterior upwards, the subject’s right to the right. Colour is ${abscissaName()}.`,
    make: () => ({
      x: axis("right, mm"), y: axis("anterior, mm"), isEqual: true, key: overFlexion(model.flexion).key,
      layers: [...(outline.length > 0 ? [outlineLayer(outline)] : []), ...paths.compartments.flatMap((one) => pathLayers(model, one, body))],
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

// Each axis is a segment around its crossing with the sagittal plane of the rotation centre, or around its own point; in [right, anterior, proximal].
function axisLines(model) {
  const { colours } = overFlexion(midFlexion(model));
  return model.axes.point_mm.flatMap((point, k) => {
    const direction = model.axes.direction[k];
    if (point[0] === null || direction[0] === null) return [];
    const middle = Math.abs(direction[2]) > 0.5 ? -point[2] / direction[2] : 0;
    return [{ colour: colours[k], points: [middle - HALF_LENGTH_MM, middle + HALF_LENGTH_MM].map((s) => [2, 0, 1].map((c) => point[c] + s * direction[c])) }];
  });
}

function helicalFigure(model) {
  const lines = axisLines(model);
  // A cube around the rotation centre keeps lengths and directions true and every title visible.
  const half = 1.05 * Math.max(...rangeOf(lines.flatMap(({ points }) => points.flat())).map(Math.abs), 1);
  return figure({
    title: "Finite helical axes", size: "tall", view: viewFrom(-0.6, 0.45),
    caption: "The rotation axis of the moving body from one flexion to the next, as segments of 100 mm in the axes of the reference body, mm from the rotation centre. Colour is flexion.",
    make: () => ({ size: [1, 1, 1], axes: ["right, mm", "anterior, mm", "proximal, mm"].map((title) => ({ title, range: [-half, half] })), lines, key: overFlexion(midFlexion(model)).key }),
  });
}

function centreFigure(model) {
  const centres = model.axes.instant_centre_mm, [x, y] = [0, 1].map((c) => centres.map((p) => p[c])), flexion = midFlexion(model);
  return figure({
    title: "Instant centres in the sagittal plane", size: "tall",
    caption: "Intersection of the helical axis with the sagittal plane of the reference body, anterior to the right; mm from the rotation centre. Colour is flexion.",
    make: () => {
      const { colours, key } = overFlexion(flexion);
      return { x: axis("anterior, mm"), y: axis("proximal, mm"), isEqual: true, key,
        layers: [{ kind: "line", x, y, colour: theme().rule, width: 1.2 },
          { kind: "points", x, y, colours, size: 7, text: (k) => `flexion ${flexion[k]}°: anterior ${decimal(x[k], 1)}, proximal ${decimal(y[k], 1)} mm` }] };
    },
  });
}

function rollingFigure(model) {
  const layers = () => ["medial", "lateral"].flatMap((name) => [["rolling", "solid"], ["sliding", "dot"]].map(([kind, dash]) =>
    curve(`${name}, ${kind}`, midFlexion(model), model.axes[`${name}_${kind}_mm`], "mm", { colour: compartmentColor(name), dash: dashNamed(dash) })));
  return figure({
    title: "Rolling and sliding",
    caption: "Contact travel from one flexion to the next: the part common to both surfaces (rolling) and their difference (sliding), mm per step. In a flexing knee the reference rolls backwards (−) and slides forwards (+); schemas/clinical.md has the formulas.",
    make: () => ({ x: axis(gridTitle(model, "flexion")), y: axis("mm per step"), layers: layers() }),
  });
}

function screwFigure(model) {
  return figure({
    title: "Rotation and translation along the axis",
    caption: "Rotation about the axis (degrees, left) and translation along it (mm, right) from one flexion to the next.",
    make: () => ({
      x: axis(gridTitle(model, "flexion")), y: axis("degrees per step", { fromZero: true }), right: axis("mm per step"),
      layers: [curve("rotation, degrees", midFlexion(model), model.axes.rotation_deg, "degrees", lineStyle(0)),
        curve("translation, mm", midFlexion(model), model.axes.translation_mm, "mm", { ...lineStyle(1), scale: "right" })],
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

// With solver.equilibrium.branch = "continuous" a chosen one may be higher than another.
const takesLowest = (branches) => excess(branches).every((value) => value > -1e-6);
const branchName = (branches, isChosen) => !isChosen ? "other equilibrium found"
  : takesLowest(branches) ? "chosen: lowest energy, the spine of the motion" : "chosen: continuous path, the spine of the motion";

// Energy above the chosen equilibrium of the same flexion.
function excess({ flexion, energy, is_chosen: isChosen }) {
  const chosen = new Map(flexion.flatMap((f, k) => (isChosen[k] ? [[f, energy[k]]] : [])));
  return energy.map((value, k) => value - chosen.get(flexion[k]));
}

function branchLayers(branches, values, isChosen, unit) {
  const rows = branches.flexion.map((_, k) => k).filter((k) => (branches.is_chosen[k] === 1) === isChosen), above = excess(branches);
  const x = rows.map((k) => branches.flexion[k]), y = rows.map((k) => values[k]), { colour } = lineStyle(isChosen ? 0 : 1);
  const text = (k) => `flexion ${x[k]}°: ${decimal(y[k], 2)} ${unit}, energy ${decimal(above[rows[k]], 3)} N mm above the chosen`;
  const points = { kind: "points", name: branchName(branches, isChosen), x, y, colour, size: isChosen ? 4 : 8, isOpen: !isChosen, text };
  return isChosen ? [{ kind: "line", name: points.name, x, y, colour, width: 1.6 }, points] : [points];
}

function branchFigure(model, { key, title, caption, label, unit }) {
  const { branches } = model.spine;
  return figure({ title, caption, make: () => ({ x: axis(gridTitle(model, "flexion")), y: axis(label), layers: [true, false].flatMap((isChosen) => branchLayers(branches, branches[key], isChosen, unit)) }) });
}

export function branchesSection(model) {
  const title = "Equilibria with free varus";
  if (!model.spine) return section("branches", title, absent("The stability search has no energies; method = \"equilibrium\" computes them."));
  const { branches } = model.spine;
  const nOther = branches.is_chosen.filter((one) => one === 0).length;
  const nFlexions = model.spine.n_optima.filter((n) => n > 1).length;
  const text = `From different starts the joint comes to rest in different poses. ${takesLowest(branches) ? "The motion uses the one of lowest energy." : "The motion uses the path over flexion with the least sum of energy and penalty on change (branch = \"continuous\")."} ${nOther} other equilibria were found, at ${nFlexions} of ${model.flexion.length} flexions. Equilibria are distinct if they differ by more than 0.1 mm, or 0.1 degrees of rotation or varus.`;
  return section("branches", title, el("p", {}, text), el("div", { class: "columns" },
    branchFigure(model, { key: "energy", title: "Energy", label: "N mm", unit: "N mm", caption: "Energy of the ligaments minus the work of the loads, N mm." }),
    branchFigure(model, { key: "theta", title: "Rotation θ about Δ", label: "degrees", unit: "degrees", caption: "Rotation of each equilibrium, internal +, degrees." })));
}

// Contact forces by compartment and fibre strain and tension by bundle.

function share(part, forces, k) {
  const sum = forces.medial_n[k] + forces.lateral_n[k] + forces.none_n[k];
  return forces.medial_n[k] === null || sum === 0 ? null : (100 * part[k]) / sum;
}

// The compartments' shares above one another.
function shareLayers(model) {
  const { forces, flexion } = model, kinds = [["medial_n", "medial", compartmentColor("medial")], ["lateral_n", "lateral", compartmentColor("lateral")], ["none_n", "neither", theme().quiet]];
  let low = flexion.map(() => 0);
  return kinds.filter(([key]) => key !== "none_n" || forces.none_n.some((value) => value > 0)).flatMap(([key, name, colour]) => {
    const own = flexion.map((_, k) => share(forces[key], forces, k)), from = low, high = own.map((part, k) => (part === null ? null : from[k] + part));
    low = high;
    return [{ kind: "band", name, x: flexion, low: from, high, colour: `${colour}99` },
      { kind: "line", name, x: flexion, y: high, colour, width: 1, text: (k) => `${name}: ${decimal(own[k], 1)} % at ${flexion[k]}°` }];
  });
}

function shareFigure(model) {
  return figure({
    title: "Share of the load",
    caption: "Contact force along Δ carried by each compartment, per cent of the total contact force along the spine.",
    make: () => ({ x: axis(gridTitle(model, "flexion")), y: axis("per cent", { range: [0, 100] }), layers: shareLayers(model) }),
  });
}

// Curves by compartment, of names and values along the spine.
function compartmentFigure(model, { title, caption, unit, curves }) {
  return figure({ title, caption,
    make: () => ({ x: axis(gridTitle(model, "flexion")), y: axis(unit, { fromZero: true }),
      layers: curves.map(({ name, values }) => curve(name, model.flexion, values, unit, { colour: compartmentColor(name) })) }) });
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
    make: () => ({ x: axis(gridTitle(model, "flexion")), y: axis(unit),
      layers: model.fibres.map((bundle, k) => curve(`${bundle.name} (${bundle.n_fibres})`, model.flexion, bundle[key].map((v) => (v === null ? null : scale * v)), unit, lineStyle(k))) }),
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
    make: () => ({ x: axis(gridTitle(model, "flexion")), y: axis(unit),
      layers: held.map((one, k) => curve(coordinateName(model, one), model.flexion, one.holding_load.map((v) => (v === null ? null : v * scale)), unit, lineStyle(k))) }),
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
