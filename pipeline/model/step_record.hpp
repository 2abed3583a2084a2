/// Result of one motion step and trace of one search, passed between solve, sweep, journal, store and app.
/// Frame S and its units: model/frames.hpp.
#pragma once

#include <Eigen/Core>

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/fields.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"

namespace vrda::inline model {

enum class StepStatus : std::int8_t {
  pending = -1,         ///< not solved yet
  stable = 0,           ///< a stable pose
  no_contact = 1,       ///< no reference surface along Delta
  no_clearance = 2,     ///< no free pose along -Delta
  iteration_limit = 3,  ///< max_steps or max_iterations reached
  unbounded = 4,        ///< no equilibrium: slides off at any step size
  overlapping = 5,      ///< equilibrium found, but the check finds the meshes overlapping
};

/// As stored.
inline constexpr auto status_pending = static_cast<std::int8_t>(StepStatus::pending);
inline constexpr auto status_stable = static_cast<std::int8_t>(StepStatus::stable);

inline constexpr Named<StepStatus> step_status_names[] = {
    {StepStatus::pending, "pending", "not solved yet"},
    {StepStatus::stable, "stable", "stable pose found"},
    {StepStatus::no_contact, "no_contact",
     "no reference surface along Delta: the objects separated or never met"},
    {StepStatus::no_clearance, "no_clearance",
     "no collision-free pose within reach along -Delta: the objects stay interlocked"},
    {StepStatus::iteration_limit, "iteration_limit", "not converged within max_steps or max_iterations"},
    {StepStatus::unbounded, "unbounded",
     "no equilibrium: the loads push the moving object off the reference"},
    {StepStatus::overlapping, "overlapping",
     "equilibrium found, but the meshes overlap there: check their winding with vrda check"}};
constexpr const auto& names_of(StepStatus)
{
  return step_status_names;
}
inline constexpr auto all_step_statuses = values_in(step_status_names);

/// Kind of node in the seeding graph (solve/README.md). The values are those of the journal.
enum class StepKind : std::uint8_t {
  spine_probe = 0,  ///< trial in the search for the spine's cell; not in the motion model
  spine = 1,        ///< the spine's cell of a flexion
  row = 2,          ///< solved outward from the spine's cell
  /// Solved with varus free. `flexion` counts the flexions of the spine's path, `varus` the starts: the two
  /// chains, restarts, propagated solutions, small offsets (from 1000).
  free_spine = 3,
  band = 4,         ///< as free_spine with an extra moment about Delta; `varus` 0: against theta, 1: along it
  sample = 5,       ///< as free_spine with the uncertain inputs of one sample, whose number is `varus`
  alone_spine = 6,  ///< as free_spine without the prior of the job
  /// Without the prior, with an extra moment about Delta as `band`: measures the joint's own stiffness.
  prior_probe = 7,
  prior_level = 8,  ///< with the prior at the level of one estimation, whose number is `varus`
  /// A follower on the spine and in a row (solve/followers.hpp): `varus` is 64 times the number of the start,
  /// or the column, plus the follower's number; 63: the joint with the followers' reaction.
  follower_start = 9,
  follower = 10,
  sample_follower = 11,  ///< of a sample: `varus` is 64 times the number of the sample plus the follower's
};

inline constexpr Named<StepKind> step_kind_names[] = {{StepKind::spine_probe, "spine_probe"},
                                                      {StepKind::spine, "spine"},
                                                      {StepKind::row, "row"},
                                                      {StepKind::free_spine, "free_spine"},
                                                      {StepKind::band, "band"},
                                                      {StepKind::sample, "sample"},
                                                      {StepKind::alone_spine, "alone_spine"},
                                                      {StepKind::prior_probe, "prior_probe"},
                                                      {StepKind::prior_level, "prior_level"},
                                                      {StepKind::follower_start, "follower_start"},
                                                      {StepKind::follower, "follower"},
                                                      {StepKind::sample_follower, "sample_follower"}};
constexpr const auto& names_of(StepKind)
{
  return step_kind_names;
}
/// The kinds that a stability search can have; these have traces.
inline constexpr StepKind search_step_kinds[] = {StepKind::spine_probe, StepKind::spine, StepKind::row};

/// Indices into the grid's axes, except for the kinds with free varus. Ordered by kind, flexion, varus.
struct StepKey {
  StepKind kind = StepKind::row;
  std::int32_t flexion = 0;
  std::int32_t varus = 0;

