#include "solve/compliant_contact.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.hpp"

namespace vrda::solve {
namespace {

constexpr double spacing_mm = 0.5;        // of the height map
constexpr std::int64_t point_stride = 2;  // columns from one point to the next: a contact of 60 mm2 has 60
// Passes at this spacing that smooth as much as DistanceField does with 1 mm.
constexpr int point_passes = 4 * geometry::surface_passes;
constexpr double area_mm2 = spacing_mm * spacing_mm * point_stride * point_stride;  // of a point, projected
constexpr std::int64_t tile_columns = 8;
// Area over projected area: steeper walls (76 degrees) bear no load along Delta, and heights there are vague.
constexpr double steepest = 4.0;

// The highest surface over a grid of columns along Delta.
struct HeightMap {
  std::array<std::int64_t, 2> first{};  // of x and z, in spacings
  std::array<std::int64_t, 3> n{1, 1, 1};
  std::vector<double> y_mm;
  std::vector<std::int32_t> triangle;  // -1: none

  std::size_t row_of(std::int64_t i, std::int64_t k) const { return static_cast<std::size_t>(k * n[0] + i); }
  bool is_covered(std::int64_t i, std::int64_t k) const
  {
    return i >= 0 && k >= 0 && i < n[0] && k < n[1] && triangle[row_of(i, k)] >= 0;
  }
  double x_mm(std::int64_t i) const { return spacing_mm * static_cast<double>(i + first[0]); }
  double z_mm(std::int64_t k) const { return spacing_mm * static_cast<double>(k + first[1]); }
};

std::int64_t above(double mm)
{
  return static_cast<std::int64_t>(std::ceil(mm / spacing_mm));
}
std::int64_t below(double mm)
{
  return static_cast<std::int64_t>(std::floor(mm / spacing_mm));
}

void add_triangle(HeightMap& map, const Mesh& mesh, Eigen::Index t)
{
  const geometry::Corners c = corners(mesh, t);
  const Eigen::Vector3d across = (c[1] - c[0]).cross(c[2] - c[0]);
  if (!(across.y() > 1e-6 * across.norm())) return;
  const geometry::Extent x = geometry::extent(c, 0), z = geometry::extent(c, 2);
  for (std::int64_t k = above(z.least) - map.first[1]; k <= below(z.most) - map.first[1]; ++k) {
    for (std::int64_t i = above(x.least) - map.first[0]; i <= below(x.most) - map.first[0]; ++i) {
      const Eigen::Vector3d at(map.x_mm(i), 0.0, map.z_mm(k));
      bool is_under = true;
      for (std::size_t e = 0; e < 3; ++e) {
        const Eigen::Vector3d edge = c[(e + 1) % 3] - c[e], to = at - c[e];
        is_under = is_under && edge.z() * to.x() - edge.x() * to.z() >= 0.0;
      }
      if (!is_under) continue;
      const Eigen::Vector3d to = at - c[0];
      const double y_mm = c[0].y() - (across.x() * to.x() + across.z() * to.z()) / across.y();
      const std::size_t row = map.row_of(i, k);
      if (map.triangle[row] >= 0 && map.y_mm[row] >= y_mm) continue;
      map.y_mm[row] = y_mm;
      map.triangle[row] = static_cast<std::int32_t>(t);
    }
  }
}

HeightMap height_map_of(const Mesh& mesh)
{
  const Box box = bounding_box(mesh);
  HeightMap map;
  map.first = {below(box.min_mm.x()), below(box.min_mm.z())};
  map.n = {above(box.max_mm.x()) - map.first[0] + 1, above(box.max_mm.z()) - map.first[1] + 1, 1};
  map.y_mm.assign(static_cast<std::size_t>(map.n[0] * map.n[1]), 0.0);
  map.triangle.assign(map.y_mm.size(), -1);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) add_triangle(map, mesh, t);
  // Smoothed by the mean of the columns that are covered.
  std::vector<double> weight(map.y_mm.size());
  for (std::size_t row = 0; row < weight.size(); ++row) weight[row] = map.triangle[row] >= 0 ? 1.0 : 0.0;
  for (int axis = 0; axis < 2; ++axis) {
    geometry::filter_binomially(map.y_mm, map.n, axis, point_passes);
    geometry::filter_binomially(weight, map.n, axis, point_passes);
  }
  for (std::size_t row = 0; row < weight.size(); ++row) {
    if (map.triangle[row] >= 0) map.y_mm[row] /= weight[row];
  }
  return map;
}

// Slope at a column from its neighbours that are covered.
double slope_of(const HeightMap& map, std::int64_t i, std::int64_t k, int axis)
{
  const std::int64_t di = axis == 0 ? 1 : 0, dk = 1 - di;
  const bool has_next = map.is_covered(i + di, k + dk), has_last = map.is_covered(i - di, k - dk);
  const double here = map.y_mm[map.row_of(i, k)];
  const double next = has_next ? map.y_mm[map.row_of(i + di, k + dk)] : here;
  const double last = has_last ? map.y_mm[map.row_of(i - di, k - dk)] : here;
  const int n = static_cast<int>(has_next) + static_cast<int>(has_last);
  return n == 0 ? 0.0 : (next - last) / (n * spacing_mm);
}

std::vector<CompliantSurfaces::Point> points_of(const Mesh& mesh, std::vector<CompliantSurfaces::Tile>& tiles)
{
  const HeightMap map = height_map_of(mesh);
  std::vector<CompliantSurfaces::Point> points;
  for (std::int64_t tile_k = 0; tile_k < map.n[1]; tile_k += tile_columns) {
    for (std::int64_t tile_i = 0; tile_i < map.n[0]; tile_i += tile_columns) {
      const std::size_t begin = points.size();
      for (std::int64_t k = tile_k; k < std::min(tile_k + tile_columns, map.n[1]); ++k) {
        for (std::int64_t i = tile_i; i < std::min(tile_i + tile_columns, map.n[0]); ++i) {
          // Every second column in space, so that a larger map has the same points.
          const bool is_point =
              (i + map.first[0]) % point_stride == 0 && (k + map.first[1]) % point_stride == 0;
          if (!is_point || !map.is_covered(i, k)) continue;
          const double sx = slope_of(map, i, k, 0), sz = slope_of(map, i, k, 1);
          const double stretch = std::sqrt(1.0 + sx * sx + sz * sz);
          if (stretch > steepest) continue;
          const std::int32_t triangle = map.triangle[map.row_of(i, k)];
          points.push_back({{map.x_mm(i), map.y_mm[map.row_of(i, k)], map.z_mm(k)},
                            stretch * area_mm2,
                            offset_mm(mesh, triangle),
                            triangle});
        }
      }
      if (points.size() == begin) continue;
      CompliantSurfaces::Tile tile{begin, points.size(), Eigen::Vector3d::Zero(), 0.0, 0.0};
      for (std::size_t p = begin; p < points.size(); ++p) tile.centre_mm += points[p].p_mm;
      tile.centre_mm /= static_cast<double>(points.size() - begin);
      for (std::size_t p = begin; p < points.size(); ++p) {
        tile.radius_mm = std::max(tile.radius_mm, (points[p].p_mm - tile.centre_mm).norm());
        tile.largest_offset_mm = std::max(tile.largest_offset_mm, points[p].offset_mm);
      }
      tiles.push_back(tile);
    }
  }
  return points;
}

// Rows of the reference without the far sides of thin layers. Which side is near is decided for the whole
// object, by the normals' components away from the axis of flexion where the moving object is near.
std::vector<Eigen::Index> near_side(const Mesh& mesh, const geometry::NearestSurface& surface,
                                    const geometry::NearestSurface& moving)
{
  constexpr double layer_mm = 6.0, reach_mm = 15.0, opposite = 0.5, far_side = -0.2;
  std::vector<double> outward(static_cast<std::size_t>(mesh.triangles.rows()), 1.0);
  double vote_mm2 = 0.0;
  std::vector<bool> is_thin(outward.size(), false);
  geometry::NearestLimits near;
  near.max_distance_mm = reach_mm;
  for (std::size_t row = 0; row < outward.size(); ++row) {
    const auto t = static_cast<Eigen::Index>(row);
    const auto [a, b, c] = corners(mesh, t);
    const Eigen::Vector3d centre_mm = (a + b + c) / 3.0, normal = face_normal(mesh, t);
    geometry::NearestLimits behind{layer_mm, opposite, -normal};
    const geometry::SurfacePoint back = surface.nearest(centre_mm, behind);
    is_thin[row] = back.triangle >= 0 && (back.p_mm - centre_mm).dot(normal) < 0.0;
    if (!is_thin[row]) continue;
    outward[row] = normal.dot(Eigen::Vector3d(centre_mm.x(), centre_mm.y(), 0.0).stableNormalized());
    const geometry::SurfacePoint from_front = moving.nearest(centre_mm, near);
    const geometry::SurfacePoint from_back = moving.nearest(back.p_mm, near);
    const bool is_front = from_front.triangle >= 0 &&
                          (from_back.triangle < 0 || from_front.distance_mm < from_back.distance_mm);
    if (is_front) vote_mm2 += (b - a).cross(c - a).norm() * outward[row];
  }
  std::vector<Eigen::Index> kept;
  for (std::size_t row = 0; row < outward.size(); ++row) {
    if (!is_thin[row] || (vote_mm2 < 0.0 ? -outward[row] : outward[row]) >= far_side)
      kept.push_back(static_cast<Eigen::Index>(row));
  }
  return kept;
}

geometry::DistanceField reference_field(const Joint& joint, const geometry::NearestSurface& surface,
                                        const std::vector<std::int32_t>& component)
{
  const Mesh& mesh = surface.mesh();
  const std::vector<Eigen::Index> kept =
      near_side(mesh, surface, geometry::NearestSurface(joint.moving.tree_mesh.mesh));
  std::vector<std::int32_t> of_kept;
  for (const Eigen::Index t : kept)
    if (!component.empty()) of_kept.push_back(component[static_cast<std::size_t>(t)]);
  return geometry::DistanceField(select_triangles(mesh, kept), of_kept);
}

// A point in contact: where it is and how deep.
struct Pressed {
  std::size_t row = 0;
  Eigen::Vector3d p_mm, arm_mm;  // S; arm from the pivot
  double overlap_mm = 0.0;
  Eigen::Vector3d gradient;  // of the distance, S
  Eigen::Matrix3d hessian_per_mm;
};

// Calls `visit(pressed)` for every point in contact, in the order of the points.
template <typename Visit>
void for_each_pressed(const FoundationState& state, const Visit& visit)
{
  const CompliantSurfaces& surfaces = state.surfaces;
  const Rotations rotations(state.configuration, state.flexion_rad);
  const Eigen::Matrix3d A = rotations.of_reference;
  // By columns: Eigen's products of a pose and of a matrix are calls.
  const Eigen::Matrix3d R = A.transpose() * rotations.of_moving;
  const Eigen::Vector3d Rx = R.col(0), Ry = R.col(1), Rz = R.col(2),
                        t_mm = A.transpose() *
                               (state.configuration.pivot_mm - rotations.of_moving * state.scale.pivot_mm);
  const auto in_reference = [&](const Eigen::Vector3d& p_mm) {
    return Eigen::Vector3d(Rx * p_mm.x() + Ry * p_mm.y() + Rz * p_mm.z() + t_mm);
  };
  for (const CompliantSurfaces::Tile& tile : surfaces.tiles) {
    if (surfaces.reference.bound_mm(in_reference(tile.centre_mm)) >
        tile.radius_mm + tile.largest_offset_mm + state.thicker_mm)
      continue;
    for (std::size_t row = tile.begin; row < tile.end; ++row) {
      const CompliantSurfaces::Point& point = surfaces.points[row];
      const Eigen::Vector3d p_reference_mm = in_reference(point.p_mm);
      const double offset_mm = point.offset_mm + state.thicker_mm;
      if (surfaces.reference.bound_mm(p_reference_mm) > offset_mm) continue;
      const geometry::DistanceField::Sample field = surfaces.reference.sample(p_reference_mm, offset_mm);
      Pressed at;
      at.overlap_mm = offset_mm - field.distance_mm;
      if (!(at.overlap_mm > 0.0)) continue;
      at.row = row;
      at.p_mm = A * p_reference_mm;
      at.arm_mm = at.p_mm - state.configuration.pivot_mm;
      at.gradient = A * field.gradient;
      at.hessian_per_mm = A * field.hessian_per_mm * A.transpose();
      visit(at);
    }
  }
}

}  // namespace

