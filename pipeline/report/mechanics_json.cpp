// The report's data about contacts, loads, fibres and outlines as JSON, rounded for the page.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model/clinical.hpp"
#include "model/mesh.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "report/clinical_curve.hpp"
#include "report/model_json.hpp"
#include "store/solved_cells.hpp"

namespace vrda::report {

Json short_number(double value)
{
  if (!std::isfinite(value)) return nullptr;
  constexpr double per_unit = 1e6;
  return std::round(value * per_unit) / per_unit;
}

Json short_numbers(const std::vector<double>& values)
{
  Json list = Json::array();
  for (const double value : values) list.push_back(short_number(value));
  return list;
}

Json short_grid(const store::GridD& grid)
{
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < grid.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < grid.cols(); ++j) row.push_back(short_number(grid(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json short_rows(const std::vector<double>& values, std::size_t width)
{
  Json rows = Json::array();
  for (std::size_t begin = 0; begin + width <= values.size(); begin += width) {
    Json row = Json::array();
    for (std::size_t k = begin; k < begin + width; ++k) row.push_back(short_number(values[k]));
    rows.push_back(std::move(row));
  }
  return rows;
}

namespace {

using Point = Eigen::Vector2d;
struct Edge {
  Point a, b;
};

double cross(const Point& a, const Point& b)
{
  return a.x() * b.y() - a.y() * b.x();
}

bool is_included(const std::array<Eigen::Vector3d, 3>& corner, const OutlineOptions& options)
{
  return std::all_of(corner.begin(), corner.end(), [&](const Eigen::Vector3d& p) {
    return p.y() >= options.from_mm && p.y() <= options.to_mm;
  });
}

std::vector<Edge> edges_of(const Mesh& mesh, const OutlineOptions& options)
{
  std::vector<Edge> edges;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const std::array<Eigen::Vector3d, 3> corner = corners(mesh, t);
    if (!is_included(corner, options)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = corner[k];
      const Eigen::Vector3d& b = corner[(k + 1) % 3];
      edges.push_back({{a.x(), a.z()}, {b.x(), b.z()}});
    }
  }
  return edges;
}

Point middle_of(const std::vector<Edge>& edges)
{
  Point least = edges.front().a, largest = edges.front().a;
  for (const Edge& edge : edges) {
    least = least.cwiseMin(edge.a);
    largest = largest.cwiseMax(edge.a);
  }
  return 0.5 * (least + largest);
}

// Distance from `middle` along `direction` to the crossing with the edge; negative without one.
double crossing_mm(const Edge& edge, const Point& middle, const Point& direction)
{
  const Point a = edge.a - middle, b = edge.b - middle;
  const double side_a = cross(direction, a), side_b = cross(direction, b);
  if ((side_a > 0.0) == (side_b > 0.0)) return -1.0;
  const double fraction = side_a / (side_a - side_b);
  return direction.dot(a + fraction * (b - a));
}

}  // namespace

std::vector<Eigen::Vector2d> projected_outline(const Mesh& mesh, const OutlineOptions& options)
{
  const std::vector<Edge> edges = edges_of(mesh, options);
  if (edges.empty()) return {};
  const Point middle = middle_of(edges);
  std::vector<Point> rim;
  for (int k = 0; k < options.n_directions; ++k) {
    const SinCos angle = sin_cos(2.0 * pi * k / options.n_directions);
    const Point direction(angle.cos, angle.sin);
    double farthest_mm = 0.0;
    for (const Edge& edge : edges) farthest_mm = std::max(farthest_mm, crossing_mm(edge, middle, direction));
    if (farthest_mm > 0.0) rim.push_back(middle + farthest_mm * direction);
  }
  return rim;
}

namespace {

// Added to the heights of the contacts: includes the rim of a body, but not its shaft.
constexpr double rim_mm = 12.0;

/// [n_flexion, 3] of the spine's cells.
std::vector<double> along_spine(const store::MotionModel& model, const std::vector<double>& cells)
{
  std::vector<double> rows;
  for (const Eigen::Index cell : solved_spine(model)) {
    for (std::size_t k = 0; k < 3; ++k)
      rows.push_back(cell < 0 ? nan : cells[3 * static_cast<std::size_t>(cell) + k]);
  }
  return rows;
}

struct Path {
  const char* compartment;
  std::vector<double> reference_mm, moving_mm;  ///< [n_flexion, 3]
};

std::vector<Path> paths_of(const store::MotionModel& model)
{
  if (model.zero_varus && !model.zero_varus->medial_reference_mm.empty()) {
    const store::ZeroVarus& z = *model.zero_varus;
    return {{"medial", z.medial_reference_mm, z.medial_moving_mm},
            {"lateral", z.lateral_reference_mm, z.lateral_moving_mm}};
  }
  if (!model.contact_paths) return {};
  const store::ContactPaths& c = *model.contact_paths;
  return {{"medial", along_spine(model, c.medial_reference_mm), along_spine(model, c.medial_moving_mm)},
          {"lateral", along_spine(model, c.lateral_reference_mm), along_spine(model, c.lateral_moving_mm)}};
}

/// Extends the height range (canonical Y) to include the points.
void include_heights(const std::vector<double>& points, OutlineOptions& heights)
{
  for (std::size_t k = 1; k < points.size(); k += 3) {
    if (!std::isfinite(points[k])) continue;
    heights.from_mm = std::min(heights.from_mm, points[k]);
    heights.to_mm = std::max(heights.to_mm, points[k]);
  }
}

Json outline_json(const Mesh& mesh, OutlineOptions heights)
{
  Json list = Json::array();
  if (!(heights.from_mm <= heights.to_mm)) return list;
  heights.from_mm -= rim_mm;
  heights.to_mm += rim_mm;
  for (const Eigen::Vector2d& p : projected_outline(mesh, heights))
    list.push_back(Json::array({short_number(p.x()), short_number(p.y())}));
  return list;
}

Mesh whole_mesh(const Body& body)
{
  Mesh mesh = body.contact.mesh;
  append(mesh, body.visual.mesh);
  return mesh;
}

/// Force along Delta of one cell by compartment: none, medial, lateral.
std::array<double, 3> forces_of_cell(const store::ForceRows& forces, Eigen::Index cell)
{
  if (cell < 0) return {nan, nan, nan};
  std::array<double, 3> sums{};
  const auto c = static_cast<std::size_t>(cell);
  for (std::int64_t k = forces.row_start[c]; k < forces.row_start[c + 1]; ++k) {
    const auto row = static_cast<std::size_t>(k);
    sums[static_cast<std::size_t>(forces.compartment[row])] += forces.along_delta_n[row];
  }
  return sums;
}

/// The fibres of one bundle.
struct Bundle {
  std::string name;
  std::vector<std::size_t> fibres;
};

std::vector<Bundle> bundles_of(const store::LigamentRows& ligaments)
{
  std::vector<Bundle> bundles;
  for (std::size_t f = 0; f < ligaments.bundle.size(); ++f) {
    const auto same = std::find_if(bundles.begin(), bundles.end(),
                                   [&](const Bundle& b) { return b.name == ligaments.bundle[f]; });
    Bundle& bundle = same == bundles.end() ? bundles.emplace_back(Bundle{ligaments.bundle[f], {}}) : *same;
    bundle.fibres.push_back(f);
  }
  return bundles;
}

Json bundle_json(const store::LigamentRows& ligaments, const Bundle& bundle,
                 const std::vector<Eigen::Index>& spine)
{
  const std::size_t n_fibres = ligaments.name.size();
  std::vector<double> strain, tension_n;
  for (const Eigen::Index cell : spine) {
    double most = nan, sum_n = cell < 0 ? nan : 0.0;
    for (const std::size_t fibre : bundle.fibres) {
      if (cell < 0) break;
      const std::size_t k = static_cast<std::size_t>(cell) * n_fibres + fibre;
      if (!(ligaments.strain[k] <= most)) most = ligaments.strain[k];
      sum_n += ligaments.tension_n[k];
    }
    strain.push_back(most);
    tension_n.push_back(sum_n);
  }
  return {{"name", bundle.name},
          {"n_fibres", bundle.fibres.size()},
          {"largest_strain", short_numbers(strain)},
          {"tension_n", short_numbers(tension_n)}};
}

}  // namespace

Json contact_paths_json(const store::MotionModel& model)
{
  OutlineOptions reference, moving;
  reference.from_mm = moving.from_mm = std::numeric_limits<double>::infinity();
  reference.to_mm = moving.to_mm = -std::numeric_limits<double>::infinity();
  Json compartments = Json::array();
  for (const Path& path : paths_of(model)) {
    include_heights(path.reference_mm, reference);
    include_heights(path.moving_mm, moving);
    compartments.push_back({{"name", path.compartment},
                            {"reference", short_rows(path.reference_mm, 3)},
                            {"moving", short_rows(path.moving_mm, 3)}});
  }
  if (compartments.empty()) return nullptr;
  return {{"compartments", compartments},
          {"outline_reference", outline_json(whole_mesh(model.reference), reference)},
          {"outline_moving", outline_json(whole_mesh(model.moving), moving)}};
}

namespace {

/// Rows of coordinates minus those of a point.
std::vector<double> from_point(std::vector<double> rows, const Eigen::VectorXd& point_mm)
{
  const auto width = static_cast<std::size_t>(point_mm.size());
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] -= point_mm[static_cast<Eigen::Index>(k % width)];
  return rows;
}

}  // namespace

Json axes_json(const store::MotionModel& model)
{
  if (!model.zero_varus) return nullptr;
  const store::ZeroVarus& z = *model.zero_varus;
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  return {{"rotation_deg", short_numbers(z.helical_rotation_deg)},
          {"translation_mm", short_numbers(z.helical_translation_mm)},
          {"direction", short_rows(z.helical_direction, 3)},
          {"point_mm", short_rows(from_point(z.helical_point_mm, centre_mm), 3)},
          {"instant_centre_mm", short_rows(from_point(z.instant_centre_mm, centre_mm.head<2>()), 2)},
          {"medial_rolling_mm", short_numbers(z.medial_rolling_mm)},
          {"medial_sliding_mm", short_numbers(z.medial_sliding_mm)},
          {"lateral_rolling_mm", short_numbers(z.lateral_rolling_mm)},
          {"lateral_sliding_mm", short_numbers(z.lateral_sliding_mm)}};
}

Json forces_json(const store::MotionModel& model)
{
  if (!model.equilibrium) return nullptr;
  std::array<std::vector<double>, 3> sums;
  for (const Eigen::Index cell : solved_spine(model)) {
    const std::array<double, 3> of_cell = forces_of_cell(model.equilibrium->forces, cell);
    for (std::size_t k = 0; k < 3; ++k) sums[k].push_back(of_cell[k]);
  }
  return {{"none_n", short_numbers(sums[static_cast<std::size_t>(Compartment::none)])},
          {"medial_n", short_numbers(sums[static_cast<std::size_t>(Compartment::medial)])},
          {"lateral_n", short_numbers(sums[static_cast<std::size_t>(Compartment::lateral)])}};
}

Json fibres_json(const store::MotionModel& model)
{
  if (!model.ligaments || model.ligaments->name.empty()) return nullptr;
  const std::vector<Eigen::Index> spine = solved_spine(model);
  Json bundles = Json::array();
  for (const Bundle& bundle : bundles_of(*model.ligaments))
    bundles.push_back(bundle_json(*model.ligaments, bundle, spine));
  return bundles;
}

namespace {

Json branches_json(const store::MotionModel& model)
{
  const store::SpineBranches& branches = model.equilibrium->spine.branches;
  std::vector<double> flexion_deg;
  for (std::size_t i = 0; i + 1 < branches.row_start.size(); ++i)
    flexion_deg.insert(flexion_deg.end(),
                       static_cast<std::size_t>(branches.row_start[i + 1] - branches.row_start[i]),
                       model.flexion_deg[i]);
  return {{"flexion", short_numbers(flexion_deg)},
          {"theta", short_numbers(branches.theta_deg)},
          {"varus", short_numbers(branches.varus_deg)},
          {"energy", short_numbers(branches.energy_nmm)},
          {"is_chosen", branches.is_chosen}};
}

// The band is of theta about Delta. For Delta = +Y internal rotation differs from it by the same offset
// within the band; otherwise it is that of the pose turned by theta at the attitude of the spine.
double internal_in_band_deg(const store::MotionModel& model, const store::ClinicalSurfaces& clinical,
                            std::size_t flexion, Eigen::Index cell, double theta_deg)
{
  if (cell < 0) return nan;
  const double internal_deg = clinical.internal_rotation_deg.data()[cell];
  const store::FreeSpine& spine = model.equilibrium->spine;
  if (!store::has_turned_axes(model)) return theta_deg + (internal_deg - spine.theta_deg[flexion]);
  const SolverFrame frame{model.side == "left" ? Side::left : Side::right, model.rotation_centre_mm,
                          model.push.delta.row(static_cast<Eigen::Index>(flexion)).transpose()};
  const Attitude attitude{rad_from_deg(model.flexion_deg[flexion]), rad_from_deg(spine.varus_deg[flexion])};
  const auto internal_at_deg = [&](double at_deg) {
    const Pose X = X_reference_moving(frame, attitude, {Eigen::Vector3d::Zero(), rad_from_deg(at_deg)});
    return deg_from_rad(clinical_coordinates(X, frame.side, frame.rotation_centre_mm).internal_rotation_rad);
  };
  const double chosen_deg = internal_at_deg(spine.theta_deg[flexion]);
  return internal_deg + nearest_turn(internal_at_deg(theta_deg), chosen_deg, 360.0) - chosen_deg;
}

}  // namespace

Json spine_json(const store::MotionModel& model)
{
  if (!model.equilibrium) return nullptr;
  const store::FreeSpine& spine = model.equilibrium->spine;
  const std::vector<Eigen::Index> cells = solved_spine(model);
  const store::ClinicalCurves clinical = store::clinical_curves(model);
  std::vector<double> low_deg, high_deg;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    low_deg.push_back(internal_in_band_deg(model, clinical.surfaces, i, cells[i], spine.theta_low_deg[i]));
    high_deg.push_back(internal_in_band_deg(model, clinical.surfaces, i, cells[i], spine.theta_high_deg[i]));
  }
  return {{"band_moment_nmm", short_number(model.equilibrium->band_moment_nmm)},
          {"internal_low", short_numbers(low_deg)},
          {"internal_high", short_numbers(high_deg)},
          {"n_optima", spine.n_optima},
          {"branches", branches_json(model)}};
}

}  // namespace vrda::report
