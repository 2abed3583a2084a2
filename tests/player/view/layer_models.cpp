#include "player/view/layer_models.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"
#include "view/scene.hpp"

namespace vrda::test {
namespace {

Eigen::Vector3d single_precision(const std::array<float, 3>& v)
{
  return {v[0], v[1], v[2]};
}

/// Two rows per cell: points, normals and further columns.
template <typename Rows>
void set_rows(Rows& rows, std::size_t n_cells, double z_sign)
{
  const auto n = static_cast<Eigen::Index>(2 * n_cells);
  rows.row_start.clear();
  for (std::size_t cell = 0; cell <= n_cells; ++cell)
    rows.row_start.push_back(static_cast<std::int64_t>(2 * cell));
  rows.point_world_mm.resize(n, 3);
  rows.normal_world.resize(n, 3);
  for (Eigen::Index cell = 0; cell < n / 2; ++cell) {
    rows.point_world_mm.row(2 * cell) << 5.0 + 0.1 * static_cast<double>(cell), -20.0, 8.0 * z_sign;
    rows.point_world_mm.row(2 * cell + 1) << -4.0, -20.5, -9.0 * z_sign;
    rows.normal_world.row(2 * cell) << 0.0, -1.0, 0.0;
    rows.normal_world.row(2 * cell + 1) = Eigen::RowVector3d(0.1, -0.99, 0.05 * z_sign).normalized();
  }
  rows.triangle_reference.assign(2 * n_cells, 0);
  rows.triangle_moving.assign(2 * n_cells, 0);
  rows.compartment.assign(2 * n_cells, 0);
}

void set_forces(store::MotionModel& model, std::size_t n_cells, double z_sign)
{
  model.equilibrium.emplace();
  store::ForceRows& rows = model.equilibrium->forces;
  set_rows(rows, n_cells, z_sign);
  for (Eigen::Index row = 0; row < rows.normal_world.rows(); ++row) {
    const double force_n = row % 2 == 0 ? 10.0 * force_ratio : 10.0;
    rows.along_delta_n.push_back(force_n * -rows.normal_world(row, 1));
  }
}

void set_ligaments(store::MotionModel& model, std::size_t n_cells, double z_sign)
{
  const auto at = [&](double x, double y, double z) -> Eigen::RowVector3d {
    return model.rotation_centre_mm.transpose() + Eigen::RowVector3d(x, y, z * z_sign);
  };
  store::LigamentRows rows;
  rows.name = {"straight", "round"};
  rows.bundle = rows.name;
  rows.reference_mm.resize(2, 3);
  rows.moving_mm.resize(2, 3);
  rows.reference_mm << at(12, 0, 22), at(16, 4, -20);
  rows.moving_mm << at(3, -32, 24), at(-20, -10, -15);
  rows.stiffness_n = {1000, 1000};
  rows.slack_length_mm = {39, 40};
  rows.wrap = {-1, 0};
  rows.wrap_name = {"cylinder"};
  rows.wrap_shape = {0};
  rows.wrap_body = {0};
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> X = Eigen::Matrix4d::Identity();
  X.topRightCorner<3, 1>() = model.rotation_centre_mm;
  rows.X_body_wrap.assign(X.data(), X.data() + 16);
  rows.wrap_radii_mm.resize(1, 3);
  rows.wrap_radii_mm << 15, 15, 60;
  rows.strain.assign(2 * n_cells, 0.12);
  model.ligaments = rows;
}

/// Centres that move by a quarter of a millimetre a flexion, with a jump in the middle of the medial ones.
void set_contact_paths(store::MotionModel& model, std::size_t n_cells, double z_sign)
{
  store::ContactPaths paths;
  const std::size_t n_varus = model.varus_deg.size();
  for (std::size_t cell = 0; cell < n_cells; ++cell) {
    const double x = 0.25 * static_cast<double>(cell / n_varus);
    const double jump_mm = 2 * cell < n_cells ? 0.0 : 9.0;
    const Eigen::Vector3d medial =
        model.rotation_centre_mm + Eigen::Vector3d(x + jump_mm, -20, -8.0 * z_sign);
    const Eigen::Vector3d lateral = model.rotation_centre_mm + Eigen::Vector3d(x, -20, 8.0 * z_sign);
    for (std::vector<double>* own : {&paths.medial_reference_mm, &paths.medial_moving_mm})
      own->insert(own->end(), medial.begin(), medial.end());
    for (std::vector<double>* own : {&paths.lateral_reference_mm, &paths.lateral_moving_mm})
      own->insert(own->end(), lateral.begin(), lateral.end());
  }
  model.contact_paths = paths;
}

/// Samples of an uncertain job at zero varus: row k of the quantiles is k mm anterior of the first.
void set_uncertainty(store::MotionModel& model)
{
  store::UncertainMotion motion;
  for (std::size_t k = 0; k < store::band_probabilities.size(); ++k) {
    for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
      motion.quantile_status.push_back(0);
      motion.tx_mm.push_back(static_cast<double>(k));
      motion.ty_mm.push_back(0.0);
      motion.tz_mm.push_back(0.0);
      motion.theta_deg.push_back(0.0);
      motion.varus_deg.push_back(0.0);
    }
  }
  model.uncertainty = motion;
}

}  // namespace

