#include "solve/stability_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "proximity/gap_query.hpp"
#include "solve/joint.hpp"

namespace vrda {
namespace {

// The approach stops this share of the translation resolution before the exact touch, so that rounding never
// makes a result overlap.
constexpr double standoff_share = 0.01;

// Share of the translation resolution within which a contact surely bears load: ten stand-offs. Those
// further off are neighbours that the thesis's band takes in.
constexpr double really_touching = 10.0 * standoff_share;

// Bands, as shares of the translation resolution, whose contacts are asked for a way up: narrow ones name
// the slope at the pose, wide ones the obstacles next to it.
constexpr std::array<double, 3> climb_bands = {5.0 * standoff_share, 20.0 * standoff_share, 1.0};

// A climb tries a way of half the translation resolution and then longer and longer ones up to the
// translation step. It must gain a thousandth of the resolution: enough to be no
// rounding, little enough for slopes of a few thousandths.
constexpr double climb_way_share = 0.5;
constexpr double climb_growth = 4.0;
constexpr double climb_gain_share = 0.001;

// Bound of the sub-steps of one motion: keeps absurd steps from overflowing the count.
constexpr double most_substeps = 1e6;

MovingPose turned_about(MovingPose pose, const Eigen::Vector3d& centre_mm, double angle_rad)
{
  const double height_mm = pose.translation_mm.y();
  pose.translation_mm = centre_mm + rotation_y(angle_rad) * (pose.translation_mm - centre_mm);
  pose.translation_mm.y() = height_mm;
  pose.theta_rad += angle_rad;
  return pose;
}

enum class LastMotion { none, turn, slide };

class Search {
 public:
  Search(const Joint& joint, const Attitude& attitude, const MovingPose& seed, const SearchOptions& options,
         const Watch& watch)
      : joint_(joint),
        reference_(turned(joint.reference.solid, attitude)),
        gap_(joint.reference_gap, joint.moving_gap),
        varus_rad_(attitude.varus_rad),
        options_(options),
        watch_(watch),
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
    record.varus_rad = varus_rad_;
    record.iterations = iteration_;
    record.residual_mm = residual_mm_;
    if (record.status == StepStatus::stable) measure(record);
    record.queries = queries_;
    return record;
  }

 private:
  StepStatus search()
  {
    if (collides(pose_) && !retreat()) return StepStatus::no_clearance;
    for (iteration_ = 1; iteration_ <= options_.max_steps; ++iteration_) {
      if (!approach()) return StepStatus::no_contact;
      const bool is_cycle = adapt_steps();
      const std::vector<Contact> contacts = touching();
      tell_touch(contacts, is_cycle);
      const RotationPrediction rotation = predict_rotation(contacts);
      if (rotation.sign != 0 && rotation_step_rad_ >= options_.rotation_resolution_rad) {
        turn(rotation);
        continue;
      }
      if (!slides_by(contacts) && !slides_by(within(contacts, really_touching)) && !climbs(contacts))
        return StepStatus::stable;
    }
    iteration_ = options_.max_steps;
    return StepStatus::iteration_limit;
  }

  bool collides(const MovingPose& pose)
  {
    ++queries_;
    const auto hit = find_collision(reference_, joint_.moving.solid, pose, narrow_phase_, collision_hint_);
    if (hit) collision_hint_ = *hit;
    return hit.has_value();
  }

  std::vector<Contact> touching()
  {
    ++queries_;
    return find_contacts({reference_, joint_.reference.features, joint_.moving}, pose_, narrow_phase_,
                         {options_.translation_resolution_mm, options_.rotation_resolution_rad,
                          options_.points, options_.normals});
  }

  // Those nearer than a share of the translation resolution.
  std::vector<Contact> within(const std::vector<Contact>& contacts, double share) const
  {
    std::vector<Contact> near;
    std::copy_if(contacts.begin(), contacts.end(), std::back_inserter(near), [&](const Contact& c) {
      return c.distance_mm <= share * options_.translation_resolution_mm;
    });
    return near;
  }

