// Reads a motion model (schemas/motion-model.md) from the bytes of a file; angles in degrees as in the file.
import { readBodies } from "./bodies.js";
import { Hdf5File } from "./hdf5_file.js";
import { readLigaments } from "./ligaments.js";
import { ModelError, refuse } from "./model_error.js";
import { stable } from "./motion.js";
import { checkBytes } from "./seal.js";
import { surfaceNames } from "./smoothed_surfaces.js";

const formatName = "vrda motion model";
const formatMajor = 1;
const mostDegree = 20;
// Allows for single precision in files of other programs; the pipeline's unit vectors are exact to 1e-15.
const unitTolerance = 1e-6;

function text(file, name) {
  const value = file.attribute(name)?.[0];
  return typeof value === "string" ? value : "";
}

function threeNumbers(file, name) {
  const value = file.attribute(name);
  if (value?.length !== 3 || !value.every(Number.isFinite)) refuse(name, "another value", "three numbers");
  return value;
}

function checkFormat(file) {
  const format = text(file, "format"), version = text(file, "format_version");
  if (format !== formatName) {
    throw new ModelError(`This HDF5 file is not a motion model: its attribute "format" is ${format ? `"${format}"` : "missing"}, wanted "${formatName}".`);
  }
  const found = /^(\d+)\.(\d+)$/.exec(version);
  if (!found) refuse("format_version", `"${version}"`, `${formatMajor}.x`);
  if (Number(found[1]) !== formatMajor) {
    throw new ModelError(`This motion model has format version ${version}; this page reads ${formatMajor}.x. Use the player of the vrda version that wrote it.`);
  }
}

function axis(file, name) {
  const at = file.numbers(name, [null]);
  if (at.length === 0) refuse(name, "no value", "at least one value");
  if (!at.every((x, i) => Number.isFinite(x) && (i === 0 || x > at[i - 1]))) refuse(name, "values that do not increase", "strictly increasing numbers");
  return at;
}

function unit(v, field) {
  if (!(Math.abs(Math.hypot(...v) - 1) <= unitTolerance)) refuse(field, `(${v})`, "a unit vector");
  return v;
}

function readSurfaces(file, model) {
  const size = [model.flexion.length, model.varus.length];
  for (const name of ["tx", "ty", "tz", "theta"]) model[name] = file.numbers(`/${name}`, size);
  model.status = file.numbers("/status", size, "int8");
  if (file.hasDataset("/plausibility")) model.plausibility = file.numbers("/plausibility", size, "int8");
  model.isSpine = file.numbers("/is_spine", size, "int8");
  const onAxis = () => Float64Array.from(model.status, (_, k) => model.varus[k % size[1]]);
  model.varusSolved = file.hasDataset("/varus_solved") ? file.numbers("/varus_solved", size) : onAxis();
  const used = [model.tx, model.ty, model.tz, model.theta, model.varusSolved];
  for (let k = 0; k < model.status.length; ++k) {
    if (model.status[k] === stable && !used.every((surface) => Number.isFinite(surface[k]))) refuse("/status", `a solved attitude (number ${k}) without a pose`, "finite numbers");
  }
  if (!model.status.includes(stable)) throw new ModelError("No attitude of this motion model is solved: there is nothing to show. A run writes its results when it ends.");
}

function readPush(file, model) {
  model.delta = unit(threeNumbers(file, "delta"), "delta");
  model.hasTurnedAxes = model.delta[1] !== 1;
  if (!file.hasDataset("/push/delta")) return;
  model.pushDelta = file.numbers("/push/delta", [model.flexion.length, 3]);
  for (let i = 0; i < model.flexion.length; ++i) unit(model.pushDelta.subarray(3 * i, 3 * i + 3), "/push/delta");
  model.hasTurnedAxes = model.flexion.some((_, i) => model.pushDelta[3 * i + 1] !== 1);
}

function coefficients(file, group, nTerms) {
  return surfaceNames.map((surface) => {
    const name = `${group}/coefficients_${surface}`;
    if (surface === "varus_solved" && !file.hasDataset(name)) return null;
    const found = file.numbers(name, [nTerms]);
    if (!found.every(Number.isFinite)) refuse(name, "a coefficient that is not finite", "finite numbers");
    return found;
  });
}

function readSmoothed(file, model) {
  const size = [model.flexion.length, model.varus.length];
  model.smoothed = file.groups("/smoothed").map((name) => {
    const group = `/smoothed/${name}`, found = /^degree_(\d{1,2})$/.exec(name);
    const degree = found ? Number(found[1]) : -1;
    if (degree < 0 || degree > mostDegree) refuse(group, name, `degree_0 to degree_${mostDegree}`);
    const exponents = file.numbers(`${group}/exponents`, [null, 2], "int32");
    if (!exponents.every((n, k) => n >= 0 && (k % 2 === 0 || n + exponents[k - 1] <= degree))) refuse(`${group}/exponents`, "exponents beyond the degree", `sums up to ${degree}`);
    const set = { degree, exponents, coefficients: coefficients(file, group, exponents.length / 2) };
    if (file.hasDataset(`${group}/recontact`)) set.recontact = file.numbers(`${group}/recontact`, size);
    return set;
  });
}