store::MotionModel layered_model(const std::string& side)
{
  const double z_sign = side == "left" ? -1.0 : 1.0;
  ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {100, -200, 40 * z_sign};
  plan.motion = [z_sign](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{-0.05 * flexion_deg, -0.01 * flexion_deg, 0.2 * z_sign * varus_deg,
                                  0.1 * flexion_deg};
  };
  store::MotionModel model = model_of(plan);
  add_bodies(model);
  Mesh fine = sheet(44, 44);
  fine.vertices_mm.rowwise() += model.rotation_centre_mm.transpose() - Eigen::RowVector3d(0, 20, 0);
  if (side == "left") fine = mirrored_z(fine);
  if (side == "left") fine.vertices_mm.col(2).array() += 2.0 * model.rotation_centre_mm.z();
  append(model.moving.contact.mesh, fine);
  model.moving.contact.component.resize(static_cast<std::size_t>(model.moving.contact.mesh.triangles.rows()),
                                        2);
  model.moving.components.push_back({"sheet", "cartilage"});
  model.compartment_of_triangle.resize(model.moving.contact.component.size());
  const auto n_cells = static_cast<std::size_t>(model.status.size());
  set_rows(model.contacts, n_cells, z_sign);
  model.contacts.distance_mm.assign(2 * n_cells, 0.0);
  set_forces(model, n_cells, z_sign);
  set_ligaments(model, n_cells, z_sign);
  set_contact_paths(model, n_cells, z_sign);
  set_uncertainty(model);
  return model;
}

Degrees attitude_deg(const store::MotionModel& model, std::size_t cell)
{
  return {model.flexion_deg[cell / model.varus_deg.size()], model.varus_deg[cell % model.varus_deg.size()]};
}

Stage::Stage(store::MotionModel made)
    : model(std::move(made)),
      scene(view::scene_of(model.reference, model.moving, model.rotation_centre_mm)),
      layers(model, scene),
      motion(model, "raw")
{
}

void Stage::show(const store::JointPose& pose, const view::LayerSet& wanted)
{
  const view::JointFrames frames = view::frames_of(pose, held, model.rotation_centre_mm);
  view::place(scene, frames);
  layers.update(scene, motion, {pose, frames, wanted});
}

void Stage::show(const Degrees& attitude, const view::LayerSet& wanted)
{
  const store::JointPose pose = motion.at({rad_from_deg(attitude.flexion), rad_from_deg(attitude.varus)});
  check(pose.status == store::PoseStatus::solved, "the model is solved everywhere");
  show(pose, wanted);
}

void Stage::show(const Degrees& attitude, std::initializer_list<view::Layer> wanted)
{
  show(attitude, set_of(wanted));
}

view::LayerSet set_of(std::initializer_list<view::Layer> layers)
{
  view::LayerSet set;
  for (const view::Layer layer : layers) set.set(layer, true);
  return set;
}

view::LayerSet every_layer()
{
  view::LayerSet set;
  for (const std::string& name : view::layer_names()) set.set(*view::layer_named(name), true);
  return set;
}

const view::Drawable& drawable_of(const view::Scene& scene, const std::string& name)
{
  const auto found = std::ranges::find(scene.drawables, name, &view::Drawable::name);
  check(found != scene.drawables.end(), "a drawable of that name");
  return *found;
}

Eigen::Vector3d middle_world_mm(const view::Drawable& drawable, std::size_t first, std::size_t n)
{
  Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
  for (std::size_t v = first; v < first + n; ++v)
    sum_mm += single_precision(drawable.mesh.vertices[v].position_mm);
  return drawable.X_world_mesh * Eigen::Vector3d(sum_mm / static_cast<double>(n));
}

Eigen::Vector3d middle_of_drawn_mm(const view::Drawable& drawable)
{
  Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
  int n = 0;
  const std::vector<std::uint32_t>& corner = drawable.mesh.triangles;
  for (std::size_t t = 0; t < corner.size(); t += 3) {
    if (corner[t] == corner[t + 1]) continue;
    for (std::size_t k = 0; k < 3; ++k, ++n)
      sum_mm += single_precision(drawable.mesh.vertices[corner[t + k]].position_mm);
  }
  check(n > 0, "something is drawn");
  return drawable.X_world_mesh * Eigen::Vector3d(sum_mm / n);
}

Eigen::Vector3d unlifted_mm(const Stage& stage, const view::Drawable& sheet, std::size_t v)
{
  const RenderVertex& vertex = sheet.mesh.vertices[v];
  const double lift_mm = 0.05 * view::marker_scale(stage.model);
  return single_precision(vertex.position_mm) - lift_mm * single_precision(vertex.normal) + sheet.origin_mm;
}

double gap_by_every_face_mm(const Mesh& reference, const store::JointPose& pose,
                            const Eigen::Vector3d& p_moving_mm)
{
  const Eigen::Vector3d p_mm = pose.X_world_moving * p_moving_mm;
  double gap_mm = std::numeric_limits<double>::infinity();
  for (Eigen::Index t = 0; t < reference.triangles.rows(); ++t) {
    std::array<Eigen::Vector3d, 3> c = corners(reference, t);
    for (Eigen::Vector3d& corner : c) corner = pose.X_world_reference * corner;
    const Eigen::Vector3d n = (c[1] - c[0]).cross(c[2] - c[0]);
    if (!(n.y() < 0.0)) continue;
    const double travel_mm = n.dot(c[0] - p_mm) / n.y();
    const Eigen::Vector3d place_mm = p_mm + travel_mm * Eigen::Vector3d::UnitY();
    bool is_inside = travel_mm > -3.0;
    for (std::size_t k = 0; k < 3; ++k)
      is_inside =
          is_inside && n.dot((c[(k + 1) % 3] - c[k]).cross(place_mm - c[k])) >= -1e-9 * n.squaredNorm();
    if (is_inside) gap_mm = std::min(gap_mm, travel_mm);
  }
  return gap_mm;
}

int difference(const view::VertexColour& a, const view::VertexColour& b)
{
  int largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(int{a[k]} - int{b[k]}));
  return largest;
}

}  // namespace vrda::test
