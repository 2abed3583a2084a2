// Poses of a joint at any attitude, and the state of the player.
import { composed, degree, followerPose, normalised, placed, rotationWorldSolver, rows, scaled, still, sum } from "./geometry.js";

// Bicubic Hermite interpolation of values on a grid of attitudes; as pipeline/store/motion. Angles in radians.

/// A grid with `width` numbers per node. `value` [n_flexion n_varus width], row-major; `solved` [n_flexion n_varus].
function hermiteGrid(flexion, varus, width, value, solved) {
  const size = value.length;
  const grid = { flexion, varus, width, value, solved, byFlexion: new Float64Array(size), byVarus: new Float64Array(size), byBoth: new Float64Array(size) };
  const nVarus = varus.length;
  for (let number = 0; number < width; ++number) {
    for (let j = 0; j < nVarus; ++j) fillSlopes(grid, flexion, j, nVarus, number, grid.value, grid.byFlexion);
    for (let i = 0; i < flexion.length; ++i) {
      fillSlopes(grid, varus, i * nVarus, 1, number, grid.value, grid.byVarus);
      fillSlopes(grid, varus, i * nVarus, 1, number, grid.byFlexion, grid.byBoth);
    }
  }
  return grid;
}

/// Slopes of `from` along a grid line with coordinates `at`, whose nodes are `first`, `first` + `stride`, ...
function fillSlopes(grid, at, first, stride, number, from, to) {
  const line = {
    at,
    value: (k) => from[(first + k * stride) * grid.width + number],
    isSolved: (k) => k >= 0 && k < at.length && grid.solved[first + k * stride] === 1,
  };
  for (let k = 0; k < at.length; ++k) to[(first + k * stride) * grid.width + number] = slope(line, k);
}

function slope(line, k) {
  if (!line.isSolved(k)) return 0;
  const { at, value } = line;
  const hasBefore = line.isSolved(k - 1), hasAfter = line.isSolved(k + 1);
  if (hasBefore && hasAfter) {
    const hBefore = at[k] - at[k - 1], hAfter = at[k + 1] - at[k];
    const before = (value(k) - value(k - 1)) / hBefore, after = (value(k + 1) - value(k)) / hAfter;
    return (before * hAfter + after * hBefore) / (hBefore + hAfter);
  }
  if (hasAfter) return oneSidedSlope(line, k, 1);
  return hasBefore ? oneSidedSlope(line, k, -1) : 0;
}

function oneSidedSlope({ at, value, isSolved }, k, step) {
  const chord = (value(k + step) - value(k)) / (at[k + step] - at[k]);
  const far = k + 2 * step;
  if (!isSolved(far)) return chord;
  const nextChord = (value(far) - value(k + step)) / (at[far] - at[k + step]);
  return chord - ((at[k + step] - at[k]) * (nextChord - chord)) / (at[far] - at[k]);
}

// Relative distance below which a point is on the node, as in the library.
const onNode = 1e-9;

/// Index of the cell of `at` that contains x: the last whose lower end is not above it.
function cellOf(at, x) {
  let first = 0;
  while (first + 2 < at.length && at[first + 1] <= x) ++first;
  return first;
}

function spanOf(at, x) {
  if (at.length === 1) return { first: 0, value: [1, 0], slope: [0, 0] };
  const first = cellOf(at, x);
  const h = at[first + 1] - at[first];
  let s = (x - at[first]) / h;
  if (Math.abs(s) < onNode) s = 0;
  if (Math.abs(1 - s) < onNode) s = 1;
  const r = 1 - s;
  return { first, value: [r * r * (1 + 2 * s), s * s * (1 + 2 * r)], slope: [h * s * r * r, -h * r * s * s] };
}

/// The interpolated numbers at an attitude within the axes; null if a corner of the patch is not solved.
function sample(grid, flexion, varus) {
  const f = spanOf(grid.flexion, flexion), v = spanOf(grid.varus, varus);
  const numbers = new Array(grid.width).fill(0);
  for (let a = 0; a < 2; ++a) {
    if (f.value[a] === 0) continue;  // on a node the far end has no weight
    for (let b = 0; b < 2; ++b) {
      if (v.value[b] === 0) continue;
      const node = (f.first + a) * grid.varus.length + v.first + b;
      if (grid.solved[node] !== 1) return null;
      for (let k = 0; k < grid.width; ++k) {
        const at = node * grid.width + k;
        numbers[k] += f.value[a] * v.value[b] * grid.value[at] + f.slope[a] * v.value[b] * grid.byFlexion[at] +
                      f.value[a] * v.slope[b] * grid.byVarus[at] + f.slope[a] * v.slope[b] * grid.byBoth[at];
      }
    }
  }
  return numbers;
}

