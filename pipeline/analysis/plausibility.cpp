// Independent check of the solved poses of a motion model: borders, strain, stability of joint and followers.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "analysis/audit.hpp"
#include "analysis/follower_meter.hpp"
#include "core/text.hpp"
#include "geometry/nearest_surface.hpp"
#include "solve/potential.hpp"

namespace vrda::analysis {
namespace {

// Search range for the contact of a neighbouring pose, in resolutions: sufficient next to a wall of slope 4
// (76 degrees). Steeper ones are left to the narrow phase.
constexpr double range_resolutions = 4.0;
// Features of this band bound the travel after a step of one resolution on slopes up to 60 degrees.
constexpr double band_resolutions = 2.0;
// Far above the rounding of heights (about 1e-12 mm) and below the slope that the solvers treat as level:
// 1e-3 in the search (solve/stability_search.cpp).
constexpr double level_slope = 1e-3;

Eigen::Vector3d vector_at(const std::vector<double>& rows, std::size_t row)
{
  return {rows[3 * row], rows[3 * row + 1], rows[3 * row + 2]};
}

void add_applied(const store::LoadRows& rows, std::size_t flexion, const SolverFrame& frame, Loads& loads)
{
  for (std::size_t k = 0; k < rows.name.size(); ++k) {
    const std::size_t at = flexion * rows.name.size() + k;
    loads.applied.push_back(
        {static_cast<BodyIndex>(rows.frame[k] - 1), solver_translation_mm(frame, vector_at(rows.force_n, at)),
         solver_moment_nmm(frame, vector_at(rows.moment_nmm, at)),
         solver_translation_mm(frame, rows.point_mm.row(static_cast<Eigen::Index>(k)).transpose())});
  }
}

// Between the last point on the reference and the first on the moving object.
void add_lines(const store::LineRows& rows, std::size_t flexion, const SolverFrame& frame, Loads& loads)
{
  const std::size_t n_lines = rows.name.size();
  for (std::size_t p = 0; p + 1 < rows.point_line.size(); ++p) {
    const bool is_free_segment = rows.point_line[p] == rows.point_line[p + 1] && rows.point_body[p] == 0 &&
                                 rows.point_body[p + 1] == 1;
    if (!is_free_segment) continue;
    const auto row = static_cast<Eigen::Index>(p);
    loads.lines.push_back({rows.tension_n[flexion * n_lines + static_cast<std::size_t>(rows.point_line[p])],
                           solver_translation_mm(frame, rows.point_mm.row(row).transpose()),
                           solver_translation_mm(frame, rows.point_mm.row(row + 1).transpose())});
  }
}

Loads loads_of(const store::MotionModel& model, Eigen::Index flexion, const SolverFrame& frame)
{
  Loads loads;
  loads.force_n = Eigen::Vector3d::UnitY();  // the only load of the stability search
  if (!model.equilibrium) return loads;
  const auto row = static_cast<std::size_t>(flexion);
  loads.force_n = solver_translation_mm(frame, model.push.force_n.row(flexion).transpose());
  loads.point_mm = solver_translation_mm(frame, model.push.point_mm);
  loads.moment_nmm = model.push.moment_nmm[row];
  loads.varus_moment_nmm = model.push.varus_moment_nmm[row];
  if (model.push.loads) add_applied(*model.push.loads, row, frame, loads);
  if (model.push.lines) add_lines(*model.push.lines, row, frame, loads);
  return loads;
}

// Unit steps along what the solver leaves free; a step back is the other side.
std::vector<Vector5d> free_directions(bool is_varus_free)
{
  const double half = std::sqrt(0.5);
  std::vector<Vector5d> directions(4, Vector5d::Zero());
  directions[0](along_x) = 1.0;
  directions[1](along_z) = 1.0;
  directions[2](along_x) = directions[2](along_z) = half;
  directions[3](along_x) = half;
  directions[3](along_z) = -half;
  directions.push_back(Vector5d::Unit(about_y));
  if (is_varus_free) directions.push_back(Vector5d::Unit(about_varus));
  return directions;
}

// Failure of an anterior cruciate ligament (Noyes and Grood 1976).
constexpr double largest_strain = 0.44;
constexpr double largest_bundle_n = 1730.0;

/// The edges at which the surfaces of both objects end.
struct Borders {
  std::vector<std::int8_t> reference, moving;
};

// A line of constant tension has no strain.
bool has_overlong_fibre(const store::LigamentRows& rows, std::size_t cell)
{
  const std::size_t n = rows.name.size();
  for (std::size_t k = 0; k < n; ++k) {
    const bool is_line = !rows.constant_tension_n.empty() && rows.constant_tension_n[k] > 0.0;
    if (!is_line && rows.strain[cell * n + k] > largest_strain) return true;
  }
  return false;
}

bool is_overstrained(const store::LigamentRows& rows, std::size_t cell)
{
  const std::size_t n = rows.name.size();
  if (has_overlong_fibre(rows, cell)) return true;
  std::map<std::string, double> bundle_n;
  for (std::size_t k = 0; k < n; ++k) {
    double& tension_n = bundle_n[rows.bundle[k]];
    tension_n += rows.tension_n[cell * n + k];
    if (tension_n > largest_bundle_n) return true;
  }
  return false;
}

/// A configuration and its travel along Delta into contact.
struct ContactTravel {
  solve::Configuration configuration;
  double travel_mm = 0.0;
};

PoseAssessment nothing_judged(const store::GridB& status)
{
  return {store::GridB::Zero(status.rows(), status.cols()),
          store::GridB::Constant(status.rows(), status.cols(), plausibility_not_judged),
          {}};
}

/// Assesses the stable poses of one row of the grid.
class RowAssessor {
 public:
  RowAssessor(const store::MotionModel& model, Eigen::Index flexion, const model::Ligaments& canonical,
              const JointBounds& bounds, const Borders& borders, PoseMeter& meter)
      : model_(model),
        flexion_(flexion),
        bounds_(bounds),
        borders_(borders),
        meter_(meter),
        resolution_mm_(model.contact_resolution_mm),
        rotation_scale_(solve::rotation_scale_of(meter.scene().moving.mesh())),
        ligaments_(model::solver_ligaments(canonical, meter.scene().frame)),
        loads_(loads_of(model, flexion, meter.scene().frame)),
        forces_{ligaments_, loads_, rotation_scale_,
                rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)])}
  {
    if (!loads_.applied.empty() || !loads_.lines.empty()) forces_.applied = &applied_;
  }

  void assess(Eigen::Index varus, bool is_varus_free, PoseAssessment& verdicts)
  {
    const Attitude attitude{forces_.flexion_rad, rad_from_deg(model_.varus_solved_deg(flexion_, varus))};
    const std::size_t cell = static_cast<std::size_t>(flexion_ * model_.status.cols() + varus);
    const PoseAudit found =
        meter_.measure(attitude, store::pose_in(model_.X_reference_moving, cell), OverlapTest::sweep);
    verdicts.is_overlapping(flexion_, varus) = found.is_overlapping ? 1 : 0;
    if (found.is_overlapping) return;
    verdicts.plausibility(flexion_, varus) =
        static_cast<std::int8_t>(plausibility_of(cell, attitude, found.gap_mm, is_varus_free));
  }

 private:
  Plausibility plausibility_of(std::size_t cell, const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (pose && !is_within(bounds_, meter_.scene().frame, *pose)) return Plausibility::dislocated;
    if (pose && has_border_contact(cell, attitude, *pose)) return Plausibility::border_contact;
    if (model_.ligaments && is_overstrained(*model_.ligaments, cell)) return Plausibility::overstrained;
    if (!is_held_by_contact(cell)) return Plausibility::nothing_found;
    if (gap_mm > resolution_mm_) return Plausibility::nothing_ahead;
    return neighbour_plausibility(attitude, gap_mm, is_varus_free);
  }

  bool has_border_contact(std::size_t cell, const Attitude& attitude, const MovingPose& pose) const
  {
    const AuditScene& scene = meter_.scene();
    const store::ContactRows& rows = model_.contacts;
    const Eigen::Matrix3d R_reference_solver = reference_rotation(attitude).transpose();
    const Pose X_moving_solver = pose_of(pose).inverse();
    for (std::int64_t i = rows.row_start[cell]; i < rows.row_start[cell + 1]; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Eigen::Vector3d p_mm = solver_translation_mm(scene.frame, rows.point_world_mm.row(i).transpose());
      // The moving surface is at most the contact's distance away from the point, and where they overlap
      // either of these surfaces (inward_limit) is.
      const double inside_mm = std::max(0.0, -rows.distance_mm[k]);
      if (is_at_border(scene.reference.mesh(), borders_.reference, rows.triangle_reference[k],
                       R_reference_solver * p_mm, resolution_mm_ + inside_mm) ||
          is_at_border(scene.moving.mesh(), borders_.moving, rows.triangle_moving[k], X_moving_solver * p_mm,
                       resolution_mm_ + std::abs(rows.distance_mm[k])))
        return true;
    }
    return false;
  }

  bool is_held_by_contact(std::size_t cell) const
  {
    if (!model_.equilibrium) return true;
    const std::vector<std::int64_t>& row_start = model_.equilibrium->forces.row_start;
    return row_start[cell + 1] > row_start[cell];
  }

  Plausibility neighbour_plausibility(const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (!pose) return Plausibility::nothing_found;
    const solve::Configuration here = solve::configuration_at(*pose, attitude.varus_rad, rotation_scale_);
    const ContactTravel start{here, gap_mm};
    // About this pose, of whose neighbours the energies are compared.
    applied_ = solve::potential_near(loads_, attitude, *pose);
    meter_.note_features(band_resolutions * resolution_mm_);
    for (const Vector5d& direction : free_directions(is_varus_free)) {
      if (is_clearly_held(start, direction)) continue;
      const ContactTravel one =
          contact_travel(solve::moved(here, resolution_mm_ * direction, rotation_scale_));
      const ContactTravel other =
          contact_travel(solve::moved(here, -resolution_mm_ * direction, rotation_scale_));
      const double furthest_mm = std::max(one.travel_mm, other.travel_mm);
      if (std::isfinite(furthest_mm) && is_lower_both_ways(start, one, other))
        return Plausibility::unstable_balance;
      if (furthest_mm > resolution_mm_) return Plausibility::nothing_ahead;
    }
    return Plausibility::nothing_found;
  }

  // By upper bounds of both travels: most directions of most poses need no query.
  bool is_clearly_held(const ContactTravel& start, const Vector5d& direction)
  {
    double sum_mm = 0.0;
    for (const double side : {1.0, -1.0}) {
      const solve::Configuration aside =
          solve::moved(start.configuration, side * resolution_mm_ * direction, rotation_scale_);
      const double bound_mm = meter_.travel_near_bound_mm({forces_.flexion_rad, aside.varus_rad},
                                                          solve::pose_at(aside, rotation_scale_));
      if (!(bound_mm <= resolution_mm_) || bound_mm < -range_resolutions * resolution_mm_) return false;
      sum_mm += bound_mm;
    }
    return is_level(start.travel_mm, sum_mm);
  }

  // In equilibrium the slope along the path is 0, so only its curvature can lower the energy on both sides.
  bool is_level(double start_mm, double sum_mm) const
  {
    return sum_mm - 2.0 * start_mm <= 2.0 * level_slope * resolution_mm_;
  }

  ContactTravel contact_travel(const solve::Configuration& configuration)
  {
    return {configuration, meter_.travel_near_mm({forces_.flexion_rad, configuration.varus_rad},
                                                 solve::pose_at(configuration, rotation_scale_),
                                                 range_resolutions * resolution_mm_)};
  }

  bool is_lower_both_ways(const ContactTravel& start, const ContactTravel& one,
                          const ContactTravel& other) const
  {
    if (is_level(start.travel_mm, one.travel_mm + other.travel_mm)) return false;
    const double least_nmm = energy_nmm(start) - level_slope * resolution_mm_ * loads_.force_n.norm();
    return energy_nmm(one) < least_nmm && energy_nmm(other) < least_nmm;
  }

  double energy_nmm(const ContactTravel& travel) const
  {
    solve::Configuration configuration = travel.configuration;
    configuration.pivot_mm.y() += travel.travel_mm;
    return solve::potential_at(forces_, configuration).energy_nmm;
  }

  const store::MotionModel& model_;
  Eigen::Index flexion_;
  const JointBounds& bounds_;
  const Borders& borders_;
  PoseMeter& meter_;
  double resolution_mm_;
  solve::RotationScale rotation_scale_;
  model::Ligaments ligaments_;
  Loads loads_;
  solve::LoadPotential applied_;
  solve::NonContactForces forces_;
};

