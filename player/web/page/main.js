// The page: connects its controls, 3-D view and plots to a Player.
import { helpLines, watchFiles, watchKeys } from "./controls.js";
import { degree } from "./geometry.js";
import { Joint } from "./joint.js";
import { bodyNames, gapPalette, gradientOf, Labels, strainPalette } from "./layers.js";
import { connectLive } from "./live.js";
import { readMotionModel } from "./model_file.js";
import { Player, stable } from "./motion.js";
import { landmarksOf } from "./placement.js";
import { columnsAlong, CurvePlot, Maps, PlateauPlot } from "./plots.js";
import { clinicalNumbers, clinicalOf, doubtfulSpans, doubtText, formatNumber, modelWarnings, quantitiesOf } from "./readings.js";
import { save, usdzOf, Viewer, views } from "./viewer.js";
import { connectXr } from "./xr.js";

// Directions, positive and negative, of flexion and varus of the kinds whose words differ (schemas/clinical.md).
const foot = [["plantarflexion", "dorsiflexion"], ["inversion", "eversion"]];
const kindWords = { hip: [["extension", "flexion"], ["adduction", "abduction"]], ankle: foot, subtalar: foot };

const byId = (id) => document.getElementById(id);
const framedPoses = 5;  // over flexion, to which the camera is fitted

let player = null, joint = null, view = "oblique", quantities = [], lastFrame = null;
const viewer = new Viewer(byId("joint"));
const labels = new Labels(byId("labels"));
const plateau = new PlateauPlot(byId("plateau"));
const maps = new Maps(byId("maps"), (flexion, varus) => goTo({ flexion, varus }));
const curve = new CurvePlot(byId("curve"), (flexion) => goTo({ flexion }));

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
  for (const button of byId("views").children) button.setAttribute("aria-pressed", String(button.value === view));
}

/// The body that is drawn where there is no pose.
const drawnAlone = () => bodyNames(player.model)[heldNow() === "moving" ? "moving" : "reference"];
const heldNow = () => (xr.session ? "reference" : byId("held").value);

function noteOf(pose) {
  const notes = [], range = (axis, unit) => `${formatNumber(axis[0], 1)} to ${formatNumber(axis.at(-1), 1)}${unit}`;
  const { model } = player, isBeyond = (x, axis) => x < axis[0] || x > axis.at(-1);
  if (isBeyond(player.flexion, model.flexion)) notes.push(`Flexion ${formatNumber(player.flexion, 1)}° is outside the grid's range ${range(model.flexion, "°")}: drawn at ${formatNumber(pose.attitude.flexion / degree, 1)}°.`);
  if (player.motion().isVarusFree) notes.push(["two_sided", "zero_varus"].includes(player.set) ? "Varus is determined by this motion." : "Varus was free: the solved varus is shown.");
  else if (!player.isBalanced && isBeyond(player.varus, model.varus)) notes.push(`Varus ${formatNumber(player.varus, 1)}° is outside the grid's range ${range(model.varus, "°")}: drawn at ${formatNumber(pose.attitude.varus / degree, 1)}°.`);
  if (player.shown.statement && player.set === player.shown.set) notes.push(player.shown.statement);
  if (player.reason && player.set === "raw") notes.push(`The solved poses are shown: ${player.reason}.`);
  const doubt = doubtText(model, pose, drawnAlone());
  if (doubt) notes.push(`${doubt[0].toUpperCase()}${doubt.slice(1)}.`);
  return notes.join(" ");
}

function rowsOf(pose) {
  const numbers = pose.isSolved ? clinicalOf(pose.referenceMoving, player.model.rotationCentre, player.model.side) : {};
  const clinical = clinicalNumbers.map(({ name, label, unit, note }) => [note ? `${label} (${note})` : label, `${formatNumber(numbers[name])} ${unit}`]);
  const gaps = player.motion().sideGapsAt(pose.attitude.flexion)?.map((gap, k) => [`gap along Delta, ${["medial", "lateral"][k]}`, `${formatNumber(gap)} mm`]) ?? [];
  const [x, y, z] = pose.translation ?? [NaN, NaN, NaN];
  return [...clinical, ["x, world", `${formatNumber(x)} mm`], ["y, world", `${formatNumber(y)} mm`], ["z, world", `${formatNumber(z)} mm`], ["theta about Delta", `${formatNumber(pose.theta / degree)} °`], ...gaps];
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
  byId("shown").textContent = `${player.model.hasTurnedAxes ? "attitude, about axes turned with Delta: " : ""}${angleText(0, shown.flexion)}, ${angleText(1, shown.varus)}${wordsOf(pose)}; ${setLabel(player.set)}`;
  byId("note").textContent = noteOf(pose);
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
  if (!pose.isSolved) return;
  joint.showLayers(pose, player.motion(), { hasLigaments: byId("ligaments").checked, hasGaps: byId("gaps").checked, hasBand: byId("band").checked });
}