CompliantSurfaces::CompliantSurfaces(const Joint& joint, const std::vector<std::int32_t>& component)
    // Noise above the length of edges folds a surface, which then has no inside.
    : points(points_of(geometry::without_noise(joint.moving.tree_mesh.mesh), tiles)),
      reference_surface(geometry::without_noise(joint.reference.tree_mesh.mesh)),
      reference(reference_field(joint, reference_surface, component))
{
}

const CompliantSurfaces& LazyCompliantSurfaces::of(const Joint& joint) const
{
  std::call_once(flag_, [&] { surfaces_ = std::make_unique<const CompliantSurfaces>(joint, component_); });
  return *surfaces_;
}

Foundation foundation_at(const FoundationState& state, double stiffness_n_per_mm3)
{
  Foundation out;
  Potential& u = out.potential;
  for_each_pressed(state, [&](const Pressed& at) {
    const double weight = stiffness_n_per_mm3 * state.surfaces.points[at.row].area_mm2;
    // The point's velocities, as point_jacobian() with the pivot for the moving object's origin: the axes,
    // v = y x arm and w = x x p; written out, since this is where a solve spends its time.
    const Eigen::Vector3d &g = at.gradient, &arm = at.arm_mm, &p = at.p_mm;
    const Eigen::Vector3d v(arm.z(), 0.0, -arm.x()), w(0.0, -p.z(), p.y());
    const Eigen::Vector3d Hv = at.hessian_per_mm * v, Hw = at.hessian_per_mm * w;
    Vector5d slope;
    slope << g, g.dot(v), g.dot(w);
    Matrix5d curvature;
    curvature.topLeftCorner<3, 3>() = at.hessian_per_mm;
    curvature.col(about_y) << Hv, v.dot(Hv) - (g.x() * arm.x() + g.z() * arm.z()), 0.0;
    curvature.col(about_varus) << Hw.x(), Hw.y() + g.z(), Hw.z() - g.y(), v.dot(Hw) + g.y() * arm.x(),
        w.dot(Hw) - (g.y() * p.y() + g.z() * p.z());
    u.energy_nmm += 0.5 * weight * at.overlap_mm * at.overlap_mm;
    u.gradient -= weight * at.overlap_mm * slope;
    for (int column = 0; column < 5; ++column) {
      for (int row = 0; row <= column; ++row)
        u.hessian(row, column) +=
            weight * (slope(row) * slope(column) - at.overlap_mm * curvature(row, column));
    }
    out.deepest_mm = std::max(out.deepest_mm, at.overlap_mm);
  });
  u.hessian.triangularView<Eigen::StrictlyLower>() = u.hessian.transpose();
  return out;
}

