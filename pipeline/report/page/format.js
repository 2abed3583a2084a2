// Formats numbers and names for display.

/** Significant digits; a dash for a missing number. */
export function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const text = Math.abs(value) >= 1e-5 && Math.abs(value) < 1e6 ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1);
  return text.replace("-", "−");
}

/** A fixed number of decimals. */
export function decimal(value, digits = 2) {
  return value === null || value === undefined || !Number.isFinite(value) ? "–" : value.toFixed(digits).replace("-", "−");
}

/** A length in mm, small ones in micrometres. */
export function length(mm, digits = 3) {
  if (mm !== null && mm !== 0 && Math.abs(mm) < 0.01) return `${number(1000 * mm, digits)} µm`;
  return `${number(mm, digits)} mm`;
}

export function percent(share) {
  return share === null ? "–" : `${number(100 * share)} %`;
}

/** Display name of a set such as "degree_6_recontacted". */
export function motionName(set) {
  if (set === "raw") return "raw, along the spine";
  if (set === "two_sided") return "two-sided, both compartments in contact";
  if (set === "zero_varus") return "zero varus, both compartments in contact";
  const found = /^degree_(\d+)(_recontacted)?$/.exec(set);
  return found ? `smoothed, degree ${found[1]}${found[2] ? ", recontacted" : ""}` : set;
}

/** Display name of a set over the whole grid. */
export function setName(set) {
  return set === "raw" ? "raw" : motionName(set);
}

/** A surface's name, sign and unit. */
export const PARAMETERS = {
  tx: { name: "x, anterior", unit: "mm" },
  ty: { name: "y, proximal", unit: "mm" },
  tz: { name: "z, to the subject’s right", unit: "mm" },
  theta: { name: "θ about Δ, internal +", unit: "degrees" },
  varus: { name: "solved varus, adduction +", unit: "degrees" },
  frame_flexion: { name: "flexion of the frame", unit: "degrees" },
};

export function parameterTitle(key) {
  return `${PARAMETERS[key].name}, ${PARAMETERS[key].unit}`;
}

/** What the joint's kind calls a rotation: "varus", or "adduction (abduction -)" of a hip. */
export function wordOf(model, rotation) {
  return (model.words?.[rotation] ?? rotation).replace("-", "−");
}

/** Title of an axis of the grid. If Delta is not proximal, its angles are about turned axes and not those of the joint. */
export function gridTitle(model, angle, unit = "degrees") {
  return `${wordOf(model, angle)}${model.axes_are_turned ? " of the attitude" : ""}, ${unit}`;
}

/** Minimum and maximum of numbers, ignoring null. */
export function extent(values) {
  let least = Infinity, most = -Infinity;
  for (const value of values) {
    if (value === null || value === undefined) continue;
    least = Math.min(least, value);
    most = Math.max(most, value);
  }
  return [least, most];
}
