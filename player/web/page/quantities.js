// Quantities of a pose for the plots: names, units and values.
import { clinicalNumbers, clinicalOf } from "./clinical.js";
import { degree } from "./frames.js";

const surfaces = [
  { name: "tx", label: "x, world", unit: "mm", of: (pose) => pose.translation[0] },
  { name: "ty", label: "y, world", unit: "mm", of: (pose) => pose.translation[1] },
  { name: "tz", label: "z, world", unit: "mm", of: (pose) => pose.translation[2] },
  { name: "theta", label: "theta about Delta", unit: "°", of: (pose) => pose.theta / degree },
];

/// The quantities of a model: its surfaces, the solved varus if it was free, and the clinical numbers.
export function quantitiesOf(model, isVarusFree) {
  const found = { name: "varus_found", label: "solved varus", unit: "°", of: (pose) => pose.attitude.varus / degree };
  const clinical = clinicalNumbers.map(({ name, label, unit, note }) => ({
    name: `clinical_${name}`, label: note ? `${label} (${note})` : label, unit, isClinical: true,
    of: (pose) => clinicalOf(pose.referenceMoving, model.rotationCentre, model.side)[name],
  }));
  return [...surfaces, ...(isVarusFree ? [found] : []), ...clinical];
}

/// Formats a number for the page; NaN as a dash.
export const formatNumber = (x, digits = 2) => (Number.isFinite(x) ? x.toFixed(digits).replace(/^-(0\.?0*)$/, "$1").replace("-", "−") : "–");
