// Finite helical axes, instant centres, rolling and sliding.
import { absent, el, section } from "./dom.js";
import { axis, compartmentColor, figure, lineStyle, scene, theme } from "./plot.js";
import { extent, gridTitle } from "./format.js";

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
