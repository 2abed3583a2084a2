// Where the numbers come from.
import { el, folded, section, table } from "./dom.js";

function inputsTable(inputs) {
  return table("SHA-256 of every input, a generated mesh's own bytes where there is no file", ["input", "SHA-256"], inputs.map((input) => [input.name, input.sha256]), { kinds: ["", "hash"] });
}

function bodiesTable(model) {
  const rows = [model.reference, model.moving].flatMap((body, k) => [[
    body.name, k === 0 ? "reference" : "moving", body.components.map((c) => `${c.name} (${c.material})`).join(", "), String(body.contact_triangles), String(body.visual_triangles)]]);
  return table("Bodies", ["body", "role", "components", "triangles in contact", "only drawn"], rows, { kinds: ["", "word", "text"] });
}

// How a joint was scaled to its subject, and how well the landmarks fit.
function scaled(scaling) {
  if (!scaling) return [];
  const [x, y, z] = scaling.factor;
  const by = x === y && y === z ? String(x) : `${x} (anterior), ${y} (proximal), ${z} (right)`;
  const steps = scaling.keeps_steps ? "the steps were solved at factor 1, their results scaled" : "the steps were solved at this size";
  if (scaling.landmarks.length === 0) return [el("p", {}, `The joint is the meshes' scaled by ${by}; ${steps}.`)];
  const error = scaling.standard_error === null ? "unknown" : String(scaling.standard_error);
  const rows = scaling.landmarks.map((name, i) => [name, scaling.model_mm[i], scaling.subject_mm[i], scaling.residual_mm[i]].map(String));
  return [
    el("p", {}, `The joint is the meshes' scaled by ${by} (standard error ${error}), fitted to distances between landmarks, which leaves ${scaling.residual_rms_mm} mm (root mean square); ${steps}.`),
    table("Landmarks, mm", ["pair", "model", "subject", "residual"], rows)];
}

function ofModel(model) {
  const p = model.provenance;
  return [bodiesTable(model), ...scaled(p.scaling), inputsTable(p.inputs),
    folded("The job, as given", el("pre", {}, p.job)),
    folded("The job, every key with its value", el("pre", {}, p.resolved))];
}

export function provenanceSection(data) {
  const parts = data.models.length === 1 ? ofModel(data.models[0])
    : data.models.map((model) => folded(`${model.name}: ${model.title}`, ...ofModel(model)));
  const versions = `Made by ${data.program} from motion models of format ${data.models[0].provenance.format_version}; plots by plotly.js ${window.Plotly.version} (MIT licence). The page holds no time or host: the same files make the same page.`;
  return section("provenance", "Provenance", el("p", {}, versions), ...parts);
}
