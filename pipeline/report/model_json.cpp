#include "report/model_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/fields_json.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "report/clinical_curve.hpp"
#include "solve/case_solver.hpp"
#include "store/motion.hpp"
#include "store/solved_cells.hpp"
#include "store/verdict.hpp"

namespace vrda::report {
namespace {

/// One row per flexion with the values over varus.
template <typename Grid>
Json grid_rows(const Grid& grid)
{
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < grid.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < grid.cols(); ++j) row.push_back(grid(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Rows of `width` numbers.
Json rows_of(const std::vector<double>& values, std::size_t width)
{
  Json rows = Json::array();
  for (std::size_t k = 0; k + width <= values.size(); k += width)
    rows.push_back(std::vector<double>(&values[k], &values[k] + width));
  return rows;
}

bool is_varus_free(const store::MotionModel& model)
{
  return store::Motion(model, "raw").is_varus_free();
}

Json body_json(const Body& body)
{
  Json components = Json::array();
  for (const Component& c : body.components)
    components.push_back({{"name", c.name}, {"material", c.material}});
  return {{"name", body.name},
          {"components", components},
          {"contact_triangles", body.contact.mesh.triangles.rows()},
          {"visual_triangles", body.visual.mesh.triangles.rows()}};
}

Json statuses_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const StepStatus status : all_step_statuses) {
    const auto code = static_cast<std::int8_t>(status);
    const auto n = (model.status == code).count();
    list.push_back(
        {{"code", code}, {"name", name_of(status)}, {"meaning", meaning_of(status)}, {"cells", n}});
  }
  return list;
}

Json plausibilities_json()
{
  Json list = Json::array();
  for (const Plausibility plausibility : all_plausibilities) {
    list.push_back({{"code", static_cast<std::int8_t>(plausibility)}, {"name", name_of(plausibility)}});
  }
  return list;
}

Json rotation_json(const store::CurveFigures& f)
{
  return {{"net_deg", f.net_deg},
          {"first_deg", f.first_deg},
          {"last_deg", f.last_deg},
          {"peak_deg", f.peak_deg},
          {"peak_at_deg", f.peak_at_deg},
          {"change_deg", f.change_deg},
          {"change_from_deg", f.change_from_deg},
          {"change_to_deg", f.change_to_deg}};
}

Json numbers_json(const ReportModel& entry)
{
  const MotionSummary n = motion_summary(entry.model);
  return {{"cells", n.n_cells},
          {"stable", n.n_stable},
          {"overlapping", entry.raw.n_overlapping},
          {"largest_penetration_mm", entry.raw.largest_penetration_mm},
          {"largest_gap_mm", entry.raw.largest_gap_mm},
          {"contact_resolution_mm", entry.model.contact_resolution_mm},
          {"theta_undetermined_share", n.theta_undetermined_share},
          {"rotation", rotation_json(n.rotation)},
          {"largest_spine_jump_deg", n.spine_jump.change_deg},
          {"several_optima", n.n_several_optima},
          {"optima_spread_deg", n.largest_optima_spread_deg},
          {"balance_residual_n", n.balance_residual_n},
          {"worst_gap_mm", n.worst_gap_mm},
          {"push_n", n.push_n},
          {"fibres", entry.model.ligaments ? entry.model.ligaments->name.size() : 0},
          {"largest_strain", n.largest_strain},
          {"largest_tension_n", n.largest_tension_n}};
}

// What the kind calls the rotations; nothing where it uses their keys.
Json words_json(const JointKind& kind)
{
  if (!has_own_words(kind)) return {};
  return {{"flexion", label_of(kind, JointCoordinate::flexion)},
          {"varus", label_of(kind, JointCoordinate::varus)}};
}

Json head_json(const ReportModel& entry)
{
  const store::MotionModel& model = entry.model;
  Json head = {{"name", entry.name},
               {"title", model.title},
               {"joint", model.joint},
               {"side", model.side},
               {"method", model.method},
               {"is_varus_free", is_varus_free(model)},
               {"has_compartments", model.has_compartments},
               {"reference", body_json(model.reference)},
               {"moving", body_json(model.moving)},
               {"key_name", model.frames ? Json(model.frames->key_name) : Json()},
               {"flexion", model.frames ? model.frames->key : model.flexion_deg},
               {"varus", model.varus_deg},
               {"statuses", statuses_json(model)},
               {"numbers", numbers_json(entry)},
               {"default_motion", store::default_motion(model).set},
               {"warnings", warnings_of(entry)}};
  if (const Json words = words_json(joint_kind(model.joint)); !words.is_null()) head["words"] = words;
  return head;
}

Json curves_json(const store::MotionModel& model, const Eigen::Vector3d& point_mm)
{
  Json list = Json::array();
  for (const ClinicalCurve& curve : clinical_curves(model, point_mm)) list.push_back(curve_json(curve));
  return list;
}

Json raw_surfaces_json(const store::MotionModel& model)
{
  Json raw = {{"name", "raw"},
              {"tx", grid_rows(model.tx_mm)},
              {"ty", grid_rows(model.ty_mm)},
              {"tz", grid_rows(model.tz_mm)},
              {"theta", grid_rows(model.theta_deg)}};
  if (is_varus_free(model)) raw["varus"] = grid_rows(model.varus_solved_deg);
  if (model.frames) {
    const auto n = static_cast<Eigen::Index>(model.flexion_deg.size());
    raw["frame_flexion"] = grid_rows(Eigen::Map<const store::GridD>(model.flexion_deg.data(), n, 1));
  }
  return raw;
}

// The set's surfaces plus the travel into contact, in W along the Delta of each flexion.
Json recontacted_json(const store::MotionModel& model, const store::SmoothedSet& set, const std::string& name)
{
  Json result = {{"name", name}};
  for (const store::SmoothedSurface& surface : set.surfaces) {
    store::GridD values = surface.values;
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      const Eigen::Vector3d delta = model.push.delta.row(i).transpose();
      const double component = surface.name == "tx"   ? delta.x()
                               : surface.name == "ty" ? delta.y()
                               : surface.name == "tz" ? delta.z()
                                                      : 0.0;
      if (component != 0.0) values.row(i) += component * set.recontact_mm->row(i);
    }
    result[surface.name] = grid_rows(values);
  }
  return result;
}

Json surfaces_json(const store::MotionModel& model)
{
  Json list = Json::array({raw_surfaces_json(model)});
  for (const store::SmoothedSet& set : model.smoothed) {
    const std::string name = "degree_" + std::to_string(set.degree);
    Json values = {{"name", name}};
    for (const store::SmoothedSurface& surface : set.surfaces)
      values[surface.name] = grid_rows(surface.values);
    list.push_back(std::move(values));
    if (set.recontact_mm) list.push_back(recontacted_json(model, set, name + "_recontacted"));
  }
  return list;
}

Json degrees_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const store::SmoothedSet& set : model.smoothed) {
    Json surfaces = Json::array();
    for (const store::SmoothedSurface& s : set.surfaces) {
      surfaces.push_back({{"name", s.name},
                          {"cells", s.n_cells},
                          {"rms", s.rms},
                          {"largest_residual", s.largest_residual},
                          {"leave_one_out_rms", s.leave_one_out_rms},
                          {"condition_number", s.condition_number}});
    }
    list.push_back({{"degree", set.degree},
                    {"is_robust", set.is_robust},
                    {"is_recontacted", set.recontact_mm.has_value()},
                    {"surfaces", surfaces}});
  }
  return list;
}