/// Poses over flexion; `state` names the dataset that is -1 without a pose.
function readFlexionTable(file, group, state, n) {
  const names = ["tx", "ty", "tz", "theta", "varus"];
  const table = { [state]: file.numbers(`${group}/${state}`, [n], "int8") };
  for (const name of names) table[name] = file.numbers(`${group}/${name}`, [n]);
  for (let i = 0; i < n; ++i) {
    if (table[state][i] !== -1 && !names.every((name) => Number.isFinite(table[name][i]))) refuse(`${group}/${state}`, `a pose (number ${i}) that is not finite`, "finite numbers");
  }
  return table;
}

function readMotionsOverFlexion(file, model) {
  const [set, reason] = file.hasGroup("/default_motion") ? ["set", "reason"].map((name) => file.attribute(name, "/default_motion")?.[0]) : [];
  if (typeof set === "string") model.defaultMotion = { set, reason: reason ?? "" };
  if (file.hasGroup("/two_sided")) {
    const flexion = axis(file, "/two_sided/flexion");
    model.twoSided = { flexion, ...readFlexionTable(file, "/two_sided", "contact", flexion.length) };
    for (const side of ["medial", "lateral"]) model.twoSided[side] = file.numbers(`/two_sided/gap_${side}`, [flexion.length]);
  }
  if (file.hasGroup("/zero_varus")) model.zeroVarus = readFlexionTable(file, "/zero_varus", "source", model.flexion.length);
}

/// The samples of an uncertain job: their motions at five probabilities, and the 5 to 95 % band of the clinical numbers.
function readUncertainty(file, model) {
  if (!file.hasGroup("/uncertainty")) return;
  const n = model.flexion.length, group = "/uncertainty", probabilities = 5, low = 1, high = 3;
  const names = ["tx", "ty", "tz", "theta", "varus"];
  const all = Object.fromEntries(names.map((name) => [name, file.numbers(`${group}/${name}`, [probabilities, n])]));
  const status = file.numbers(`${group}/quantile_status`, [probabilities, n], "int8");
  const row = (values, k) => values.subarray(k * n, (k + 1) * n);
  model.quantiles = [0, 5, 50, 95, 100].map((percent, k) => ({
    name: `quantile_${percent}`, state: Array.from(row(status, k), (s) => (s === 0 ? 0 : -1)), ...Object.fromEntries(names.map((name) => [name, row(all[name], k)])),
  })).filter(({ state }) => state.includes(0));
  const bands = { ...Object.fromEntries(["flexion", "varus", "internal"].map((name, k) => [name, ["rotation_band", k]])), ...Object.fromEntries(["anterior", "proximal", "lateral"].map((name, k) => [name, ["translation_band", k]])) };
  model.bands = Object.fromEntries(Object.entries(bands).map(([name, [dataset, k]]) => {
    const values = file.numbers(`${group}/${dataset}`, [probabilities, n, 3]);
    const at = (p) => Array.from({ length: n }, (_, i) => values[3 * (p * n + i) + k]);
    return [name, { low: at(low), high: at(high) }];
  }));
}

function readContactPaths(file, model) {
  const size = [model.flexion.length, model.varus.length, 3];
  const names = ["medial_reference", "medial_moving", "lateral_reference", "lateral_moving"];
  if (!names.every((name) => file.hasDataset(`/contact_paths/${name}`))) return;
  model.contactPaths = Object.fromEntries(names.map((name) => [name, file.numbers(`/contact_paths/${name}`, size)]));
}

function readAll(file) {
  checkFormat(file);
  // Flexion may repeat in a sequence of frames: it is no axis.
  if (file.hasDataset("/frame")) throw new ModelError("This motion model is a sequence of frames; this page shows motions over a grid of attitudes. Use vrda-player show.");
  const side = text(file, "side");
  if (side !== "right" && side !== "left") refuse("side", `"${side}"`, "right or left");
  const model = { title: text(file, "title"), joint: text(file, "joint"), method: text(file, "method"), version: text(file, "format_version"), side };
  model.rotationCentre = threeNumbers(file, "rotation_centre_mm");
  model.flexion = axis(file, "/flexion");
  model.varus = axis(file, "/varus");
  readSurfaces(file, model);
  readPush(file, model);
  readSmoothed(file, model);
  readMotionsOverFlexion(file, model);
  readUncertainty(file, model);
  readContactPaths(file, model);
  model.warnings = file.hasDataset("/job/warnings") ? file.texts("/job/warnings") : [];
  model.ligaments = readLigaments(file, [model.flexion.length, model.varus.length]);
  model.bodies = { reference: readBodies(file, "reference"), moving: readBodies(file, "moving") };
  return model;
}

/// Throws ModelError with one message for the user.
export async function readMotionModel(bytes) {
  checkBytes(bytes);
  const file = await Hdf5File.open(bytes);
  try {
    return readAll(file);
  } catch (error) {
    if (error instanceof ModelError) throw error;
    throw new ModelError(`The file is damaged, or does not have the structure of a motion model (${error.message}).`);
  } finally {
    file.close();
  }
}