/// Assesses the stable poses of one follower.
class FollowerAssessor {
 public:
  FollowerAssessor(const store::MotionModel& model, const store::FollowerRows& rows)
      : model_(model),
        rows_(rows),
        motion_(model, "raw"),
        borders_{boundary_edges(FollowerMeter::touched(model, rows, {})),
                 boundary_edges(rows.body.contact.mesh)},
        scale_(solve::rotation_scale_of(rows.body.contact.mesh))
  {
    int part = 0;
    for (const solve::TouchedBody& touched : FollowerMeter::touched_bodies(model, rows)) {
      for (const Mesh* mesh : {&touched.body->contact.mesh, &touched.body->visual.mesh}) {
        if (mesh == &touched.body->visual.mesh && !touched.has_drawn) continue;
        part_.insert(part_.end(), static_cast<std::size_t>(mesh->triangles.rows()), part++);
      }
    }
  }

  PoseAssessment assessed(int n_threads) const
  {
    PoseAssessment found = nothing_judged(rows_.status);
    for_each_follower_row(model_, rows_, model_.flexion_deg.size(), n_threads,
                          [&](std::size_t row, FollowerMeter& meter) {
                            for (Eigen::Index j = 0; j < rows_.status.cols(); ++j) {
                              const auto i = static_cast<Eigen::Index>(row);
                              if (rows_.status(i, j) == status_stable) assess(i, j, meter, found);
                            }
                          });
    return found;
  }