  // clang-tidy 14 mistakes the generated comparison with 0 for a null pointer.
  auto operator<=>(const StepKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

/// One contact of the final pose.
struct ContactRecord {
  Eigen::Vector3d point_solver_mm = Eigen::Vector3d::Zero();  ///< on the reference's surface
  Eigen::Vector3d normal_solver = Eigen::Vector3d::Zero();    ///< unit, reaction on the moving object
  double distance_mm = 0.0;
  std::int32_t triangle_reference = -1;  ///< row of the reference's contact triangles
  std::int32_t triangle_moving = -1;     ///< row of the moving object's contact triangles
  std::int8_t compartment = 0;           ///< 0 none, 1 medial, 2 lateral
};

/// One contact force of an equilibrium, on the moving object: along_delta_n * normal / -normal.y.
struct ContactForce {
  Eigen::Vector3d point_solver_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_solver = Eigen::Vector3d::Zero();  ///< unit, y < 0
  double along_delta_n = 0.0;                               ///< above 0: its share of the push
  std::int32_t triangle_reference = -1;
  std::int32_t triangle_moving = -1;
  std::int8_t compartment = 0;  ///< 0 none, 1 medial, 2 lateral
};

/// Force balance of an equilibrium pose: its certificate. NaN where none was computed.
struct Balance {
  /// Ligament energy minus the work of the loads from zero coordinates.
  double energy_nmm = nan;
  /// Residual force along the free coordinates: Euclidean norm, moments divided by a lever of the moving
  /// object's size.
  double residual_n = nan;
  /// Gaps of the load-bearing features, weighted by their share of the load.
  double complementarity_mm = nan;
  double worst_gap_mm = nan;  ///< smallest signed gap of any feature
  /// Moments on the moving object that hold the attitude; positive towards more flexion and more varus (0
  /// where varus is free). About the images of both axes in S: -Rx(-varus) Z and X.
  double flexion_moment_nmm = nan;
  double varus_moment_nmm = nan;
  std::vector<ContactForce> forces;
};

/// Results of a step whose coordinates have roles of their own (coordinates.hpp).
struct CoordinateForces {
  double flexion_rad = 0.0;  ///< of the pose, about the axis of S
  /// Generalised force on the moving object that holds the coordinate, positive along it; N or N mm. NaN
  /// where the coordinate is free.
  std::array<double, n_joint_coordinates> holding{};
  /// Of a free coordinate: 1 if loads, fibres or contacts determine it, 0 if nothing does; else -1.
  std::array<std::int8_t, n_joint_coordinates> determined{-1, -1, -1, -1, -1, -1};
};

struct StepRecord {
  StepKey key;
  MovingPose pose;  ///< in S; the best pose so far where `status` is not stable
  StepStatus status = StepStatus::pending;
  std::int32_t iterations = 0;
  std::int32_t queries = 0;  ///< collision and gap queries
  double residual_mm = nan;  ///< last predicted translation
  /// Remaining directional gap of each compartment; NaN without facing surfaces.
  OfCompartments<double> gap_mm{nan, nan};
  OfCompartments<bool> is_in_contact{};
  bool theta_determined = false;
  std::vector<ContactRecord> contacts;
  double varus_rad = 0.0;  ///< solved where varus is free, else the attitude's
  Balance balance;         ///< of the equilibrium only
  std::optional<CoordinateForces> coordinates = std::nullopt;
};

// The fields of a record in the order of the journal (store/journal.hpp).

constexpr auto fields_of(const StepKey*)
{
  return std::tuple{Field{"kind", &StepKey::kind}, Field{"flexion", &StepKey::flexion},
                    Field{"varus", &StepKey::varus}};
}

constexpr auto fields_of(const MovingPose*)
{
  return std::tuple{Field{"translation", &MovingPose::translation_mm, unit::mm},
                    Field{"theta", &MovingPose::theta_rad, unit::radian}};
}

/// Of a contact or contact force, which differ in one measure.
template <typename Contact>
constexpr auto contact_fields(const Field<Contact, double>& measure)
{
  return std::tuple{Field{"point", &Contact::point_solver_mm, unit::mm},
                    Field{"normal", &Contact::normal_solver, unit::one},
                    measure,
                    Field{"triangle_reference", &Contact::triangle_reference},
                    Field{"triangle_moving", &Contact::triangle_moving},
                    Field{"compartment", &Contact::compartment}};
}
constexpr auto fields_of(const ContactRecord*)
{
  return contact_fields(Field{"distance", &ContactRecord::distance_mm, unit::mm});
}
constexpr auto fields_of(const ContactForce*)
{
  return contact_fields(Field{"along_delta", &ContactForce::along_delta_n, unit::n});
}

constexpr auto fields_of(const Balance*)
{
  return std::tuple{Field{"energy", &Balance::energy_nmm, unit::nmm},
                    // Not scaled: its moments are divided by a lever that scales by the same factor.
                    Field{"residual", &Balance::residual_n, unit::n},
                    Field{"complementarity", &Balance::complementarity_mm, unit::mm},
                    Field{"worst_gap", &Balance::worst_gap_mm, unit::mm},
                    Field{"flexion_moment", &Balance::flexion_moment_nmm, unit::nmm},
                    Field{"varus_moment", &Balance::varus_moment_nmm, unit::nmm},
                    Field{"forces", &Balance::forces}};
}

constexpr auto fields_of(const CoordinateForces*)
{
  return std::tuple{Field{"flexion", &CoordinateForces::flexion_rad, unit::radian},
                    Field{"holding", &CoordinateForces::holding},
                    Field{"determined", &CoordinateForces::determined}};
}

constexpr auto fields_of(const StepRecord*)
{
  using R = StepRecord;
  return std::tuple{Field{"key", &R::key},
                    Field{"pose", &R::pose},
                    Field{"status", &R::status},
                    Field{"iterations", &R::iterations},
                    Field{"queries", &R::queries},
                    Field{"residual", &R::residual_mm, unit::mm},
                    Field{"gap", &R::gap_mm, unit::mm},
                    Field{"is_in_contact", &R::is_in_contact},
                    Field{"theta_determined", &R::theta_determined},
                    Field{"varus", &R::varus_rad, unit::radian},
                    Field{"balance", &R::balance},
                    Field{"coordinates", &R::coordinates},
                    Field{"contacts", &R::contacts}};
}

/// Whether a value read from a journal can be used: numbers within the bounds of motion models. A pose may be
/// NaN (none was found) unless its record is stable.
bool is_sound(const MovingPose& pose);
bool is_sound(const CoordinateForces& forces);
bool is_sound(const StepRecord& record);

/// The record for a joint `factor` times as large: lengths, energies and moments are scaled; angles, forces,
/// counts and flags are unchanged.
StepRecord scaled(const StepRecord& record, double factor);

/// The values are those of the trace file and its journal.
enum class MoveKind : std::uint8_t {
  retreat = 0,    ///< against Delta, out of an overlap
  approach = 1,   ///< along Delta
  bisect = 2,     ///< a trial within the approach, rotation or translation recorded next
  rotate = 3,     ///< about Delta
  translate = 4,  ///< across Delta
  iterate = 5,    ///< a configuration accepted by the equilibrium, in contact
  trial = 6,      ///< a configuration rejected by the equilibrium
};

inline constexpr Named<MoveKind> move_kind_names[] = {
    {MoveKind::retreat, "retreat"}, {MoveKind::approach, "approach"},   {MoveKind::bisect, "bisect"},
    {MoveKind::rotate, "rotate"},   {MoveKind::translate, "translate"}, {MoveKind::iterate, "iterate"},
    {MoveKind::trial, "trial"}};
constexpr const auto& names_of(MoveKind)
{
  return move_kind_names;
}
inline constexpr auto all_move_kinds = values_in(move_kind_names);

/// One modelling step. Each iteration of a search has one move in contact: the approach that ends at the
/// contact. An iteration without an obstruction has no move. Of an equilibrium: a configuration.
struct SearchMove {
  std::int32_t iteration = 0;  ///< 0: the retreat from the seed, of an equilibrium the seed in contact
  MoveKind kind = MoveKind::approach;
  MovingPose pose;  ///< after the move; for a bisection, the trial pose
  /// Current value; for a search's move in contact, after cycle detection. Of an equilibrium both are its
  /// trust radius.
  double translation_step_mm = 0.0;
  double rotation_step_rad = 0.0;
  bool collides = false;                ///< a trial that was blocked
  bool is_cycle = false;                ///< equals an earlier pose in contact within both resolutions
  bool in_contact = false;              ///< the approach has ended, or the iterate was accepted
  std::vector<ContactRecord> contacts;  ///< for a move in contact: those that predict the next motion
};

/// Called for every move, in order.
using SearchObserver = std::function<void(const SearchMove&)>;

/// One search or equilibrium from seed to result.
struct SearchTrace {
  StepKey key;
  MovingPose seed;
  StepStatus status = StepStatus::pending;
  std::vector<SearchMove> moves;
};

constexpr auto fields_of(const SearchMove*)
{
  using M = SearchMove;
  return std::tuple{Field{"iteration", &M::iteration},
                    Field{"kind", &M::kind},
                    Field{"pose", &M::pose},
                    Field{"translation_step", &M::translation_step_mm, unit::mm},
                    Field{"rotation_step", &M::rotation_step_rad, unit::radian},
                    Field{"collides", &M::collides},
                    Field{"is_cycle", &M::is_cycle},
                    Field{"in_contact", &M::in_contact},
                    Field{"contacts", &M::contacts}};
}
constexpr auto fields_of(const SearchTrace*)
{
  return std::tuple{Field{"key", &SearchTrace::key}, Field{"seed", &SearchTrace::seed},
                    Field{"status", &SearchTrace::status}, Field{"moves", &SearchTrace::moves}};
}

/// Whether the key is that of a step with a search.
bool is_sound(const SearchTrace& trace);

// The settings of the stability search and of the equilibrium, in internal units.

enum class ContactPoints { exact, triangle_centre };
enum class ContactNormals { least_curvature, reference, moving };

/// Motions across and about Delta that a search does not make.
struct HeldMotions {
  bool x = false;
  bool z = false;
  bool theta = false;

  bool any_translation() const { return x || z; }
};

struct SearchOptions {
  double approach_step_mm = 5.0;
  double translation_step_mm = 1.0;
  double translation_resolution_mm = 0.1;
  double rotation_step_rad = rad_from_deg(1.0);
  double rotation_resolution_rad = rad_from_deg(0.1);
  ContactPoints points = ContactPoints::exact;
  ContactNormals normals = ContactNormals::least_curvature;
  int max_steps = 10000;
  HeldMotions held;
};

/// Settings of one equilibrium solve.
struct EquilibriumOptions {
  double tolerance_mm = 1e-4;  ///< convergence tolerance of the pose along Delta
  int max_iterations = 200;
  double contact_resolution_mm = 0.01;       ///< surfaces closer than this are in contact (/contacts, flags)
  double contact_stiffness_n_per_mm3 = 0.0;  ///< pressure over overlap of compliant contact; 0: exact contact
  double contact_thickness_mm = 4.0;         ///< of both layers: the largest overlap of compliant contact
};

/// Which of several equilibria of a flexion the motion takes.
enum class BranchRule {
  lowest,      ///< the one of lowest energy
  continuous,  ///< the path over flexion with the least sum of energies and penalties on change
};

/// Settings of the spine: the continuation path along flexion, with varus free, from which each row starts.
struct SpineOptions {
  int n_restarts = 4;              ///< additional starts at each flexion besides the two chains
  double band_moment_nmm = 500.0;  ///< extra moments about Delta for the theta band; 0: none
  BranchRule branch = BranchRule::lowest;
};

/// A force at a material point of the moving object and a moment on it; their opposites act on the reference.
struct AppliedLoad {
  /// The axes in which the load keeps its direction; all coincide at zero attitude and theta.
  BodyIndex frame = BodyIndex::world;
  Eigen::Vector3d force_n{0.0, 0.0, 0.0};     ///< axes of `frame`
  Eigen::Vector3d moment_nmm{0.0, 0.0, 0.0};  ///< right-handed, axes of `frame`
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};    ///< in the moving object's frame
};

/// A straight line of constant tension between both objects.
struct TensionLine {
  double tension_n = 0.0;
  Eigen::Vector3d reference_mm{0.0, 0.0, 0.0};  ///< in the reference's frame
  Eigen::Vector3d moving_mm{0.0, 0.0, 0.0};     ///< in the moving object's frame
};

/// A spring on the direction of a tendon as its body sees it: stiffness / 2 times the squared angle, about
/// the axis, from the rest direction to the line from a point of the moving object to one of the reference.
struct DirectionSpring {
  double stiffness_nmm = 0.0;                   ///< per rad
  Eigen::Vector3d reference_mm{0.0, 0.0, 0.0};  ///< in the reference's frame
  Eigen::Vector3d moving_mm{0.0, 0.0, 0.0};     ///< in the moving object's frame
  Eigen::Vector3d axis{0.0, 0.0, 1.0};          ///< unit, moving object's frame
  Eigen::Vector3d rest{0.0, -1.0, 0.0};         ///< moving object's frame, not parallel to the axis
};

/// Coordinates that a prior may hold (schemas/prior.md), as stored. `centre_anterior`: the rotation centre of
/// the reference, between the condyles of a prepared knee, along the moving object's anterior axis.
enum class PriorCoordinate : std::int8_t {
  varus = 0,
  internal = 1,
  anterior = 2,
  proximal = 3,
  lateral = 4,
  centre_anterior = 5
};
inline constexpr Named<PriorCoordinate> prior_coordinate_names[] = {
    {PriorCoordinate::varus, "varus", "varus, adduction positive"},
    {PriorCoordinate::internal, "internal", "internal rotation"},
    {PriorCoordinate::anterior, "anterior", "anterior translation of the moving body"},
    {PriorCoordinate::proximal, "proximal", "proximal translation of the moving body"},
    {PriorCoordinate::lateral, "lateral", "lateral translation of the moving body"},
    {PriorCoordinate::centre_anterior, "centre_anterior",
     "anterior position of the rotation centre on the moving body"}};
constexpr const auto& names_of(PriorCoordinate)
{
  return prior_coordinate_names;
}
inline constexpr auto all_prior_coordinates = values_in(prior_coordinate_names);
constexpr bool is_angle(PriorCoordinate coordinate)
{
  return coordinate == PriorCoordinate::varus || coordinate == PriorCoordinate::internal;
}

/// One [[prior]]: a spring from a coordinate to a published curve over flexion, mm and rad.
struct PriorTerm {
  PriorCoordinate coordinate = PriorCoordinate::internal;
  std::string shape;                       ///< name of the curve; "table" for numbers of the job
  std::vector<double> flexion_rad, value;  ///< linear between rows, constant beyond the ends
  double stiffness = 0.0;                  ///< N mm per rad or N per mm; with `has_factor` the least
  bool has_factor = false;                 ///< multiplied by the factor of each flexion (solve/prior.hpp)
  double times_own = 0.0;                  ///< of the one term that defines the factor, else 0
  double at_most_times = 1.0;              ///< largest factor
  std::optional<double> level;             ///< added to the curve; absent: estimated from the motion
  double shape_change = 0.0, level_change = 0.0;  ///< of a sample of an uncertain job
};

/// The curve of a term without its level, rad or mm.
double prior_value(const PriorTerm& term, double flexion_rad);

/// A spring of the potential: stiffness / 2 times the squared distance of the coordinate from the target.
struct CoordinateSpring {
  PriorCoordinate coordinate = PriorCoordinate::internal;
  double stiffness = 0.0;  ///< N mm per rad or N per mm
  double target = 0.0;     ///< rad or mm
};

/// Loads on the moving object at one flexion, in the solver frame S; frames of the objects are those in S at
/// zero attitude. The work of the constant (dead) load, the first four members, is
/// force . translation + moment_nmm * theta + varus_moment_nmm * varus + (point x force) . (Y theta + X
/// varus); the last term is the force's moment about the origin of S.
struct Loads {
  Eigen::Vector3d force_n{0.0, 20.0, 0.0};
  double moment_nmm = 0.0;        ///< about Delta, on theta
  double varus_moment_nmm = 0.0;  ///< on varus
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};
  std::vector<AppliedLoad> applied;
  std::vector<TensionLine> lines;
  std::vector<CoordinateSpring> springs;    ///< Delta must be +Y
  std::vector<DirectionSpring> directions;  ///< with CoordinateEquilibrium only
};

// Result of the independent check of a stable pose. The values are those of the motion model's
// `plausibility`.

enum class Plausibility : std::int8_t {
  not_judged = -1,       ///< no stable pose
  nothing_found = 0,     ///< the check found no objection
  nothing_ahead = 1,     ///< no surface along the push within the contact resolution
  unstable_balance = 2,  ///< the energy decreases both ways along one direction
  dislocated = 3,        ///< further from the neutral pose than the joint's size allows
  border_contact = 4,    ///< a contact at an edge where a surface ends
  overstrained = 5,      ///< beyond the strain or tension that ligaments bear
};

/// As stored.
inline constexpr auto plausibility_not_judged = static_cast<std::int8_t>(Plausibility::not_judged);

inline constexpr Named<Plausibility> plausibility_names[] = {
    {Plausibility::not_judged, "not_judged", "no stable pose, or not checked"},
    {Plausibility::nothing_found, "nothing_found", "the check found no objection to the pose"},
    {Plausibility::nothing_ahead, "nothing_ahead",
     "no surface along the push within the contact resolution, here or displaced sideways by it"},
    {Plausibility::unstable_balance, "unstable_balance",
     "the energy is lower one contact resolution away in both senses of one direction"},
    {Plausibility::dislocated, "dislocated",
     "further from the start pose in contact than half the joint's smallest width, or rotated by more than "
     "45 "
     "degrees (a knee) or 90; add ligaments, check side, axes and frame.origin, or narrow the grid"},
    {Plausibility::border_contact, "border_contact",
     "a contact at an edge where the mesh ends; use a mesh that covers more of the joint, or narrow the "
     "grid"},
    {Plausibility::overstrained, "overstrained",
     "a fibre's strain above 0.44 or a bundle's tension above 1730 N, where ligaments fail; check "
     "attachments "
     "and slack lengths, or narrow the grid"}};
constexpr const auto& names_of(Plausibility)
{
  return plausibility_names;
}
inline constexpr auto all_plausibilities = values_in(plausibility_names);
/// The values that make a pose doubtful.
inline constexpr Plausibility doubtful_plausibilities[] = {
    Plausibility::dislocated, Plausibility::border_contact, Plausibility::overstrained,
    Plausibility::nothing_ahead, Plausibility::unstable_balance};
inline bool is_doubtful(Plausibility plausibility)
{
  return plausibility > Plausibility::nothing_found;
}

}  // namespace vrda::inline model
