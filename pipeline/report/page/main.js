// Builds the report: sections in reading order, then their plots.
import { axesSection } from "./axes.js";
import { branchesSection } from "./branches.js";
import { rotationSection, translationsSection } from "./clinical.js";
import { comparisonSection } from "./comparison.js";
import { contactPathsSection } from "./contact_paths.js";
import { coordinatesSection } from "./coordinates.js";
import { degreesSection } from "./degrees.js";
import { el } from "./dom.js";
import { fibresSection, forcesSection } from "./loads.js";
import { drawAll, drawOver, followTheme } from "./plot.js";
import { provenanceSection } from "./provenance.js";
import { repairSection } from "./repair.js";
import { statusSection } from "./status_map.js";
import { stillsSection } from "./stills.js";
import { leadText, summariesSection, summarySection } from "./summary.js";
import { surfacesSection } from "./surfaces.js";
import { uncertaintySection } from "./uncertainty.js";

function coordinates(model) {
  return model.coordinates ? [coordinatesSection] : [];
}

function uncertainty(model) {
  return model.uncertainty ? [uncertaintySection] : [];
}

// A sequence of frames has no smoothed set, no flexion-only motion and no map over a grid.
function sectionsOfFrames(data) {
  const model = data.models[0];
  drawOver(model.key_name);
  const repair = model.repair ? [repairSection] : [];
  return [summarySection, stillsSection, ...repair, surfacesSection, rotationSection, translationsSection, ...uncertainty(model), ...coordinates(model), contactPathsSection, fibresSection].map((make) => make(model)).concat(provenanceSection(data));
}

function sectionsOfOne(data) {
  const model = data.models[0];
  if (model.key_name) return sectionsOfFrames(data);
  const of = [summarySection, stillsSection, surfacesSection, degreesSection, rotationSection, translationsSection, contactPathsSection, axesSection, branchesSection, forcesSection, fibresSection, ...uncertainty(model), ...coordinates(model), statusSection];
  const sections = of.map((make) => make(model));
  const comparison = data.against.length > 0 ? [comparisonSection(data)] : [];
  return [...sections.slice(0, 6), ...comparison, ...sections.slice(6), provenanceSection(data)];
}

function sectionsOfSeveral(data) {
  return [summariesSection(data.models), comparisonSection(data), provenanceSection(data)];
}

function contents(sections) {
  const items = sections.map((one) => el("li", {}, el("a", { href: `#${one.id}` }, one.querySelector("h2").textContent)));
  return el("nav", { class: "contents", "aria-label": "Contents" }, el("ul", {}, items));
}

function heading(data) {
  if (data.models.length === 1) return [el("h1", {}, data.models[0].title), el("p", { class: "lead" }, leadText(data.models[0]))];
  return [el("h1", {}, `Comparison of ${data.models.length} motion models`), el("p", { class: "lead" }, data.models.map((model) => `${model.name}: ${model.title}`).join("; "))];
}

async function main() {
  const data = JSON.parse(document.getElementById("report-data").textContent);
  const sections = data.models.length === 1 ? sectionsOfOne(data) : sectionsOfSeveral(data);
  document.getElementById("report").append(...heading(data), contents(sections), ...sections, el("footer", {}, `Report of ${data.program}.`));
  followTheme();
  await drawAll();
  document.documentElement.dataset.report = "ready";
}

main();
