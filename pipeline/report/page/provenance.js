// Provenance: inputs, bodies, scaling, job.
import { el, folded, section, table } from "./dom.js";

function inputsTable(inputs) {
  return table("SHA-256 of every input file, or of the bytes of a generated mesh", ["input", "SHA-256"], inputs.map((input) => [input.name, input.sha256]), { kinds: ["", "hash"] });
}

function bodiesTable(model) {
  const rows = [model.reference, model.moving].flatMap((body, k) => [[
    body.name, k === 0 ? "reference" : "moving", body.components.map((c) => `${c.name} (${c.material})`).join(", "), String(body.contact_triangles), String(body.visual_triangles)]]);
  return table("Bodies", ["body", "role", "components", "contact triangles", "visual triangles"], rows, { kinds: ["", "word", "text"] });
}

// Scaling of the joint to its subject and fit of the landmarks.
function scaled(scaling) {
  if (!scaling) return [];
  const [x, y, z] = scaling.factor;
  const by = x === y && y === z ? String(x) : `${x} (anterior), ${y} (proximal), ${z} (right)`;
  const steps = scaling.keeps_steps ? "steps solved at factor 1, then scaled" : "steps solved at this size";
  if (scaling.landmarks.length === 0) return [el("p", {}, `The meshes are scaled by ${by}; ${steps}.`)];
  const error = scaling.standard_error === null ? "unknown" : String(scaling.standard_error);
  const rows = scaling.landmarks.map((name, i) => [name, scaling.model_mm[i], scaling.subject_mm[i], scaling.residual_mm[i]].map(String));
  return [
    el("p", {}, `The meshes are scaled by ${by} (standard error ${error}), fitted to distances between landmarks with a residual of ${scaling.residual_rms_mm} mm (root mean square); ${steps}.`),
    table("Landmarks, mm", ["pair", "model", "subject", "residual"], rows)];
}

function ofModel(model) {
  const p = model.provenance;
  return [bodiesTable(model), ...scaled(p.scaling), inputsTable(p.inputs),
    folded("Job file", el("pre", {}, p.job)),
    folded("Job with all keys and values", el("pre", {}, p.resolved))];
}

export function provenanceSection(data) {
  const parts = data.models.length === 1 ? ofModel(data.models[0])
    : data.models.map((model) => folded(`${model.name}: ${model.title}`, ...ofModel(model)));
  const versions = `Made by ${data.program} from motion models of format ${data.models[0].provenance.format_version}; plots by plotly.js ${window.Plotly.version} (MIT licence). The page contains no time or host: the same files give the same page.`;
  return section("provenance", "Provenance", el("p", {}, versions), ...parts);
}
