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

/// [x, y, z mm, theta degree, varus degree] of a set at an attitude in degrees; 0 for a missing surface.
export function evaluateSmoothed(set, axes, flexionDeg, varusDeg) {
  const P = legendre(unitCoordinate(flexionDeg, axes.flexion[0], axes.flexion.at(-1)), set.degree);
  const Q = legendre(unitCoordinate(varusDeg, axes.varus[0], axes.varus.at(-1)), set.degree);
  const numbers = [0, 0, 0, 0, 0];
  for (let k = 0; k < set.exponents.length / 2; ++k) {
    const basis = P[set.exponents[2 * k]] * Q[set.exponents[2 * k + 1]];
    for (let n = 0; n < numbers.length; ++n) numbers[n] += set.coefficients[n] ? set.coefficients[n][k] * basis : 0;
  }
  return numbers;
}
