// The page: connects its controls, 3-D view and plots to a Player.
import { Comparison } from "./compare.js";
import { helpLines, watchFiles, watchKeys } from "./controls.js";
import { degree, difference, dot, normalised } from "./geometry.js";
import { insideOf, pageMaker } from "./inside.mjs";
import { bandEnds, Joint } from "./joint.js";
import { Labels } from "./labels.js";
import { bodyNames, gapPalette, gradientOf, highestStrain, strainPalette } from "./layers.js";
import { Arrow, LessonEditor, LessonPlayer } from "./lesson.js";
import { connectLive } from "./live.js";
import { readMotionModel } from "./model_file.js";
import { Player, stable } from "./motion.js";
import { landmarksOf } from "./placement.js";
import { bandOf, columnsAlong, CurvePlot, inkNow, lineStyle, Maps, pathAlong, PlateauPlot, sampledFlexion, valuesOf } from "./plots.js";
import { clinicalNumbers, clinicalOf, doubtfulSpans, doubtText, formatNumber, modelWarnings, quantitiesOf, surfaceRows } from "./readings.js";
import { bodyPath, Card, gapStructure, Looks, pathsStructure, readingText, StructureList, structuresOf } from "./structures.js";
import { save, usdzOf, Viewer, views } from "./viewer.js";
import { checkLesson, checkState, newState, readAddress, sectionNormals, writeAddress } from "./view_state.js";
import { connectXr } from "./xr.js";

// Directions, positive and negative, of flexion and varus of the kinds whose words differ (schemas/clinical.md).
const foot = [["plantarflexion", "dorsiflexion"], ["inversion", "eversion"]];
const kindWords = { hip: [["extension", "flexion"], ["adduction", "abduction"]], ankle: foot, subtalar: foot };

const makePage = pageMaker(document), inside = insideOf(document);
const byId = (id) => document.getElementById(id);
const mostContacts = 16;  // in a band of contact positions, each of which is searched
const framedPoses = 5;  // over flexion, to which the camera is fitted

let player = null, joint = null, view = "oblique", isFree = false, quantities = [], lastFrame = null;
let looks = null, file = null, strainCurves = new Map(), touched = null;  // bytes and name of the model; readings of bundles over flexion; who waits for a point
const viewer = new Viewer(byId("joint"));
const labels = new Labels(byId("labels")), otherLabels = new Labels(byId("labels-other"));
const plateau = new PlateauPlot(byId("plateau"));
const maps = new Maps(byId("maps"), (flexion, varus) => goTo({ flexion, varus }));
const curveIn = (element) => new CurvePlot(element, (flexion) => goTo({ flexion }));
const curve = curveIn(byId("curve")), quantityCurve = curveIn(byId("quantity-curve"));
const otherCurves = Object.fromEntries([["clinical_varus", "Varus"], ["clinical_anterior", "Anterior translation"], ["contact", "Contact positions on the moving bone"], ["strain", "Strain of each bundle"], ["tension", "Force of each bundle"]].map(([name, caption]) => {
  const figure = Object.assign(document.createElement("figure"), { className: `of-${name}` });
  byId("plateau-figure").before(figure);
  figure.append(Object.assign(document.createElement("figcaption"), { textContent: `${caption} over flexion` }));
  return [name, { figure, plot: curveIn(figure.appendChild(document.createElement("div"))) }];
}));
const list = new StructureList(byId("structure-list"), { onChange: () => draw(), onSelect: (id) => select(id) });
const card = new Card(byId, (act) => {
  if (act === "close") return highlight(null);
  looks[act](looks.highlighted);
  draw();
});
const comparison = new Comparison(byId, {
  player: () => player, joint: () => joint, nameOf, setLabel, goTo, bundles: () => looks.bundles,
  bundleBand: (id, x) => {
    const own = hasEnds() && [...ends().map(({ pose }) => pose), (f) => player.motion().at({ flexion: f * degree, varus: player.varusAt(f * degree) })].map((pose) => x.map((f) => joint.bundleReading(id, pose(f))));
    return own ? bandOf(x, (n) => own.map((one) => (one[n] && own[2][n] ? 100 * (one[n].strain - own[2][n].strain) : null))) : undefined;
  },
  onChange: (other) => {
    viewer.showOther(other, comparison.isSide);
    byId("labels").style.width = comparison.isSide ? "50%" : "";
    if (other) otherLabels.show(other);
    fitCamera();
    drawCurves();
    draw();
  },
});
const arrows = ["arrow", "arrow-other"].map((id) => new Arrow(byId(id)));
const lesson = new LessonPlayer(byId, { useState, nameOf, onStep: () => { firstState = JSON.stringify(currentState()); } });
const editor = new LessonEditor(byId, {
  state: () => currentState(), useState, nameOf, highlighted: () => looks.highlighted, onChange: () => viewer.redraw(), showError,
  touchPoint: () => new Promise((done) => { touched = done; }),
  save: async (made) => {
    try {
      save(await makePage({ ...file, lesson: made }), `${made.title}.html`, "text/html");
    } catch (error) {
      showError(`Lesson: cannot be saved (${error.message})`);
    }
  },
});

