// Poses of a joint at any attitude, from one set of surfaces of a motion model; as pipeline/motion/poses.
import { degree, normalised, placed, rotationWorldSolver, scaled, sum } from "./frames.js";
import { cellOf, hermiteGrid, sample } from "./hermite_grid.js";
import { evaluateSmoothed } from "./smoothed_surfaces.js";

export const stable = 0;  // status of a solved attitude
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const radians = (angles) => Array.from(angles, (x) => x * degree);

/// Set names: two_sided; smoothed sets by decreasing degree, recontacted ones first; then raw; zero_varus; last the samples of an uncertain job.
export function setNames(model) {
  const names = model.twoSided ? ["two_sided"] : [];
  for (const set of [...model.smoothed].sort((a, b) => b.degree - a.degree)) {
    if (set.recontact) names.push(`degree_${set.degree}_recontacted`);
    names.push(`degree_${set.degree}`);
  }
  names.push("raw");
  if (model.zeroVarus && model.zeroVarus.source.some((s) => s !== -1)) names.push("zero_varus");
  return [...names, ...(model.quantiles ?? []).map(({ name }) => name)];
}

/// The motion shown at first, and why it is not the smoothed one; as motion::default_motion of the pipeline.
export function defaultMotion(model) {
  const names = setNames(model);
  return names.includes(model.defaultMotion?.set) ? model.defaultMotion : { set: names[0], reason: "" };
}

/// A grid with unsolved nodes set to 0. `columns` have one value per node; `factors` convert degrees to radians.
function gridOf(axes, columns, factors, isSolved) {
  const width = columns.length, n = axes.flexion.length * axes.varus.length;
  const value = new Float64Array(n * width), solved = new Uint8Array(n);
  for (let node = 0; node < n; ++node) {
    solved[node] = isSolved(node) ? 1 : 0;
    for (let k = 0; k < width && solved[node]; ++k) value[node * width + k] = columns[k][node] * factors[k];
  }
  return hermiteGrid(axes.flexion, axes.varus, width, value, solved);
}

/// Linear interpolation over flexion between [flexion, varus] pairs (at least one), constant beyond the ends.
function varusBetween(attitudes, flexion) {
  const after = attitudes.findIndex((a) => a[0] >= flexion);
  if (after === 0) return attitudes[0][1];
  if (after < 0) return attitudes.at(-1)[1];
  const [before, next] = [attitudes[after - 1], attitudes[after]];
  return before[1] + ((flexion - before[0]) / (next[0] - before[0])) * (next[1] - before[1]);
}

/// The solved varus at each solved flexion; empty if varus was not free.
function freeVarus(model, axes) {
  if (axes.varus.length > 1) return [];
  const found = [];
  let isFree = false;
  for (let i = 0; i < axes.flexion.length; ++i) {
    if (model.status[i] !== stable) continue;
    isFree ||= model.varusSolved[i] !== model.varus[0];
    found.push([axes.flexion[i], model.varusSolved[i] * degree]);
  }
  return isFree ? found : [];
}

function solvedSpine(model, axes) {
  const spine = [], n = axes.varus.length;
  for (let i = 0; i < axes.flexion.length; ++i) {
    for (let j = 0; j < n; ++j) {
      if (model.isSpine[i * n + j] !== 1 || model.status[i * n + j] !== stable) continue;
      spine.push([axes.flexion[i], axes.varus[j]]);
      break;
    }
  }
  return spine;
}

/// One set of a motion model, ready for evaluation. Angles in radians, lengths in mm.
export class Motion {
  constructor(model, set) {
    this.model = model;
    this.axes = { flexion: radians(model.flexion), varus: radians(model.varus) };
    this.degrees = { flexion: model.flexion, varus: model.varus };
    this.raw = gridOf(this.axes, [model.tx, model.ty, model.tz, model.theta], [1, 1, 1, degree], (k) => model.status[k] === stable);
    this.spine = solvedSpine(model, this.axes);
    this.free = freeVarus(model, this.axes);
    this.#useDeltas();
    if (set === "two_sided") this.#useTwoSided(model.twoSided);
    else if (set === "zero_varus") this.#useFlexionTable(this.axes.flexion, model.zeroVarus, model.zeroVarus.source);
    else if (set.startsWith("quantile_")) this.#useQuantile(model.quantiles.find(({ name }) => name === set));
    else if (set !== "raw") this.#useSmoothed(set);
    const own = this.free.length ? this.free.map((a) => a[1]) : this.axes.varus;
    this.firstVarus = Math.min(...own);
    this.lastVarus = Math.max(...own);
    this.firstFlexion = this.axes.flexion[0];
    this.lastFlexion = this.axes.flexion.at(-1);
  }

  get isVarusFree() { return this.free.length > 0; }