 private:
  void assess(Eigen::Index i, Eigen::Index j, FollowerMeter& meter, PoseAssessment& found) const
  {
    const auto cell = static_cast<std::size_t>(i * rows_.status.cols() + j);
    const store::JointPose pose =
        motion_.is_sequence() ? motion_.at_frame(model_.frames->key[static_cast<std::size_t>(i)])
                              : motion_.at({rad_from_deg(model_.flexion_deg[static_cast<std::size_t>(i)]),
                                            rad_from_deg(model_.varus_solved_deg(i, j))});
    const Pose X_of = store::pose_in(rows_.X_of_follower, cell);
    const PoseAudit measured = meter.measure(pose, X_of, OverlapTest::sweep);
    found.is_overlapping(i, j) = measured.is_overlapping ? 1 : 0;
    if (!measured.is_overlapping)
      found.plausibility(i, j) =
          static_cast<std::int8_t>(plausibility_of(cell, pose, X_of, measured.gap_mm, meter));
  }

  Plausibility plausibility_of(std::size_t cell, const store::JointPose& pose, const Pose& X_of,
                               double gap_mm, FollowerMeter& meter) const
  {
    const Mesh touched = FollowerMeter::touched(model_, rows_, pose);
    if (is_dislocated(cell, X_of, touched)) return Plausibility::dislocated;
    if (has_border_contact(cell, X_of, touched)) return Plausibility::border_contact;
    if (rows_.ligaments && has_overlong_fibre(*rows_.ligaments, cell)) return Plausibility::overstrained;
    if (rows_.forces.row_start[cell + 1] == rows_.forces.row_start[cell]) return Plausibility::nothing_found;
    const bool is_held =
        gap_mm <= model_.contact_resolution_mm && is_held_aside(meter.attitude_of(X_of), meter);
    return is_held ? Plausibility::nothing_found : Plausibility::nothing_ahead;
  }

