// One HDF5 file in memory. Every size is checked before data are read.
import { File, FS, Module, ready } from "h5wasm";
import { ModelError, refuse } from "./model_error.js";

/// Limit per dataset: a hundred times a full grid of poses; 400 MB of float64.
const mostNumbers = 50_000_000;
const mostTexts = 10_000;
const path = "/model.h5";

const kinds = { float64: ["Float64Array", 1, 8], int64: ["BigInt64Array", 0, 8], int32: ["Int32Array", 0, 4], int8: ["Int8Array", 0, 1] };

export class Hdf5File {
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
