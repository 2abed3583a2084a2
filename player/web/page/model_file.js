// Reads a motion model (schemas/motion-model.md) from the bytes of a file; angles in degrees as in the file.
import { File, FS, Module, ready } from "h5wasm";
import { stable, surfaceNames } from "./motion.js";

/// An error in a file, with a message for the user.
class ModelError extends Error {}

/// Throws a ModelError that names the field, what was found and what was wanted.
function refuse(field, found, wanted) {
  throw new ModelError(`${field ? `${field}: ` : ""}found ${found}, wanted ${wanted}`);
}

// Checks of a file's bytes before HDF5 reads them: the HDF5 signature, and the seal of schemas/motion-model.md.

/// Largest file. Far above any knee, well below the memory limit of a page.
export const largestFileMb = 400;

const signature = [0x89, 0x48, 0x44, 0x46, 0x0d, 0x0a, 0x1a, 0x0a];
const sealName = "VRDASEAL";
const sealLength = 16;

/// CRC-32 as in zlib.
function crc32(bytes) {
  const table = Array.from({ length: 256 }, (_, n) => {
    let c = n;
    for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
    return c >>> 0;
  });
  let crc = 0xffffffff;
  for (const byte of bytes) crc = table[(crc ^ byte) & 0xff] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

/// Throws ModelError unless the bytes may be an undamaged HDF5 file.
function checkBytes(bytes) {
  if (bytes.length === 0) throw new ModelError("The file is empty, wanted a motion model (.h5) that vrda run wrote.");
  if (!signature.every((byte, i) => bytes[i] === byte)) throw new ModelError("This is not an HDF5 file, wanted a motion model (.h5) that vrda run wrote.");
  if (bytes.length < sealLength) throw new ModelError("The file is cut off.");
  const seal = bytes.subarray(bytes.length - sealLength);
  if (![...sealName].every((letter, i) => seal[i] === letter.charCodeAt(0))) return;
  const stored = new DataView(seal.buffer, seal.byteOffset + 8, 4).getUint32(0, true);
  if (stored !== crc32(bytes.subarray(0, bytes.length - sealLength))) throw new ModelError("The file is damaged: its bytes do not match its seal. Copy it again.");
}

// One HDF5 file in memory. Every size is checked before data are read.

/// Limit per dataset: a hundred times a full grid of poses; 400 MB of float64.
const mostNumbers = 50_000_000;
const mostTexts = 10_000;
const path = "/model.h5";

const kinds = { float64: ["Float64Array", 1, 8], int64: ["BigInt64Array", 0, 8], int32: ["Int32Array", 0, 4], int8: ["Int8Array", 0, 1] };

class Hdf5File {
  #file;

  /// Opens the bytes; throws ModelError if HDF5 cannot open them. close() must be called.
  static async open(bytes) {
    await ready;
    const opened = new Hdf5File();
    FS.writeFile(path, bytes);
    try {
      opened.#file = new File(path, "r");
    } catch {
      opened.#file = null;
    }
    if (!opened.#file || BigInt(opened.#file.file_id ?? -1) < 0n) {
      FS.unlink(path);
      throw new ModelError("This HDF5 file cannot be opened: it is cut off or damaged.");
    }
    return opened;
  }

  close() {
    try {
      this.#file.close();
    } finally {
      FS.unlink(path);
    }
  }

  #type(name) {
    try {
      return this.#file.get(name)?.type;
    } catch {
      return undefined;
    }
  }

  hasDataset(name) { return this.#type(name) === "Dataset"; }
  hasGroup(name) { return this.#type(name) === "Group"; }
  groups(name) { return this.hasGroup(name) ? this.#file.get(name).keys() : []; }

  /// Lengths of a dataset's axes.
  shape(name) {
    if (!this.hasDataset(name)) refuse(name, "no such dataset", "a dataset");
    return this.#file.get(name).metadata.shape.map(Number);
  }

  #checked(name, wanted) {
    const shape = this.shape(name);
    if (shape.length !== wanted.length || wanted.some((n, i) => n !== null && n !== shape[i])) {
      refuse(name, `a size of ${shape.join(" x ") || "1"}`, wanted.map((n) => n ?? "any").join(" x "));
    }
    return { shape, metadata: this.#file.get(name).metadata, count: shape.reduce((a, b) => a * b, 1) };
  }

  /// The numbers of a dataset of this size (null: any) and type, in row-major order.
  numbers(name, wanted, kind = "float64") {
    const { metadata, count } = this.#checked(name, wanted);
    const [array, type, size] = kinds[kind];
    if (metadata.type !== type || metadata.size !== size || metadata.vlen) refuse(name, "another type", kind);
    if (count > mostNumbers) refuse(name, `${count} numbers`, `at most ${mostNumbers}`);
    if (count === 0) return new globalThis[array](0);
    const value = this.#value(name);
    if (value?.constructor?.name !== array || value.length !== count) refuse(name, "data that cannot be read", kind);
    return value;
  }

  /// The strings of a one-dimensional dataset.
  texts(name) {
    const { metadata, count } = this.#checked(name, [null]);
    if (metadata.type !== Module.H5T_class_t.H5T_STRING.value) refuse(name, "another type", "text");
    if (count > mostTexts) refuse(name, `${count} texts`, `at most ${mostTexts}`);
    return count === 0 ? [] : [...this.#value(name)].map(String);
  }

  #value(name) {
    try {
      return this.#file.get(name).value;
    } catch {
      return refuse(name, "data that cannot be read", "the data of an undamaged file");
    }
  }

  /// The elements of an attribute of a group; undefined if missing.
  attribute(name, group = "/") {
    try {
      const attribute = this.#file.get(group).attrs[name];
      if (!attribute || attribute.shape.reduce((a, b) => a * Number(b), 1) > mostTexts) return undefined;
      const { value } = attribute;
      return typeof value === "string" ? [value] : Array.from(value);
    } catch {
      return undefined;
    }
  }
}

// The meshes of a body: contact and visual parts.

function checkIndices(field, indices, count) {
  for (const index of indices) {
    if (index < 0 || index >= count) refuse(field, `row ${index}`, `0 to ${count - 1}`);
  }
}

function part(file, group, nComponents) {
  const vertices = file.numbers(`${group}/vertices`, [null, 3]);
  const triangles = file.numbers(`${group}/triangles`, [null, 3], "int32");
  const component = file.numbers(`${group}/component`, [triangles.length / 3], "int32");
  if (!vertices.every(Number.isFinite)) refuse(`${group}/vertices`, "a coordinate that is not a finite number", "finite numbers");
  checkIndices(`${group}/triangles`, triangles, vertices.length / 3);
  checkIndices(`${group}/component`, component, nComponents);
  return { vertices, triangles, component };
}

/// { components: [{ name, material }], parts: [{ vertices, triangles, component }] }; mm, canonical.
function readBodies(file, name, group = `/bodies/${name}`) {
  const names = file.texts(`${group}/component_name`), materials = file.texts(`${group}/component_material`);
  if (names.length !== materials.length) refuse(`${group}/component_material`, `${materials.length} materials`, `${names.length}`);
  const parts = [part(file, group, names.length)];
  if (file.hasGroup(`${group}/visual`)) parts.push(part(file, `${group}/visual`, names.length));
  return { name: file.attribute("name", group)?.[0] ?? name, components: names.map((own, k) => ({ name: own, material: materials[k] })), parts };
}

function wrapsOf(file, group, moving) {
  const shapes = file.numbers(`${group}/wrap_shape`, [null], "int8"), n = shapes.length;
  const bodies = file.numbers(`${group}/wrap_body`, [n], "int8");
  const poses = file.numbers(`${group}/X_body_wrap`, [n, 4, 4]), radii = file.numbers(`${group}/wrap_radii`, [n, 3]);
  if (!poses.every(Number.isFinite)) refuse(`${group}/X_body_wrap`, "a pose that is not finite", "finite numbers");
  if (!radii.every((r) => r > 0 && Number.isFinite(r))) refuse(`${group}/wrap_radii`, "an invalid radius", "numbers above 0");
  return Array.from(shapes, (shape, k) => {
    const row = (r) => poses.subarray(16 * k + 4 * r, 16 * k + 4 * r + 4);
    const R = [0, 1, 2].map((r) => Array.from(row(r).subarray(0, 3))), t = [0, 1, 2].map((r) => row(r)[3]);
    return { shape, isOnMoving: bodies[k] === moving, R, t, radii: Array.from(radii.subarray(3 * k, 3 * k + 3)) };
  });
}

/// { fibres, wraps, transitionStrain }, or undefined if the model has no ligaments. mm. `moving`: the index of the
/// body of the second ends, that of the joint or of a follower, whose fibres also have `from`, the index of the other body.
function readLigaments(file, group = "/ligaments", moving = 1) {
  if (!file.hasGroup(group)) return undefined;
  const names = file.texts(`${group}/name`), bundles = file.texts(`${group}/bundle`), n = names.length;
  const reference = file.numbers(`${group}/reference`, [n, 3]), end = file.numbers(`${group}/moving`, [n, 3]);
  const slackLengths = file.numbers(`${group}/slack_length`, [n]), wrap = file.numbers(`${group}/wrap`, [n], "int32");
  const wraps = wrapsOf(file, group, moving), isFollower = moving > 1;
  const from = isFollower ? file.numbers(`${group}/from_body`, [n], "int8") : undefined;
  const tension = isFollower ? file.numbers(`${group}/constant_tension`, [n]) : undefined;
  const stiffness = file.numbers(`${group}/stiffness`, [n]), transitionStrain = Number(file.attribute("transition_strain", group)?.[0]);
  if (!reference.every(Number.isFinite) || !end.every(Number.isFinite)) refuse(`${group}/reference`, "an attachment that is not finite", "finite numbers");
  if (!slackLengths.every((length) => length > 0)) refuse(`${group}/slack_length`, "an invalid length", "numbers above 0");
  if (!wrap.every((row) => row >= -1 && row < wraps.length)) refuse(`${group}/wrap`, "an invalid row", `-1 to ${wraps.length - 1}`);
  if (from && !from.every((body) => body >= 0 && body < moving)) refuse(`${group}/from_body`, "an invalid body", `0 to ${moving - 1}`);
  const point = (table, k) => Array.from(table.subarray(3 * k, 3 * k + 3));
  const fibres = names.map((name, k) => ({
    name, bundle: bundles[k] ?? "", reference: point(reference, k), moving: point(end, k), slackLength: slackLengths[k], wrap: wraps[wrap[k]],
    from: from?.[k] ?? 0, isLine: tension?.[k] > 0, constantTension: tension?.[k] ?? 0, stiffness: stiffness[k],
  }));
  return { fibres, wraps, transitionStrain };
}

const followerCoordinates = ["flexion_angle", "rotation_angle", "tilt", "anterior", "proximal", "lateral"];

/// Bodies that follow the joint, in the order in which they are solved.
function readFollowers(file, model) {
  const size = [model.flexion.length, model.varus.length];
  const followers = file.groups("/followers").map((name) => {
    const group = `/followers/${name}`, [index, of] = ["body_index", "of"].map((key) => Number(file.attribute(key, group)?.[0]));
    const centre = file.attribute("centre_mm", group)?.map(Number) ?? [];
    if (!(index >= 2 && of >= 0 && of < index)) refuse(group, `the bodies ${index} and ${of}`, "body_index above of");
    if (centre.length !== 3 || !centre.every(Number.isFinite)) refuse(group, "no centre", "centre_mm");
    const delta = file.attribute("delta", group)?.map(Number) ?? [];
    if (delta.length !== 3 || !delta.every(Number.isFinite)) refuse(group, "no direction", "delta");
    const plausibility = file.hasDataset(`${group}/plausibility`) ? file.numbers(`${group}/plausibility`, size, "int8") : undefined;
    return { name, index, of, centre, delta, plausibility, status: file.numbers(`${group}/status`, size, "int8"), ...datasets(file, group, followerCoordinates, size),
             body: { ...readBodies(file, name, `${group}/body`), name }, ligaments: readLigaments(file, `${group}/ligaments`, index) };
  });
  return followers.sort((a, b) => a.index - b.index);
}

// Reads a motion model (schemas/motion-model.md) from the bytes of a file; angles in degrees as in the file.

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
  Object.assign(model, datasets(file, "", ["tx", "ty", "tz", "theta"], size));
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

function coefficients(file, group, nTerms, names = surfaceNames) {
  return names.map((surface) => {
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
    set.followers = file.groups(`${group}/followers`).map((follower) => {
      const own = `${group}/followers/${follower}`;
      return { name: follower, coefficients: coefficients(file, own, exponents.length / 2, followerCoordinates),
               recontact: file.hasDataset(`${own}/recontact`) ? file.numbers(`${own}/recontact`, size) : undefined };
    });
    return set;
  });
}

const coordinates = ["tx", "ty", "tz", "theta", "varus"];

/// The datasets of a group by their names.
const datasets = (file, group, names, size) => Object.fromEntries(names.map((name) => [name, file.numbers(`${group}/${name}`, size)]));

/// Poses over flexion; `state` names the dataset that is -1 without a pose.
function readFlexionTable(file, group, state, n) {
  const table = { [state]: file.numbers(`${group}/${state}`, [n], "int8"), ...datasets(file, group, coordinates, [n]) };
  for (let i = 0; i < n; ++i) {
    if (table[state][i] !== -1 && !coordinates.every((name) => Number.isFinite(table[name][i]))) refuse(`${group}/${state}`, `a pose (number ${i}) that is not finite`, "finite numbers");
  }
  return table;
}

function readMotionsOverFlexion(file, model) {
  const [set, reason] = file.hasGroup("/default_motion") ? ["set", "reason"].map((name) => file.attribute(name, "/default_motion")?.[0]) : [];
  if (typeof set === "string") model.defaultMotion = { set, reason: reason ?? "" };
  if (model.defaultMotion && file.hasGroup("/prior")) model.defaultMotion.statement = file.attribute("statement", "/prior")?.[0] ?? "";
  if (file.hasGroup("/two_sided")) {
    const flexion = axis(file, "/two_sided/flexion");
    model.twoSided = { flexion, ...readFlexionTable(file, "/two_sided", "contact", flexion.length) };
    model.twoSided.degree = Number(file.attribute("degree", "/two_sided")?.[0]);
    for (const side of ["medial", "lateral"]) model.twoSided[side] = file.numbers(`/two_sided/gap_${side}`, [flexion.length]);
  }
  if (file.hasGroup("/zero_varus")) model.zeroVarus = readFlexionTable(file, "/zero_varus", "source", model.flexion.length);
}

/// The motion without the prior, a motion over flexion like those of the samples.
function readBonesAlone(file, model) {
  if (!file.hasGroup("/prior/bones_alone")) return;
  const n = model.flexion.length, group = "/prior/bones_alone";
  const state = Array.from(file.numbers(`${group}/status`, [n], "int8"), (s) => (s === 0 ? 0 : -1));
  model.quantiles = [...(model.quantiles ?? []), { name: "bones_alone", state, ...datasets(file, group, coordinates, [n]) }];
}

/// Of the sample at each probability: { follower: { status, columns } over flexion, its six coordinates }.
function readSampledFollowers(file, n, probabilities) {
  const group = "/uncertainty/followers", names = file.hasGroup(group) ? file.groups(group) : [];
  if (names.length === 0) return Array.from({ length: probabilities }, () => ({}));
  const all = names.map((name) => {
    const own = `${group}/${name}`, status = file.numbers(`${own}/status`, [null, n], "int8"), size = [status.length / n, n, 3];
    return { name, status, values: ["rotation", "translation"].map((dataset) => file.numbers(`${own}/${dataset}`, size)) };
  });
  const column = (values, sample, k) => Float64Array.from({ length: n }, (_, i) => values[3 * (sample * n + i) + k]);
  return Array.from(file.numbers("/uncertainty/quantile_sample", [probabilities], "int32"), (sample) => Object.fromEntries(all.map(({ name, status, values }) => [name, {
    status: status.subarray(sample * n, (sample + 1) * n), columns: values.flatMap((table) => [0, 1, 2].map((k) => column(table, sample, k))),
  }])));
}

/// The samples of an uncertain job: their motions at five probabilities, and the 5 to 95 % band of the clinical numbers.
function readUncertainty(file, model) {
  if (!file.hasGroup("/uncertainty")) return;
  const n = model.flexion.length, group = "/uncertainty", probabilities = 5, low = 1, high = 3;
  const all = datasets(file, group, coordinates, [probabilities, n]);
  const status = file.numbers(`${group}/quantile_status`, [probabilities, n], "int8");
  const row = (values, k) => values.subarray(k * n, (k + 1) * n);
  const followers = readSampledFollowers(file, n, probabilities);
  model.quantiles = [0, 5, 50, 95, 100].map((percent, k) => ({
    name: `quantile_${percent}`, state: Array.from(row(status, k), (s) => (s === 0 ? 0 : -1)), ...Object.fromEntries(coordinates.map((name) => [name, row(all[name], k)])), followers: followers[k],
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
  model.contactPaths = datasets(file, "/contact_paths", names, size);
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
  readBonesAlone(file, model);
  readContactPaths(file, model);
  model.warnings = file.hasDataset("/job/warnings") ? file.texts("/job/warnings") : [];
  model.ligaments = readLigaments(file);
  model.bodies = { reference: readBodies(file, "reference"), moving: readBodies(file, "moving") };
  model.followers = readFollowers(file, model);
  for (const { name, body } of model.followers) model.bodies[name] = body;
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