const clampToRange = (x, axis) => Math.min(Math.max(x, axis[0]), axis.at(-1));

/// Goes to an attitude in degrees selected by a click or slider, clamped to the grid's range.
function goTo({ flexion, varus }) {
  byId("follow").checked = false;
  if (flexion !== undefined) player.flexion = clampToRange(flexion, player.model.flexion);
  if (varus !== undefined && player.model.varus.length > 1 && !player.motion().isVarusFree) {
    player.varus = clampToRange(varus, player.model.varus);
    player.isBalanced = false;
    drawCurves();
  }
  draw();
}

/// Fits the camera to the joint over the whole range.
function fitCamera() {
  const { model } = player, first = model.flexion[0], last = model.flexion.at(-1);
  // In the top view the cut shaft is nearest to the camera and must be framed.
  viewer.fitCamera(view, byId("whole").checked || view === "top", (include) => {
    for (let k = 0; k < framedPoses; ++k) {
      const flexion = (first + (k / (framedPoses - 1)) * (last - first)) * degree;
      const pose = player.motion().at({ flexion, varus: player.varusAt(flexion) });
      if (!pose.isSolved) continue;
      joint.place(pose, byId("held").value);
      include();
    }
    const pose = player.pose();
    if (!pose.isSolved) return include();
    joint.place(pose, byId("held").value);
    include();
  });
  isFree = false;
  pressView();
}

function pressView() {
  for (const button of byId("views").children) button.setAttribute("aria-pressed", String(!isFree && button.value === view));
}

// Structures, and the state of the view (schemas/view-state.md).

function nameOf(id) { return looks.structures.find((one) => one.id === id).name; }

function highlight(id) {
  looks.highlighted = id;
  draw();
}

function toggleStructure(id) {
  if (!looks.byId.has(id)) return;
  looks.change([id], { visible: !looks.of(id).visible });
  draw();
}

/// Cuts the joint by a plane: a name of sectionNormals, a unit vector, or undefined for none; at mm.
function cut(plane, at) {
  const normal = sectionNormals[plane] ?? plane, range = 60 * joint.scale;
  viewer.section = normal ? { plane, normal, at } : null;
  Object.assign(byId("section-at"), { hidden: !normal, min: -range, max: range, value: at });
  byId("section").value = typeof plane === "string" || !plane ? plane ?? "" : "free";
  draw();
}

const knownToState = () => ({ sets: player.sets, structures: looks.structures.map(({ id }) => id), views: Object.keys(views), fixed: [...byId("held").options].map(({ value }) => value), bodies: Object.keys(joint.bodies).map(bodyPath) });

function currentState() {
  const checked = (id) => byId(id).checked || undefined, structures = looks.data, rounded = (x) => Number(x.toFixed(3));
  const { eye_mm: eye, target_mm: target, roll } = viewer.place;
  return JSON.parse(JSON.stringify(newState({
    set: player.set, flexion: rounded(player.flexion), varus: player.isBalanced || player.motion().isVarusFree ? undefined : rounded(player.varus), fixed: byId("held").value,
    view: isFree ? { eye_mm: eye.map(rounded), target_mm: target.map(rounded), roll: rounded(roll) || undefined } : view, whole: checked("whole"), labels: checked("named"), band: checked("band"),
    section: viewer.section ? { plane: viewer.section.plane, at_mm: viewer.section.at } : undefined,
    structures: Object.keys(structures).length > 0 ? structures : undefined, highlighted: looks.highlighted ?? undefined,
  })));
}

/// Shows a checked state.
function useState(state) {
  stop();
  byId("follow").checked = false;
  for (const [id, key] of [["whole", "whole"], ["named", "labels"], ["band", "band"]]) byId(id).checked = Boolean(state[key]);
  byId("held").value = state.fixed;
  looks.data = state.structures ?? {};
  looks.highlighted = state.highlighted ?? null;
  player.flexion = state.flexion;
  player.isBalanced = state.varus === undefined;
  if (state.varus !== undefined) player.varus = state.varus;
  useSet(state.set);
  view = typeof state.view === "string" ? state.view : "oblique";
  fitCamera();
  cut(state.section?.plane, state.section?.at_mm ?? 0);
  if (typeof state.view !== "string") {
    viewer.place = state.view;
    isFree = true;
    pressView();
  }
  draw();
}

let addressTimer = null, firstState = "";
/// Half a second after the last change; the first view of the model or step needs no address.
function writeAddressSoon() {
  clearTimeout(addressTimer);
  addressTimer = setTimeout(() => {
    if (!player || lastFrame !== null || byId("follow").checked || xr.session) return;
    const state = currentState();
    writeAddress({ step: lesson.number, state: JSON.stringify(state) === firstState ? null : state });
  }, 500);
}

/// Shows the lesson inside this page and the state of the address.
function useAddress() {
  try {
    const { step, state } = readAddress();
    if (file.isInside && inside.lesson) lesson.open(checkLesson(inside.lesson, knownToState()), step);
    if (state) useState(checkState(state, knownToState(), "address"));
  } catch (error) {
    showError(error.message);
  }
}