// The polynomials of a smoothed set (schemas/motion-model.md). Angles in degrees, as in the file.

/// Names of a pose's numbers in the order used by all modules; varus only if it was free.
export const surfaceNames = ["tx", "ty", "tz", "theta", "varus_solved"];

function legendre(u, degree) {
  const P = [1, u];
  for (let n = 1; n < degree; ++n) P[n + 1] = ((2 * n + 1) * u * P[n] - n * P[n - 1]) / (n + 1);
  return P;
}

function unitCoordinate(x, first, last) {
  return first === last ? 0 : (x - first - (last - x)) / (last - first);
}

/// One number per list of coefficients, mm and degrees, of a set at an attitude in degrees: by default [x, y, z, theta, varus]; 0 for a missing list.
function evaluateSmoothed(set, axes, flexionDeg, varusDeg, coefficients = set.coefficients) {
  const P = legendre(unitCoordinate(flexionDeg, axes.flexion[0], axes.flexion.at(-1)), set.degree);
  const Q = legendre(unitCoordinate(varusDeg, axes.varus[0], axes.varus.at(-1)), set.degree);
  const numbers = Array(Math.max(coefficients.length, surfaceNames.length)).fill(0);
  for (let k = 0; k < set.exponents.length / 2; ++k) {
    const basis = P[set.exponents[2 * k]] * Q[set.exponents[2 * k + 1]];
    for (let n = 0; n < numbers.length; ++n) numbers[n] += coefficients[n] ? coefficients[n][k] * basis : 0;
  }
  return numbers;
}

// Poses of a joint at any attitude, from one set of surfaces of a motion model; as pipeline/store/motion.

export const stable = 0;  // status of a solved attitude
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const radians = (angles) => Array.from(angles, (x) => x * degree);

/// Set names: two_sided; smoothed sets by decreasing degree, recontacted ones first; then raw; zero_varus; last the samples of an uncertain job.
function setNames(model) {
  const names = model.twoSided ? ["two_sided"] : [];
  for (const set of [...model.smoothed].sort((a, b) => b.degree - a.degree)) {
    if (set.recontact) names.push(`degree_${set.degree}_recontacted`);
    names.push(`degree_${set.degree}`);
  }
  names.push("raw");
  if (model.zeroVarus && model.zeroVarus.source.some((s) => s !== -1)) names.push("zero_varus");
  return [...names, ...(model.quantiles ?? []).map(({ name }) => name)];
}

