// A second model, or this one with another motion: beside the first or over it, and differences over flexion, the second minus the first.
import { degree } from "./geometry.js";
import { Joint } from "./joint.js";
import { Player } from "./motion.js";
import { bandOf, columnsAlong, CurvePlot, lineStyle, sampledFlexion } from "./plots.js";
import { clinicalNumbers, clinicalOf, formatNumber } from "./readings.js";
import { pathsStructure } from "./structures.js";

const overlaidOpacity = 0.4, another = "file";

/// [{ name, title, unit, numbers }]: the plots of differences; without numbers that of the bundles.
const plots = [{ name: "rotation", title: "rotation", unit: "°", numbers: ["internal", "varus"] }, { name: "translation", title: "translation", unit: "mm", numbers: ["anterior", "proximal", "lateral"] },
  { name: "bundles", title: "largest strain", unit: "%" }];

const valueAt = (band, axis, flexion, end) => {
  const above = axis.findIndex((x) => x >= flexion);
  if (above <= 0) return band[end][Math.max(above, 0)];
  const s = (flexion - axis[above - 1]) / (axis[above] - axis[above - 1]);
  return (1 - s) * band[end][above - 1] + s * band[end][above];
};

export class Comparison {
  /// `host`: player(), joint(), nameOf(structure), setLabel(set), goTo({ flexion }), onChange(joint or null), bundles(), bundleBand(id, x).
  constructor(byId, host) {
    Object.assign(this, { byId, host, player: null, joint: null });
    this.plots = plots.map((plot) => {
      const figure = document.createElement("figure");
      figure.append(Object.assign(document.createElement("figcaption"), { textContent: `Difference of ${plot.numbers ? plot.title : "strain of each bundle"} over flexion, second minus first` }));
      byId("differences").append(figure);
      return { ...plot, figure, plot: new CurvePlot(figure.appendChild(document.createElement("div")), (flexion) => host.goTo({ flexion })) };
    });
    byId("compare").addEventListener("change", () => {
      const { value } = byId("compare");
      if (value === another) {
        byId("compare").value = "";
        byId("other").click();
      }
      if (value === "" || value === another) return this.#use(null);
      this.#use(host.player().model, host.setLabel(value), value);
    });
    for (const id of ["compare-as", "compare-without"]) byId(id).addEventListener("change", () => host.onChange(this.joint));
  }

  /// The first model is another: nothing is compared.
  reset() {
    const { byId, host } = this, option = (value, textContent) => Object.assign(document.createElement("option"), { value, textContent });
    byId("compare").replaceChildren(option("", "nothing"), ...host.player().sets.map((set) => option(set, `this model: ${host.setLabel(set)}`)), option(another, "another file…"));
    this.#use(null);
  }

  /// A file that was opened.
  open(model, name) {
    const shown = Object.assign(document.createElement("option"), { value: "opened", textContent: name, hidden: true });
    this.byId("compare").append(shown);
    this.#use(model, name);
    shown.selected = true;
  }