std::array<PressureSum, 3> pressures_at(const FoundationState& state, double stiffness_n_per_mm3,
                                        const Joint& joint)
{
  std::array<PressureSum, 3> sums;
  for_each_pressed(state, [&](const Pressed& at) {
    const CompliantSurfaces::Point& point = state.surfaces.points[at.row];
    const auto& of_triangle = joint.compartment_of_triangle;
    const std::size_t compartment =
        of_triangle.empty() ? 0
                            : static_cast<std::size_t>(of_triangle[static_cast<std::size_t>(point.triangle)]);
    PressureSum& sum = sums.at(compartment);
    const double pressed_n = stiffness_n_per_mm3 * point.area_mm2 * at.overlap_mm;
    const Eigen::Vector3d force_n = pressed_n * at.gradient;
    sum.force_n += force_n;
    sum.moment_nmm += at.p_mm.cross(force_n);
    sum.weighted_point_nmm += pressed_n * at.p_mm;
    sum.pressed_n += pressed_n;
    sum.area_mm2 += point.area_mm2;
  });
  return sums;
}

// One step.

namespace {

constexpr double first_step_mm = 0.5, longest_step_mm = 2.0;
constexpr double shortest_step_mm = 1e-9;
constexpr double converged_share = 1e-7;  // of the push: residual force at the end
constexpr double certified_share = 1e-2;  // as for exact contact
constexpr double accepted_gain = 0.1, good_gain = 0.7, poor_gain = 0.25;  // of the predicted gain
constexpr double rounding_share = 1e-13;                                  // of an energy
// A saddle has a curvature below this, as a share of the push per mm.
constexpr double saddle_share_per_mm = 1e-3;
constexpr int max_seat_steps = 60;
constexpr double seat_share = 0.1;  // of the push: balance along Delta alone
// Smoothing and noise move a surface by some mm: a larger change of height is no recontact.
constexpr double recontact_mm = 6.0;
constexpr double first_bracket_rad = rad_from_deg(0.25), largest_bracket_rad = rad_from_deg(8.0);
constexpr double balanced_gap_mm = 1e-7;
constexpr int max_root_steps = 100;
constexpr double standoff_tolerances = 0.1;
constexpr double difference_rad = 1e-4;
constexpr double turn_rad = pi / 180.0, turn_cost_tolerances = 10.0;  // as for exact contact
constexpr double turned_share = 1e-6;
constexpr int max_turns = 50;
constexpr double same_mm = 0.01;            // an equilibrium that is known already
constexpr double same_energy_share = 1e-6;  // of the push times a mm

double push_of(const Loads& loads)
{
  return loads.force_n.norm() > 0.0 ? loads.force_n.norm() : 1.0;
}

}  // namespace