// Null without a number, and if it is infinite.
Json largest_json(const store::GridD& grid)
{
  double most = -1.0;
  for (const double value : grid.reshaped()) {
    if (value > most) most = value;
  }
  return most < 0.0 ? Json() : Json(most);
}

Json audits_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const store::AuditSet& a : model.audits) {
    const auto n_of = [&](store::AuditState state) {
      return (a.state == static_cast<std::int8_t>(state)).count();
    };
    list.push_back({{"name", a.name},
                    {"refine", a.refine},
                    {"attitudes", a.state.size()},
                    {"no_pose", n_of(store::AuditState::no_pose)},
                    {"overlapping", n_of(store::AuditState::overlapping)},
                    {"nothing_ahead", n_of(store::AuditState::nothing_ahead)},
                    {"largest_gap_mm", largest_json(a.gap_mm)},
                    {"largest_penetration_mm", largest_json(a.penetration_mm)},
                    {"two_sided", two_sided_json(store::two_sided_figures(a))}});
  }
  return list;
}

Json scaling_json(const std::optional<Scaling>& scaling)
{
  if (!scaling) return {};
  return {{"factor", {scaling->factor.x(), scaling->factor.y(), scaling->factor.z()}},
          {"keeps_steps", scaling->keeps_steps},
          {"standard_error", scaling->standard_error},
          {"residual_rms_mm", scaling->residual_rms_mm},
          {"landmarks", scaling->landmark},
          {"model_mm", scaling->model_mm},
          {"subject_mm", scaling->subject_mm},
          {"residual_mm", scaling->residual_mm}};
}

