/// Gap and penetration of a motion at and between the attitudes of its model; travel of smoothed motions into
/// contact.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "contact/contacts.hpp"
#include "core/units.hpp"
#include "geometry/gap_query.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "model/mesh.hpp"
#include "model/step_record.hpp"
#include "solve/sweep.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Which test may classify a pose as free.
enum class OverlapTest {
  narrow_phase,  ///< only the narrow phase: independent of the queries that the equilibrium uses
  sweep,  ///< also the directional gap, if it finds no contact on the way from far below; ten times as fast
};

struct AuditScene;

/// Scenes of one joint, shared by its audits: models with other motions have the same bodies. Thread-safe.
class AuditScenes {
 public:
  /// `model` must outlive it. The first scene is made in `n_threads` threads.
  AuditScenes(const store::MotionModel& model, int n_threads) : model_(model), n_threads_(n_threads) {}
  /// `delta` in world W. That of the first call is kept.
  std::shared_ptr<const AuditScene> along(const Eigen::Vector3d& delta);

 private:
  std::shared_ptr<const AuditScene> made(const Eigen::Vector3d& delta, int n_threads) const;

  const store::MotionModel& model_;
  int n_threads_;
  std::mutex mutex_;
  std::shared_ptr<const AuditScene> first_;
};

/// Threads, and the scenes of the joint if other audits share them.
struct Measuring {
  Measuring(int threads, AuditScenes* shared = nullptr) : n_threads(threads), scenes(shared) {}
  int n_threads;
  AuditScenes* scenes;
};

/// Measures the motion `set` (one of set_names of store/motion.hpp) at the attitudes of the model's grid,
/// with each cell subdivided into `refine` (at least 1) parts per axis; for "two_sided", on its own axis, and
/// "zero_varus" only along flexion.
/// A sequence of frames is measured over its key. Followers are measured at the same poses against what they
/// touch.
/// Poses: the stored X_reference_moving for "raw" at the model's own attitudes, otherwise from Motion. At the
/// model's own attitudes `at_grid` tests every pose, between them the sweep if possible: both find the same
/// states, and gaps that differ by rounding. Same bits for any number of threads.
store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine,
                      const Measuring& with, OverlapTest at_grid = OverlapTest::narrow_phase);
/// The same without the followers.
store::AuditSet audit_joint(const store::MotionModel& model, const std::string& set, int refine,
                            const Measuring& with, OverlapTest at_grid);

/// An extreme value of an audit and its attitude.
struct AuditExtreme {
  double value_mm = 0.0;  ///< 0 (attitude meaningless) without any
  double flexion_deg = 0.0, varus_deg = 0.0;
  double key = nan;  ///< of a sequence of frames
};

struct AuditFigures {
  int n_poses = 0;
  int n_overlapping = 0;
  int n_nothing_ahead = 0;
  AuditExtreme largest_penetration;
  AuditExtreme largest_gap;          ///< of the free poses with a contact ahead
  double mean_gap_mm = 0.0;          ///< of the same poses
  double mean_penetration_mm = 0.0;  ///< of the overlapping poses
  store::TwoSidedFigures two_sided;  ///< of all poses, if the joint has compartments

  int n_free() const { return n_poses - n_overlapping - n_nothing_ahead; }
};

AuditFigures figures_of(const store::AuditSet& audit);
/// Of a follower of the audit.
AuditFigures figures_of(const store::AuditSet& audit, const store::FollowerAudit& follower);

/// How far the moving object goes from one frame of a sequence to the next; frames without a pose are
/// omitted.
struct FrameTravel {
  int n_steps = 0;
  double largest_mm = 0.0,
         mean_mm = 0.0;  ///< of the moving point that is at the rotation centre in the zero pose
  double largest_rad = 0.0, mean_rad = 0.0;  ///< about the helical axis
  double key_of_mm = nan, key_of_rad = nan;  ///< at which the largest steps end
};
FrameTravel frame_travel(const store::MotionModel& model);

/// Travel along Delta (mm, negative: retreat) from the smoothed pose of `set` into contact at every attitude
/// of the model's grid, also without a raw pose, since polynomials are defined everywhere. A free pose
/// advances to the next contact. An overlapping pose retreats by 0.1, 0.2, 0.4 mm ... until free and advances
/// from there. Stops contact_margin_mm before contact, so that nothing overlaps. NaN without a contact ahead.
/// Same bits for any number of threads. `set` need not belong to the model; its recontact_mm is ignored.
store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, const Measuring& with);

/// Sets recontact_mm of the set and of its followers; each of these along its own Delta.
void add_recontact(const store::MotionModel& model, store::SmoothedSet& set, const Measuring& with);

// Gap and penetration at one pose from meshes and poses only, independent of the solver's state.

/// Both objects of a motion model for one Delta, in S at zero attitude. Shared by all threads.
struct AuditScene {
  SolverFrame frame;
  geometry::LateTreeMesh reference, moving;
  geometry::GapTree reference_gap, moving_gap;
  /// Of the moving triangles of each compartment; empty without compartments.
  OfCompartments<geometry::GapTree> compartment_gap;

  bool has_compartments() const
  {
    return std::ranges::none_of(compartment_gap, &geometry::GapTree::is_empty);
  }
};

/// Expects contact meshes in canonical axes of the joint's own side. `compartment_of_triangle` is empty or
/// has one Compartment per moving triangle.
AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame,
                            const std::vector<std::int8_t>& compartment_of_triangle = {}, int n_threads = 1);

/// Signed travel along Delta until each compartment's first contact from below; negative: overlap. NaN where
/// the compartment faces nothing, the joint has none, or the pose is not a rotation about Delta alone.
using CompartmentGaps = OfCompartments<double>;