/// A click or tap in the picture: a point for an arrow, an answer, or a structure to highlight.
function touch({ x, y, reachPx }) {
  const hit = viewer.pick(x, y, reachPx);
  if (touched && hit) {
    // Points are relative to the rotation centre, in the axes of the body; ligaments and gaps are on bodies.
    const [name, group] = Object.entries(joint.bodies).find(([, own]) => { for (let up = hit.mesh; up; up = up.parent) if (up === own) return true; return false; });
    touched({ body: bodyPath(name), point_mm: group.worldToLocal(hit.point.clone()).toArray().map((c) => Number(c.toFixed(2))) });
    touched = null;
    return;
  }
  select(hit && hit.structure !== looks.highlighted ? hit.structure : null);
}

/// A structure chosen in the picture or in the list answers an open question.
function select(id) {
  if (lesson.isAsking && id) lesson.answer(id);
  highlight(id);
}

/// Readings of a bundle over flexion in the motion shown.
function strainCurve(id) {
  const key = `${id} ${player.set} ${player.isBalanced ? "" : player.varus}`;
  if (!strainCurves.has(key)) {
    const x = sampledFlexion(player.model);
    strainCurves.set(key, { x, readings: x.map((f) => joint.bundleReading(id, player.motion().at({ flexion: f * degree, varus: player.varusAt(f * degree) }))) });
  }
  return strainCurves.get(key);
}

function drawCard(pose) {
  const one = lesson.isAsking ? undefined : looks.structures.find(({ id }) => id === looks.highlighted);
  card.show(one, one?.isBundle && readingOf(one, pose));
}

const readingOf = ({ id }, pose) => ({ now: joint.bundleReading(id, pose), flexion: pose.attitude.flexion / degree, curve: strainCurve(id), ink: inkNow() });

/// The body that is drawn where there is no pose.
const drawnAlone = () => bodyNames(player.model)[heldNow() === "moving" ? "moving" : "reference"];
const heldNow = () => (xr.session ? "reference" : byId("held").value);

/// [text, whether it is a warning].
function notesOf(pose) {
  const notes = [], range = (axis, unit) => `${formatNumber(axis[0], 1)} to ${formatNumber(axis.at(-1), 1)}${unit}`;
  const { model } = player, isBeyond = (x, axis) => x < axis[0] || x > axis.at(-1), warn = (text) => notes.push([text, true]);
  if (isBeyond(player.flexion, model.flexion)) warn(`Flexion ${formatNumber(player.flexion, 1)}° is outside the grid's range ${range(model.flexion, "°")}: drawn at ${formatNumber(pose.attitude.flexion / degree, 1)}°.`);
  if (player.motion().isVarusFree) notes.push([["two_sided", "zero_varus"].includes(player.set) ? "Varus is determined by this motion." : "Varus was free: the solved varus is shown.", false]);
  else if (!player.isBalanced && isBeyond(player.varus, model.varus)) warn(`Varus ${formatNumber(player.varus, 1)}° is outside the grid's range ${range(model.varus, "°")}: drawn at ${formatNumber(pose.attitude.varus / degree, 1)}°.`);
  if (player.shown.statement && player.set === player.shown.set) notes.push([player.shown.statement, false]);
  if (player.reason && player.set === "raw") warn(`The solved poses are shown: ${player.reason}.`);
  const doubt = doubtText(model, pose, drawnAlone());
  if (doubt) warn(`${doubt[0].toUpperCase()}${doubt.slice(1)}.`);
  return notes;
}

function rowsOf(pose) {
  const numbers = pose.isSolved ? clinicalOf(pose.referenceMoving, player.model.rotationCentre, player.model.side) : {};
  const clinical = clinicalNumbers.map(({ name, label, unit, note }) => [note ? `${label} (${note})` : label, `${formatNumber(numbers[name])} ${unit}`]);
  const gaps = player.motion().sideGapsAt(pose.attitude.flexion)?.map((gap, k) => [`${["Medial", "Lateral"][k]} gap along the push`, `${formatNumber(gap)} mm`]) ?? [];
  return [...clinical, ...surfaceRows(player.model, pose), ...gaps];
}

/// Rotation and translation that the attitude does not contain, with the names of their directions.
function wordsOf(pose) {
  if (!pose.isSolved) return "";
  const { internal, anterior } = clinicalOf(pose.referenceMoving, player.model.rotationCentre, player.model.side);
  return `, ${internal < 0 ? "external" : "internal"} rotation ${formatNumber(Math.abs(internal), 1)}°, ${anterior < 0 ? "posterior" : "anterior"} ${formatNumber(Math.abs(anterior), 1)} mm`;
}

/// "flexion 30.0°", of a hip with its directions: "abduction 5.0°".
function angleText(k, degrees) {
  const words = kindWords[player.model.joint]?.[k];
  if (!words) return `${["flexion", "varus"][k]} ${formatNumber(degrees, 1)}°`;
  return `${words[degrees < 0 ? 1 : 0]} ${formatNumber(Math.abs(degrees), 1)}°`;
}

/// As in the window: "degree_6_recontacted" is "degree 6, recontacted".
function setLabel(set) {
  if (set.startsWith("quantile_")) return `sample at ${set.slice(9)} %`;
  return set === "raw" ? "raw cells" : set.replace("_recontacted", ", recontacted").replaceAll("_", " ");
}

