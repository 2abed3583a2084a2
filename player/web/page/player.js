// The state of the player, independent of the page: requested attitude, set, and resulting pose.
import { rows, degree } from "./frames.js";
import { Motion, defaultMotion, setNames } from "./motion.js";

export class Player {
  constructor(model) {
    this.model = model;
    this.sets = setNames(model);
    this.motions = new Map();
    this.raw = this.motion("raw");
    ({ set: this.set, reason: this.reason } = defaultMotion(model));
    this.isBalanced = this.raw.spine.length > 0;
    this.flexion = Math.min(Math.max(0, model.flexion[0]), model.flexion.at(-1));
    this.varus = Math.min(Math.max(0, model.varus[0]), model.varus.at(-1));
    this.direction = 1;
  }

  motion(set = this.set) {
    if (!this.sets.includes(set)) throw new Error(`found set "${set}", wanted one of: ${this.sets.join(", ")}`);
    if (!this.motions.has(set)) this.motions.set(set, new Motion(this.model, set));
    return this.motions.get(set);
  }

  /// The requested varus at a flexion, both in radians: the balanced varus, or the slider's.
  varusAt(flexion) {
    return this.isBalanced || this.motion().isVarusFree ? this.motion().balancedVarus(flexion) : this.varus * degree;
  }

  pose() {
    const flexion = this.flexion * degree;
    return this.motion().at({ flexion, varus: this.varusAt(flexion) });
  }

  /// Advances flexion by `seconds` at `speed` degrees per second, back and forth over the grid's range.
  advance(seconds, speed) {
    const [low, high] = [this.model.flexion[0], this.model.flexion.at(-1)];
    let next = Math.min(Math.max(this.flexion, low), high) + this.direction * speed * seconds;
    if (next >= high) [next, this.direction] = [high, -1];
    else if (next <= low) [next, this.direction] = [low, 1];
    this.flexion = next;
  }

  /// For scripts and tests: the pose of any set at any attitude in degrees.
  poseOf(set, flexion, varus) {
    const pose = this.motion(set).at({ flexion: flexion * degree, varus: varus * degree });
    const result = { isSolved: pose.isSolved, isFlexionClamped: pose.isFlexionClamped, isVarusClamped: pose.isVarusClamped };
    return pose.isSolved ? { ...result, X_reference_moving: rows(pose.referenceMoving), theta_rad: pose.theta } : result;
  }
}