  // Asked again at the same pose, the answer is kept.
  const Gap& gap_ahead()
  {
    const bool is_known =
        ahead_ && ahead_at_.translation_mm == pose_.translation_mm && ahead_at_.theta_rad == pose_.theta_rad;
    if (is_known) return *ahead_;
    ++queries_;
    ahead_ = gap_.touch(pose_);
    ahead_at_ = pose_;
    return *ahead_;
  }

  // Thesis 5.3 turns the reference under a resting object, which often makes them overlap: back out along
  // -Delta, with short strides first, since a ball in a socket has little room.
  bool retreat()
  {
    const double limit_mm = std::max(
        std::min(extent_along_delta_mm(reference_.mesh), extent_along_delta_mm(joint_.moving.solid.mesh)),
        options_.approach_step_mm);
    MovingPose free = pose_;
    double stride_mm = std::min(options_.translation_resolution_mm, options_.translation_step_mm);
    for (double travelled_mm = 0.0; travelled_mm < limit_mm; travelled_mm += stride_mm) {
      if (travelled_mm > 0.0) stride_mm = std::min(2.0 * stride_mm, options_.translation_step_mm);
      free.translation_mm.y() -= stride_mm;
      if (collides(free)) continue;
      pose_ = free;
      tell(MoveKind::retreat, pose_);
      return true;
    }
    return false;
  }

  // Up to the touch; false when nothing is in the way.
  bool approach()
  {
    const Gap gap = gap_ahead();
    if (!std::isfinite(gap.travel_mm)) return false;
    const double travel_mm = gap.travel_mm - standoff_share * options_.translation_resolution_mm;
    tell_strides(travel_mm);
    has_touched_ = true;
    if (travel_mm <= 0.0) return true;
    const MovingPose start = pose_;
    move_while_free(travel_mm, options_.translation_resolution_mm, 1, [&](double share) {
      MovingPose pose = start;
      pose.translation_mm.y() += share * travel_mm;
      return pose;
    });
    return true;
  }

  // The way is known to be free, so the thesis's approach stride is only for those who watch.
  void tell_strides(double travel_mm) const
  {
    if (!watch_ || has_touched_) return;
    MovingPose pose = pose_;
    for (double s = options_.approach_step_mm; s < travel_mm; s += options_.approach_step_mm) {
      pose.translation_mm.y() = pose_.translation_mm.y() + s;
      tell(MoveKind::approach, pose);
    }
  }

  // Slides as the contacts predict, unless that is below the resolution.
  bool slides_by(const std::vector<Contact>& contacts)
  {
    Eigen::Vector3d by_mm = translation_step_mm_ * predict_translation(contacts);
    residual_mm_ = by_mm.norm();
    if (residual_mm_ < options_.translation_resolution_mm) return false;
    const MovingPose start = pose_;
    slide(by_mm);
    // A step that leaves the reference behind may just have been too long.
    while (!std::isfinite(gap_ahead().travel_mm)) {
      by_mm *= 0.5;
      if (by_mm.norm() < options_.translation_resolution_mm) break;
      translation_step_mm_ *= 0.5;
      pose_ = start;
      slide(by_mm);
    }
    last_motion_ = LastMotion::slide;
    tell(MoveKind::translate, pose_);
    return true;
  }

  // The average by component may point into a surface that is touched already, halving then ends short of the
  // place of rest (thesis 3.5 and 3.6), and a neighbour within the band holds a turn before it is reached. So
  // before a pose counts as stable, its contacts are asked for a motion that leads up, first without a turn;
  // one that does is taken as far as it goes on rising.
  bool climbs(const std::vector<Contact>& contacts)
  {
    // One resolution of each kind counts alike.
    const double lever_mm = options_.translation_resolution_mm / options_.rotation_resolution_rad;
    for (const double band : climb_bands) {
      const std::vector<Contact> near = within(contacts, band);
      if (climbs_by(predict_climb(near)) || climbs_by(predict_climb(near, lever_mm))) return true;
    }
    return false;
  }