function writeNumbers(pose) {
  const shown = { flexion: pose.attitude.flexion / degree, varus: pose.attitude.varus / degree };
  byId("shown").textContent = `${player.model.hasTurnedAxes ? "angles about axes turned with the push: " : ""}${angleText(0, shown.flexion)}, ${angleText(1, shown.varus)}${wordsOf(pose)}; ${setLabel(player.set)}`;
  byId("note").replaceChildren(...notesOf(pose).flatMap(([text, isWarning], k) => [k > 0 ? " " : "", Object.assign(document.createElement("span"), { textContent: text, className: isWarning ? "warning" : "" })]));
  byId("doubt").textContent = byId("doubt").title = doubtText(player.model, pose, drawnAlone());
  byId("numbers").tBodies[0].replaceChildren(...rowsOf(pose).map(([label, value], k) => {
    const row = document.createElement("tr"), name = document.createElement("th"), number = document.createElement("td");
    name.textContent = label;
    number.textContent = value;
    row.classList.toggle("apart", k === clinicalNumbers.length);
    row.append(name, number);
    return row;
  }));
  const requested = { flexion: player.flexion, varus: player.varusAt(player.flexion * degree) / degree };
  for (const angle of ["flexion", "varus"]) {
    byId(angle).value = requested[angle];
    if (document.activeElement !== byId(`${angle}-number`)) byId(`${angle}-number`).value = Number(requested[angle].toFixed(2));
  }
}

/// Places the joint and its layers; in space it is drawn there.
function place(pose) {
  joint.place(pose, heldNow());
  joint.applyLooks((id) => looks.of(id), viewer.section !== null);
  const layers = { hasGaps: looks.of(gapStructure).visible, hasBand: byId("band").checked };
  if (pose.isSolved) joint.showLayers(pose, player.motion(), layers);
  if (!xr.session) comparison.place(heldNow(), (id) => (looks.byId.has(id) ? looks.of(id) : null), viewer.section !== null, layers);
}

function draw() {
  const pose = player.pose();
  if (xr.session) return place(pose);
  const flexion = pose.attitude.flexion / degree, varus = pose.attitude.varus / degree;
  const columns = columnsAlong(player.model, (f) => player.varusAt(f * degree) / degree);
  const hasPaths = Boolean(player.model.contactPaths) && looks.of(pathsStructure).visible;
  if (hasPaths) joint.showPaths(columns, flexion);
  place(pose);
  list.update(looks);
  byId("ligaments").checked = looks.bundles.some((id) => looks.of(id).visible);
  byId("labels").hidden = !byId("named").checked;
  byId("labels-other").hidden = byId("labels").hidden || !comparison.isSide;
  byId("strain-scale").hidden = !byId("ligaments").checked;
  byId("gap-scale").hidden = !looks.of(gapStructure).visible;
  byId("paths-legend").hidden = !hasPaths;
  drawCard(pose);
  viewer.redraw();
  writeNumbers(pose);
  byId("balanced").checked = player.isBalanced;
  maps.draw(flexion, varus);
  for (const [plot, of] of quantityPlots()) plot.setMark(flexion, pose.isSolved ? of.of(pose) : NaN);
  for (const name of ["contact", "strain", "tension"]) otherCurves[name].plot.setMark(flexion);
  plateau.draw(columns, flexion);
  writeAddressSoon();
}

/// The plots of one quantity: [plot, quantity]; the chosen one has its own unless it is among the others.
function quantityPlots() {
  const named = (name) => quantities.find((one) => one.name === name);
  const shown = [[curve, named("clinical_internal")], ...["clinical_varus", "clinical_anterior"].map((name) => [otherCurves[name].plot, named(name)])];
  return shown.some(([, one]) => one === quantity()) ? shown : [...shown, [quantityCurve, quantity()]];
}

const quantity = () => quantities.find(({ name }) => name === byId("quantity").value) ?? quantities[0];

/// Doubtful flexions in amber and those without a pose in red, under the slider.
function markSlider(spans) {
  const [low, high] = [player.model.flexion[0], player.model.flexion.at(-1)], share = (x) => `${(100 * (x - low)) / (high - low)}%`;
  const stops = spans.flatMap(({ first, last, hasPose }) => ["transparent", hasPose ? "#ffb02e" : "#eb5a3c"].flatMap((colour, k) => (k === 0 ? [`${colour} ${share(first)}`] : [`${colour} ${share(first)}`, `${colour} ${share(last)}`, `transparent ${share(last)}`])));
  byId("flexion-marks").style.background = spans.length > 0 ? `linear-gradient(to right, ${stops.join(", ")})` : "none";
}