Json provenance_json(const store::MotionModel& model)
{
  Json inputs = Json::array();
  for (const store::InputFile& input : model.job.inputs)
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}});
  return {{"job", model.job.text},
          {"resolved", model.job.resolved},
          {"inputs", inputs},
          {"scaling", scaling_json(model.job.scaling)},
          {"format_version", store::format_version}};
}

// Bit 0: contact of the medial compartment, bit 1: of the lateral one; -1 without a pose.
Json contacts_json(const store::MotionModel& model)
{
  if (!model.has_compartments) return nullptr;
  store::GridB contacts = model.is_in_contact[0];
  for (Eigen::Index k = 0; k < contacts.size(); ++k) {
    if (contacts.data()[k] < 0) continue;
    contacts.data()[k] = static_cast<std::int8_t>(contacts.data()[k] + 2 * model.is_in_contact[1].data()[k]);
  }
  return grid_rows(contacts);
}

Json errors_json(const std::string& name, const analysis::ErrorMeasures& errors)
{
  return {{"name", name},
          {"rms", errors.rms},
          {"largest", errors.largest},
          {"leave_one_out", errors.leave_one_out},
          {"roughness", errors.roughness}};
}

Json faults_json(const analysis::DegreeRow& row)
{
  if (!row.audit_totals) return nullptr;
  const analysis::AuditTotals& f = row.audit_totals->at_grid;
  return {{"attitudes", f.n_attitudes},
          {"overlapping", f.n_overlapping},
          {"nothing_ahead", f.n_nothing_ahead},
          {"largest_penetration_mm", f.largest_penetration_mm},
          {"largest_gap_mm", f.largest_gap_mm}};
}

Json contact_json(const std::optional<analysis::ContactFigures>& contact)
{
  if (!contact) return nullptr;
  return {{"poses", contact->n_poses},
          {"lifted_off", contact->n_lifted_off},
          {"largest_gap_mm", contact->largest_gap_mm},
          {"largest_overlap_mm", contact->largest_overlap_mm},
          {"two_sided", contact->sides ? two_sided_json(*contact->sides) : Json()}};
}

Json followers_json(const std::vector<analysis::FollowerRow>& followers)
{
  Json list = Json::array();
  for (const analysis::FollowerRow& follower : followers) {
    Json errors = Json::array();
    for (std::size_t k = 0; k < n_joint_coordinates; ++k)
      errors.push_back(
          errors_json(std::string(follower_coordinate_names[k]) + (is_rotation(k) ? ", degrees" : ", mm"),
                      follower.surfaces[k].errors));
    list.push_back({{"name", follower.name}, {"errors", errors}});
  }
  return list;
}

