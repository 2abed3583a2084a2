// The page: ties its controls, pictures and plots to a Player.
import { clinicalNumbers, clinicalOf } from "./clinical.js";
import { columnsAlong, PlateauPlot } from "./contact_paths.js";
import { CurvePlot } from "./curves.js";
import { degree } from "./frames.js";
import { Joint } from "./joint.js";
import { Maps } from "./maps.js";
import { readMotionModel } from "./model_file.js";
import { Player } from "./player.js";
import { quantitiesOf, written } from "./quantities.js";
import { watchFiles } from "./files.js";
import { watchKeys } from "./keys.js";
import { closeness, gradientOf, tension } from "./scale_of_layer.js";
import { Viewer, views } from "./viewer.js";

const the = (id) => document.getElementById(id);
const framedPoses = 5;  // over flexion, that the camera must have room for

let player = null, joint = null, view = "oblique", quantities = [], lastFrame = null;
const viewer = new Viewer(the("joint"));
const plateau = new PlateauPlot(the("plateau"));
const maps = new Maps(the("maps"), (flexion, varus) => ask({ flexion, varus }));
const curve = new CurvePlot(the("curve"), (flexion) => ask({ flexion }));

const clampToRange = (x, axis) => Math.min(Math.max(x, axis[0]), axis.at(-1));

/// Goes to an attitude in degrees, as a click or a slider asks for it.
function ask({ flexion, varus }) {
  if (flexion !== undefined) player.flexion = clampToRange(flexion, player.model.flexion);
  if (varus !== undefined && player.model.varus.length > 1 && !player.motion().isVarusFree) {
    player.varus = clampToRange(varus, player.model.varus);
    player.isBalanced = false;
    drawCurves();
  }
  draw();
}

/// The camera, with room for the joint over the whole range.
function look() {
  const { model } = player, first = model.flexion[0], last = model.flexion.at(-1);
  // From above the cut shaft is what comes nearest: the picture must have room for it.
  viewer.look(view, the("whole").checked || view === "top", (include) => {
    for (let k = 0; k < framedPoses; ++k) {
      const flexion = (first + (k / (framedPoses - 1)) * (last - first)) * degree;
      const pose = player.motion().at({ flexion, varus: player.varusAt(flexion) });
      if (!pose.isSolved) continue;
      joint.place(pose, the("held").value);
      include();
    }
    const pose = player.pose();
    if (!pose.isSolved) return include();
    joint.place(pose, the("held").value);
    include();
  });
  for (const button of the("views").children) button.setAttribute("aria-pressed", String(button.value === view));
}

function noteOf(pose) {
  const notes = [], range = (axis, unit) => `${written(axis[0], 1)} to ${written(axis.at(-1), 1)}${unit}`;
  const { model } = player, isBeyond = (x, axis) => x < axis[0] || x > axis.at(-1);
  if (isBeyond(player.flexion, model.flexion)) notes.push(`Flexion ${written(player.flexion, 1)}° lies outside the measured ${range(model.flexion, "°")}: drawn at ${written(pose.attitude.flexion / degree, 1)}°.`);
  if (player.motion().isVarusFree) notes.push(player.set === "zero_varus" ? "This motion has a varus of its own." : "Varus was free: it is drawn as it was found.");
  else if (!player.isBalanced && isBeyond(player.varus, model.varus)) notes.push(`Varus ${written(player.varus, 1)}° lies outside the measured ${range(model.varus, "°")}: drawn at ${written(pose.attitude.varus / degree, 1)}°.`);
  if (!pose.isSolved) notes.push("No pose here: an attitude around it is not solved. The joint stays where it was.");
  return notes.join(" ");
}

function rowsOf(pose) {
  const numbers = pose.isSolved ? clinicalOf(pose.referenceMoving, player.model.rotationCentre, player.model.side) : {};
  const clinical = clinicalNumbers.map(({ name, label, unit, note }) => [note ? `${label} (${note})` : label, `${written(numbers[name])} ${unit}`]);
  const [x, y, z] = pose.translation ?? [NaN, NaN, NaN];
  return [...clinical, ["x, world", `${written(x)} mm`], ["y, world", `${written(y)} mm`], ["z, world", `${written(z)} mm`], ["theta about Delta", `${written(pose.theta / degree)} °`]];
}