  #useDeltas() {
    const { pushDelta, delta, side } = this.model;
    const rowOf = (i) => Array.from(pushDelta.subarray(3 * i, 3 * i + 3));
    const rows = pushDelta ? this.axes.flexion.map((_, i) => rowOf(i)) : [];
    const isVariable = rows.some((row) => row.some((x, k) => x !== rows[0][k]));
    this.deltas = isVariable ? rows : null;
    this.fixedFrame = { worldSolver: rotationWorldSolver(side, delta), centre: this.model.rotationCentre };
  }

  /// `state` is -1 at flexions without a pose.
  #useFlexionTable(flexion, table, state) {
    const columns = [table.tx, table.ty, table.tz, table.theta, table.varus];
    this.byFlexion = gridOf({ flexion, varus: [0] }, columns, [1, 1, 1, degree, degree], (k) => state[k] !== -1);
    this.free = flexion.flatMap((f, i) => (state[i] === -1 ? [] : [[f, table.varus[i] * degree]]));
  }

  #useQuantile(table) { this.#useFlexionTable(this.axes.flexion, table, table.state); }

  #useTwoSided(table) {
    const flexion = radians(table.flexion);
    this.#useFlexionTable(flexion, table, table.contact);
    this.sideGaps = gridOf({ flexion, varus: [0] }, [table.medial, table.lateral], [1, 1], (k) => table.contact[k] !== -1);
  }

  /// Medial and lateral gap stored with the two-sided motion, mm; null for other sets and without a pose.
  sideGapsAt(flexion) {
    return this.sideGaps ? sample(this.sideGaps, Math.min(Math.max(flexion, this.firstFlexion), this.lastFlexion), 0) : null;
  }

  #useSmoothed(name) {
    const [, number, recontacted] = /^degree_(\d+)(_recontacted)?$/.exec(name);
    const set = this.model.smoothed.find((s) => s.degree === Number(number));
    this.smoothed = set;
    this.hasVarusSurface = Boolean(set.coefficients[4]);
    if (this.hasVarusSurface) this.free = this.axes.flexion.map((f) => [f, evaluateSmoothed(set, this.degrees, f / degree, 0)[4] * degree]);
    if (recontacted) this.travel = gridOf(this.axes, [set.recontact], [1], (k) => !Number.isNaN(set.recontact[k]));
  }

  /// Unit vector, world W: the rows of the push interpolated linearly, then normalised.
  delta(flexion) {
    if (!this.deltas) return this.model.delta;
    const at = this.axes.flexion;
    if (flexion <= at[0]) return this.deltas[0];
    if (flexion >= at.at(-1)) return this.deltas.at(-1);
    const i = cellOf(at, flexion);
    const s = (flexion - at[i]) / (at[i + 1] - at[i]);
    return s === 0 ? this.deltas[i] : normalised(sum(scaled(this.deltas[i], 1 - s), scaled(this.deltas[i + 1], s)));
  }

  #smoothedAt(attitude) {
    const here = evaluateSmoothed(this.smoothed, this.degrees, attitude.flexion / degree, attitude.varus / degree);
    const varus = this.hasVarusSurface ? here[4] * degree : attitude.varus;
    let translation = here.slice(0, 3), isSolved = true;
    if (this.travel) {
      const travel = sample(this.travel, attitude.flexion, attitude.varus);
      isSolved = travel !== null;
      if (travel) translation = sum(translation, scaled(this.delta(attitude.flexion), travel[0]));
    }
    return { attitude: { flexion: attitude.flexion, varus }, translation, theta: here[3] * degree, isSolved };
  }

  #found(wanted) {
    const { flexion } = wanted;
    const attitude = { flexion, varus: this.isVarusFree ? varusBetween(this.free, flexion) : wanted.varus };
    if (this.smoothed) return this.#smoothedAt(attitude);
    const numbers = this.byFlexion ? sample(this.byFlexion, flexion, 0) : sample(this.raw, flexion, attitude.varus);
    if (!numbers) return { attitude, isSolved: false };
    if (this.byFlexion) attitude.varus = numbers[4];
    return { attitude, translation: numbers.slice(0, 3), theta: numbers[3], isSolved: true };
  }

  /// The poses at an attitude, clamped to the grid's range.
  at(wanted) {
    const found = this.#found({ flexion: clamp(wanted.flexion, this.firstFlexion, this.lastFlexion),
                                varus: clamp(wanted.varus, this.firstVarus, this.lastVarus) });
    const { attitude } = found;
    const result = { attitude, isSolved: found.isSolved, isFlexionClamped: attitude.flexion !== wanted.flexion, isVarusClamped: attitude.varus !== wanted.varus };
    if (!found.isSolved) return result;
    const frame = !this.deltas ? this.fixedFrame
      : { worldSolver: rotationWorldSolver(this.model.side, this.delta(attitude.flexion)), centre: this.model.rotationCentre };
    return { ...result, ...placed(frame, attitude, found.translation, found.theta), translation: found.translation, theta: found.theta };
  }

  /// The varus at which the compartments are closest to balance.
  balancedVarus(flexion) {
    if (this.isVarusFree) return this.#found({ flexion: clamp(flexion, this.firstFlexion, this.lastFlexion), varus: 0 }).attitude.varus;
    return this.spine.length ? varusBetween(this.spine, flexion) : clamp(0, this.firstVarus, this.lastVarus);
  }
}
