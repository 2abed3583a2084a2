/// Evaluation of smoothed surfaces between the attitudes of the grid.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

/// First and last value of an axis. An axis with one value has both equal and maps to 0.
struct AxisRange {
  double first_deg = 0.0;
  double last_deg = 0.0;
};

struct AxisRanges {
  AxisRange flexion, varus;
};

/// Ranges of axes with at least one value each.
AxisRanges axis_ranges(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg);

/// Largest degree of a surface; tables of this size are on the stack.
inline constexpr int max_smoothed_degree = 20;

/// Legendre polynomials at one point of [-1, 1] (or a little outside).
struct LegendreTable {
  double value[max_smoothed_degree + 1] = {};
};
/// `degree`: the highest that is needed.
LegendreTable legendre(double u, int degree);

/// Maps `x_deg` to [-1, 1]; 0 where the axis has one value.
double unit_coordinate(double x_deg, const AxisRange& range);

/// The value (mm, degrees for theta) of a surface at any attitude; outside the grid it extrapolates, with
/// large errors. Allocates nothing. `set` is the set of `surface`.
double evaluate(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges,
                double flexion_deg, double varus_deg);

// Bicubic Hermite interpolation of values at the nodes of an attitude grid.

/// One node with its slopes; all zero if it is unsolved.
template <std::size_t N>
struct HermiteNode {
  std::array<double, N> value{};       ///< mm, rad
  std::array<double, N> by_flexion{};  ///< derivative by flexion, per radian
  std::array<double, N> by_varus{};    ///< derivative by varus, per radian
  std::array<double, N> by_both{};     ///< mixed derivative, per radian squared
  bool is_solved = false;
};

/// N surfaces over one grid: 4 (pose), 1 (travel), 5 (pose and varus) or 6 (and flexion).
template <std::size_t N>
struct HermiteGrid {
  std::vector<double> flexion_rad;    ///< [n_flexion] ascending
  std::vector<double> varus_rad;      ///< [n_varus] ascending
  std::vector<HermiteNode<N>> nodes;  ///< [n_flexion * n_varus], varus runs fastest
};

/// Sets the slopes at the nodes from the parabola through a node and its solved neighbours: central with two
/// neighbours, one-sided next to a hole or an end, the chord with a single neighbour.
template <std::size_t N>
void set_slopes(HermiteGrid<N>& grid);

template <std::size_t N>
struct HermiteSample {
  std::array<double, N> values{};
  bool is_solved = false;  ///< false if a corner of the patch is unsolved; the numbers are then invalid
};

/// `attitude` must be within the axes. Exact at the nodes; allocates nothing.
template <std::size_t N>
HermiteSample<N> sample(const HermiteGrid<N>& grid, const Attitude& attitude);

// The surfaces of a motion model, raw and smoothed.

/// x, y, z of the moving object in world W (mm), and theta (rad, right-knee sign).
using PoseCoordinates = std::array<double, 4>;
/// The same, then varus (rad).
using PoseAndVarus = std::array<double, 5>;

using RawNode = HermiteNode<4>;
using RawSurfaces = HermiteGrid<4>;
using RawSample = HermiteSample<4>;

RawSurfaces raw_surfaces(const store::MotionModel& model);

/// One basis polynomial of a smoothed set with its coefficient in every surface.
template <std::size_t N>
struct SmoothedTerm {
  int flexion_degree = 0;
  int varus_degree = 0;
  std::array<double, N> coefficient{};  ///< mm, rad
};

/// Sum of coefficient P_i(u) P_j(v) as in store/motion.hpp, for all surfaces in one pass.
template <std::size_t N>
struct SmoothedTerms {
  store::AxisRanges ranges;
  int degree = 0;  ///< highest exponent
  std::vector<SmoothedTerm<N>> terms;
};

struct SmoothedSurfaces : SmoothedTerms<5> {
  bool has_varus = false;  ///< varus was free and has a surface; if false its coefficients are 0
};

SmoothedSurfaces smoothed_surfaces(const store::MotionModel& model, const store::SmoothedSet& set);

