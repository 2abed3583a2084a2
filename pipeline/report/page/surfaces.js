// Raw next to smoothed surfaces, as in figure 16 of the thesis.
import { curvePlots } from "./curves.js";
import { absent, choice, el, section } from "./dom.js";
import { axis, figure, scene } from "./plot.js";
import { extent, gridTitle, parameterTitle, PARAMETERS, setName } from "./format.js";

const SCALE = "Viridis";
const AROUND_ZERO = [[0, "#0b6aa8"], [0.5, "#f1f0ec"], [1, "#c2500a"]];
const START_CAMERA = { eye: { x: -1.4, y: -1.55, z: 0.87 }, center: { x: 0, y: 0, z: -0.13 } };

function difference(a, b) {
  return a.map((row, i) => row.map((value, j) => (value === null || b[i][j] === null ? null : value - b[i][j])));
}

function transposed(grid) {
  return grid[0].map((_, j) => grid.map((row) => row[j]));
}

function rangeOf(grids) {
  const [least, most] = extent(grids.flat(2));
  return least < most ? [least, most] : [least - 1, least + 1];
}

function surfaceTrace(model, z, range) {
  const unitLines = { show: true, color: "rgba(255,255,255,.35)", width: 1 };
  return { type: "surface", x: model.varus, y: model.flexion, z, cmin: range[0], cmax: range[1], colorscale: SCALE, showscale: false,
    contours: { x: { ...unitLines, size: 2, start: model.varus[0], end: model.varus.at(-1) }, y: { ...unitLines, size: 10, start: model.flexion[0], end: model.flexion.at(-1) } },
    lighting: { ambient: 0.75, diffuse: 0.5, specular: 0.05 },
    hovertemplate: "flexion %{y}°, varus %{x}°: %{z:.3f}<extra></extra>" };
}

function heatTrace(model, grid, range, colorscale = SCALE) {
  return { type: "heatmap", x: model.flexion, y: model.varus, z: transposed(grid), zmin: range[0], zmax: range[1], colorscale, zsmooth: false,
    colorbar: { thickness: 12, outlinewidth: 0, len: 0.95 }, hovertemplate: "flexion %{x}°, varus %{y}°: %{z:.3f}<extra></extra>" };
}

function surfaceLayout(model, state, range) {
  const axes = scene(gridTitle(model, "varus", "°"), gridTitle(model, "flexion", "°"), PARAMETERS[state.parameter].unit, { camera: state.camera, aspectmode: "manual", aspectratio: { x: 1.1, y: 1.25, z: 0.75 } });
  axes.zaxis.range = range;
  return { scene: axes, margin: { l: 0, r: 0, t: 0, b: 0 } };
}

function heatLayout(model) {
  return { xaxis: axis(gridTitle(model, "flexion")), yaxis: axis(`${gridTitle(model, "varus")}${model.words ? "" : " (adduction +)"}`) };
}

function panel(model, state, isRaw) {
  const raw = () => model.surfaces[0][state.parameter];
  const smoothed = () => state.set[state.parameter];
  const make = () => {
    const range = rangeOf([raw(), smoothed()]);
    const grid = isRaw ? raw() : smoothed();
    if (state.view === "surface") return { data: [surfaceTrace(model, grid, range)], layout: surfaceLayout(model, state, range) };
    return { data: [heatTrace(model, grid, range)], layout: heatLayout(model) };
  };
  return figure({ title: isRaw ? "Raw" : "Smoothed", size: "tall", make,
    caption: isRaw ? "The solver's result at each attitude; holes are attitudes without a pose."
      : "The least-squares polynomial with the same axes and colours; set and parameter are selected above." });
}

function residualPanel(model, state) {
  return figure({
    title: "Smoothed minus raw", size: "low",
    caption: "Change by smoothing at each attitude, in the unit of the parameter; pale is no change. Changes above 0.145 mm or 0.27 degrees are perceptible on the bench.",
    make: () => {
      const grid = difference(state.set[state.parameter], model.surfaces[0][state.parameter]);
      const most = Math.max(...extent(grid.flat()).map(Math.abs), 1e-9);
      return { data: [heatTrace(model, grid, [-most, most], AROUND_ZERO)], layout: heatLayout(model) };
    },
  });
}