struct CompliantSolver::State {
  const Joint& joint;
  const model::Ligaments& ligaments;
  EquilibriumOptions options;
  RotationScale scale;
  const CompliantSurfaces& surfaces;
  geometry::GapQuery gap;
  OfCompartments<geometry::GapQuery> compartment_gap;
  contact::NarrowPhase narrow_phase;
};

class CompliantSolver::Run {
 public:
  Run(State& state, const EquilibriumSolver::Task& task, const SearchObserver& observer)
      : state_(state),
        task_(task),
        observer_(observer),
        forces_{state.ligaments, task.loads, state.scale, task.attitude.flexion_rad, nullptr, nullptr},
        push_n_(push_of(task.loads)),
        at_(configuration_at(task.seed, task.attitude.varus_rad, state.scale))
  {
    size_ << 1.0, 1.0, 1.0, 1.0 / state.scale.lever_mm, task.is_varus_free ? 1.0 / state.scale.lever_mm : 0.0;
  }

  StepRecord run()
  {
    n_queries_before_ = n_queries();
    StepRecord record;
    record.status = find_equilibrium();
    record.iterations = iteration_;
    record.residual_mm = step_mm_;
    record.pose = pose_at(at_, state_.scale);
    record.varus_rad = at_.varus_rad;
    if (record.status == StepStatus::stable) {
      if (const StepRecord* known = known_equilibrium()) {
        record = *known;
        record.iterations = iteration_;
        record.queries = 0;
      } else {
        fill_balance(record);
        recontact(record);
      }
    }
    if (observer_) report(record.pose);
    record.queries += n_queries() - n_queries_before_;
    return record;
  }

