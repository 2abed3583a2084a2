// The state of the view and lessons as plain data (schemas/view-state.md): their checks, and the page's address.

const stateFormat = "vrda view state", lessonFormat = "vrda lesson", version = 1;
const largestMm = 1e5, largestDegrees = 360, mostSteps = 200, longestText = 2000;

function refuse(field, found, wanted) { throw new Error(`${field}: found ${typeof found === "string" ? `"${found}"` : JSON.stringify(found)}, wanted ${wanted}`); }

/// Normals of the named sections in the axes of what is fixed.
export const sectionNormals = { sagittal: [0, 0, 1], coronal: [1, 0, 0], axial: [0, 1, 0] };

const isObject = (x) => typeof x === "object" && x !== null && !Array.isArray(x);
const isNumber = (x, most) => typeof x === "number" && Number.isFinite(x) && Math.abs(x) <= most;
const isText = (x) => typeof x === "string" && x.length <= longestText;
const isPoint = (x) => Array.isArray(x) && x.length === 3 && x.every((c) => isNumber(c, largestMm));

function checkKeys(field, value, keys) {
  if (!isObject(value)) refuse(field, value, "an object");
  for (const key of Object.keys(value)) if (!keys.includes(key)) refuse(`${field}.${key}`, "this key", keys.join(", "));
}

function checkFormat(field, value, format) {
  if (value.format !== format) refuse(`${field}.format`, value.format, `"${format}"`);
  if (value.version !== version) refuse(`${field}.version`, value.version, `${version}`);
}

function checkView(field, view, views) {
  if (isObject(view) && isPoint(view.eye_mm) && isPoint(view.target_mm)) {
    checkKeys(field, view, ["eye_mm", "target_mm", "roll"]);
    if (view.roll !== undefined && !isNumber(view.roll, largestDegrees)) refuse(`${field}.roll`, view.roll, "degrees");
    return;
  }
  if (!views.includes(view)) refuse(field, view, `${views.join(", ")}, or eye_mm and target_mm`);
}

/// Throws an Error that says what is wrong with a view state; `of`: { sets, structures (ids), views, fixed } that the model and page have.
export function checkState(state, of, field = "state") {
  checkKeys(field, state, ["format", "version", "set", "flexion", "varus", "fixed", "view", "whole", "labels", "band", "section", "structures", "highlighted"]);
  checkFormat(field, state, stateFormat);
  if (!of.sets.includes(state.set)) refuse(`${field}.set`, state.set, of.sets.join(", "));
  if (!isNumber(state.flexion, largestDegrees)) refuse(`${field}.flexion`, state.flexion, "degrees");
  if (state.varus !== undefined && !isNumber(state.varus, largestDegrees)) refuse(`${field}.varus`, state.varus, "degrees, or no varus");
  if (!of.fixed.includes(state.fixed)) refuse(`${field}.fixed`, state.fixed, of.fixed.join(", "));
  checkView(`${field}.view`, state.view, of.views);
  for (const key of ["whole", "labels", "band"]) if (![undefined, true, false].includes(state[key])) refuse(`${field}.${key}`, state[key], "true or false");
  if (state.section !== undefined) {
    checkKeys(`${field}.section`, state.section, ["plane", "at_mm"]);
    const { plane, at_mm: at } = state.section, isUnit = isPoint(plane) && Math.abs(Math.hypot(...plane) - 1) < 1e-2;
    if (!(plane in sectionNormals) && !isUnit) refuse(`${field}.section.plane`, plane, `${Object.keys(sectionNormals).join(", ")}, or a unit vector`);
    if (!isNumber(at, largestMm)) refuse(`${field}.section.at_mm`, at, "mm");
  }
  for (const [id, look] of Object.entries(state.structures ?? {})) {
    if (!of.structures.includes(id)) refuse(`${field}.structures`, id, "a structure of the model");
    checkKeys(`${field}.structures["${id}"]`, look, ["visible", "opacity"]);
    if (![undefined, true, false].includes(look.visible)) refuse(`${field}.structures["${id}"].visible`, look.visible, "true or false");
    if (look.opacity !== undefined && !(isNumber(look.opacity, 1) && look.opacity > 0)) refuse(`${field}.structures["${id}"].opacity`, look.opacity, "a number above 0, at most 1");
  }
  if (state.highlighted !== undefined && !of.structures.includes(state.highlighted)) refuse(`${field}.highlighted`, state.highlighted, "a structure of the model");
  return state;
}

export const newState = (values) => ({ format: stateFormat, version, ...values });
export const newLesson = (title, steps) => ({ format: lessonFormat, version, title, steps });

/// The same for a lesson; `of` also has `bodies`.
export function checkLesson(lesson, of) {
  checkKeys("lesson", lesson, ["format", "version", "title", "steps"]);
  checkFormat("lesson", lesson, lessonFormat);
  if (!isText(lesson.title)) refuse("lesson.title", lesson.title, "a text");
  if (!Array.isArray(lesson.steps) || lesson.steps.length === 0 || lesson.steps.length > mostSteps) refuse("lesson.steps", lesson.steps, `1 to ${mostSteps} steps`);
  lesson.steps.forEach((step, k) => {
    const field = `lesson.steps[${k}]`;
    checkKeys(field, step, ["text", "state", "arrow", "question"]);
    if (!isText(step.text)) refuse(`${field}.text`, step.text, `a text of at most ${longestText} characters`);
    checkState(step.state, of, `${field}.state`);
    if (step.arrow !== undefined) {
      checkKeys(`${field}.arrow`, step.arrow, ["body", "point_mm"]);
      if (!of.bodies.includes(step.arrow.body)) refuse(`${field}.arrow.body`, step.arrow.body, of.bodies.join(", "));
      if (!isPoint(step.arrow.point_mm)) refuse(`${field}.arrow.point_mm`, step.arrow.point_mm, "three numbers");
    }
    if (step.question === undefined) return;
    checkKeys(`${field}.question`, step.question, ["ask", "answers", "right", "wrong"]);
    for (const key of ["ask", "right", "wrong"]) if (!isText(step.question[key])) refuse(`${field}.question.${key}`, step.question[key], "a text");
    const { answers } = step.question;
    if (!Array.isArray(answers) || answers.length === 0) refuse(`${field}.question.answers`, answers, "a list of structures");
    for (const id of answers) if (!of.structures.includes(id)) refuse(`${field}.question.answers`, id, "a structure of the model");
  });
  return lesson;
}

// The address: #step=N&view=STATE.

/// { step, state } of the address; throws an Error if the state is no JSON.
export function readAddress() {
  const found = new URLSearchParams(location.hash.slice(1)), view = found.get("view");
  try {
    return { step: Math.max(1, Number(found.get("step")) || 1), state: view === null ? null : JSON.parse(view) };
  } catch {
    return refuse("address", view.slice(0, 40), "the state of a view");
  }
}

export function writeAddress({ step, state }) {
  const parts = new URLSearchParams();
  if (step) parts.set("step", step);
  if (state) parts.set("view", JSON.stringify(state));
  const hash = parts.toString();
  if (location.hash.slice(1) !== hash) history.replaceState(null, "", hash ? `#${hash}` : `${location.pathname}${location.search}`);
}