function writeNumbers(pose) {
  const shown = { flexion: pose.attitude.flexion / degree, varus: pose.attitude.varus / degree };
  the("shown").textContent = `flexion ${written(shown.flexion, 1)}°   varus ${written(shown.varus, 1)}°   ${player.set}`;
  the("note").textContent = noteOf(pose);
  the("numbers").tBodies[0].replaceChildren(...rowsOf(pose).map(([label, value], k) => {
    const row = document.createElement("tr"), name = document.createElement("th"), number = document.createElement("td");
    name.textContent = label;
    number.textContent = value;
    row.classList.toggle("apart", k === clinicalNumbers.length);
    row.append(name, number);
    return row;
  }));
  const asked = { flexion: player.flexion, varus: player.varusAt(player.flexion * degree) / degree };
  for (const angle of ["flexion", "varus"]) {
    the(angle).value = asked[angle];
    if (document.activeElement !== the(`${angle}-number`)) the(`${angle}-number`).value = Number(asked[angle].toFixed(2));
  }
}

function draw() {
  const pose = player.pose();
  const flexion = pose.attitude.flexion / degree, varus = pose.attitude.varus / degree;
  const columns = columnsAlong(player.model, (f) => player.varusAt(f * degree) / degree);
  if (pose.isSolved) joint.place(pose, the("held").value);
  if (pose.isSolved) joint.showLayers(pose, player.motion(), { hasLigaments: the("ligaments").checked, hasGaps: the("gaps").checked });
  the("strain-scale").hidden = !(joint.ligaments && the("ligaments").checked);
  the("gap-scale").hidden = !the("gaps").checked;
  joint.paths.visible = the("paths").checked;
  joint.showPaths(columns, flexion);
  viewer.redraw();
  writeNumbers(pose);
  the("balanced").checked = player.isBalanced;
  maps.draw(flexion, varus);
  curve.setMark(flexion, pose.isSolved ? quantity().of(pose) : NaN);
  plateau.draw(columns, flexion);
}

const quantity = () => quantities.find(({ name }) => name === the("quantity").value) ?? quantities[0];

function drawCurves() {
  const raw = { label: "raw", motion: player.raw, colour: "#c2500a", dash: player.set === "raw" ? undefined : [5, 3] };
  const own = { label: player.set, motion: player.motion(), colour: "#0b6aa8" };
  curve.setCurves(player.model, player.set === "raw" ? [raw] : [own, raw], (flexion) => player.varusAt(flexion), quantity());
}

function drawPlots() {
  maps.setModel(player.model, player.raw, player.motion(), player.set, quantity());
  drawCurves();
  draw();
}

function useSet(set) {
  player.set = the("set").value = set;
  const isOwn = player.motion().isVarusFree || player.model.varus.length === 1;
  for (const id of ["varus", "varus-number", "balanced"]) the(id).disabled = isOwn;
  the("balanced").disabled ||= player.raw.spine.length === 0;
  drawPlots();
}

function options(select, names, labels = names) {
  select.replaceChildren(...names.map((name, k) => Object.assign(document.createElement("option"), { value: name, textContent: labels[k] })));
}

function setRange(angle, low, high) {
  Object.assign(the(angle), { min: low, max: high });
}

function show(model, name) {
  stop();
  const made = new Joint(model);
  player = new Player(model);
  joint = made;
  the("title").textContent = model.title || name;
  document.title = `${model.title || name} – VRDA player`;
  const solved = model.status.reduce((count, status) => count + (status === 0), 0);
  the("facts").textContent = `${name}: ${model.side} ${model.joint}, ${model.method}, ${solved} of ${model.status.length} attitudes solved`;
  the("welcome").hidden = the("message").hidden = true;
  the("player").hidden = false;
  setRange("flexion", model.flexion[0], model.flexion.at(-1));
  const own = [player.raw.firstVarus / degree, player.raw.lastVarus / degree];
  setRange("varus", Math.min(own[0], model.varus[0]), Math.max(own[1], model.varus.at(-1)));
  options(the("set"), player.sets);
  quantities = quantitiesOf(model, player.raw.isVarusFree);
  options(the("quantity"), quantities.map((q) => q.name), quantities.map((q) => `${q.label}, ${q.unit}`));
  the("plateau-figure").hidden = !model.contactPaths;
  plateau.setModel(model);
  the("ligaments-choice").hidden = !joint.ligaments;
  if (joint.ligaments) the("strain-highest").textContent = `${Math.round(100 * joint.ligaments.highest)} %`;
  viewer.show(joint);
  useSet(player.sets[0]);
  look();
  draw();
}