 private:
  int n_queries() const
  {
    return state_.gap.n_queries() + state_.compartment_gap[0].n_queries() +
           state_.compartment_gap[1].n_queries();
  }

  FoundationState foundation_state(const Configuration& at) const
  {
    return {state_.surfaces, at, state_.scale, task_.attitude.flexion_rad,
            state_.joint.thicker_than_compliant_mm};
  }

  Attitude attitude_at(double varus_rad) const { return {task_.attitude.flexion_rad, varus_rad}; }

  // Of foundation, fibres and loads.
  Foundation total(const Configuration& at) const
  {
    Foundation sum = foundation_at(foundation_state(at), state_.options.contact_stiffness_n_per_mm3);
    const Potential u = potential_at(forces_, at);
    sum.potential.energy_nmm += u.energy_nmm;
    sum.potential.gradient += u.gradient;
    sum.potential.hessian += u.hessian;
    return sum;
  }

  StepStatus find_equilibrium()
  {
    state_.gap.set_attitude(task_.attitude);
    const double travel_mm = state_.gap.travel_mm(task_.seed);
    if (!std::isfinite(travel_mm)) return StepStatus::no_contact;
    at_.pivot_mm.y() += travel_mm;
    std::optional<LoadPotential> applied;
    for (int turn = 0; turn < max_turns; ++turn) {
      const bool has_loads = !task_.loads.applied.empty() || !task_.loads.lines.empty();
      if (has_loads) {
        const LoadPotential turned =
            potential_near(task_.loads, attitude_at(at_.varus_rad), pose_at(at_, state_.scale));
        if (applied && change_n(turned, *applied) <= turned_share * push_n_) return StepStatus::stable;
        applied = turned;
        forces_.applied = &*applied;
      }
      if (turn == 0) seat();
      const StepStatus status = minimise();
      if (status != StepStatus::stable || !has_loads) return status;
    }
    return StepStatus::iteration_limit;
  }

  double change_n(const LoadPotential& a, const LoadPotential& b) const
  {
    const MovingPose pose = pose_at(at_, state_.scale);
    const Vector5d change = energy_of(a, attitude_at(at_.varus_rad), pose).gradient -
                            energy_of(b, attitude_at(at_.varus_rad), pose).gradient;
    return size_.cwiseProduct(change).norm();
  }

  // Balances the forces along Delta, the other coordinates held.
  void seat()
  {
    for (int k = 0; k < max_seat_steps; ++k) {
      const Potential u = total(at_).potential;
      const double slope_n = u.gradient(along_y), stiffness = u.hessian(along_y, along_y);
      if (std::abs(slope_n) <= seat_share * push_n_) return;
      const double most_mm = first_step_mm;
      const double newton_mm = stiffness > 0.0 ? std::abs(slope_n) / stiffness : most_mm;
      at_.pivot_mm.y() += (slope_n < 0.0 ? 1.0 : -1.0) * std::min(newton_mm, most_mm);
    }
  }