/// The motion shown at first, and why it is not the smoothed one; as store::default_motion of the pipeline.
function defaultMotion(model) {
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
    this.followers = (model.followers ?? []).map((follower) => ({ ...follower, grid: gridOf(this.axes,
      [follower.flexion_angle, follower.rotation_angle, follower.tilt, follower.anterior, follower.proximal, follower.lateral],
      [degree, degree, degree, 1, 1, 1], (k) => follower.status[k] === stable) }));
    this.#useDeltas();
    if (set === "two_sided") this.#useTwoSided(model.twoSided);
    else if (set === "zero_varus") this.#useFlexionTable(this.axes.flexion, model.zeroVarus, model.zeroVarus.source);
    else if (set.startsWith("quantile_") || set === "bones_alone") this.#useQuantile(model.quantiles.find(({ name }) => name === set));
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

  #useQuantile(table) {
    this.#useFlexionTable(this.axes.flexion, table, table.state);
    for (const follower of this.followers) {
      const own = table.followers?.[follower.name];
      if (own) follower.grid = gridOf({ flexion: this.axes.flexion, varus: [0] }, own.columns, [degree, degree, degree, 1, 1, 1], (k) => own.status[k] === stable);
    }
  }

  #useTwoSided(table) {
    const flexion = radians(table.flexion);
    this.#useFlexionTable(flexion, table, table.contact);
    this.#useSmoothedFollowers(this.model.smoothed.find((s) => s.degree === table.degree), true);
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
    if (recontacted) this.travel = this.#travels(set.recontact);
    this.#useSmoothedFollowers(set, Boolean(recontacted));
  }

  #travels(mm) { return gridOf(this.axes, [mm], [1], (k) => !Number.isNaN(mm[k])); }

  #useSmoothedFollowers(set, isRecontacted) {
    for (const follower of this.followers) {
      const found = set?.followers.find(({ name }) => name === follower.name);
      if (!found) continue;
      follower.smoothed = { set, coefficients: found.coefficients };
      if (isRecontacted && found.recontact) follower.travel = this.#travels(found.recontact);
    }
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
    const poses = placed(frame, attitude, found.translation, found.theta);
    return { ...result, ...poses, followers: this.#followersAt(attitude, poses.referenceMoving), translation: found.translation, theta: found.theta };
  }

  /// { name: its pose in the reference's frame } of the bodies that follow the joint and have a pose.
  #followersAt({ flexion, varus }, referenceMoving) {
    const { axes } = this, poses = {}, byIndex = [still, referenceMoving];
    const at = [clamp(flexion, axes.flexion[0], axes.flexion.at(-1)), clamp(varus, axes.varus[0], axes.varus.at(-1))];
    for (const follower of this.followers) {
      const { name, index, of } = follower, own = byIndex[of] && this.#followerAt(follower, at);
      if (own) byIndex[index] = poses[name] = composed(byIndex[of], own);
    }
    return poses;
  }

  /// Its pose relative to the body of its coordinates, or null.
  #followerAt({ grid, smoothed, travel, centre, delta }, at) {
    const { side } = this.model;
    if (!smoothed) {
      const numbers = sample(grid, ...at);
      return numbers && followerPose(numbers, side, centre);
    }
    const numbers = evaluateSmoothed(smoothed.set, this.degrees, at[0] / degree, at[1] / degree, smoothed.coefficients);
    const pose = followerPose(numbers.map((x, k) => (k < 3 ? x * degree : x)), side, centre);
    if (!travel) return pose;
    const shift = sample(travel, ...at);
    return shift && composed(pose, { R: still.R, t: scaled(delta, shift[0]) });
  }

  /// The varus at which the compartments are closest to balance.
  balancedVarus(flexion) {
    if (this.isVarusFree) return this.#found({ flexion: clamp(flexion, this.firstFlexion, this.lastFlexion), varus: 0 }).attitude.varus;
    return this.spine.length ? varusBetween(this.spine, flexion) : clamp(0, this.firstVarus, this.lastVarus);
  }
}

/// The state of the player, independent of the page: requested attitude, set, and resulting pose.
export class Player {
  constructor(model) {
    this.model = model;
    this.sets = setNames(model);
    this.motions = new Map();
    this.raw = this.motion("raw");
    this.shown = defaultMotion(model);
    ({ set: this.set, reason: this.reason } = this.shown);
    this.isBalanced = this.raw.spine.length > 0;
    this.flexion = Math.min(Math.max(0, model.flexion[0]), model.flexion.at(-1));
    this.varus = Math.min(Math.max(0, model.varus[0]), model.varus.at(-1));
    this.direction = 1;
  }

  motion(set = this.set) {
    if (!this.sets.includes(set)) throw new Error(`found set "${set}", wanted one of: ${this.sets.join(", ")}`);
    if (!this.motions.has(set)) this.motions.set(set, new Motion(this.model, set));
    return this.motions.get(set);
  }

  /// The requested varus at a flexion, both in radians: the balanced varus, or the slider's.
  varusAt(flexion) {
    return this.isBalanced || this.motion().isVarusFree ? this.motion().balancedVarus(flexion) : this.varus * degree;
  }

  pose() {
    const flexion = this.flexion * degree;
    return this.motion().at({ flexion, varus: this.varusAt(flexion) });
  }

  /// Advances flexion by `seconds` at `speed` degrees per second, back and forth over the grid's range.
  advance(seconds, speed) {
    const [low, high] = [this.model.flexion[0], this.model.flexion.at(-1)];
    let next = Math.min(Math.max(this.flexion, low), high) + this.direction * speed * seconds;
    if (next >= high) [next, this.direction] = [high, -1];
    else if (next <= low) [next, this.direction] = [low, 1];
    this.flexion = next;
  }

  /// For scripts and tests: the pose of any set at any attitude in degrees.
  poseOf(set, flexion, varus) {
    const pose = this.motion(set).at({ flexion: flexion * degree, varus: varus * degree });
    const result = { isSolved: pose.isSolved, isFlexionClamped: pose.isFlexionClamped, isVarusClamped: pose.isVarusClamped };
    if (!pose.isSolved) return result;
    const followers = this.model.followers.map(({ name }) => (pose.followers[name] ? rows(pose.followers[name]) : null));
    return { ...result, X_reference_moving: rows(pose.referenceMoving), theta_rad: pose.theta, followers };
  }
}
