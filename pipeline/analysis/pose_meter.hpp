/// Gap and penetration at one pose from meshes and poses only, independent of the solver's state.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "model/frames.hpp"
#include "store/poses.hpp"
#include "geometry/gap_query.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Both objects of a motion model for one Delta, in S at zero attitude. Shared by all threads.
struct AuditScene {
  SolverFrame frame;
  geometry::TreeMesh reference, moving;
  geometry::GapTree reference_gap, moving_gap;
  geometry::GapTree medial_gap,
      lateral_gap;  ///< moving triangles of each compartment; empty without compartments
};

/// Expects contact meshes in canonical axes of the joint's own side. `compartment_of_triangle` is empty or
/// has one Compartment per moving triangle.
AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame,
                            const std::vector<std::int8_t>& compartment_of_triangle = {});

/// Signed travel along Delta until each compartment's first contact from below; negative: overlap. NaN where
/// the compartment faces nothing, the joint has none, or the pose is not a rotation about Delta alone.
struct CompartmentGaps {
  double medial_mm = nan, lateral_mm = nan;
};

/// Measurement of one pose.
struct PoseAudit {
  bool is_overlapping = false;  ///< the narrow phase finds triangles with a common point
  double penetration_mm = 0.0;  ///< retreat along Delta until nothing overlaps; 0 if free
  double gap_mm = 0.0;  ///< travel along Delta to the next contact; infinite without one, 0 if overlapping
};

/// Which test may classify a pose as free.
enum class OverlapTest {
  narrow_phase,  ///< only the narrow phase: independent of the queries that the equilibrium uses
  sweep,  ///< also the directional gap, if it finds no contact on the way from far below; ten times as fast
};

/// Measures poses in one thread. Its cached state affects the time, not the results.
/// Poses map stored moving vertices to stored reference vertices, like a motion model's X_reference_moving.
class PoseMeter {
 public:
  /// `scene` must outlive it.
  explicit PoseMeter(const AuditScene& scene);

  PoseAudit measure(const Attitude& attitude, const Pose& X_reference_moving, OverlapTest judge);

  /// Signed travel along Delta into contact from `pose` (in S), which must be near a measured pose. Searches
  /// from `range_mm` behind it; returns -range_mm if the objects also overlap there.
  double travel_near_mm(const Attitude& attitude, const MovingPose& pose, double range_mm);

  /// Remembers the features within `band_mm` of first contact at the measured pose, for bounds of poses near
  /// it.
  void note_features(double band_mm);
  /// Upper bound of travel_near_mm(), if it is at least -range_mm: from the noted features, without a query.
  double travel_near_bound_mm(const Attitude& attitude, const MovingPose& pose);

  /// The last measured pose, in S; empty if it is not a rotation about Delta alone.
  std::optional<MovingPose> solver_pose() const;
  const AuditScene& scene() const { return scene_; }

  CompartmentGaps compartment_gaps(const Attitude& attitude, const Pose& X_reference_moving);

  /// Signed travel along Delta from the pose into contact, minus `contact_margin_mm` (or a multiple if that
  /// still overlaps): an overlapping pose retreats until free, a free pose advances to the next contact. NaN
  /// without a contact ahead.
  double travel_into_contact_mm(const Attitude& attitude, const Pose& X_reference_moving);

 private:
  void place(const Attitude& attitude, const Pose& X_reference_moving);
  void turn_reference(const Attitude& attitude);
  bool is_overlapping(double shift_mm, OverlapTest judge);
  const geometry::Gap& first_from_below();
  bool is_reached_from_below(double shift_mm);
  double touch_mm(double shift_mm);
  double retreat_mm();
  MovingPose shifted(double shift_mm) const;
  geometry::GapQuery& query() { return tilted_query_ ? *tilted_query_ : query_; }

  const AuditScene& scene_;
  contact::NarrowPhase narrow_phase_;
  geometry::GapQuery query_;
  geometry::GapQuery medial_query_, lateral_query_;
  std::optional<geometry::GapQuery> tilted_query_;  ///< for a pose that is not a rotation about Delta alone
  Attitude attitude_;                                ///< attitude of the query
  MovingPose pose_;                                  ///< in S, at the placed attitude
  Pose X_zero_;                                      ///< moving to reference, S at zero attitude
  Eigen::Vector3d delta_zero_;                       ///< Delta there
  double radii_mm_ = 0.0;                            ///< of both objects about the origin of S
  double beneath_mm_ = 0.0;                          ///< no contact is possible this far back along Delta
  geometry::TrianglePair hint_;                     ///< the last overlapping pair
  std::vector<geometry::TrianglePair> noted_;       ///< pairs of the noted features
  std::optional<geometry::Gap> from_below_;         ///< of the placed pose
};

/// Distance along Delta at which a recontacted pose stops before contact. Poses and the narrow phase have
/// about 1e-12 mm of rounding each (coordinates of hundreds of mm through a few rotations); at a contact with
/// slope 1e-4 the surfaces still keep ten times that distance.
inline constexpr double contact_margin_mm = 1e-7;

/// `axis_deg` with each step divided into `refine` parts; its own values stay bitwise equal.
std::vector<double> refined(const std::vector<double>& axis_deg, int refine);

/// Calls `measure(row, meter)` once for every row of `deltas` (world W), from `n_threads` threads, with a
/// meter for the row's Delta. `measure` must write to its row only. Rethrows its first exception.
void for_each_delta(const store::MotionModel& model, const std::vector<Eigen::Vector3d>& deltas,
                    int n_threads, const std::function<void(std::size_t, PoseMeter&)>& measure);

/// Calls `measure(row, meter)` once for every row of `flexion_deg`, from `n_threads` threads, with a meter
/// for the row's Delta. `measure` must write to its row only. Rethrows its first exception.
void for_each_row(const store::MotionModel& model, const store::Motion& motion,
                  const std::vector<double>& flexion_deg, int n_threads,
                  const std::function<void(std::size_t, PoseMeter&)>& measure);

}  // namespace vrda::analysis
