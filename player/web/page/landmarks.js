// Points to touch: those of the bench file, or the outermost points of both bones near the joint.
import { bodyNames } from "./labels.js";

const reachMm = 68;  // about a knee's centre: the epicondyles and the tuberosity, not the ends of long bones

/// [{ name, body, point }], mm, relative to the rotation centre; `points`: of the bench, canonical axes.
export function landmarksOf(model, scale, points = []) {
  const relative = (p) => p.map((x, k) => x - model.rotationCentre[k]);
  if (points.length > 0) return points.map(({ name, body, point }) => ({ name, body, point: relative(point) }));
  const names = bodyNames(model), outward = model.side === "left" ? -1 : 1;
  const directions = [["medial", [0, 0, -outward]], ["lateral", [0, 0, outward]], ["front", [1, 0, 0]]];
  return ["reference", "moving"].flatMap((body) => directions.map(([word, direction]) => {
    const { vertices } = model.bodies[body].parts[0];
    let best = null, farthest = -Infinity;
    for (let at = 0; at < vertices.length; at += 3) {
      const p = relative(Array.from(vertices.subarray(at, at + 3))), along = p.reduce((total, x, k) => total + x * direction[k], 0);
      if (along > farthest && Math.hypot(...p) <= scale * reachMm) [best, farthest] = [p, along];
    }
    return best && { name: `${names[body]}, ${word}`, body, point: best };
  })).filter(Boolean);
}
