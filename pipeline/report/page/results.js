// Results of other commands: laxity tests and ranges of motion.
import { decimal, el, number, section, table } from "./page.js";
import { axis, curve, dashNamed, figure, lineStyle, theme } from "./plot.js";
import { kindCells, kindsLegend } from "./quality.js";

// Laxity tests: how far a load moves the joint at a held flexion, and which fibres resist it (schemas/laxity.md).

const PAIRS = [["anterior", "posterior"], ["internal", "external"], ["varus", "valgus"]];
const LEAST_SHARE = 0.05;  // below, a bundle is not listed

/** The curves of one result and what is derived from them. */
class Tests {
  constructor({ document, cuts }) {
    this.flexion = document.flexion_deg;
    this.states = document.states;
    this.cuts = cuts;  // [states - 1] names of the bundles that are removed
    this.published = document.published;
    this.curves = new Map(document.curves.map((curve) => [`${curve.state} ${curve.flexion_deg} ${curve.test}`, curve]));
  }

  curve(s, flexion, test) {
    return this.curves.get(`${this.states[s]} ${flexion} ${test}`);
  }

  stateName(s) {
    return s === 0 ? this.states[0] : `without ${this.states[s]}`;
  }
}

// The coordinate along which the pair of tests acts: degrees or mm.
function coordinateOf(pose, pair) {
  return pose.coordinates[pair[0] === "anterior" ? "anterior_mm" : `${pair[0]}_deg`];
}

// How much farther than the intact joint the test moves it without some fibres.
function farther(tests, s, flexion, pair, test) {
  const [cut, whole] = [s, 0].map((state) => tests.curve(state, flexion, test));
  if (cut.laxity === null || whole.laxity === null) return null;
  return (test === pair[0] ? 1 : -1) * (coordinateOf(cut.poses.at(-1), pair) - coordinateOf(whole.poses.at(-1), pair));
}

// Of the fibres of a cut, in the intact joint.
function cutShare(tests, s, flexion, test) {
  const shares = tests.curve(0, flexion, test).bundles.filter(({ name }) => tests.cuts[s - 1].includes(name)).map(({ share }) => share);
  return shares.includes(null) ? null : shares.reduce((sum, share) => sum + share, 0);
}

function laxityTable(tests, pair, unit) {
  const rows = tests.flexion.flatMap((flexion) => tests.states.map((_, s) => {
    const laxity = pair.map((test) => tests.curve(s, flexion, test).laxity);
    const cells = pair.flatMap((test, k) => [decimal(laxity[k]), ...(s === 0 ? ["", ""] : [decimal(farther(tests, s, flexion, pair, test)), wholePercent(cutShare(tests, s, flexion, test))])]);
    return [`${number(flexion, 4)}°`, tests.stateName(s), ...cells, decimal(laxity.includes(null) ? null : laxity[0] + laxity[1])];
  }));
  return table(`Laxity, ${unit}; of a cut: how much farther than the intact joint, and the share of the load that its fibres carry there`,
    ["flexion", "state", ...pair.flatMap((test) => [test, "farther", "share"]), "both"], rows, { kinds: ["", "word"] });
}

function wholePercent(share) {
  return share === null ? "–" : `${decimal(100 * share, 0)} %`;
}

function sharesTable(tests, pair) {
  const text = (flexion, test) => {
    const { bundles, contact } = tests.curve(0, flexion, test);
    return [...bundles, contact].filter(({ share }) => share >= LEAST_SHARE).sort((a, b) => b.share - a.share).map(({ name, share }) => `${name} ${wholePercent(share)}`).join(", ");
  };
  return table("Share of the load that bundles and contact resist with all fibres, at least 5 %", ["flexion", ...pair],
    tests.flexion.map((flexion) => [`${number(flexion, 4)}°`, ...pair.map((test) => text(flexion, test))]), { kinds: ["", "text", "text"] });
}

// The first test above zero, the second below; published values as points with their standard deviation.
function overFlexion(tests, pair, unit) {
  const published = tests.published.filter((row) => pair.includes(row.test));
  const sign = (test) => (test === pair[0] ? 1 : -1);
  return figure({
    title: "Laxity over flexion", caption: `${pair[0]} above zero, ${pair[1]} below, ${unit}.`,
    make: () => ({
      x: axis("flexion, degrees"), y: axis(unit),
      layers: [
        ...tests.states.flatMap((_, s) => pair.map((test) => {
          const y = tests.flexion.map((flexion) => { const { laxity } = tests.curve(s, flexion, test); return laxity === null ? null : sign(test) * laxity; });
          return curve(tests.stateName(s), tests.flexion, y, unit, { colour: lineStyle(s).colour, dash: dashNamed(s > 0 ? "dash" : "solid") });
        })),
        ...(published.length > 0 ? [curve("published", published.map((row) => row.flexion_deg), published.map((row) => sign(row.test) * row.value), unit,
          { kind: "points", colour: theme().ink, size: 7, error: published.map((row) => row.sd ?? 0) })] : [])],
    }),
  });
}