  StepStatus minimise()
  {
    end_ = total(at_);
    double radius_mm = first_step_mm;
    for (; iteration_ < state_.options.max_iterations; ++iteration_) {
      if (observer_) report(pose_at(at_, state_.scale));
      const Trial trial = step(end_.potential, radius_mm);
      step_mm_ = trial.length_mm;
      if (trial.is_converged || radius_mm < shortest_step_mm) break;
      const Configuration next = moved(at_, trial.step_mm, state_.scale);
      const Foundation there = total(next);
      const double here_nmm = end_.potential.energy_nmm, gain_nmm = here_nmm - there.potential.energy_nmm;
      const double rounding_nmm = rounding_share * (std::abs(here_nmm) + push_n_ * state_.scale.lever_mm);
      const double share = gain_nmm / trial.gain_nmm;
      const bool is_fall = trial.gain_nmm <= rounding_nmm
                               ? residual_n(there.potential) < residual_n(end_.potential)
                               : share > accepted_gain;
      if (share < poor_gain || !is_fall) radius_mm = 0.25 * trial.length_mm;
      if (share > good_gain && trial.length_mm > 0.8 * radius_mm)
        radius_mm = std::min(2.0 * radius_mm, longest_step_mm);
      if (!is_fall) continue;
      at_ = next;
      end_ = there;
    }
    if (residual_n(end_.potential) <= certified_share * push_n_) return StepStatus::stable;
    return end_.deepest_mm > 0.0 ? StepStatus::iteration_limit : StepStatus::unbounded;
  }

  double residual_n(const Potential& u) const { return size_.cwiseProduct(u.gradient).norm(); }

  struct Trial {
    Vector5d step_mm = Vector5d::Zero();
    double length_mm = 0.0;
    double gain_nmm = 0.0;  // predicted
    bool is_converged = false;
  };