function drawCurves() {
  const spans = doubtfulSpans(player.model, (f) => player.motion().at({ flexion: f * degree, varus: player.varusAt(f * degree) }));
  markSlider(spans);
  const { model } = player, x = sampledFlexion(model), plots = quantityPlots(), varusOf = (f) => player.varusAt(f), [rawInk, ownInk] = inkNow().lines;
  const hasBonesAlone = player.sets.includes("bones_alone") && player.set !== "bones_alone";
  byId("quantity-figure").hidden = plots.length < 4;
  for (const [plot, of] of plots) {
    plot.setCurves(model, () => {
      const raw = { name: "raw", y: valuesOf(player.raw, x, varusOf, of), colour: rawInk, dash: player.set === "raw" ? undefined : [5, 3] };
      const own = { name: setLabel(player.set), y: valuesOf(player.motion(), x, varusOf, of), colour: ownInk };
      const alone = hasBonesAlone ? [{ name: setLabel("bones_alone"), y: valuesOf(player.motion("bones_alone"), x, varusOf, of), colour: bandEnds.bones_alone, width: 1 }] : [];
      return { title: of.label, unit: of.unit, lines: [...(player.set === "raw" ? [raw] : [own, raw]), ...alone], band: model.bands?.[of.name.replace("clinical_", "")], spans };
    }, plot === curve);
  }
  otherCurves.contact.figure.hidden = !model.contactPaths;
  if (model.contactPaths) {
    const columns = columnsAlong(model, (f) => player.varusAt(f * degree) / degree), centre = model.rotationCentre[0];
    otherCurves.contact.plot.setCurves(model, () => ({ title: "forwards", unit: "mm", spans, lines: ["medial", "lateral"].map((side, k) => {
      const path = pathAlong(model, `${side}_moving`, columns), few = path.filter((_, n) => n % Math.ceil(path.length / mostContacts) === 0 || n + 1 === path.length);
      const at = ({ flexion, point }) => ends().map(({ pose, motion }) => joint.contactAbout(point, pose(flexion), motion)).map((p) => (p ? p[0] - centre : null));
      return { name: side, x: path.map(({ flexion }) => flexion), y: path.map(({ point }) => point[0] - centre), colour: inkNow().lines[1 - k],
        band: hasEnds() ? bandOf(few.map(({ flexion }) => flexion), (n) => [...at(few[n]), few[n].point[0] - centre]) : undefined };
    }) }));
  }
  for (const [name, title, unit, of] of [["strain", "largest strain", "%", ({ strain }) => (strain === -1 ? null : 100 * strain)], ["tension", "force", "N", ({ tension }) => tension]]) {
    otherCurves[name].figure.hidden = looks.bundles.length === 0;
    otherCurves[name].plot.setCurves(model, () => ({ title, unit, spans, lines: looks.bundles.map((id, k) => {
      const { x, readings } = strainCurve(id), y = readings.map((one) => (one ? of(one) : null)), all = hasEnds() ? ends().map(({ pose }) => x.map((f) => joint.bundleReading(id, pose(f)))) : [];
      return { name: nameOf(id), y, ...lineStyle(k), band: hasEnds() ? bandOf(x, (n) => [y[n], ...all.map((one) => (one[n] ? of(one[n]) : null))]) : undefined };
    }) }));
  }
  comparison.drawCurves(spans);
}

/// The motions of the samples at 5 % and 95 % of internal rotation.
const hasEnds = () => player.sets.includes("quantile_5") && !player.set.startsWith("quantile_");
const ends = () => ["quantile_5", "quantile_95"].map((set) => player.motion(set)).map((motion) => ({ motion, pose: (flexion) => motion.at({ flexion: flexion * degree, varus: 0 }) }));

function drawPlots() {
  maps.setModel(player.model, player.raw, player.motion(), player.set, quantity());
  drawCurves();
  draw();
}

function useSet(set) {
  player.set = byId("set").value = set;
  const isOwn = player.motion().isVarusFree || player.model.varus.length === 1;
  for (const id of ["varus", "varus-number", "balanced"]) byId(id).disabled = isOwn;
  byId("balanced").disabled ||= player.raw.spine.length === 0;
  drawPlots();
}

function options(select, names, labels = names) {
  select.replaceChildren(...names.map((name, k) => Object.assign(document.createElement("option"), { value: name, textContent: labels[k] })));
}

function setRange(angle, low, high) {
  Object.assign(byId(angle), { min: low, max: high });
}