Json comparison_json(const std::optional<analysis::Comparison>& comparison)
{
  if (!comparison) return nullptr;
  Json rows = Json::array();
  const analysis::Recommendation& r = comparison->recommendation;
  for (std::size_t k = 0; k < comparison->rows.size(); ++k) {
    const analysis::DegreeRow& row = comparison->rows[k];
    Json errors = Json::array({errors_json("translation", row.translation)});
    for (const analysis::SurfaceRow& surface : row.surfaces) {
      const bool is_angle = surface.name == "theta" || surface.name == "varus";
      if (is_angle) errors.push_back(errors_json(surface.name, surface.errors));
    }
    rows.push_back({{"degree", row.set.degree},
                    {"errors", errors},
                    {"perceptible_share", row.perceptible_share},
                    {"left_out", r.ranked[k].error},
                    {"second_difference", row.second_difference},
                    {"contact", contact_json(row.contact)},
                    {"fault", name_of(r.ranked[k].fault)},
                    {"faults", faults_json(row)},
                    {"followers", followers_json(row.followers)}});
  }
  return {{"rows", rows},
          {"not_carried", comparison->undetermined_degrees},
          {"recommended", r.degree},
          {"status", r.degree >= 0 ? "recommended" : name_of(r.fault)},
          {"left_out", {{"flexions", r.block_size.flexion}, {"varus_columns", r.block_size.varus}}},
          {"reason", r.reason}};
}

std::string base64(const std::string& bytes)
{
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - k);
    unsigned word = 0;
    for (std::size_t j = 0; j < 3; ++j)
      word = word << 8 | (j < n ? static_cast<unsigned char>(bytes[k + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= n ? digits[word >> (18 - 6 * j) & 63u] : '=';
  }
  return text;
}

Json stills_json(const RenderedImages& stills)
{
  Json list = Json::array();
  for (const RenderedImage& still : stills.images)
    list.push_back({{"view", still.view}, {"label", still.label}, {"png", base64(still.png)}});
  return {{"note", stills.note}, {"stills", list}};
}

// Roles of the joint's coordinates and the loads that hold them, along the spine, for the page.

Json coordinates_json(const store::MotionModel& model)
{
  if (!model.coordinates) return nullptr;
  const store::CoordinateSurfaces& c = *model.coordinates;
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  Json list = Json::array();
  for (std::size_t q = 0; q < n_joint_coordinates; ++q) {
    const std::vector<double>& loads = is_rotation(q) ? c.holding_moment_nmm : c.holding_force_n;
    std::vector<double> load;
    std::int32_t n_determined = 0, n_solved = 0;
    for (const Eigen::Index cell : spine) {
      const auto row = static_cast<std::size_t>(cell);
      load.push_back(cell < 0 ? nan : loads[3 * row + q % 3]);
      if (cell < 0) continue;
      ++n_solved;
      n_determined += c.determined[n_joint_coordinates * row + q] == 1;
    }
    list.push_back({{"name", joint_coordinate_names[q]},
                    {"role", name_of(static_cast<CoordinateRole>(c.role[q]))},
                    {"solved", n_solved},
                    {"determined", n_determined},
                    {"holding_load", load}});
  }
  return list;
}

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
  for (const Eigen::Index cell : store::solved_spine(model)) {
    for (std::size_t k = 0; k < 3; ++k)
      rows.push_back(cell < 0 ? nan : cells[3 * static_cast<std::size_t>(cell) + k]);
  }
  return rows;
}

/// [n_flexion, 3]
std::optional<store::ContactPaths> paths_of(const store::MotionModel& model)
{
  if (model.zero_varus && !model.zero_varus->centres[0].reference_mm.empty())
    return model.zero_varus->centres;
  std::optional<store::ContactPaths> paths = model.contact_paths;
  if (!paths) return paths;
  for (store::ContactPath& path : *paths)
    path = {along_spine(model, path.reference_mm), along_spine(model, path.moving_mm)};
  return paths;
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
    list.push_back(Json::array({p.x(), p.y()}));
  return list;
}

Mesh whole_mesh(const Body& body)
{
  Mesh mesh = body.contact.mesh;
  append(mesh, body.visual.mesh);
  return mesh;
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
          {"largest_strain", strain},
          {"tension_n", tension_n}};
}