  // Goes the longest way tried at whose end the moving object rests higher than here, unless something is in
  // the way.
  bool climbs_by(const Climb& climb)
  {
    if (climb.rise <= 0.0) return false;
    const double length_mm = length_up_mm(climb);
    if (length_mm <= 0.0) return false;
    const int n = substeps(length_mm * sweep_of(climb));
    for (int k = 0; k <= n; ++k) {
      if (collides(under(pose_, climb, static_cast<double>(k) / n * length_mm, length_mm))) return false;
    }
    pose_ = under(pose_, climb, length_mm, length_mm);
    last_motion_ = climb.turn_rad_mm == 0.0 ? LastMotion::slide : LastMotion::turn;
    tell(climb.turn_rad_mm == 0.0 ? MoveKind::translate : MoveKind::rotate, pose_);
    return true;
  }

  // 0 when the shortest way does not lead up.
  double length_up_mm(const Climb& climb)
  {
    const MovingPose here = pose_;
    const double rest_mm = rest_height_mm();  // a slide may have stopped nearer than an approach
    double best_mm = 0.0, best_rise_mm = climb_gain_share * options_.translation_resolution_mm;
    for (double length_mm = climb_way_share * options_.translation_resolution_mm / std::max(1.0, climb.rise);
         length_mm <= options_.translation_step_mm &&
         length_mm * std::abs(climb.turn_rad_mm) <= options_.rotation_step_rad;
         length_mm *= climb_growth) {
      pose_ = under(here, climb, length_mm, length_mm);
      const double rise_mm = rest_height_mm() - rest_mm;
      if (!std::isfinite(rise_mm) || rise_mm <= best_rise_mm) break;
      best_rise_mm = rise_mm;
      best_mm = length_mm;
    }
    pose_ = here;
    return best_mm;
  }

  double rest_height_mm() { return pose_.translation_mm.y() + gap_ahead().travel_mm; }

  // A part of a climb, backed out by the way that the whole one takes its farthest point, which clears flanks
  // of up to 45 degrees.
  MovingPose under(const MovingPose& start, const Climb& climb, double length_mm, double whole_mm) const
  {
    MovingPose pose = turned_about(start, climb.centre_mm, length_mm * climb.turn_rad_mm);
    pose.translation_mm += length_mm * climb.direction;
    pose.translation_mm.y() -= whole_mm * sweep_of(climb);
    return pose;
  }

  // The farthest that any point goes, mm a mm of the motion.
  double sweep_of(const Climb& climb) const
  {
    if (climb.turn_rad_mm == 0.0) return 1.0;
    return climb.direction.norm() + std::abs(climb.turn_rad_mm) * farthest_from_axis_mm(climb.centre_mm);
  }

  // A long slide ends where the way left along Delta is longest: the push would not let the moving object
  // pass a hollow on its way, and steps as long as the objects would throw it out on the far side.
  void slide(const Eigen::Vector3d& by_mm)
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

  void turn(const RotationPrediction& rotation)
  {
    const MovingPose start = pose_;
    const double angle_rad = rotation.sign * rotation_step_rad_;
    const double sweep_mm = std::abs(angle_rad) * farthest_from_axis_mm(rotation.centre_mm);
    move_while_free(std::abs(angle_rad), options_.rotation_resolution_rad, substeps(sweep_mm),
                    [&](double share) { return turned_about(start, rotation.centre_mm, share * angle_rad); });
    last_motion_ = LastMotion::turn;
    tell(MoveKind::rotate, pose_);
  }

  // Parts thinner than the resolution are not told apart from their contacts anyway.
  int substeps(double length_mm) const
  {
    const double longest_mm = std::max(joint_.substep_mm, options_.translation_resolution_mm);
    return std::max(1, static_cast<int>(std::ceil(std::min(length_mm / longest_mm, most_substeps))));
  }

