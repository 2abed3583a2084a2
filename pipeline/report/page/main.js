// Builds the report: sections in reading order, then their plots.
import { axesSection, branchesSection, contactPathsSection, coordinatesSection, curvesSection, fibresSection, forcesSection } from "./mechanics.js";
import { comparisonSection, repairSection, rotationSection, surfacesSection, translationsSection } from "./motion.js";
import { el } from "./page.js";
import { drawAll, drawOver, followTheme } from "./plot.js";
import { degreesSection, statusSection, uncertaintySection } from "./quality.js";
import { laxitySections, rangeSections } from "./results.js";
import { leadText, provenanceSection, stillsSection, summariesSection, summarySection, verdictSection } from "./summary.js";

function coordinates(model) {
  return model.coordinates ? [coordinatesSection] : [];
}

function curves(model) {
  return model.flexion_curves.length > 0 ? [curvesSection] : [];
}

function uncertainty(model) {
  return model.uncertainty ? [uncertaintySection] : [];
}

function verdict(model) {
  return model.verdict ? [verdictSection] : [];
}

// A sequence of frames has no smoothed set, no flexion-only motion and no map over a grid.
function sectionsOfFrames(data) {
  const model = data.models[0];
  drawOver(model.key_name);
  const repair = model.repair ? [repairSection] : [];
  return [...verdict(model), summarySection, stillsSection, ...repair, surfacesSection, rotationSection, translationsSection, ...uncertainty(model), ...coordinates(model), contactPathsSection, ...curves(model), fibresSection].map((make) => make(model)).concat(provenanceSection(data));
}

function sectionsOfOne(data) {
  const model = data.models[0];
  if (model.key_name) return sectionsOfFrames(data);
  const of = [summarySection, stillsSection, surfacesSection, degreesSection, rotationSection, translationsSection, contactPathsSection, axesSection, branchesSection, forcesSection, ...curves(model), fibresSection, ...uncertainty(model), ...coordinates(model), statusSection];
  const sections = of.map((make) => make(model));
  const comparison = data.against.length > 0 ? [comparisonSection(data)] : [];
  return [...verdict(model).map((make) => make(model)), ...sections.slice(0, 6), ...comparison, ...sections.slice(6), provenanceSection(data)];
}

function sectionsOfSeveral(data) {
  return [summariesSection(data.models), comparisonSection(data), provenanceSection(data)];
}

function contents(sections) {
  const items = sections.map((one) => el("li", {}, el("a", { href: `#${one.id}` }, one.querySelector("h2").textContent)));
  return el("nav", { class: "contents", "aria-label": "Contents" }, el("ul", {}, items));
}

// That the motion is a model of which a prior decided a part.
function statement(model) {
  return model.statement ? [el("p", { class: "lead", role: "note" }, el("strong", {}, model.statement))] : [];
}

function heading(data) {
  if (data.models.length === 1) return [el("h1", {}, data.models[0].title), ...statement(data.models[0]), el("p", { class: "lead" }, leadText(data.models[0]))];
  return [el("h1", {}, `Comparison of ${data.models.length} motion models`), el("p", { class: "lead" }, data.models.map((model) => `${model.name}: ${model.title}`).join("; "))];
}

// The sections of the data's kind: one result of another command, or motion models.
function sectionsOf(data) {
  if (data.laxity) return laxitySections(data.laxity);
  if (data.range) return rangeSections(data.range);
  return data.models.length === 1 ? sectionsOfOne(data) : sectionsOfSeveral(data);
}

function main() {
  const data = JSON.parse(document.getElementById("report-data").textContent);
  const sections = sectionsOf(data);
  const title = data.models ? heading(data) : [el("h1", {}, document.title)];
  document.getElementById("report").append(...title, contents(sections), ...sections, el("footer", {}, `Report of ${data.program}.`));
  followTheme();
  drawAll();
  document.documentElement.dataset.report = "ready";
}

main();
