// The bench's stream (schemas/live.md) and its controls on the page.
import { Matrix4 } from "three";
import { cross, difference, dot, rows } from "./geometry.js";
import { composed, inverse, tracked } from "./placement.js";

// The bench's stream (schemas/live.md): checks each message, reconnects after a loss, and reports problems. The last valid message
// is kept.

const slowS = 0.5, firstPauseS = 0.25, longestPauseS = 4, openingS = 10;
const largestMm = 1e5, largestDegrees = 360, mostMarks = 10, mostPoints = 64, longestText = 200;
const roundingOfRotation = 1e-6;

const isNumber = (x, largest) => typeof x === "number" && Number.isFinite(x) && Math.abs(x) <= largest;
const isText = (x) => typeof x === "string" && x.length <= longestText;

function refuse(found, wanted) { throw new Error(`found ${found}, wanted ${wanted}`); }

/// { R, t } of twelve numbers, the rows of a rigid motion.
function placementOf(rows) {
  if (!Array.isArray(rows) || rows.length !== 12 || !rows.every((x) => isNumber(x, largestMm))) refuse("a placement that is not 12 numbers", "the rows of a rigid motion in mm");
  const R = [0, 4, 8].map((k) => rows.slice(k, k + 3)), t = [rows[3], rows[7], rows[11]];
  const third = difference(cross(R[0], R[1]), R[2]);
  if (Math.max(...third.map(Math.abs), Math.abs(dot(R[0], R[1])), Math.abs(dot(R[0], R[0]) - 1), Math.abs(dot(R[1], R[1]) - 1)) > roundingOfRotation) refuse("a placement that is not a rotation", "a rigid motion");
  return { R, t };
}

/// The message of a text; throws an Error with what was found.
function parseMessage(text) {
  let message;
  try {
    message = JSON.parse(text);
  } catch {
    refuse("a message that is not JSON", "one of schemas/live.md");
  }
  if (message?.kind === "bench") {
    if (message.version !== 1) refuse(`version ${message.version}`, "version 1: use page and server of the same release");
    if (!isText(message.title) || !isText(message.set)) refuse("a bench without title and set", "both as texts");
    if (!isNumber(message.scale, 2) || message.scale < 0.5) refuse(`a scale of ${message.scale}`, "0.5 to 2");
    const isPoint = ({ name, body, point }) => isText(name) && ["reference", "moving"].includes(body) && Array.isArray(point) && point.length === 3 && point.every((x) => isNumber(x, largestMm));
    if (!Array.isArray(message.points) || message.points.length > mostPoints || !message.points.every((p) => p && isPoint(p))) refuse("points without name, body and position", "the bench's points");
    return message;
  }
  if (message?.kind !== "pose") refuse("a message of an unknown kind", "bench or pose");
  if (!Number.isSafeInteger(message.number)) refuse("a message without a number", "the count of messages");
  for (const name of ["flexion", "varus"]) if (!isNumber(message[name], largestDegrees)) refuse(`${name} ${message[name]}`, "degrees");
  if (!Array.isArray(message.marks) || message.marks.length > mostMarks || !message.marks.every(isText)) refuse("marks that are not texts", "a list of texts");
  return { ...message, placement: placementOf(message.placement) };
}

class LiveStream {
  /// `onPose(message)`, `onBench(message)`; `address`: of the WebSocket.
  constructor(address, { onPose, onBench }) {
    Object.assign(this, { address, onPose, onBench, pose: null, bench: null, refused: "", pauseS: firstPauseS, heardAt: null });
    this.#connect();
  }

  #connect() {
    this.isOpen = false;
    const socket = new WebSocket(this.address);
    // A server that accepts but sends nothing counts as no connection.
    const silent = setTimeout(() => socket.close(), openingS * 1000);
    socket.addEventListener("open", () => { clearTimeout(silent); [this.isOpen, this.openedAt] = [true, performance.now()]; });
    socket.addEventListener("message", ({ data }) => this.#take(data));
    socket.addEventListener("close", () => {
      clearTimeout(silent);
      this.isOpen = false;
      setTimeout(() => this.#connect(), this.pauseS * 1000);
      this.pauseS = Math.min(2 * this.pauseS, longestPauseS);
    });
  }

  #take(data) {
    try {
      const message = parseMessage(data);
      this.refused = "";
      if (message.kind === "bench") return this.onBench(this.bench = message);
      [this.heardAt, this.pauseS, this.pose] = [performance.now(), firstPauseS, message];
      this.onPose(message);
    } catch (error) {
      this.refused = `bench: ${error.message}`;
    }
  }

  /// The problems, as texts: of the connection, then of the bench.
  marks(now = performance.now()) {
    const seconds = (since) => `${((now - since) / 1000).toFixed(1)} s`;
    if (this.refused) return [this.refused];
    if (!this.isOpen) return [this.pose ? `no connection to the bench for ${seconds(this.heardAt)}: the last pose is shown` : "no connection to the bench"];
    const since = this.heardAt ?? this.openedAt;
    if (now - since > slowS * 1000) return [`no message from the bench for ${seconds(since)}${this.pose ? ": the last pose is shown" : ""}`];
    return this.pose?.marks ?? [];
  }
}

// The bench on the page: a box that follows it, a box that moves the joint as the leg moves, and marks over the picture.

const marksMs = 250, varusStep = 0.5;

/// `host`: player, joint, `useSet(set)`, `show()` draws, `drawCurves()`. Null without a stream in the page's address.
export function connectLive(byId, host) {
  const path = new URLSearchParams(location.search).get("live");
  if (!path || !["http:", "https:"].includes(location.protocol)) return null;
  const address = new URL(path, location.href);
  if (address.origin !== location.origin) return null;
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  let isScheduled = false, drawnVarus = null, first = null;
  const follow = byId("follow"), placed = byId("placed");

  const place = (message) => {
    const { group } = host.joint(), centre = host.player().model.rotationCentre, scale = stream.bench?.scale ?? 1;
    const now = placed.checked && message ? tracked(message.placement, centre, scale) : null;
    if (now && !first) first = now;
    if (!now) first = null;
    group.matrixAutoUpdate = false;
    group.matrix = now ? new Matrix4().set(...rows(composed(inverse(first), now))) : new Matrix4();
  };
  /// Takes the newest pose; the caller draws.
  const apply = () => {
    const { pose } = stream, player = host.player();
    if (!pose || !player || !follow.checked) return false;
    [player.flexion, player.varus, player.isBalanced] = [pose.flexion, pose.varus, false];
    return true;
  };
  const draw = () => {
    isScheduled = false;
    if (!host.player() || host.isInSpace() || !apply()) return;
    place(stream.pose);
    host.show();
    if (drawnVarus === null || Math.abs(host.player().varus - drawnVarus) > varusStep) host.drawCurves();
    drawnVarus = host.player().varus;
  };
  const stream = new LiveStream(address, {
    onPose: () => { if (!isScheduled) requestAnimationFrame(draw); isScheduled = true; },
    onBench: (bench) => { if (host.player()?.sets.includes(bench.set)) host.useSet(bench.set); },
  });
  for (const id of ["follow-choice", "placed-choice"]) byId(id).hidden = false;
  follow.checked = true;
  placed.addEventListener("change", () => {
    // The placement is the reference's.
    if (placed.checked) byId("held").value = "reference";
    place(stream.pose);
    host.show();
  });
  setInterval(() => {
    const text = stream.marks().join("\n");
    if (byId("marks").textContent !== text) byId("marks").textContent = text;
  }, marksMs);
  return { stream, apply };
}