Json contact_paths_json(const store::MotionModel& model)
{
  OutlineOptions reference, moving;
  reference.from_mm = moving.from_mm = std::numeric_limits<double>::infinity();
  reference.to_mm = moving.to_mm = -std::numeric_limits<double>::infinity();
  Json compartments = Json::array();
  const std::optional<store::ContactPaths> paths = paths_of(model);
  for (const auto& [side, name, meaning] : compartment_names) {
    if (!paths) break;
    const store::ContactPath& path = (*paths)[side];
    include_heights(path.reference_mm, reference);
    include_heights(path.moving_mm, moving);
    compartments.push_back({{"name", name},
                            {"reference", rows_of(path.reference_mm, 3)},
                            {"moving", rows_of(path.moving_mm, 3)}});
  }
  if (compartments.empty()) return nullptr;
  return {{"compartments", compartments},
          {"outline_reference", outline_json(whole_mesh(model.reference), reference)},
          {"outline_moving", outline_json(whole_mesh(model.moving), moving)}};
}

/// Rows of coordinates minus those of a point.
std::vector<double> from_point(std::vector<double> rows, const Eigen::VectorXd& point_mm)
{
  const auto width = static_cast<std::size_t>(point_mm.size());
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] -= point_mm[static_cast<Eigen::Index>(k % width)];
  return rows;
}

Json axes_json(const store::MotionModel& model)
{
  if (!model.zero_varus) return nullptr;
  const store::ZeroVarus& z = *model.zero_varus;
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  return {{"rotation_deg", z.helical_rotation_deg},
          {"translation_mm", z.helical_translation_mm},
          {"direction", rows_of(z.helical_direction, 3)},
          {"point_mm", rows_of(from_point(z.helical_point_mm, centre_mm), 3)},
          {"instant_centre_mm", rows_of(from_point(z.instant_centre_mm, centre_mm.head<2>()), 2)},
          {"medial_rolling_mm", z.rolling[0].rolling_mm},
          {"medial_sliding_mm", z.rolling[0].sliding_mm},
          {"lateral_rolling_mm", z.rolling[1].rolling_mm},
          {"lateral_sliding_mm", z.rolling[1].sliding_mm}};
}

Json forces_json(const store::MotionModel& model)
{
  if (!model.equilibrium) return nullptr;
  std::array<std::vector<double>, 3> sums;
  for (const Eigen::Index cell : store::solved_spine(model)) {
    const auto of_cell = store::forces_in(model.equilibrium->forces,
                                          static_cast<std::size_t>(std::max<Eigen::Index>(cell, 0)));
    for (std::size_t k = 0; k < 3; ++k) sums[k].push_back(cell < 0 ? nan : of_cell.of_n[k]);
  }
  return {{"none_n", sums[static_cast<std::size_t>(Compartment::none)]},
          {"medial_n", sums[static_cast<std::size_t>(Compartment::medial)]},
          {"lateral_n", sums[static_cast<std::size_t>(Compartment::lateral)]}};
}

Json flexion_curves_json(const std::vector<analysis::CurveGroup>& groups)
{
  Json list = Json::array();
  for (const analysis::CurveGroup& group : groups) {
    Json curves = Json::array();
    for (const analysis::Curve& curve : group.curves)
      curves.push_back({{"name", curve.label}, {"values", curve.values}});
    list.push_back({{"title", group.title},
                    {"caption", group.caption},
                    {"unit", group.unit},
                    {"curves", std::move(curves)}});
  }
  return list;
}

Json fibres_json(const store::MotionModel& model)
{
  if (!model.ligaments || model.ligaments->name.empty()) return nullptr;
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  Json bundles = Json::array();
  for (const Bundle& bundle : bundles_of(*model.ligaments))
    bundles.push_back(bundle_json(*model.ligaments, bundle, spine));
  return bundles;
}

Json branches_json(const store::MotionModel& model)
{
  const store::SpineBranches& branches = model.equilibrium->spine.branches;
  std::vector<double> flexion_deg;
  for (std::size_t i = 0; i + 1 < branches.row_start.size(); ++i)
    flexion_deg.insert(flexion_deg.end(),
                       static_cast<std::size_t>(branches.row_start[i + 1] - branches.row_start[i]),
                       model.flexion_deg[i]);
  return {{"flexion", flexion_deg},
          {"theta", branches.theta_deg},
          {"varus", branches.varus_deg},
          {"energy", branches.energy_nmm},
          {"is_chosen", branches.is_chosen}};
}