  // Goes from share 0 to 1 in equal sub-steps; the first that collides is bisected down to the resolution.
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
        if (middle <= free || middle >= blocked) break;  // a resolution below that of the numbers
        const MovingPose trial = pose_at(middle);
        const bool is_blocked = collides(trial);
        tell(MoveKind::bisect, trial, is_blocked);
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
    const BoxTree::Node& box = joint_.moving.solid.tree.nodes().front();
    const Placement place(pose_);
    double farthest_sq = 0.0;
    for (const double x : {box.min_mm[0], box.max_mm[0]}) {
      for (const double z : {box.min_mm[2], box.max_mm[2]}) {
        const Eigen::Vector3d arm = place(Eigen::Vector3d(x, 0.0, z)) - centre_mm;
        farthest_sq = std::max(farthest_sq, arm.x() * arm.x() + arm.z() * arm.z());
      }
    }
    return std::sqrt(farthest_sq);
  }

  // Cycle detection (thesis 3.6): back at an earlier pose, the last motion was too coarse; at a new one, the
  // other kind of motion gets its full step again. Says which.
  bool adapt_steps()
  {
    const bool was_here = std::any_of(history_.begin(), history_.end(), [&](const MovingPose& earlier) {
      return (earlier.translation_mm - pose_.translation_mm).norm() < options_.translation_resolution_mm &&
             std::abs(earlier.theta_rad - pose_.theta_rad) < options_.rotation_resolution_rad;
    });
    if (was_here) {
      if (last_motion_ == LastMotion::turn) rotation_step_rad_ *= 0.5;
      if (last_motion_ == LastMotion::slide) translation_step_mm_ *= 0.5;
      return true;
    }
    history_.push_back(pose_);
    if (last_motion_ == LastMotion::turn) translation_step_mm_ = options_.translation_step_mm;
    if (last_motion_ == LastMotion::slide) rotation_step_rad_ = options_.rotation_step_rad;
    return false;
  }

  void measure(StepRecord& record)
  {
    ContactOptions exact{options_.translation_resolution_mm, options_.rotation_resolution_rad,
                         ContactPoints::exact, options_.normals};
    const std::vector<Contact> contacts =
        find_contacts({reference_, joint_.reference.features, joint_.moving}, pose_, narrow_phase_, exact);
    queries_ += 1 + measure_step(joint_, reference_, contacts, options_.translation_resolution_mm, record);
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

  void tell(MoveKind kind, const MovingPose& pose, bool is_blocked = false) const
  {
    if (!watch_) return;
    SearchMove move = move_of(kind, pose);
    move.collides = is_blocked;
    watch_(move);
  }

  void tell_touch(const std::vector<Contact>& contacts, bool is_cycle) const
  {
    if (!watch_) return;
    SearchMove move = move_of(MoveKind::approach, pose_);
    move.is_cycle = is_cycle;
    move.in_contact = true;
    for (const Contact& c : contacts) move.contacts.push_back(contact_record(joint_, c));
    watch_(move);
  }

  const Joint& joint_;
  TreeMesh reference_;  // at the attitude
  GapQuery gap_;        // likewise
  double varus_rad_;
  const SearchOptions& options_;
  const Watch& watch_;
  NarrowPhase narrow_phase_;
  MovingPose pose_;
  double translation_step_mm_;
  double rotation_step_rad_;
  LastMotion last_motion_ = LastMotion::none;
  bool has_touched_ = false;
  std::vector<MovingPose> history_;
  std::optional<Gap> ahead_;  // at ahead_at_
  MovingPose ahead_at_;
  TrianglePair collision_hint_;
  double residual_mm_ = 0.0;
  int iteration_ = 0;
  int queries_ = 0;
};

}  // namespace

StepRecord find_stable_pose(const Joint& joint, const Attitude& attitude, const MovingPose& seed,
                            const SearchOptions& options, const Watch& watch)
{
  return Search(joint, attitude, seed, options, watch).run();
}

}  // namespace vrda
