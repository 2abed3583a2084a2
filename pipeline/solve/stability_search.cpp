#include "solve/stability_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "geometry/gap_query.hpp"

namespace vrda::solve {
namespace {

// The approach stops this share of the translation resolution before the exact contact, so that rounding
// never makes a result overlap.
constexpr double search_standoff_share = 0.01;

// Share of the translation resolution within which a contact carries load: ten stand-offs. Contacts further
// away are neighbours within the thesis's band.
constexpr double loaded_share = 10.0 * search_standoff_share;

// Bands, as shares of the translation resolution, whose contacts predict an ascent: narrow ones give the
// slope at the pose, wide ones include the neighbouring contacts.
constexpr std::array<double, 3> ascent_bands = {5.0 * search_standoff_share, 20.0 * search_standoff_share,
                                                1.0};

// An ascent starts with half the translation resolution and grows up to the translation step. It must rise by
// a thousandth of the resolution: above rounding, below the rise of slopes of a few thousandths.
constexpr double ascent_start_share = 0.5;
constexpr double ascent_growth = 4.0;
constexpr double ascent_gain_share = 0.001;

// Limit of the sub-steps of one motion: avoids integer overflow for extreme step sizes.
constexpr double max_substeps = 1e6;

MovingPose rotated_about(MovingPose pose, const Eigen::Vector3d& centre_mm, double angle_rad)
{
  const double height_mm = pose.translation_mm.y();
  pose.translation_mm = centre_mm + rotation_y(angle_rad) * (pose.translation_mm - centre_mm);
  pose.translation_mm.y() = height_mm;
  pose.theta_rad += angle_rad;
  return pose;
}

enum class LastMotion { none, rotation, translation };

class Search {
 public:
  Search(const Joint& joint, const Attitude& attitude, const MovingPose& seed, const SearchOptions& options,
         const SearchObserver& observer)
      : joint_(joint),
        reference_(geometry::rotated_reference(joint.reference.tree_mesh, attitude)),
        gap_(joint.reference_gap, joint.moving_gap),
        attitude_(attitude),
        options_(options),
        observer_(observer),
        pose_(seed),
        translation_step_mm_(options.translation_step_mm),
        rotation_step_rad_(options.rotation_step_rad)
  {
    gap_.set_attitude(attitude);
  }

  StepRecord run()
  {
    StepRecord record;
    record.status = search();
    record.pose = pose_;
    record.varus_rad = attitude_.varus_rad;
    record.iterations = iteration_;
    record.residual_mm = residual_mm_;
    if (record.status == StepStatus::stable) measure(record);
    record.queries += queries_;
    return record;
  }

 private:
  StepStatus search()
  {
    if (collides(pose_) && !retreat()) return StepStatus::no_clearance;
    for (iteration_ = 1; iteration_ <= options_.max_steps; ++iteration_) {
      if (!approach()) return StepStatus::no_contact;
      const bool is_cycle = adapt_steps();
      const std::vector<contact::Contact> contacts = contacts_here();
      report_contact(contacts, is_cycle);
      const RotationPrediction rotation = rotation_of(contacts);
      if (rotation.sign != 0 && rotation_step_rad_ >= options_.rotation_resolution_rad) {
        rotate(rotation);
        continue;
      }
      if (!try_translate(contacts) && !try_translate(within(contacts, loaded_share)) && !try_ascend(contacts))
        return StepStatus::stable;
    }
    iteration_ = options_.max_steps;
    return StepStatus::iteration_limit;
  }

  RotationPrediction rotation_of(const std::vector<contact::Contact>& contacts) const
  {
    if (options_.held.theta) return {};
    return options_.held.any_translation() ? predict_rotation_about(contacts, pose_.translation_mm)
                                           : predict_rotation(contacts);
  }

  bool collides(const MovingPose& pose)
  {
    ++queries_;
    const auto hit = contact::find_collision(reference_.mesh, joint_.moving.tree_mesh.mesh, pose, gap_,
                                             narrow_phase_, collision_hint_);
    if (hit) collision_hint_ = *hit;
    return hit.has_value();
  }

  std::vector<contact::Contact> contacts_here()
  {
    ++queries_;
    return contacts_of(options_.points);
  }

  std::vector<contact::Contact> contacts_of(ContactPoints points)
  {
    const double band_mm = options_.translation_resolution_mm;
    return contact::find_contacts(
        {reference_, joint_.reference.features, joint_.moving, &gap_.close_pairs(pose_, band_mm)}, pose_,
        narrow_phase_, {band_mm, options_.rotation_resolution_rad, points, options_.normals});
  }