// Both directions of the intact joint in one line, through the unloaded pose.
function overLoad(tests, pair, unit, load) {
  const trace = (flexion, k) => {
    const poses = pair.flatMap((test, t) => {
      const curve = tests.curve(0, flexion, test), start = coordinateOf(curve.poses[0], pair);
      const points = curve.poses.filter((pose) => coordinateOf(pose, pair) !== null).map((pose) => [(t === 0 ? 1 : -1) * load.shown(pose.load), coordinateOf(pose, pair) - start]);
      return t === 0 ? points : points.reverse();
    }).sort((a, b) => a[0] - b[0]);
    const [x, y] = [0, 1].map((c) => poses.map((p) => p[c])), name = `${number(flexion, 4)}°`;
    return { kind: "line", name, x, y, ...lineStyle(k), text: (row) => `${name}: ${decimal(y[row])} ${unit} at ${number(x[row])} ${load.unit}` };
  };
  return figure({ title: "Displacement over load", caption: `With all fibres, from the unloaded pose, ${unit}.`,
    make: () => ({ x: axis(load.title), y: axis(unit), layers: tests.flexion.map(trace) }) });
}

function pairSection(tests, pair, wholeLoad) {
  const isForce = pair[0] === "anterior", unit = isForce ? "mm" : "degrees";
  const load = isForce ? { title: "force, N", unit: "N", shown: (n) => n } : { title: "moment, N m", unit: "N m", shown: (nmm) => 1e-3 * nmm };
  return section(pair[0], `${pair.join("-")}, ${number(load.shown(wholeLoad), 4)} ${load.unit}`, laxityTable(tests, pair, unit),
    el("div", { class: "columns" }, overFlexion(tests, pair, unit), overLoad(tests, pair, unit, load)), sharesTable(tests, pair));
}

function publishedSection({ published }) {
  const rows = published.map((row) => [row.test, `${number(row.flexion_deg, 4)}°`, `${decimal(row.value)}${row.sd === null ? "" : ` ± ${decimal(row.sd)}`}`, decimal(row.found), decimal(row.difference),
    decimal(row.sd === null || row.difference === null ? null : row.difference / row.sd, 1), `${row.source}${row.missing}`]);
  return section("published", "Published values", table("Intact joint", ["test", "flexion", "published", "found", "difference", "in standard deviations", "source"], rows, { kinds: ["", "", "", "", "", "", "text"] }));
}

/** The sections of `vrda laxity`. */
export function laxitySections(data) {
  const tests = new Tests(data);
  const about = `Flexion is held; the other five coordinates are free. Each load acts besides those of the job, along the joint’s own coordinate, and grows in ${data.load_steps} steps from the unloaded equilibrium. Laxity is the change of the coordinate.`;
  const tested = PAIRS.filter((pair) => tests.curve(0, tests.flexion[0], pair[0]));
  return [section("about", "Laxity", el("p", {}, about)), ...tested.map((pair) => pairSection(tests, pair, data.loads[pair[0]])),
    ...(tests.published.length > 0 ? [publishedSection(tests)] : [])];
}

// Range of motion, of one joint or of two compared: limits, volume, ends and a map of each slice (schemas/range-of-motion.md).

const VOLUME_UNITS = ["", "degrees", "square degrees", "degrees cubed"];

function limitsText({ translation_mm: translation, opening_mm: opening, strain, delta_of: deltaOf }) {
  const limit = (value, unit) => (value === null ? "not limited" : `${number(value, 4)}${unit}`);
  return `Translation across Delta ${limit(translation, " mm")}, opening against Delta ${limit(opening, " mm")}, fibre strain ${limit(strain, "")}; Delta is fixed to the ${deltaOf === "reference" ? "reference" : "moving object"}.`;
}

function volumesTable(volumes) {
  return table("Attitudes in range", ["in range of", "attitudes", VOLUME_UNITS[volumes[0].n_driven], "% of the driven box"],
    volumes.map(({ name, cells, volume, share }) => [name, String(cells), number(volume, 4), number(100 * share, 4)]));
}

// Through the neutral attitude only; boundary.csv has all of them.
function endsTable(ends) {
  const text = (end) => `${number(end.deg, 4)}° (${end.cause})`;
  return table("Range along each rotation, the others neutral", ["rotation", "from", "to"],
    ends.map(({ name, low, high }) => (low ? [name, text(low), text(high)] : [name, "not in range at the neutral attitude", ""])), { kinds: ["", "text", "text"] });
}

function kindsOf(maps) {
  return maps.legend.map(([color, name], code) => ({ code, name, color }));
}

function mapFigure(maps, slice) {
  const lines = maps.outlines[slice];
  return figure({
    title: `${maps.titles[2]} ${number(maps.slices[slice], 4)}°`, caption: "One cell per attitude.",
    make: () => ({
      x: axis(`${maps.titles[0]}, degrees`), y: axis(`${maps.titles[1]}, degrees`),
      layers: [{ ...kindCells(maps.x, maps.y, maps.cells[slice], kindsOf(maps), (x, y) => `from ${number(x)}°, ${number(y)}°`), isEdges: true },
        { kind: "line", x: lines.flatMap((l) => [l[0], l[2], null]), y: lines.flatMap((l) => [l[1], l[3], null]), colour: "#101418", width: 1.5 }],
    }),
  });
}

/** The sections of `vrda rom`, or of its comparison of two. */
export function rangeSections({ maps, volumes, ends, ranges }) {
  const about = ranges.map(({ title, limits }) => el("p", {}, ranges.length > 1 ? el("strong", {}, `${title}: `) : null, limitsText(limits)));
  return [section("range", "Range of motion", ...about, volumesTable(volumes), ends ? endsTable(ends) : null),
    section("maps", "Maps", kindsLegend(kindsOf(maps)), el("div", { class: "columns three" }, maps.slices.map((_, k) => mapFigure(maps, k))))];
}