/// Value at `attitude`, which should be within the axes: of 5 or 6 surfaces. Allocates nothing.
template <std::size_t N>
std::array<double, N> evaluate(const SmoothedTerms<N>& surfaces, const Attitude& attitude);

// Poses of a joint at any attitude from one set of surfaces of a motion model.

enum class PoseStatus {
  solved,
  unsolved_cell,  ///< a cell around the attitude is unsolved; never for the set "degree_N"
};

inline constexpr Named<PoseStatus> pose_status_names[] = {{PoseStatus::solved, "solved"},
                                                          {PoseStatus::unsolved_cell, "unsolved_cell"}};
constexpr const auto& names_of(PoseStatus)
{
  return pose_status_names;
}

/// Poses of both objects. World W: origin at the rotation centre, canonical axes of the joint's own side. The
/// poses map stored (canonical, not recentred) vertices. Identity if not solved.
struct JointPose {
  Pose X_world_reference = Pose::Identity();
  Pose X_world_moving = Pose::Identity();
  Pose X_reference_moving = Pose::Identity();
  double theta_rad = 0.0;           ///< about Delta, right-knee sign
  Attitude attitude;                ///< evaluated attitude: the requested one, clamped
  double key = nan;                 ///< evaluated key; NaN unless the model is a sequence of frames
  bool is_flexion_clamped = false;  ///< or the key
  bool is_varus_clamped = false;    ///< also if the set has its own varus and another was requested
  PoseStatus status = PoseStatus::unsolved_cell;
  /// Bodies that follow the joint, by model::follower_row(); identity where they have no pose.
  std::array<Pose, model::most_followers> X_reference_follower = no_poses();
  std::array<bool, model::most_followers> has_follower{};

  Pose X_reference(BodyIndex body) const
  {
    return body == BodyIndex::reference ? Pose(Pose::Identity())
           : body == BodyIndex::moving  ? X_reference_moving
                                        : X_reference_follower.at(model::follower_row(body));
  }
  Pose X_world(BodyIndex body) const
  {
    return body == BodyIndex::moving ? X_world_moving : X_world_reference * X_reference(body);
  }
  /// A follower relative to the body of its coordinates; empty where it has no pose.
  std::optional<Pose> X_of(const FollowerRows& follower) const
  {
    const auto body = static_cast<BodyIndex>(follower.body_index);
    if (!has_follower.at(model::follower_row(body))) return std::nullopt;
    return X_reference(static_cast<BodyIndex>(follower.of)).inverse() * X_reference(body);
  }

 private:
  static std::array<Pose, model::most_followers> no_poses()
  {
    std::array<Pose, model::most_followers> none;
    none.fill(Pose::Identity());
    return none;
  }
};

/// Names of the sets that `Motion` accepts, smoothed ones first: "two_sided", which depends on flexion only;
/// smoothed sets by descending degree, each after its recontacted variant without overlaps and gaps
/// ("degree_6_recontacted", "degree_6", ...); then "raw"; last "zero_varus", which depends on flexion only.
std::vector<std::string> set_names(const store::MotionModel& model);

/// The motion that is shown, exported and reported if none is named, and why it is not the smoothed one: as
/// the model has it. The first of set_names without a reason if the model has none (a file before 1.10), or
/// one that it no longer contains.
store::DefaultMotion default_motion(const store::MotionModel& model);
/// `set`, or that of default_motion() if `set` is empty. Throws InputError naming `file` and --set if it is
/// not one of all_set_names(model).
std::string chosen_set(const store::MotionModel& model, const std::string& file, const std::string& set);

/// Of an uncertain job "quantile_0", "quantile_5", "quantile_50", "quantile_95" and "quantile_100", each the
/// motion over flexion of the sample with that rank in internal rotation; of other models none.
std::vector<std::string> quantile_set_names(const store::MotionModel& model);
/// The names of both, and "bones_alone" of a model with a prior: the motion over flexion without it.
std::vector<std::string> all_set_names(const store::MotionModel& model);

