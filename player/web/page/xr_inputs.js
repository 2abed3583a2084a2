// Controllers, hands and taps of a session: rays, touching tips, and whether they are tracked. Metres, in the reference space.
import { BufferGeometry, Group, Line, LineBasicMaterial, Matrix4, Mesh, MeshBasicMaterial, Raycaster, SphereGeometry, Vector3 } from "three";

const rayM = 1.5, tipM = 0.003;

/// A pose as a matrix; null if it is missing, not finite, or only estimated.
function trackedMatrix(pose) {
  if (!pose || pose.emulatedPosition || !pose.transform.matrix.every(Number.isFinite)) return null;
  return new Matrix4().fromArray(pose.transform.matrix);
}

export function trackedPose(frame, space, reference) {
  return trackedMatrix(space && frame.getPose(space, reference));
}

/// The point that touches: the tip of the index finger, or of the controller. A pinch moves its own hand, so that the other
/// hand's finger touches if it is seen.
export function touchingPoint(frame, source, sources, reference) {
  const finger = (hand) => {
    const joint = hand?.get("index-finger-tip"), matrix = trackedMatrix(joint && frame.getJointPose?.(joint, reference));
    return matrix && new Vector3().setFromMatrixPosition(matrix);
  };
  if (source.hand) {
    const other = [...sources].find((one) => one.hand && one !== source);
    return (other && finger(other.hand)) ?? finger(source.hand);
  }
  const pose = trackedPose(frame, source.targetRaySpace, reference);
  return pose && new Vector3().setFromMatrixPosition(pose);
}

export function rayOf(frame, source, reference) {
  const pose = frame.getPose(source.targetRaySpace, reference);
  if (!pose || !pose.transform.matrix.every(Number.isFinite)) return null;
  const matrix = new Matrix4().fromArray(pose.transform.matrix), origin = new Vector3().setFromMatrixPosition(matrix);
  return { origin, direction: new Vector3(0, 0, -1).transformDirection(matrix), matrix };
}

/// Where a ray meets a mesh: texture coordinates, or those of the mesh's plane.
export function meets(ray, mesh) {
  const caster = new Raycaster(ray.origin, ray.direction);
  return caster.intersectObject(mesh, false)[0]?.uv;
}

/// Rays and tips of the tracked sources.
export class Pointers {
  constructor() {
    this.group = new Group();
    this.drawn = [];
  }

  update(frame, sources, reference) {
    const tracked = [...sources].filter((source) => source.targetRayMode === "tracked-pointer");
    while (this.drawn.length < tracked.length) this.#add();
    this.drawn.forEach((one, k) => {
      const ray = tracked[k] && rayOf(frame, tracked[k], reference);
      one.visible = Boolean(ray);
      if (ray) one.matrix.copy(ray.matrix);
    });
  }

  #add() {
    const one = new Group();
    one.matrixAutoUpdate = false;
    const ray = new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 0, -rayM)]);
    one.add(new Line(ray, new LineBasicMaterial({ color: "#4aa3df", transparent: true, opacity: 0.6 })), new Mesh(new SphereGeometry(tipM, 12, 8), new MeshBasicMaterial({ color: "#ffb74a" })));
    this.drawn.push(one);
    this.group.add(one);
  }

  dispose() {
    this.group.traverse((object) => { object.geometry?.dispose(); object.material?.dispose(); });
  }
}
