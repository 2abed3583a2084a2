/// Gap and penetration at one pose, from meshes and poses alone: nothing of the solver's own state is
/// trusted.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "core/frames.hpp"
#include "motion/poses.hpp"
#include "proximity/gap_query.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Both objects as a motion model stores them, prepared for one Delta: in S at zero attitude. Shared by all
/// threads.
struct AuditScene {
  SolverFrame frame;
  TreeMesh reference, moving;
  GapTree reference_gap, moving_gap;
};

/// Of contact meshes in canonical axes of the joint's own side.
AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame);

/// One attitude measured.
struct PoseAudit {
  bool is_overlapping = false;  ///< the narrow phase finds triangles that share a point
  double penetration_mm = 0.0;  ///< travel back along Delta until nothing overlaps; 0 when free
  double gap_mm = 0.0;  ///< travel along Delta to the next touch; infinite when nothing is in the way, 0 when
                        ///< overlapping
};

/// Who may say that a pose is free.
enum class Judge {
  narrow_phase,  ///< it alone: evidence that owes nothing to the queries which the equilibrium solves with
  sweep,  ///< also the directional gap, where it brings the object from far below without any touch; ten
          ///< times as fast
};

/// One thread's measuring. What it keeps from pose to pose changes the time, never the answer.
/// Poses take stored moving vertices to stored reference vertices, as a motion model's X_reference_moving.
class PoseMeter {
 public:
  /// `scene` must outlive it.
  explicit PoseMeter(const AuditScene& scene);

  PoseAudit measure(const Attitude& attitude, const Pose& X_reference_moving, Judge judge);

  /// Signed travel along Delta into contact from `pose` (in S), near one that was measured: looks ahead from
  /// `range_mm` behind it; minus that where the objects overlap there too.
  double travel_near_mm(const Attitude& attitude, const MovingPose& pose, double range_mm);

  /// The pose measured last, in S; nothing where it turns not about Delta alone.
  std::optional<MovingPose> solver_pose() const;
  const AuditScene& scene() const { return scene_; }

  /// Signed travel along Delta from the pose into contact, short of it by `contact_margin_mm` (or, where that
  /// still overlaps, by a multiple): back to where it is free when the pose overlaps, on to the next touch
  /// when it is free. NaN where nothing is in the way.
  double travel_into_contact_mm(const Attitude& attitude, const Pose& X_reference_moving);

 private:
  void place(const Attitude& attitude, const Pose& X_reference_moving);
  void turn_reference(const Attitude& attitude);
  bool is_overlapping(double shift_mm, Judge judge);
  bool is_reached_from_below(double shift_mm);
  double touch_mm(double shift_mm);
  double retreat_mm();
  MovingPose shifted(double shift_mm) const;
  GapQuery& query() { return tilted_query_ ? *tilted_query_ : query_; }

  const AuditScene& scene_;
  NarrowPhase narrow_phase_;
  GapQuery query_;
  std::optional<GapQuery> tilted_query_;  ///< of a pose that turns not about Delta alone: a tree of its own
  Attitude attitude_;                     ///< of the query
  MovingPose pose_;                       ///< S, at the attitude placed
  Pose X_zero_;                           ///< moving to reference, S at zero attitude
  Eigen::Vector3d delta_zero_;            ///< Delta there
  double radii_mm_ = 0.0;                 ///< of both objects about the origin of S
  double beneath_mm_ = 0.0;               ///< so far back along Delta nothing can touch
  TrianglePair hint_;                     ///< the last pair found to overlap
};

/// How far short of contact a recontacted pose stops. Poses carry some 1e-12 mm of rounding (coordinates of
/// hundreds of mm through a few rotations), and a narrow phase as much; a contact that steep as 1e-4 still
/// keeps ten times that between the surfaces.
inline constexpr double contact_margin_mm = 1e-7;

/// `axis_deg` with each step cut into `refine` parts; its own values stay to the last bit.
std::vector<double> refined(const std::vector<double>& axis_deg, int refine);

/// Calls `measure(row, meter)` for every row of `flexion_deg`, each once, from `n_threads` threads; the meter
/// is that of the row's Delta. What `measure` writes must belong to its row. Its first exception is thrown
/// again.
void for_each_row(const MotionModel& model, const Motion& motion, const std::vector<double>& flexion_deg,
                  int n_threads, const std::function<void(std::size_t, PoseMeter&)>& measure);

}  // namespace vrda