  // The contacts nearer than a share of the translation resolution.
  std::vector<contact::Contact> within(const std::vector<contact::Contact>& contacts, double share) const
  {
    std::vector<contact::Contact> near;
    std::copy_if(contacts.begin(), contacts.end(), std::back_inserter(near), [&](const contact::Contact& c) {
      return c.distance_mm <= share * options_.translation_resolution_mm;
    });
    return near;
  }

  // Cached for repeated queries at the same pose.
  const geometry::Gap& gap_ahead()
  {
    const bool is_known =
        ahead_ && ahead_at_.translation_mm == pose_.translation_mm && ahead_at_.theta_rad == pose_.theta_rad;
    if (is_known) return *ahead_;
    ++queries_;
    ahead_ = gap_.next_contact(pose_);
    ahead_at_ = pose_;
    return *ahead_;
  }

  // Rotating the reference from one attitude to the next often makes the objects overlap (thesis 5.3). Moves
  // back along -Delta, with short strides first, since a ball in a socket has little clearance.
  bool retreat()
  {
    const double limit_mm = std::max(
        std::min(extent_along_delta_mm(reference_.mesh), extent_along_delta_mm(joint_.moving.tree_mesh.mesh)),
        options_.approach_step_mm);
    MovingPose free = pose_;
    double stride_mm = std::min(options_.translation_resolution_mm, options_.translation_step_mm);
    for (double travelled_mm = 0.0; travelled_mm < limit_mm; travelled_mm += stride_mm) {
      if (travelled_mm > 0.0) stride_mm = std::min(2.0 * stride_mm, options_.translation_step_mm);
      free.translation_mm.y() -= stride_mm;
      if (collides(free)) continue;
      pose_ = free;
      report(MoveKind::retreat, pose_);
      return true;
    }
    return false;
  }

  // Moves along Delta to contact; false without contact ahead.
  bool approach()
  {
    const geometry::Gap gap = gap_ahead();
    if (!std::isfinite(gap.travel_mm)) return false;
    const double travel_mm = gap.travel_mm - search_standoff_share * options_.translation_resolution_mm;
    report_strides(travel_mm);
    has_touched_ = true;
    if (travel_mm <= 0.0) return true;
    pose_.translation_mm.y() += travel_mm;
    return true;
  }

  // The gap query replaces the thesis's approach strides; they are reported to the observer only.
  void report_strides(double travel_mm) const
  {
    if (!observer_ || has_touched_) return;
    MovingPose pose = pose_;
    for (double s = options_.approach_step_mm; s < travel_mm; s += options_.approach_step_mm) {
      pose.translation_mm.y() = pose_.translation_mm.y() + s;
      report(MoveKind::approach, pose);
    }
  }

  // Translates as the contacts predict; false if that is below the resolution.
  bool try_translate(const std::vector<contact::Contact>& contacts)
  {
    Eigen::Vector3d by_mm = translation_step_mm_ * predict_translation(contacts);
    if (options_.held.x) by_mm.x() = 0.0;
    if (options_.held.z) by_mm.z() = 0.0;
    residual_mm_ = by_mm.norm();
    if (residual_mm_ < options_.translation_resolution_mm) return false;
    const MovingPose start = pose_;
    translate(by_mm);
    // Loss of contact may only mean that the step was too long.
    while (!std::isfinite(gap_ahead().travel_mm)) {
      by_mm *= 0.5;
      if (by_mm.norm() < options_.translation_resolution_mm) break;
      translation_step_mm_ *= 0.5;
      pose_ = start;
      translate(by_mm);
    }
    last_motion_ = LastMotion::translation;
    report(MoveKind::translate, pose_);
    return true;
  }

  // The component-wise average may point into a surface in contact, so that halving stops short of
  // equilibrium (thesis 3.5 and 3.6), and a neighbour within the band may block a rotation too early. So the
  // contacts of a stable pose are tested for an ascent, first without a rotation.
  bool try_ascend(const std::vector<contact::Contact>& contacts)
  {
    // The lever weighs one resolution of translation and of rotation equally.
    const double lever_mm = options_.translation_resolution_mm / options_.rotation_resolution_rad;
    for (const double band : ascent_bands) {
      const std::vector<contact::Contact> near = within(contacts, band);
      for (const std::optional<double>& lever : {std::optional<double>(), std::optional<double>(lever_mm)}) {
        if (try_ascend(predict_ascent(near, lever, options_.held, pose_.translation_mm))) return true;
      }
    }
    return false;
  }