/// One set of a motion model, ready for evaluation. Copies the required data of the model.
class Motion {
 public:
  /// `set` must be one of all_set_names(model); the grids must have the size of the axes.
  Motion(const store::MotionModel& model, const std::string& set);
  /// `set` need not belong to the model; moved by its recontact travels, if it has any.
  Motion(const store::MotionModel& model, const store::SmoothedSet& set);

  /// The poses at `wanted` or at the nearest attitude of the measured range. Takes under a microsecond and
  /// allocates nothing. Not for a sequence of frames, nor are the functions of flexion below.
  JointPose at(const Attitude& wanted) const;

  /// Whether the model is a sequence of frames, whose poses depend on the key alone.
  bool is_sequence() const { return track_.has_value(); }
  /// Ascending keys of the frames and their name; empty unless it is a sequence.
  const std::vector<double>& keys() const { return keys_; }
  const std::string& key_name() const { return key_name_; }

  /// The poses of a sequence at `key` or at the nearest end. Between frames the six coordinates are cubic
  /// Hermite polynomials of the key, with slopes as those of the raw cells; at a frame they are its own.
  /// Allocates nothing.
  JointPose at_frame(double key) const;

  /// The key at a position counted in frames from 0, linear between two frames, clamped to the sequence.
  double key_at(double position) const;
  /// Its inverse.
  double position_of(double key) const;

  /// Delta at an evaluated pose, of a grid or a sequence. Unit vector, world W.
  Eigen::Vector3d delta_of(const JointPose& pose) const;

  /// The poses for `numbers` of the moving object at `attitude`, independent of the set.
  JointPose joint_pose(const Attitude& attitude, const PoseCoordinates& numbers) const;

  /// Varus at which the compartments are closest to balance: linear in flexion between the solved spine
  /// cells, constant beyond the first and last. Without spine cells, the measured varus nearest to 0. If the
  /// set has its own varus, that varus.
  double balanced_varus_rad(double flexion_rad) const;
  bool has_spine() const { return !spine_.empty(); }
  /// True if each flexion or frame has its own varus: varus was free, the set is "two_sided" or "zero_varus",
  /// or the model is a sequence of frames.
  bool is_varus_free() const { return track_ || !free_varus_.empty(); }

  /// The joint's own coordinates (Grood-Suntay) of a solved pose, if Delta differs from +Y at some flexion
  /// and so the attitude's angles and theta from the joint's.
  std::optional<ClinicalCoordinates> own_coordinates(const JointPose& pose) const;

  /// Unit vector, world W: linear between the rows of the push, constant beyond the ends, then normalised.
  Eigen::Vector3d delta(double flexion_rad) const;

  double first_flexion_rad() const { return raw_.flexion_rad.at(0); }
  double last_flexion_rad() const { return raw_.flexion_rad.at(raw_.flexion_rad.size() - 1); }
  double first_varus_rad() const { return first_varus_rad_; }
  double last_varus_rad() const { return last_varus_rad_; }

 private:
  struct Evaluation {
    Attitude attitude;
    PoseCoordinates numbers{};
    bool is_solved = false;
  };
  explicit Motion(const store::MotionModel& model);
  void set_varus_range();
  void use_smoothed(const store::MotionModel& model, const store::SmoothedSet& set, bool is_recontacted);
  HermiteGrid<1> travels(const store::GridD& travel_mm) const;
  void use_frames(const store::MotionModel& model);
  void use_flexion_table(const std::vector<double>& flexion_rad, const std::vector<std::int8_t>& state,
                         const PoseRows& table);
  Attitude clamped(const Attitude& wanted) const;
  Evaluation evaluation_at(const Attitude& attitude) const;
  Attitude with_set_varus(const Attitude& wanted) const;
  JointPose posed(const Evaluation& found, const Attitude& wanted) const;
  Evaluation smoothed_at(const Attitude& attitude) const;
  Evaluation flexion_table_at(const Attitude& attitude) const;
  Eigen::Vector3d delta_on(const std::vector<double>& axis, double x) const;
  Eigen::Matrix3d R_world_solver(const Eigen::Vector3d& delta) const;
  JointPose pose_along(const Eigen::Vector3d& delta, const Attitude& attitude,
                       const PoseCoordinates& numbers) const;
  void use_followers(const store::MotionModel& model);
  void use_smoothed_followers(const store::MotionModel& model, const store::SmoothedSet& set,
                              bool is_recontacted);
  // Of the sample at row `quantile` of band_probabilities.
  void use_sampled_followers(const store::UncertainMotion& samples, std::size_t quantile);
  // `at`: of a sequence its key instead of the flexion.
  void place_followers(const Attitude& at, JointPose& pose) const;