function draw() {
  const pose = player.pose();
  if (xr.session) return place(pose);
  const flexion = pose.attitude.flexion / degree, varus = pose.attitude.varus / degree;
  const columns = columnsAlong(player.model, (f) => player.varusAt(f * degree) / degree);
  place(pose);
  byId("labels").hidden = !byId("named").checked;
  byId("strain-scale").hidden = !(joint.ligaments.length > 0 && byId("ligaments").checked);
  byId("gap-scale").hidden = !byId("gaps").checked;
  joint.paths.visible = byId("paths").checked;
  joint.showPaths(columns, flexion);
  viewer.redraw();
  writeNumbers(pose);
  byId("balanced").checked = player.isBalanced;
  maps.draw(flexion, varus);
  curve.setMark(flexion, pose.isSolved ? quantity().of(pose) : NaN);
  plateau.draw(columns, flexion);
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
  const raw = { label: "raw", motion: player.raw, colour: "#c2500a", dash: player.set === "raw" ? undefined : [5, 3] };
  const own = { label: setLabel(player.set), motion: player.motion(), colour: "#0b6aa8" };
  curve.setCurves(player.model, player.set === "raw" ? [raw] : [own, raw], (flexion) => player.varusAt(flexion), quantity(), player.model.bands?.[quantity().name.replace("clinical_", "")], spans);
}

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

function show(model, name) {
  stop();
  xr.leave();
  const made = new Joint(model);
  player = new Player(model);
  joint = made;
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
  if (joint.ligaments.length > 0) byId("strain-highest").textContent = `${Math.round(100 * joint.ligaments[0].layer.highest)} %`;
  viewer.show(joint);
  useSet(player.sets.includes(live?.stream.bench?.set) ? live.stream.bench.set : player.set);
  fitCamera();
  draw();
}

/// Shows the file, or an error message; the previous model then stays.
async function load(bytes, name, isLatest) {
  document.documentElement.dataset.state = "loading";
  showProgress(`Reading ${name}`);
  try {
    await new Promise((drawn) => setTimeout(drawn, 30));  // the page shows it before reading blocks it
    const model = await readMotionModel(bytes);
    if (isLatest()) show(model, name);
  } catch (error) {
    if (isLatest()) showError(`${name}: ${error.message}`);
  }
  if (!isLatest()) return;
  byId("loading").hidden = true;
  document.documentElement.dataset.state = "ready";
}

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
  for (const id of ["paths", "ligaments", "gaps", "named", "band"]) byId(id).addEventListener("change", draw);
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
  show_gap_map: () => byId("gaps").click(), show_ligaments: () => byId("ligaments").click(),
  show_contact_paths: () => byId("paths").click(), show_labels: () => byId("named").click(), show_band: () => byId("band").click(),
  ...Object.fromEntries(Object.keys(views).map((name) => [`view_${name}`, () => useView(name)])),
  reset_view: () => useView(view), full_screen: () => toggleFull(),
  show_help: () => { byId("help").open = !byId("help").open; },
  leave: () => {
    if (byId("help").open) byId("help").open = false;
    else toggleFull(false);
  },
};

const live = connectLive(byId, { player: () => player, joint: () => joint, useSet, drawCurves, show: draw, isInSpace: () => xr.session !== null });
const xr = connectXr(byId, viewer, {
  title: () => byId("title").textContent,
  joint: () => joint, model: () => player.model, flexion: () => player.flexion, range: () => [player.model.flexion[0], player.model.flexion.at(-1)],
  delta: () => player.motion().delta(player.pose().attitude.flexion),
  setFlexion: (flexion) => { stop(); goTo({ flexion }); },
  isPlaying: () => lastFrame !== null, togglePlay,
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
viewer.onDrawn = (camera) => labels.place(camera);
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
  /// For tests: abscissae and values of the curves, and the band.
  curve: () => ({ x: curve.lines[0].x, curves: curve.lines.map(({ y }) => y), band: curve.band[0] && { low: curve.band[0].low, high: curve.band[0].high } }),
  /// For tests: depth of the nearest surface in the middle of the picture, mm.
  seen: () => viewer.seen(),
  /// For tests: strains at a pose { R, t } of the moving body in the reference, and the present gaps.
  strains: (X) => joint.ligaments[0].layer.strains(X),
  live: () => live && { pose: live.stream.pose, bench: live.stream.bench, marks: live.stream.marks() },
  xr: { state: () => xr.state(), point: (target) => xr.panelPoint(target), landmarks: () => landmarksOf(player.model, joint.scale, live?.stream.bench?.points) },
  usdz: async () => Array.from(await usdzOf(joint, byId("ligaments").checked)),
  gaps: () => joint.gaps.sheets.flatMap(({ points, gaps }) => points.map((point, k) => [...point, Number.isFinite(gaps[k]) ? gaps[k] : null])),
};
document.documentElement.dataset.state = "ready";
watchFiles({ input: byId("file"), overlay: byId("drop"), load, showError, showProgress });