  // Moves by the longest tried length that ends higher along Delta, unless the motion collides.
  bool try_ascend(const Ascent& ascent)
  {
    if (ascent.rise <= 0.0) return false;
    const double length_mm = ascent_length_mm(ascent);
    if (length_mm <= 0.0) return false;
    const int n = substeps(length_mm * sweep_per_mm(ascent));
    for (int k = 0; k <= n; ++k) {
      if (collides(lowered_pose(pose_, ascent, static_cast<double>(k) / n * length_mm, length_mm)))
        return false;
    }
    pose_ = lowered_pose(pose_, ascent, length_mm, length_mm);
    last_motion_ = ascent.turn_rad_per_mm == 0.0 ? LastMotion::translation : LastMotion::rotation;
    report(ascent.turn_rad_per_mm == 0.0 ? MoveKind::translate : MoveKind::rotate, pose_);
    return true;
  }

  // 0 if the shortest motion does not rise.
  double ascent_length_mm(const Ascent& ascent)
  {
    const MovingPose here = pose_;
    const double contact_mm = contact_height_mm();  // a translation may have stopped closer than an approach
    double best_mm = 0.0, best_rise_mm = ascent_gain_share * options_.translation_resolution_mm;
    for (double length_mm =
             ascent_start_share * options_.translation_resolution_mm / std::max(1.0, ascent.rise);
         length_mm <= options_.translation_step_mm &&
         length_mm * std::abs(ascent.turn_rad_per_mm) <= options_.rotation_step_rad;
         length_mm *= ascent_growth) {
      pose_ = lowered_pose(here, ascent, length_mm, length_mm);
      const double rise_mm = contact_height_mm() - contact_mm;
      if (!std::isfinite(rise_mm) || rise_mm <= best_rise_mm) break;
      best_rise_mm = rise_mm;
      best_mm = length_mm;
    }
    pose_ = here;
    return best_mm;
  }

  double contact_height_mm() { return pose_.translation_mm.y() + gap_ahead().travel_mm; }

  // Pose after a part of an ascent, lowered by the whole motion's displacement to clear flanks of 45 degrees.
  MovingPose lowered_pose(const MovingPose& start, const Ascent& ascent, double length_mm,
                          double whole_mm) const
  {
    MovingPose pose = rotated_about(start, ascent.centre_mm, length_mm * ascent.turn_rad_per_mm);
    pose.translation_mm += length_mm * ascent.direction;
    pose.translation_mm.y() -= whole_mm * sweep_per_mm(ascent);
    return pose;
  }

  // Largest displacement of any point, mm per mm of the motion.
  double sweep_per_mm(const Ascent& ascent) const
  {
    if (ascent.turn_rad_per_mm == 0.0) return 1.0;
    return ascent.direction.norm() +
           std::abs(ascent.turn_rad_per_mm) * farthest_from_axis_mm(ascent.centre_mm);
  }

  // A long translation ends at the largest travel along Delta: under the push the moving object would
  // not leave a hollow, and steps as long as the objects would move it out on the far side.
  void translate(const Eigen::Vector3d& by_mm)
  {
    const int n = substeps(by_mm.norm());
    const Eigen::Vector3d part_mm = by_mm / n;
    MovingPose best = pose_;
    double longest_mm = 0.0;
    for (int k = 0; k < n; ++k) {
      const MovingPose start = pose_;
      move_while_free(part_mm.norm(), options_.translation_resolution_mm, 1, [&](double share) {
        MovingPose pose = start;
        pose.translation_mm += share * part_mm;
        return pose;
      });
      const bool is_blocked = pose_.translation_mm != start.translation_mm + part_mm;
      if (n == 1) return;
      const double travel_mm = gap_ahead().travel_mm;
      if (travel_mm < longest_mm) break;
      best = pose_;
      longest_mm = travel_mm;
      if (is_blocked || !std::isfinite(travel_mm)) break;
    }
    pose_ = best;
  }

  void rotate(const RotationPrediction& rotation)
  {
    const MovingPose start = pose_;
    const double angle_rad = rotation.sign * rotation_step_rad_;
    const double sweep_mm = std::abs(angle_rad) * farthest_from_axis_mm(rotation.centre_mm);
    move_while_free(
        std::abs(angle_rad), options_.rotation_resolution_rad, substeps(sweep_mm),
        [&](double share) { return rotated_about(start, rotation.centre_mm, share * angle_rad); });
    last_motion_ = LastMotion::rotation;
    report(MoveKind::rotate, pose_);
  }

  // Not below the resolution: thinner parts cannot be resolved.
  int substeps(double length_mm) const
  {
    const double longest_mm = std::max(joint_.substep_mm, options_.translation_resolution_mm);
    return std::max(1, static_cast<int>(std::ceil(std::min(length_mm / longest_mm, max_substeps))));
  }