  bool is_dislocated(std::size_t cell, const Pose& X_of, const Mesh& touched) const
  {
    constexpr double most_deg = 90.0;
    for (const auto about : {JointCoordinate::varus, JointCoordinate::internal})
      if (std::abs(rows_.coordinates[about].data()[cell]) > most_deg) return true;
    const Box box = bounding_box(touched), own = bounding_box(rows_.body.contact.mesh);
    const Eigen::Array3d centre_mm = (X_of * rows_.centre_mm).array();
    const double beyond_mm = (box.min_mm.array() - centre_mm).max(centre_mm - box.max_mm.array()).maxCoeff();
    return beyond_mm > (own.max_mm - own.min_mm).maxCoeff();
  }

  bool has_border_contact(std::size_t cell, const Pose& X_of, const Mesh& touched) const
  {
    const store::ForceRows& rows = rows_.forces;
    const Pose X_own = X_of.inverse();
    for (std::int64_t k = rows.row_start[cell]; k < rows.row_start[cell + 1]; ++k) {
      const auto row = static_cast<std::size_t>(k);
      const Eigen::Vector3d p_mm = rows.point_world_mm.row(k).transpose();
      const std::int32_t t = rows.triangle_reference[row];
      if ((is_at_border(touched, borders_.reference, t, p_mm, model_.contact_resolution_mm) &&
           !is_continued(touched, t, p_mm)) ||
          is_at_border(rows_.body.contact.mesh, borders_.moving, rows.triangle_moving[row], X_own * p_mm,
                       model_.contact_resolution_mm))
        return true;
    }
    return false;
  }

  // Whether another part of what it touches is there, as the bone beside cartilage.
  bool is_continued(const Mesh& touched, std::int32_t t, const Eigen::Vector3d& p_mm) const
  {
    for (Eigen::Index other = 0; other < touched.triangles.rows(); ++other) {
      if (part_[static_cast<std::size_t>(other)] == part_[static_cast<std::size_t>(t)]) continue;
      if ((geometry::nearest_in_triangle(p_mm, corners(touched, other)) - p_mm).norm() <=
          model_.contact_resolution_mm)
        return true;
    }
    return false;
  }