/// Measurement of one pose.
struct PoseAudit {
  bool is_overlapping = false;  ///< the narrow phase finds triangles with a common point
  double penetration_mm = 0.0;  ///< retreat along Delta until nothing overlaps; 0 if free
  double gap_mm = 0.0;  ///< travel along Delta to the next contact; infinite without one, 0 if overlapping
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
  OfCompartments<geometry::GapQuery> compartment_queries_;
  std::optional<geometry::GapQuery> tilted_query_;  ///< for a pose that is not a rotation about Delta alone
  Attitude attitude_;                               ///< attitude of the query
  MovingPose pose_;                                 ///< in S, at the placed attitude
  Pose X_zero_;                                     ///< moving to reference, S at zero attitude
  Eigen::Vector3d delta_zero_;                      ///< Delta there
  double radii_mm_ = 0.0;                           ///< of both objects about the origin of S
  double beneath_mm_ = 0.0;                         ///< no contact is possible this far back along Delta
  geometry::TrianglePair hint_;                     ///< the last overlapping pair
  std::vector<geometry::TrianglePair> noted_;       ///< pairs of the noted features
  std::optional<geometry::Gap> from_below_;         ///< of the placed pose
};

/// Cells of a sequence of frames with one Delta, whose poses are given. One thread.
class FrameMeter {
 public:
  /// `joint` must outlive it. Contacts are features of both bodies within `resolution_mm`.
  FrameMeter(const solve::Joint& joint, double resolution_mm);

  /// Signed travels along Delta until each compartment's first contact; NaN without compartments.
  CompartmentGaps gaps(const solve::SolverPosition& at);
  /// The stable cell of a frame: its contacts, and flags of the compartments by `gaps`.
  StepRecord record(std::int32_t frame, const solve::SolverPosition& at, const CompartmentGaps& gaps);

 private:
  const solve::Joint& joint_;
  double resolution_mm_;
  geometry::GapQuery whole_;
  OfCompartments<geometry::GapQuery> compartments_;
  contact::NarrowPhase narrow_phase_;
};

/// Distance along Delta at which a recontacted pose stops before contact. Poses and the narrow phase have
/// about 1e-12 mm of rounding each (coordinates of hundreds of mm through a few rotations); at a contact with
/// slope 1e-4 the surfaces still keep ten times that distance.
inline constexpr double contact_margin_mm = 1e-7;

/// `axis_deg` with each step divided into `refine` parts; its own values stay bitwise equal.
std::vector<double> refined(const std::vector<double>& axis_deg, int refine);

/// Calls `measure(row, meter)` once for every row of `deltas` (world W), from several threads, with a meter
/// for the row's Delta. `measure` must write to its row only. Rethrows its first exception.
void for_each_delta(const store::MotionModel& model, const std::vector<Eigen::Vector3d>& deltas,
                    const Measuring& with, const std::function<void(std::size_t, PoseMeter&)>& measure);

/// The same for every row of `flexion_deg`, with the motion's Delta there.
void for_each_row(const store::MotionModel& model, const store::Motion& motion,
                  const std::vector<double>& flexion_deg, const Measuring& with,
                  const std::function<void(std::size_t, PoseMeter&)>& measure);

// Independent check of the solved poses of a motion model.

/// One entry per cell of the grid.
struct PoseAssessment {
  store::GridB is_overlapping;            ///< 1 if the meshes of a stable pose overlap
  store::GridB plausibility;              ///< Plausibility; `not_judged` if not stable or overlapping
  std::vector<PoseAssessment> followers;  ///< of the model's followers, in its order
};

/// Measures every stable pose of the raw motion again (analysis/audit.hpp); the first of these that
/// applies: dislocated: beyond `bounds`. border_contact: a stored contact is within the contact resolution of
/// an edge that belongs to one triangle only, so that the surface ends there. overstrained: a fibre is
/// longer, or a bundle carries more tension, than ligaments bear: strain 0.44 and 1730 N, where anterior
/// cruciate ligaments of young adults failed (Noyes and Grood 1976, J Bone Joint Surg Am 58:1074). The last
/// two displace the pose by a contact resolution d to both sides: along X and Z of S, their diagonals,
/// rotation about Delta through the moving object's centre and, if varus was free, varus; angles are d over
/// half the object's larger horizontal extent. nothing_ahead: one of them has no contact within d along
/// Delta. unstable_balance: on both sides, after moving into contact, the energy of loads and ligaments is
/// lower than in the pose by more than the work of the push over d / 1000. Poses held by fibres without
/// contact are exempt from both.
/// Followers by the same rules along their own Delta, but: dislocated is one whose centre is further from the
/// box around what it touches than its own size, or which is rotated by more than 90 degrees about another
/// axis than that of its flexion; nothing is ahead of a displaced one only beyond four contact resolutions;
/// overstrained only by the strain, since tendons bear more tension; and the
/// balance is not judged, since the energy of a tendon's direction is not in the model.
/// `ligaments` are canonical. Same bits for any number of threads.
PoseAssessment assess_poses(const store::MotionModel& model, const model::Ligaments& ligaments,
                            const JointBounds& bounds, int n_threads);

/// Edges of one triangle only, per triangle: bit k is the edge from its corner k to the next.
std::vector<std::int8_t> boundary_edges(const Mesh& mesh);

/// Whether a point on triangle `t` is within `resolution_mm` of one of its boundary edges. `border`:
/// boundary_edges(mesh). False for a triangle outside the mesh.
bool is_at_border(const Mesh& mesh, const std::vector<std::int8_t>& border, std::int32_t t,
                  const Eigen::Vector3d& p_mm, double resolution_mm);

}  // namespace vrda::analysis