  #use(model, name, set) {
    const { byId } = this;
    const before = this.joint;
    [this.joint, this.player, this.name] = model ? [new Joint(model), new Player(model), name] : [null, null, ""];
    if (set) this.player.set = set;
    const bundles = model ? this.joint.ligaments.flatMap(({ layer }) => layer.bundles.map(({ structure }) => structure)) : [];
    byId("compare-without").replaceChildren(...["", ...new Set(bundles)].map((id) => Object.assign(document.createElement("option"), { value: id, textContent: id ? `${id.split("/").at(-1)} not drawn` : "whole" })));
    for (const id of ["compare-as", "compare-without", "differences", "shown-other"]) byId(id).hidden = !model;
    byId("compare-without").hidden ||= bundles.length === 0;
    if (before || model) this.host.onChange(this.joint);
    before?.dispose();
  }

  get isSide() { return this.joint !== null && this.byId("compare-as").value === "side"; }

  #poseAt(flexion) { return this.player.motion().at({ flexion: flexion * degree, varus: this.player.varusAt(flexion * degree) }); }

  /// Places the second joint as the first; `lookOf(structure)`: of the first.
  place(held, lookOf, isCut, layers) {
    if (!this.joint) return;
    const { player, joint, byId, host } = this, first = host.player(), without = byId("compare-without").value;
    Object.assign(player, { flexion: first.flexion, ...(first.isBalanced ? {} : { isBalanced: false, varus: first.varus }) });
    const pose = player.pose();
    if (lookOf(pathsStructure)?.visible) joint.showPaths(columnsAlong(player.model, (f) => player.varusAt(f * degree) / degree), pose.attitude.flexion / degree);
    joint.place(pose, held);
    joint.applyLooks((id) => {
      const look = lookOf(id) ?? { visible: !id.startsWith("layers/"), opacity: 1, isHighlighted: false };
      return { ...look, visible: look.visible && id !== without, opacity: look.opacity * (this.isSide ? 1 : overlaidOpacity) };
    }, isCut);
    if (pose.isSolved) joint.showLayers(pose, player.motion(), layers);
    const { internal, anterior } = pose.isSolved ? clinicalOf(pose.referenceMoving, player.model.rotationCentre, player.model.side) : {};
    byId("shown-other").textContent = `${this.isSide ? "" : "translucent: "}${this.name}${without ? `, ${byId("compare-without").selectedOptions[0].textContent}` : ""}: flexion ${formatNumber(pose.attitude.flexion / degree, 1)}°, internal rotation ${formatNumber(internal, 1)}°, anterior ${formatNumber(anterior, 1)} mm`;
    byId("shown-other").classList.toggle("beside", this.isSide);
    for (const { plot } of this.plots) plot.setMark(pose.attitude.flexion / degree);
  }

  /// The plots, where both have poses. Bands: of the samples of an uncertain job about its motion; of two such jobs the root of the sum of squares.
  drawCurves(spans) {
    if (!this.joint) return;
    const [one, two] = [this.host.player(), this.player], model = one.model;
    const [low, high] = [Math.max(one.model.flexion[0], two.model.flexion[0]), Math.min(one.model.flexion.at(-1), two.model.flexion.at(-1))];
    const x = sampledFlexion(model).filter((f) => f >= low && f <= high), line = (name, y, k, band) => ({ name, x, y, band, ...lineStyle(k) });
    const poses = x.map((f) => [one.motion().at({ flexion: f * degree, varus: one.varusAt(f * degree) }), this.#poseAt(f)]);
    const numbers = (k, pose) => { const { model: own } = [one, two][k]; return pose.isSolved ? clinicalOf(pose.referenceMoving, own.rotationCentre, own.side) : null; };
    const readings = poses.map((pair) => pair.map((pose, k) => numbers(k, pose)));
    for (const { plot, figure, title, unit, numbers: names } of this.plots) {
      const bundles = names ? [] : this.host.bundles().filter((id) => this.joint.bundleReading(id, poses[0]?.[1] ?? { isSolved: false }));
      figure.hidden = x.length === 0 || (!names && bundles.length === 0);
      if (figure.hidden) continue;
      plot.setCurves(model, () => ({
        title, unit, spans, bandText: "bands: 5 % to 95 % of the samples, about no difference",
        lines: names ? names.map((name, k) => {
          const y = readings.map(([a, b]) => (a && b ? b[name] - a[name] : null)), own = [one, two].map((player) => player.model.bands?.[name] && [player.model.bands[name], player.model.flexion]);
          const off = (n, end) => Math.hypot(...own.map((found, k2) => (found && readings[n][k2] ? valueAt(...found, x[n], end) - readings[n][k2][name] : 0)));
          return line(clinicalNumbers.find((number) => number.name === name).label, y, k, own.some(Boolean) ? bandOf(x, (n) => [-off(n, "low"), off(n, "high")].filter(Number.isFinite)) : undefined);
        }) : bundles.map((id, k) => {
          const strain = (joint, pose) => { const found = joint.bundleReading(id, pose); return found && found.strain !== -1 ? 100 * found.strain : null; };
          const y = poses.map(([a, b]) => { const [p, q] = [strain(this.host.joint(), a), strain(this.joint, b)]; return p === null || q === null ? null : q - p; });
          return line(this.host.nameOf(id), y, k, this.host.bundleBand(id, x));
        }).filter(({ y }) => y.some((value) => value !== null)),
      }));
    }
  }

  /// For tests: name, values and band of each line of a plot.
  lines(name) {
    const { plot, figure } = this.plots.find((one) => one.name === name);
    figure.scrollIntoView();
    if (plot.make) return null;  // until it is seen and drawn
    return plot.lines?.map(({ name: own, x, y }, k) => ({ name: own, x, y, band: plot.band[k] ?? null })) ?? null;
  }
}
