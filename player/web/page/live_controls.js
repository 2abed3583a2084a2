// The bench on the page: a box that follows it, a box that moves the joint as the leg moves, and marks over the picture.
import { Matrix4 } from "three";
import { rows } from "./frames.js";
import { LiveStream } from "./live.js";
import { composed, inverse, tracked } from "./placement.js";

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