function show(model, opened) {
  stop();
  xr.leave();
  lesson.close();
  const made = new Joint(model), { name } = opened, isFirst = player === null;
  player = new Player(model);
  [joint, file, looks] = [made, opened, new Looks(structuresOf(model))];
  strainCurves = new Map();
  list.show(looks);
  byId("title").textContent = model.title || name;
  byId("band-choice").hidden = joint.ghosts.length === 0;
  if (byId("band-choice").hidden) byId("band").checked = false;
  document.title = `${model.title || name} – VRDA player`;
  const solved = model.status.reduce((count, status) => count + (status === stable), 0);
  byId("facts").textContent = `${name}: ${model.side} ${model.joint}, ${model.method}, ${solved} of ${model.status.length} attitudes solved`;
  ["flexion", "varus"].forEach((angle, k) => {
    const word = kindWords[model.joint]?.[k][0] ?? angle;
    byId(`${angle}-word`).textContent = word[0].toUpperCase() + word.slice(1);
  });
  const warnings = modelWarnings(model), hasDoubtfulPoses = warnings.length > model.warnings.length;
  byId("warnings").hidden = warnings.length === 0;
  byId("warnings").replaceChildren(...warnings.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  byId("doubt").hidden = !hasDoubtfulPoses;
  byId("picture").classList.toggle("marked-poses", hasDoubtfulPoses);
  byId("welcome").hidden = byId("message").hidden = true;
  byId("player").hidden = false;
  setRange("flexion", model.flexion[0], model.flexion.at(-1));
  const own = [player.raw.firstVarus / degree, player.raw.lastVarus / degree];
  setRange("varus", Math.min(own[0], model.varus[0]), Math.max(own[1], model.varus.at(-1)));
  options(byId("set"), player.sets, player.sets.map(setLabel));
  const names = bodyNames(model);
  options(byId("held"), ["moving", "reference", "push"], [names.moving, names.reference, "direction of push"]);
  labels.show(joint);
  quantities = quantitiesOf(model, player.raw.isVarusFree);
  options(byId("quantity"), quantities.map((q) => q.name), quantities.map((q) => `${q.label}, ${q.unit}`));
  byId("plateau-figure").hidden = !model.contactPaths;
  plateau.setModel(model);
  byId("ligaments-choice").hidden = joint.ligaments.length === 0;
  viewer.show(joint);
  comparison.reset();
  cut(undefined, 0);
  useSet(player.sets.includes(live?.stream.bench?.set) ? live.stream.bench.set : player.set);
  fitCamera();
  draw();
  firstState = JSON.stringify(currentState());
  if (file.isInside && inside.lesson) editor.open(inside.lesson);
  if (isFirst) useAddress();
}

/// Uses the model of a file, or shows an error message; the previous one then stays.
const loadFor = (use) => async (bytes, name, isLatest, isInside = false) => {
  document.documentElement.dataset.state = "loading";
  showProgress(`Reading ${name}`);
  try {
    await new Promise((drawn) => setTimeout(drawn, 30));  // the page shows it before reading blocks it
    const model = await readMotionModel(bytes);
    if (isLatest()) use(model, { bytes, name, isInside });
  } catch (error) {
    if (isLatest()) showError(`${name}: ${error.message}`);
  }
  if (!isLatest()) return;
  byId("loading").hidden = true;
  document.documentElement.dataset.state = "ready";
};
const load = loadFor(show), loadOther = loadFor((model, { name }) => comparison.open(model, name));

/// What is loading, and its share from 0 to 1 if that is known.
function showProgress(text, share) {
  byId("loading").hidden = false;
  byId("loading-text").textContent = text;
  if (share === undefined) byId("loading-share").removeAttribute("value");
  else byId("loading-share").value = share;
}

function showError(message) {
  byId("loading").hidden = true;
  byId("message").textContent = message;
  byId("message").hidden = false;
}

function stop() {
  lastFrame = null;
  byId("play").setAttribute("aria-pressed", "false");
  byId("play").textContent = "Play";
}

function advance(now) {
  if (lastFrame !== null) player.advance(Math.max(0, now - lastFrame) / 1000, Number(byId("speed").value));
  if (lastFrame !== null) lastFrame = now;
}

/// Frames of the window; in space the session's frames advance the motion.
function frame(now) {
  if (lastFrame === null || xr.session) return;
  advance(now);
  draw();
  requestAnimationFrame(frame);
}

function togglePlay() {
  if (lastFrame !== null) return stop();
  lastFrame = performance.now();
  byId("follow").checked = false;
  byId("play").setAttribute("aria-pressed", "true");
  byId("play").textContent = "Pause";
  requestAnimationFrame(frame);
}

function useView(name) {
  view = name;
  fitCamera();
  draw();
}

function watchControls() {
  const number = (id) => (byId(id).value === "" ? undefined : Number(byId(id).value));
  byId("flexion").addEventListener("input", () => goTo({ flexion: number("flexion") }));
  byId("varus").addEventListener("input", () => goTo({ varus: number("varus") }));
  // Typed numbers may be outside the range: a note then reports the clamped value.
  byId("flexion-number").addEventListener("input", () => { player.flexion = number("flexion-number") ?? player.flexion; draw(); });
  byId("varus-number").addEventListener("input", () => {
    [player.varus, player.isBalanced] = [number("varus-number") ?? player.varus, false];
    drawCurves();
    draw();
  });
  byId("balanced").addEventListener("change", () => {
    player.varus = player.varusAt(player.flexion * degree) / degree;
    player.isBalanced = byId("balanced").checked;
    drawCurves();
    draw();
  });
  byId("set").addEventListener("change", () => useSet(byId("set").value));
  byId("quantity").addEventListener("change", drawPlots);
  byId("play").addEventListener("click", togglePlay);
  for (const id of ["named", "band"]) byId(id).addEventListener("change", draw);
  byId("ligaments").addEventListener("change", () => {
    looks.change(looks.bundles, { visible: byId("ligaments").checked });
    draw();
  });
  byId("section").addEventListener("change", () => {
    const { value } = byId("section"), { eye_mm: eye, target_mm: target } = viewer.place;
    // "As seen now": across the line of sight, through what the camera turns about.
    const sight = normalised(difference(eye, target)).map((x) => Number(x.toFixed(3)));
    if (value === "free") cut(sight, Number(dot(sight, target).toFixed(1)));
    else cut(value || undefined, 0);
  });
  byId("section-at").addEventListener("input", () => cut(viewer.section.plane, number("section-at")));
  byId("show-all").addEventListener("click", () => {
    looks.showAll();
    draw();
  });
  byId("strain-highest").textContent = `${100 * highestStrain} %`;
  for (const [id, palette] of [["strain-scale", strainPalette], ["gap-scale", gapPalette]]) byId(id).querySelector("i").style.background = gradientOf(palette);
  for (const id of ["whole", "held"]) byId(id).addEventListener("change", () => useView(view));
  byId("views").append(...Object.keys(views).map((name) => {
    const button = Object.assign(document.createElement("button"), { type: "button", value: name, textContent: name });
    button.addEventListener("click", () => useView(name));
    return button;
  }));
}

function fitPlateau() {
  const canvas = byId("plateau"), px = Math.min(window.devicePixelRatio, 2);
  [canvas.width, canvas.height] = [Math.max(1, Math.round(canvas.clientWidth * px)), Math.max(1, Math.round(canvas.clientHeight * px))];
  if (player) draw();
}

/// Fills the window; with the browser's full screen where it has one.
function toggleFull(isFull = !byId("picture").classList.contains("full")) {
  const wasFull = byId("picture").classList.contains("full");
  byId("picture").classList.toggle("full", isFull);
  byId("full").setAttribute("aria-pressed", String(isFull));
  if (isFull) document.documentElement.requestFullscreen?.().catch(() => {});
  else if (document.fullscreenElement) document.exitFullscreen();
  // Fitted again when the picture has its new shape.
  if (wasFull !== isFull && player) requestAnimationFrame(() => requestAnimationFrame(() => useView(view)));
}

const stepVarus = (by) => goTo({ varus: player.varusAt(player.flexion * degree) / degree + by });
const stepSet = (by) => useSet(player.sets.at((player.sets.indexOf(player.set) + by) % player.sets.length));
const stepFlexion = (by) => goTo({ flexion: player.flexion + by });
function stepSpeed(by) {
  byId("speed").selectedIndex = Math.min(Math.max(byId("speed").selectedIndex + by, 0), byId("speed").length - 1);
}
function nextHeld() {
  byId("held").selectedIndex = (byId("held").selectedIndex + 1) % byId("held").length;
  useView(view);
}

const actions = {
  play_pause: togglePlay,
  step_forward: () => stepFlexion(1), step_back: () => stepFlexion(-1), leap_forward: () => stepFlexion(10), leap_back: () => stepFlexion(-10),
  go_to_first: () => goTo({ flexion: -Infinity }), go_to_last: () => goTo({ flexion: Infinity }),
  varus_up: () => stepVarus(1), varus_down: () => stepVarus(-1), varus_balanced: () => byId("balanced").click(),
  faster: () => stepSpeed(1), slower: () => stepSpeed(-1),
  next_set: () => stepSet(1), previous_set: () => stepSet(-1), next_fixed_object: nextHeld,
  show_gap_map: () => toggleStructure(gapStructure), show_ligaments: () => byId("ligaments").click(),
  show_contact_paths: () => toggleStructure(pathsStructure), show_labels: () => byId("named").click(), show_band: () => byId("band").click(),
  ...Object.fromEntries(Object.keys(views).map((name) => [`view_${name}`, () => useView(name)])),
  reset_view: () => useView(view), full_screen: () => toggleFull(),
  show_help: () => { byId("help").open = !byId("help").open; },
  leave: () => {
    if (byId("help").open) byId("help").open = false;
    else if (looks.highlighted) highlight(null);
    else toggleFull(false);
  },
};

const live = connectLive(byId, { player: () => player, joint: () => joint, useSet, drawCurves, show: draw, isInSpace: () => xr.session !== null });
const xr = connectXr(byId, viewer, {
  title: () => byId("title").textContent,
  joint: () => joint, model: () => player.model, flexion: () => player.flexion, range: () => [player.model.flexion[0], player.model.flexion.at(-1)],
  delta: () => player.motion().delta(player.pose().attitude.flexion),
  setFlexion: (flexion) => { stop(); goTo({ flexion }); },
  isPlaying: () => lastFrame !== null, togglePlay, looks: () => looks, labels: () => byId("named"), redraw: draw,
  readingOf: (one) => (one.isBundle ? readingText(readingOf(one, player.pose())) : ""),
  live: () => live?.stream, isFollowing: () => live !== null && byId("follow").checked, setFollowing: (on) => { stop(); byId("follow").checked = on; },
  advance: (now) => {
    if (live?.apply() || lastFrame !== null) { advance(now); draw(); }
  },
  marks: () => [...(live?.stream.marks() ?? []), ...[doubtText(player.model, player.pose(), drawnAlone())].filter(Boolean)],
  landmarks: () => landmarksOf(player.model, joint.scale, live?.stream.bench?.points),
  onStart: () => { joint.group.matrix.identity(); document.documentElement.dataset.space = "on"; draw(); },
  onEnd: () => { delete document.documentElement.dataset.space; stop(); draw(); },
}, showError);

watchControls();
byId("structures").open = !matchMedia("(max-width: 60rem)").matches;
byId("usdz").addEventListener("click", async () => {
  try {
    if (!player.pose().isSolved) throw new Error(doubtText(player.model, player.pose(), drawnAlone()));
    save(await usdzOf(joint, byId("ligaments").checked), `${byId("title").textContent}.usdz`, "model/vnd.usdz+zip");
  } catch (error) {
    showError(`USDZ: cannot be made (${error.message})`);
  }
});
watchKeys(actions, () => player !== null, () => byId("picture").matches(":hover") || document.activeElement === byId("joint"));
byId("help-lines").append(...helpLines.flatMap((texts) => texts.slice(0, 2).map((text, k) => Object.assign(document.createElement(k === 0 ? "dt" : "dd"), { textContent: text }))));
byId("full").addEventListener("click", () => toggleFull());
addEventListener("fullscreenchange", () => { if (!document.fullscreenElement) toggleFull(false); });
/// The labels of each joint with a picture of its own, and what is seen of it.
const namedJoints = () => (viewer.renderer ? [labels, otherLabels] : []).map((one) => [one, (numberOf, step) => viewer.seenIds(numberOf, step, one.joint), (p) => viewer.isCut(p)]);
viewer.onDrawn = (camera) => {
  for (const [one, ...what] of namedJoints()) one.place(camera, ...what);
  const own = byId("teach").open ? editor.arrow : lesson.step?.arrow, drawn = comparison.isSide ? [joint, comparison.joint] : [joint];
  const bodyOf = ({ bodies }) => Object.entries(bodies).find(([name]) => bodyPath(name) === own.body)?.[1];
  arrows.forEach((arrow, k) => arrow.place(k < drawn.length ? own : undefined, k < drawn.length && own && bodyOf(drawn[k]), camera, k, drawn.length));
};
viewer.onStill = (camera) => { for (const [one, ...what] of namedJoints()) one.settle(camera, ...what); };
viewer.onTouch = touch;
viewer.onTurned = () => {
  isFree = true;
  pressView();
  writeAddressSoon();
};
byId("teach").addEventListener("toggle", () => viewer.redraw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (player) drawPlots(); });
addEventListener("hashchange", () => { if (player) useAddress(); });
byId("no-webgl").hidden = viewer.renderer !== null;
viewer.onLost = (isLost) => { byId("context-lost").hidden = !isLost; };
new ResizeObserver(fitPlateau).observe(byId("plateau"));
window.vrda = {
  pose: (set, flexion, varus) => player.poseOf(set, flexion, varus),
  shown: () => ({ ...player.poseOf(player.set, player.flexion, player.varusAt(player.flexion * degree) / degree), set: player.set, flexion: player.flexion }),
  sets: () => player.sets,
  /// For tests: where the bodies are drawn, and the marked spans of the slider and the curves.
  drawn: () => Object.fromEntries(Object.entries(joint.bodies).map(([name, { matrix, visible }]) => [name, { matrix: [...matrix.elements], visible }])),
  spans: () => curve.spans,
  /// For tests: abscissae and values of the curves, bands, and differences from a second model.
  differences: (name) => comparison.lines(name),
  band: (name) => otherCurves[name].plot.band?.[0] ?? null,
  curve: () => ({ x: curve.lines[0].x, curves: curve.lines.map(({ y }) => y), lines: curve.lines.map(({ name, width }) => [name, width]), band: curve.band[0] && { low: curve.band[0].low, high: curve.band[0].high } }),
  /// For tests: the state of the view, and where a structure is in the picture.
  state: () => currentState(),
  useState: (state) => useState(checkState(state, knownToState())),
  structures: () => looks.structures.map(({ id, name }) => ({ id, name, ...looks.of(id) })),
  pick: (x, y) => viewer.pick(x, y, 0)?.structure ?? null,
  /// For tests: depth of the nearest surface in the middle of the picture, mm.
  seen: () => viewer.seen(),
  /// For tests: whether all changes are drawn, sharp.
  isStill: () => viewer.isStill,
  /// For tests: strains at a pose { R, t } of the moving body in the reference, and the present gaps.
  strains: (X) => joint.ligaments[0].layer.strains(X),
  live: () => live && { pose: live.stream.pose, bench: live.stream.bench, marks: live.stream.marks() },
  xr: { state: () => xr.state(), point: (target) => xr.panelPoint(target), landmarks: () => landmarksOf(player.model, joint.scale, live?.stream.bench?.points) },
  usdz: async () => Array.from(await usdzOf(joint, byId("ligaments").checked)),
  gaps: () => joint.gaps.sheets.flatMap(({ points, gaps }) => points.map((point, k) => [...point, Number.isFinite(gaps[k]) ? gaps[k] : null])),
};
document.documentElement.dataset.state = "ready";
watchFiles({ input: byId("file"), other: byId("other"), overlay: byId("drop"), load, loadOther, showError, showProgress });
const openInside = async () => load(await inside.bytes(), inside.name, () => true, true);
byId("sample").hidden = !inside || Boolean(inside.lesson);
byId("sample").addEventListener("click", openInside);
if (inside?.lesson) openInside();