  // The minimum of the second-order expansion within the radius. Source: More and Sorensen (1983), SIAM J Sci
  // Stat Comput 4:553-572; the shift of the eigenvalues is found by bisection.
  Trial step(const Potential& u, double radius_mm) const
  {
    const Vector5d g = size_.cwiseProduct(u.gradient);
    Matrix5d H = size_.asDiagonal() * u.hessian * size_.asDiagonal();
    for (Eigen::Index k = 0; k < n_coordinates; ++k)
      if (size_(k) == 0.0) H(k, k) = push_n_;
    const Eigen::SelfAdjointEigenSolver<Matrix5d> eigen(H);
    const Vector5d lambda = eigen.eigenvalues(), along = eigen.eigenvectors().transpose() * g;
    Trial trial;
    const bool is_saddle = lambda(0) < -saddle_share_per_mm * push_n_;
    trial.is_converged = g.norm() <= converged_share * push_n_ && !is_saddle;
    if (trial.is_converged) return trial;
    const double floor = 1e-9 * push_n_;
    const auto step_of = [&](double shift) {
      return Vector5d(-along.cwiseQuotient((lambda.array() + shift).max(floor).matrix()));
    };
    double low = std::max(0.0, floor - lambda(0)), high = low;
    Vector5d d = step_of(low);
    if (d.norm() > radius_mm) {
      high = low + g.norm() / radius_mm + floor;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (step_of(middle).norm() > radius_mm ? low : high) = middle;
      }
      d = step_of(high);
    }
    // At a saddle that the gradient does not leave.
    if (is_saddle && d.norm() < radius_mm)
      d(0) += std::copysign(std::sqrt(radius_mm * radius_mm - d.squaredNorm()), along(0) > 0.0 ? -1.0 : 1.0);
    trial.gain_nmm = -(along.dot(d) + 0.5 * d.dot(lambda.cwiseProduct(d)));
    trial.step_mm = eigen.eigenvectors() * d;
    trial.length_mm = d.norm();
    return trial;
  }

  const StepRecord* known_equilibrium() const
  {
    if (task_.known == nullptr) return nullptr;
    const MovingPose pose = pose_at(at_, state_.scale);
    const auto is_here = [&](const StepRecord& known) {
      Eigen::Vector3d apart = known.pose.translation_mm - pose.translation_mm;
      apart.y() = state_.scale.lever_mm * (known.pose.theta_rad - pose.theta_rad);
      return known.status == StepStatus::stable && apart.norm() <= same_mm &&
             std::abs(known.balance.energy_nmm - end_.potential.energy_nmm) <= same_energy_share * push_n_;
    };
    const auto found = std::find_if(task_.known->begin(), task_.known->end(), is_here);
    return found == task_.known->end() ? nullptr : &*found;
  }

  void report(const MovingPose& pose) const
  {
    SearchMove move;
    move.iteration = iteration_;
    move.kind = MoveKind::iterate;
    move.pose = pose;
    move.in_contact = true;
    observer_(move);
  }

  void fill_balance(StepRecord& record)
  {
    const std::array<PressureSum, 3> pressures =
        pressures_at(foundation_state(at_), state_.options.contact_stiffness_n_per_mm3, state_.joint);
    Balance& out = record.balance;
    out.energy_nmm = end_.potential.energy_nmm;
    out.residual_n = residual_n(end_.potential);
    out.varus_moment_nmm = task_.is_varus_free ? 0.0 : end_.potential.gradient(about_varus);
    out.flexion_moment_nmm = flexion_moment_nmm(pressures);
    for (std::size_t k = 0; k < pressures.size(); ++k) {
      bears_load_[k] = pressures[k].force_n.y() < 0.0;
      if (bears_load_[k]) out.forces.push_back(force_of(pressures[k], static_cast<std::int8_t>(k)));
    }
    // Turning by a degree costs the energy of the stiffness about Delta, the other coordinates free.
    Matrix5d H = size_.asDiagonal() * end_.potential.hessian * size_.asDiagonal();
    for (Eigen::Index k = 0; k < n_coordinates; ++k) H(k, k) += size_(k) == 0.0 ? push_n_ : 1e-9 * push_n_;
    const Vector5d turn = H.ldlt().solve(Vector5d(Vector5d::Unit(about_y)));
    const double compliance = turn(about_y);
    const double turn_mm = state_.scale.lever_mm * turn_rad;
    record.theta_determined =
        compliance > 0.0 &&
        0.5 * turn_mm * turn_mm / compliance > turn_cost_tolerances * state_.options.tolerance_mm * push_n_;
  }

  // The resultant of a compartment, at its centre of pressure on the reference.
  ContactForce force_of(const PressureSum& sum, std::int8_t compartment) const
  {
    const CompliantSurfaces& surfaces = state_.surfaces;
    const Rotations rotations(at_, task_.attitude.flexion_rad);
    Eigen::Vector3d centre_mm = sum.weighted_point_nmm / sum.pressed_n;
    const Eigen::Vector3d p_moving_mm =
        rotations.of_moving.transpose() * (centre_mm - at_.pivot_mm) + state_.scale.pivot_mm;
    const geometry::SurfacePoint on_reference =
        surfaces.reference_surface.nearest(rotations.of_reference.transpose() * centre_mm);
    ContactForce force;
    force.point_solver_mm = rotations.of_reference * on_reference.p_mm;
    force.normal_solver = sum.force_n.normalized();
    force.along_delta_n = -sum.force_n.y();
    force.triangle_reference = static_cast<std::int32_t>(on_reference.triangle);
    force.compartment = compartment;
    double least_mm2 = std::numeric_limits<double>::infinity();
    for (const CompliantSurfaces::Point& point : surfaces.points) {
      const double mm2 = (point.p_mm - p_moving_mm).squaredNorm();
      if (mm2 >= least_mm2 || compartment_of(point.triangle) != compartment) continue;
      least_mm2 = mm2;
      force.triangle_moving = point.triangle;
    }
    return force;
  }

  std::int8_t compartment_of(std::int32_t triangle) const
  {
    const auto& of = state_.joint.compartment_of_triangle;
    return of.empty() ? std::int8_t{0} : static_cast<std::int8_t>(of[static_cast<std::size_t>(triangle)]);
  }

  // As of exact contact: about the image of the flexion axis; fibres by central differences.
  double flexion_moment_nmm(const std::array<PressureSum, 3>& pressures) const
  {
    const Eigen::Vector3d axis = rotation_x(-at_.varus_rad) * Eigen::Vector3d::UnitZ();
    const Loads& loads = task_.loads;
    const MovingPose pose = pose_at(at_, state_.scale);
    Eigen::Vector3d moment_nmm =
        loads.point_mm.cross(loads.force_n) + loads.moment_nmm * Eigen::Vector3d::UnitY();
    if (forces_.applied != nullptr)
      moment_nmm += wrench_of(loads, attitude_at(at_.varus_rad), pose).moment_nmm;
    for (const PressureSum& sum : pressures) moment_nmm += sum.moment_nmm;
    const auto fibres_nmm = [&](double flexion_rad) {
      if (state_.ligaments.fibres.empty()) return 0.0;
      return model::ligament_energy(state_.ligaments, {flexion_rad, at_.varus_rad}, pose).energy_nmm;
    };
    const double flexion_rad = task_.attitude.flexion_rad;
    return axis.dot(moment_nmm) +
           (fibres_nmm(flexion_rad + difference_rad) - fibres_nmm(flexion_rad - difference_rad)) /
               (2.0 * difference_rad);
  }

  double imbalance_mm(const MovingPose& pose, double varus_rad)
  {
    const Attitude at = attitude_at(varus_rad);
    return state_.compartment_gap[0].gap_mm(at, pose) - state_.compartment_gap[1].gap_mm(at, pose);
  }

  // The varus at which both compartments touch together; else the given one.
  double balanced_varus_rad(const MovingPose& pose, double start_rad)
  {
    for (double reach_rad = first_bracket_rad; reach_rad <= largest_bracket_rad; reach_rad *= 2.0) {
      double a = start_rad - reach_rad, b = start_rad + reach_rad;
      double fa = imbalance_mm(pose, a), fb = imbalance_mm(pose, b);
      if (!(fa * fb < 0.0)) continue;
      // Regula falsi; an end that stays counts half (Illinois).
      double x = start_rad;
      for (int k = 0; k < max_root_steps; ++k) {
        x = k % 8 == 7 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
        const double fx = imbalance_mm(pose, x);
        if (std::abs(fx) <= balanced_gap_mm) break;
        if (fx * fb < 0.0) {
          a = b;
          fa = fb;
        } else {
          fa *= 0.5;
        }
        b = x;
        fb = fx;
      }
      return x;
    }
    return start_rad;
  }

  // Moves the pose out of the overlap, or down to contact, and measures it.
  void recontact(StepRecord& record)
  {
    const bool both_bear = bears_load_[1] && bears_load_[2];
    if (task_.is_varus_free && both_bear) record.varus_rad = balanced_varus_rad(record.pose, at_.varus_rad);
    state_.gap.set_attitude(attitude_at(record.varus_rad));
    const double travel_mm = state_.gap.travel_mm(record.pose);
    const double standoff_mm = standoff_tolerances * state_.options.tolerance_mm;
    const double thickness_mm = state_.options.contact_thickness_mm;
    if (!(std::abs(travel_mm) <= recontact_mm + thickness_mm) || end_.deepest_mm > thickness_mm) {
      record.status = StepStatus::unbounded;
      record.balance = {};
      record.theta_determined = false;
      return;
    }
    const bool is_lifted = !bears_load_[0] && !bears_load_[1] && !bears_load_[2];
    // Without contact fibres and loads hold the pose.
    const double moved_mm = is_lifted && travel_mm > standoff_mm ? 0.0 : travel_mm - standoff_mm;
    record.pose.translation_mm.y() += moved_mm;
    record.balance.worst_gap_mm = travel_mm - moved_mm;
    record.balance.complementarity_mm = is_lifted ? 0.0 : record.balance.worst_gap_mm;
    if (task_.is_measured) measure(record);
  }

  void measure(StepRecord& record)
  {
    const bool is_determined = record.theta_determined;
    const Attitude attitude = attitude_at(record.varus_rad);
    measure_contacts(state_.joint, attitude, state_.gap, state_.narrow_phase,
                     state_.options.contact_resolution_mm, record);
    record.theta_determined = is_determined;
    if (state_.joint.compartment_of_triangle.empty()) return;
    for (const Compartment side : all_compartments)
      record.gap_mm[side] = state_.compartment_gap[side].gap_mm(attitude, record.pose);
  }

  State& state_;
  const EquilibriumSolver::Task& task_;
  const SearchObserver& observer_;
  NonContactForces forces_;
  double push_n_;
  Configuration at_;
  Vector5d size_;   // of the coordinates in mm; 0 where held
  Foundation end_;  // with fibres and loads, at at_
  double step_mm_ = nan;
  std::array<bool, 3> bears_load_{};  // by Compartment
  int iteration_ = 0;
  int n_queries_before_ = 0;
};

CompliantSolver::CompliantSolver(const Joint& joint, const model::Ligaments& ligaments,
                                 const EquilibriumOptions& options)
    : state_(new State{joint,
                       ligaments,
                       options,
                       rotation_scale_of(joint.moving.tree_mesh.mesh),
                       joint.compliant->of(joint),
                       {joint.reference_gap, joint.moving_gap},
                       compartment_queries(joint.reference_gap, joint.compartment_gap),
                       {}})
{
}

CompliantSolver::~CompliantSolver() = default;

StepRecord CompliantSolver::solve(const EquilibriumSolver::Task& task, const SearchObserver& observer)
{
  return Run(*state_, task, observer).run();
}

}  // namespace vrda::solve