/// Shows the file's bytes, or says what is wrong with them; what was shown before stays.
async function load(bytes, name, isLatest) {
  document.documentElement.dataset.state = "loading";
  try {
    const model = await readMotionModel(bytes);
    if (isLatest()) show(model, name);
  } catch (error) {
    if (isLatest()) complain(`${name}: ${error.message}`);
  }
  if (isLatest()) document.documentElement.dataset.state = "ready";
}

function complain(message) {
  the("message").textContent = message;
  the("message").hidden = false;
}

function stop() {
  lastFrame = null;
  the("play").setAttribute("aria-pressed", "false");
  the("play").textContent = "Play";
}

function frame(now) {
  if (lastFrame === null) return;
  player.advance((now - lastFrame) / 1000, Number(the("speed").value));
  lastFrame = now;
  draw();
  requestAnimationFrame(frame);
}

function togglePlay() {
  if (lastFrame !== null) return stop();
  lastFrame = performance.now();
  the("play").setAttribute("aria-pressed", "true");
  the("play").textContent = "Pause";
  requestAnimationFrame(frame);
}

function useView(name) {
  view = name;
  look();
  draw();
}

function watchControls() {
  const number = (id) => (the(id).value === "" ? undefined : Number(the(id).value));
  the("flexion").addEventListener("input", () => ask({ flexion: number("flexion") }));
  the("varus").addEventListener("input", () => ask({ varus: number("varus") }));
  // Typed numbers may lie outside: then the page says where it draws instead.
  the("flexion-number").addEventListener("input", () => { player.flexion = number("flexion-number") ?? player.flexion; draw(); });
  the("varus-number").addEventListener("input", () => {
    [player.varus, player.isBalanced] = [number("varus-number") ?? player.varus, false];
    drawCurves();
    draw();
  });
  the("balanced").addEventListener("change", () => {
    player.varus = player.varusAt(player.flexion * degree) / degree;
    player.isBalanced = the("balanced").checked;
    drawCurves();
    draw();
  });
  the("set").addEventListener("change", () => useSet(the("set").value));
  the("quantity").addEventListener("change", drawPlots);
  the("play").addEventListener("click", togglePlay);
  for (const id of ["paths", "ligaments", "gaps"]) the(id).addEventListener("change", draw);
  for (const [id, palette] of [["strain-scale", tension], ["gap-scale", closeness]]) the(id).querySelector("i").style.background = gradientOf(palette);
  for (const id of ["whole", "held"]) the(id).addEventListener("change", () => useView(view));
  the("views").append(...Object.keys(views).map((name) => {
    const button = Object.assign(document.createElement("button"), { type: "button", value: name, textContent: name });
    button.addEventListener("click", () => useView(name));
    return button;
  }));
}

function fitPlateau() {
  const canvas = the("plateau"), px = Math.min(window.devicePixelRatio, 2);
  [canvas.width, canvas.height] = [Math.max(1, Math.round(canvas.clientWidth * px)), Math.max(1, Math.round(canvas.clientHeight * px))];
  if (player) draw();
}

watchControls();
watchKeys({
  isReady: () => player !== null,
  play: togglePlay,
  view: (k) => useView(Object.keys(views)[k]),
  step: (flexion, varus) => ask(varus ? { varus: player.varusAt(player.flexion * degree) / degree + varus } : { flexion: player.flexion + flexion }),
  set: (by) => useSet(player.sets.at((player.sets.indexOf(player.set) + by) % player.sets.length)),
});
new ResizeObserver(fitPlateau).observe(the("plateau"));
window.vrda = {
  pose: (set, flexion, varus) => player.poseOf(set, flexion, varus),
  shown: () => ({ ...player.poseOf(player.set, player.flexion, player.varusAt(player.flexion * degree) / degree), set: player.set, flexion: player.flexion }),
  sets: () => player.sets,
  /// As the layers draw them at a pose { R, t } of the moving body in the reference.
  strains: (X) => joint.ligaments.strains(X),
  gaps: () => joint.gaps.sheets.flatMap(({ points, gaps }) => points.map((point, k) => [...point, Number.isFinite(gaps[k]) ? gaps[k] : null])),
};
document.documentElement.dataset.state = "ready";
watchFiles({ input: the("file"), overlay: the("drop"), load, complain });