  // Whether a surface is ahead, displaced by a resolution to both sides, as for the joint. Fibres hold a
  // follower against one steep facet too, so only a slope of more than 76 degrees counts as none.
  bool is_held_aside(const Attitude& attitude, FollowerMeter& by) const
  {
    PoseMeter& meter = by.meter();
    const std::optional<MovingPose> pose = meter.solver_pose();
    if (!pose) return true;
    const double resolution_mm = model_.contact_resolution_mm;
    const double range_mm = range_resolutions * resolution_mm;
    const solve::Configuration here = solve::configuration_at(*pose, attitude.varus_rad, scale_);
    for (const Vector5d& direction : free_directions(true)) {
      for (const double side : {1.0, -1.0}) {
        const solve::Configuration aside = solve::moved(here, side * resolution_mm * direction, scale_);
        if (meter.travel_near_mm({attitude.flexion_rad, aside.varus_rad}, solve::pose_at(aside, scale_),
                                 range_mm) > range_mm)
          return false;
      }
    }
    return true;
  }

  const store::MotionModel& model_;
  const store::FollowerRows& rows_;
  store::Motion motion_;
  Borders borders_;
  solve::RotationScale scale_;
  std::vector<int> part_;  // of each triangle of what it touches
};

}  // namespace

PoseAssessment assess_poses(const store::MotionModel& model, const model::Ligaments& ligaments,
                            const JointBounds& bounds, int n_threads)
{
  const store::Motion motion(model, "raw");
  PoseAssessment verdicts = nothing_judged(model.status);
  const Borders borders{boundary_edges(model.reference.contact.mesh),
                        boundary_edges(model.moving.contact.mesh)};
  std::vector<Eigen::Vector3d> deltas;
  for (Eigen::Index i = 0; i < model.push.delta.rows(); ++i)
    deltas.emplace_back(model.push.delta.row(i).transpose());
  for_each_delta(model, deltas, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    RowAssessor assessor(model, i, ligaments, bounds, borders, meter);
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      if (model.status(i, j) == status_stable) assessor.assess(j, motion.is_varus_free(), verdicts);
    }
  });
  for (const store::FollowerRows& rows : model.followers)
    verdicts.followers.push_back(FollowerAssessor(model, rows).assessed(n_threads));
  return verdicts;
}

// Where the surface of a mesh ends.

std::vector<std::int8_t> boundary_edges(const Mesh& mesh)
{
  struct Side {
    std::int32_t first, second;  // sorted vertices
    Eigen::Index triangle;
    int corner;
  };
  std::vector<Side> sides;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto [first, second] = std::minmax(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3));
      sides.push_back({first, second, t, k});
    }
  }
  const auto edge = [](const Side& s) { return std::pair(s.first, s.second); };
  std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) { return edge(a) < edge(b); });
  std::vector<std::int8_t> bits(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool is_shared = (i > 0 && edge(sides[i - 1]) == edge(sides[i])) ||
                           (i + 1 < sides.size() && edge(sides[i]) == edge(sides[i + 1]));
    if (!is_shared)
      bits[static_cast<std::size_t>(sides[i].triangle)] |= static_cast<std::int8_t>(1 << sides[i].corner);
  }
  return bits;
}

namespace {

double distance_to_segment_mm(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  const Eigen::Vector3d along = b - a;
  const double length_sq = along.squaredNorm();
  const double share = length_sq > 0.0 ? std::clamp((p - a).dot(along) / length_sq, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

}  // namespace

bool is_at_border(const Mesh& mesh, const std::vector<std::int8_t>& border, std::int32_t t,
                  const Eigen::Vector3d& p_mm, double resolution_mm)
{
  // Writing the model refuses a row outside the mesh, which only a damaged journal has.
  if (t < 0 || static_cast<std::size_t>(t) >= border.size()) return false;
  const int bits = border[static_cast<std::size_t>(t)];
  for (int k = 0; k < 3; ++k) {
    if ((bits >> k & 1) == 0) continue;
    const Eigen::Vector3d a = mesh.vertices_mm.row(mesh.triangles(t, k)).transpose();
    const Eigen::Vector3d b = mesh.vertices_mm.row(mesh.triangles(t, (k + 1) % 3)).transpose();
    if (distance_to_segment_mm(p_mm, a, b) <= resolution_mm) return true;
  }
  return false;
}

}  // namespace vrda::analysis