// The band is of theta about Delta. For Delta = +Y internal rotation differs from it by the same offset
// within the band; otherwise it is that of the pose turned by theta at the attitude of the spine.
double internal_in_band_deg(const store::MotionModel& model, const store::ClinicalSurfaces& clinical,
                            std::size_t flexion, Eigen::Index cell, double theta_deg)
{
  if (cell < 0) return nan;
  const double internal_deg = clinical[JointCoordinate::internal].data()[cell];
  const store::FreeSpine& spine = model.equilibrium->spine;
  if (!store::has_turned_axes(model)) return theta_deg + (internal_deg - spine.theta_deg[flexion]);
  const SolverFrame frame{side_named(model.side), model.rotation_centre_mm,
                          model.push.delta.row(static_cast<Eigen::Index>(flexion)).transpose()};
  const Attitude attitude{rad_from_deg(model.flexion_deg[flexion]), rad_from_deg(spine.varus_deg[flexion])};
  const auto internal_at_deg = [&](double at_deg) {
    const Pose X = X_reference_moving(frame, attitude, {Eigen::Vector3d::Zero(), rad_from_deg(at_deg)});
    return deg_from_rad(clinical_coordinates(X, frame.side, frame.rotation_centre_mm).internal_rotation_rad);
  };
  const double chosen_deg = internal_at_deg(spine.theta_deg[flexion]);
  return internal_deg + nearest_turn(internal_at_deg(theta_deg), chosen_deg, 360.0) - chosen_deg;
}

Json spine_json(const store::MotionModel& model)
{
  if (!model.equilibrium) return nullptr;
  const store::FreeSpine& spine = model.equilibrium->spine;
  const std::vector<Eigen::Index> cells = store::solved_spine(model);
  const store::ClinicalCurves clinical = store::clinical_curves(model);
  std::vector<double> low_deg, high_deg;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    low_deg.push_back(internal_in_band_deg(model, clinical.surfaces, i, cells[i], spine.theta_low_deg[i]));
    high_deg.push_back(internal_in_band_deg(model, clinical.surfaces, i, cells[i], spine.theta_high_deg[i]));
  }
  return {{"band_moment_nmm", model.equilibrium->band_moment_nmm},
          {"internal_low", low_deg},
          {"internal_high", high_deg},
          {"n_optima", spine.n_optima},
          {"branches", branches_json(model)}};
}

// Measured and repaired motion of a repaired model, for the page.

struct FrameLengths {
  const std::vector<double>&gap_mm, &penetration_mm;
};

Json motion_json(const store::MotionModel& model, const std::vector<double>& poses,
                 const FrameLengths& lengths)
{
  const Side side = side_named(model.side);
  ContinuousCoordinates along(side, model.rotation_centre_mm);
  Json json = {{"gap", lengths.gap_mm}, {"penetration", lengths.penetration_mm}};
  for (std::size_t k = 0; k < model.flexion_deg.size(); ++k) {
    const auto numbers = in_files(along.next(store::pose_in(poses, k)));
    for (std::size_t c = 0; c < numbers.size(); ++c) json[joint_coordinate_names[c]].push_back(numbers[c]);
  }
  return json;
}

Json repair_json(const store::MotionModel& model)
{
  if (!model.repair || !model.frames) return nullptr;
  const store::RepairedFrames& r = *model.repair;
  Json statuses = Json::array();
  for (const std::int8_t status : r.status) statuses.push_back(status);
  return {{"key_name", model.frames->key_name},
          {"key", model.frames->key},
          {"before", motion_json(model, r.X_measured, {r.gap_before_mm, r.penetration_before_mm})},
          {"after", motion_json(model, model.X_reference_moving, {r.gap_after_mm, r.penetration_after_mm})},
          {"distance", r.distance},
          {"status", statuses},
          {"converged", r.is_converged},
          {"noise_deg", r.noise_deg},
          {"noise_mm", r.noise_mm},
          {"gap_limit", r.gap_limit_mm}};
}

