// Bicubic Hermite interpolation of values on a grid of attitudes; as pipeline/motion/hermite_grid. Angles in radians.

/// A grid with `width` numbers per node. `value` [n_flexion n_varus width], row-major; `solved` [n_flexion n_varus].
export function hermiteGrid(flexion, varus, width, value, solved) {
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
export function cellOf(at, x) {
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
export function sample(grid, flexion, varus) {
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