// Rotating one scene rotates the other.
function linkCameras(figures, state) {
  figures.forEach((one, k) => {
    one.addEventListener("pointerup", () => {
      const camera = one.plotNode.layout?.scene?.camera;
      if (state.view !== "surface" || !camera) return;
      state.camera = camera;
      figures[1 - k].redraw();
    });
  });
}

function controls(model, state, redraw) {
  const parameters = Object.keys(PARAMETERS).filter((key) => model.surfaces[0][key]);
  const smoothed = model.surfaces.slice(1);
  const items = [choice("Parameter", parameters.map((key) => [key, parameterTitle(key)]), state.parameter, (value) => { state.parameter = value; redraw(); })];
  if (smoothed.length > 1) {
    items.push(choice("Smoothed set", smoothed.map((set) => [set.name, setName(set.name)]), state.set.name, (value) => { state.set = smoothed.find((set) => set.name === value); redraw(); }));
  }
  items.push(choice("View", [["surface", "surface"], ["map", "map"]], state.view, (value) => { state.view = value; redraw(); }));
  return el("div", { class: "controls" }, items);
}

// The recommended degree if it is in the file, else the highest.
function preferred(model) {
  const smoothed = model.surfaces.slice(1);
  return smoothed.find((set) => set.name === `degree_${model.comparison?.recommended}`) ?? smoothed.at(-1) ?? model.surfaces[0];
}

function gridParts(model) {
  const state = { parameter: "tx", set: preferred(model), view: "surface", camera: START_CAMERA };
  const hasSmoothed = model.surfaces.length > 1;
  const panels = hasSmoothed ? [panel(model, state, true), panel(model, state, false)] : [panel(model, state, true)];
  const residual = hasSmoothed ? residualPanel(model, state) : null;
  const redraw = () => [...panels, residual].filter(Boolean).forEach((one) => { one.plotNode.replaceChildren(); window.Plotly.purge(one.plotNode); one.redraw(); });
  if (hasSmoothed) linkCameras(panels, state);
  return [controls(model, state, redraw), hasSmoothed ? el("div", { class: "columns" }, panels) : panels, residual];
}

// A single axis: curves of each parameter, raw as points, smoothed as lines; only the preferred set is shown at first.
function overOneAxis(model) {
  const isFlexion = model.flexion.length >= model.varus.length;
  const keys = Object.keys(PARAMETERS).filter((key) => model.surfaces[0][key]);
  const values = (set, key) => (isFlexion ? set[key].map((row) => row[0]) : set[key][0]);
  const shown = preferred(model).name.replace("_recontacted", "");
  const curves = model.surfaces.map((set) => ({
    label: setName(set.name), flexion: isFlexion ? model.flexion : model.varus, isPoints: set.name === "raw", isOff: !["raw", shown, `${shown}_recontacted`].includes(set.name),
    ...Object.fromEntries(keys.filter((key) => set[key]).map((key) => [key, values(set, key)])) }));
  const caption = (key) => `Raw as points, smoothed as lines; ${PARAMETERS[key].unit}, in world axes (θ and varus with right-knee signs).`;
  return [curvePlots(curves, keys.map((key) => ({ key, ...PARAMETERS[key], caption: caption(key) })), { over: gridTitle(model, isFlexion ? "flexion" : "varus") })];
}

export function surfacesSection(model) {
  const isGrid = model.flexion.length > 1 && model.varus.length > 1;
  const intro = isGrid ? "Each parameter of the pose over flexion and varus, solved and smoothed by polynomials. Drag to rotate both views."
    : "Each parameter of the pose over the only axis of this model.";
  const missing = model.surfaces.length > 1 || model.key_name ? null : absent("The file has no smoothed set; vrda smooth FILE --degree 6 adds one.");
  return section("surfaces", "Raw and smoothed motion", el("p", {}, intro), missing, ...(isGrid ? gridParts(model) : overOneAxis(model)));
}