  // Moves from share 0 to 1 in equal sub-steps; bisects the first that collides down to the resolution.
  // `length` is that of the whole motion, in the unit of `resolution`.
  template <typename PoseAt>
  void move_while_free(double length, double resolution, int n_substeps, const PoseAt& pose_at)
  {
    double free = 0.0;
    for (int k = 1; k <= n_substeps; ++k) {
      const double next = static_cast<double>(k) / n_substeps;
      const MovingPose candidate = pose_at(next);
      if (!collides(candidate)) {
        free = next;
        pose_ = candidate;
        continue;
      }
      double blocked = next;
      while ((blocked - free) * length > resolution) {
        const double middle = 0.5 * (free + blocked);
        if (middle <= free || middle >= blocked) break;  // resolution below rounding
        const MovingPose trial = pose_at(middle);
        const bool is_blocked = collides(trial);
        report(MoveKind::bisect, trial, is_blocked);
        if (is_blocked) {
          blocked = middle;
        } else {
          free = middle;
          pose_ = trial;
        }
      }
      return;
    }
  }

  double farthest_from_axis_mm(const Eigen::Vector3d& centre_mm) const
  {
    const geometry::BoxTree::Node& box = joint_.moving.tree_mesh.tree.nodes().front();
    const geometry::Placement place(pose_);
    double farthest_sq = 0.0;
    for (const double x : {box.min_mm[0], box.max_mm[0]}) {
      for (const double z : {box.min_mm[2], box.max_mm[2]}) {
        const Eigen::Vector3d arm = place(Eigen::Vector3d(x, 0.0, z)) - centre_mm;
        farthest_sq = std::max(farthest_sq, arm.x() * arm.x() + arm.z() * arm.z());
      }
    }
    return std::sqrt(farthest_sq);
  }

  // Cycle detection (thesis 3.6): at an earlier pose, halves the step of the last motion's kind; at a new
  // pose, restores that of the other kind. Returns whether the pose is an earlier one.
  bool adapt_steps()
  {
    const bool is_earlier = std::any_of(history_.begin(), history_.end(), [&](const MovingPose& earlier) {
      return (earlier.translation_mm - pose_.translation_mm).norm() < options_.translation_resolution_mm &&
             std::abs(earlier.theta_rad - pose_.theta_rad) < options_.rotation_resolution_rad;
    });
    if (is_earlier) {
      if (last_motion_ == LastMotion::rotation) rotation_step_rad_ *= 0.5;
      if (last_motion_ == LastMotion::translation) translation_step_mm_ *= 0.5;
      return true;
    }
    history_.push_back(pose_);
    if (last_motion_ == LastMotion::rotation) translation_step_mm_ = options_.translation_step_mm;
    if (last_motion_ == LastMotion::translation) rotation_step_rad_ = options_.rotation_step_rad;
    return false;
  }

  void measure(StepRecord& record)
  {
    measure_contacts(joint_, contacts_of(ContactPoints::exact), options_.translation_resolution_mm, record);
    ++queries_;
    measure_gaps(joint_, attitude_, pose_, record);
  }

  SearchMove move_of(MoveKind kind, const MovingPose& pose) const
  {
    SearchMove move;
    move.iteration = iteration_;
    move.kind = kind;
    move.pose = pose;
    move.translation_step_mm = translation_step_mm_;
    move.rotation_step_rad = rotation_step_rad_;
    return move;
  }

  void report(MoveKind kind, const MovingPose& pose, bool is_blocked = false) const
  {
    if (!observer_) return;
    SearchMove move = move_of(kind, pose);
    move.collides = is_blocked;
    observer_(move);
  }

  void report_contact(const std::vector<contact::Contact>& contacts, bool is_cycle) const
  {
    if (!observer_) return;
    SearchMove move = move_of(MoveKind::approach, pose_);
    move.is_cycle = is_cycle;
    move.in_contact = true;
    for (const contact::Contact& c : contacts) move.contacts.push_back(contact_record(joint_, c));
    observer_(move);
  }

  const Joint& joint_;
  geometry::TreeMesh reference_;  // at the attitude
  geometry::GapQuery gap_;        // likewise
  Attitude attitude_;
  const SearchOptions& options_;
  const SearchObserver& observer_;
  contact::NarrowPhase narrow_phase_;
  MovingPose pose_;
  double translation_step_mm_;
  double rotation_step_rad_;
  LastMotion last_motion_ = LastMotion::none;
  bool has_touched_ = false;
  std::vector<MovingPose> history_;
  std::optional<geometry::Gap> ahead_;  // at ahead_at_
  MovingPose ahead_at_;
  geometry::TrianglePair collision_hint_;
  double residual_mm_ = 0.0;
  int iteration_ = 0;
  int queries_ = 0;
};

}  // namespace

StepRecord find_stable_pose(const Joint& joint, const Attitude& attitude, const MovingPose& seed,
                            const SearchOptions& options, const SearchObserver& observer)
{
  return Search(joint, attitude, seed, options, observer).run();
}

}  // namespace vrda::solve
