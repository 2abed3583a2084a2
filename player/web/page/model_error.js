/// An error in a file, with a message for the user.
export class ModelError extends Error {}

/// Throws a ModelError that names the field, what was found and what was wanted.
export function refuse(field, found, wanted) {
  throw new ModelError(`${field ? `${field}: ` : ""}found ${found}, wanted ${wanted}`);
}