// Bands of an uncertain job, and the draws that their spread comes from, for the page.

Json uncertainty_json(const store::MotionModel& model)
{
  constexpr std::size_t most_shares = 8;
  constexpr const char* band_keys[] = {"smallest", "low", "median", "high", "largest"};
  if (!model.uncertainty) return nullptr;
  const store::UncertainMotion& motion = *model.uncertainty;
  Json quantities = Json::array();
  for (const solve::BandQuantity& quantity : solve::quantities_of(motion)) {
    Json json = {{"name", quantity.name}, {"unit", quantity.unit}};
    for (std::size_t p = 0; p < store::band_probabilities.size(); ++p) {
      std::vector<double> values;
      for (std::size_t i = 0; i < motion.n_solved.size(); ++i) values.push_back(quantity.band_at(p, i));
      json[band_keys[p]] = values;
    }
    Json shares = Json::array();
    for (const solve::SpreadShare& share : solve::spread_shares(quantity)) {
      if (shares.size() == most_shares) break;
      shares.push_back({{"draw", motion.draw[share.draw]},
                        {"index", share.index},
                        {"low", share.low},
                        {"high", share.high},
                        {"rank_correlation", share.rank_correlation}});
    }
    json["shares"] = std::move(shares);
    quantities.push_back(std::move(json));
  }
  return {{"samples", motion.n_samples()}, {"sequence", motion.sequence},
          {"seed", motion.seed},           {"draws", motion.draw.size()},
          {"solved", motion.n_solved},     {"quantities", std::move(quantities)}};
}

}  // namespace

Json two_sided_json(const store::TwoSidedFigures& f)
{
  if (f.n_poses == 0) return nullptr;
  Json json{{"poses", f.n_poses}, {"both_in_contact", f.n_both_in_contact}};
  for (const auto& [side, name, meaning] : compartment_names) {
    json[std::string("largest_gap_") + name + "_mm"] = f.largest_gap_mm[side];
    json[std::string("largest_overlap_") + name + "_mm"] = f.largest_overlap_mm[side];
  }
  return json;
}

Json curve_json(const ClinicalCurve& curve)
{
  Json values = {{"name", curve.name}, {"flexion", curve.flexion_deg}};
  for (const QuantityName& q : quantity_names) {
    if (!curve.values_of(q.quantity).empty()) values[q.key] = curve.values_of(q.quantity);
  }
  return values;
}

Json model_json(const ReportModel& entry, const ModelJsonOptions& options)
{
  const store::MotionModel& model = entry.model;
  Json json = head_json(entry);
  if (store::has_turned_axes(model)) json["axes_are_turned"] = true;
  json["point_mm"] = std::vector<double>(options.point_mm.begin(), options.point_mm.end());
  json["curves"] = curves_json(model, options.point_mm);
  json["provenance"] = provenance_json(model);
  json["spine"] = spine_json(model);
  if (!options.is_whole) return json;
  json["statement"] = store::default_motion(model).statement;
  json["verdict"] = json_value(store::verdict_of(model, store::default_motion(model).set));
  json["status_grid"] = grid_rows(model.status);
  json["plausibility_grid"] = grid_rows(model.plausibility);
  json["plausibilities"] = plausibilities_json();
  json["contact_grid"] = contacts_json(model);
  json["theta_determined_grid"] = grid_rows(model.theta_determined);
  json["surfaces"] = surfaces_json(model);
  json["degrees"] = degrees_json(model);
  json["comparison"] = comparison_json(entry.comparison);
  json["audits"] = audits_json(model);
  json["coordinates"] = coordinates_json(model);
  json["repair"] = repair_json(model);
  json["uncertainty"] = uncertainty_json(model);
  json["contact_paths"] = contact_paths_json(model);
  json["axes"] = axes_json(model);
  json["forces"] = forces_json(model);
  json["fibres"] = fibres_json(model);
  json["flexion_curves"] = flexion_curves_json(entry.flexion_curves);
  json["stills"] = stills_json(entry.images);
  return json;
}

}  // namespace vrda::report