  // A body that follows the joint: its six coordinates over the cells, or those of a smoothed set.
  struct FollowerTrack {
    std::string name;
    BodyIndex body = model::follower_index(0), of = BodyIndex::reference;
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d delta = -Eigen::Vector3d::UnitX();
    HermiteGrid<6> coordinates;
    std::optional<SmoothedTerms<6>> smoothed;
    std::optional<HermiteGrid<1>> travel;  // along its Delta, mm
  };
  // False where it has no pose; X_of is relative to the body of its coordinates.
  bool place(const FollowerTrack& track, const Attitude& at, Pose& X_of) const;

  SolverFrame frame_;                    ///< at the first flexion
  Eigen::Matrix3d R_world_solver_;       ///< for frame_; orthogonal, a reflection for a left joint
  std::vector<Eigen::Vector3d> deltas_;  ///< one per flexion; empty if all equal that of frame_
  std::vector<Attitude> free_varus_;     ///< solved, by ascending flexion; empty if varus is an input
  double first_varus_rad_ = 0.0, last_varus_rad_ = 0.0;
  RawSurfaces raw_;                           ///< its axes are the measured range
  std::optional<SmoothedSurfaces> smoothed_;  ///< for "degree_N" and "degree_N_recontacted"
  std::optional<HermiteGrid<1>> travel_;      ///< along Delta, mm; for "degree_N_recontacted"
  std::optional<HermiteGrid<5>> by_flexion_;  ///< for "two_sided" and "zero_varus"
  std::vector<Attitude> spine_;               ///< solved spine cells by ascending flexion
  std::string key_name_;
  std::vector<double> keys_;
  /// Of a sequence: x, y, z, theta, varus, flexion over the key, on the axis that grids use for flexion.
  std::optional<HermiteGrid<6>> track_;
  std::vector<FollowerTrack> followers_;  ///< in the order in which they are solved
};

/// The motion of one sample of an uncertain job, of a set of quantile_set_names(model), as a table over the
/// model's flexions; `contact` is that of no pose where it is not stable. Empty for other sets.
std::optional<store::TwoSided> quantile_motion(const store::MotionModel& model, const std::string& set);

// Ligaments and names of a joint as they are drawn: by the player and in exported scenes. In: a motion
// model. Points in canonical axes of their body, mm.

/// Width of the object's contact parts relative to the plateau of a knee, 80 mm: the scale of markers.
double width_ratio(const Body& moving);

/// The name of a body on screen: of a knee "femur" and "tibia", otherwise the motion model's.
std::string displayed_name(const store::MotionModel& model, BodyIndex body);

/// A name midway between two points, one on each body or both on the same.
struct JointLabel {
  std::string text;
  BodyIndex first = BodyIndex::reference, second = BodyIndex::reference;
  Eigen::Vector3d first_mm = Eigen::Vector3d::Zero(), second_mm = Eigen::Vector3d::Zero();
};

/// Both bodies, each ligament (model::ligament_of: the bundles of one count as one) at the middle
/// of its fibres, and medial and lateral if the joint has compartments.
std::vector<JointLabel> joint_labels(const store::MotionModel& model);

/// The model's fibres; may be empty.
model::Ligaments ligaments_of(const store::MotionModel& model);

/// The fibres of a follower, from other bodies to it. Wraps on itself are on the moving body, the others on
/// the reference: as `sample_fibre_path` needs them with the other body in place of the reference.
model::Ligaments ligaments_of(const store::FollowerRows& follower);

/// The followers in the order in which they are solved.
std::vector<const store::FollowerRows*> in_order(const std::vector<store::FollowerRows>& followers);

}  // namespace vrda::store
