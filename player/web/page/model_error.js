/// Something wrong with a file, said for the person who brought it.
export class ModelError extends Error {}

/// Says where, what was found and what was wanted.
export function refuse(place, found, wanted) {
  throw new ModelError(`${place ? `${place}: ` : ""}found ${found}, wanted ${wanted}`);
}
