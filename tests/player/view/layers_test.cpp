// The layers of a joint.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"
#include "support/allocation_count.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"
#include "view/layers.hpp"
#include "view/scene.hpp"

namespace vrda::view::layers_test {

constexpr std::size_t n_rings = 24;  // of a fibre, of n_tube_sides vertices each
constexpr double force_ratio = 3.0;  // of the two contact forces of each cell

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
    for (std::vector<double>* own : {&paths[0].reference_mm, &paths[0].moving_mm})
      own->insert(own->end(), medial.begin(), medial.end());
    for (std::vector<double>* own : {&paths[1].reference_mm, &paths[1].moving_mm})
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

/// A ball of 20 mm on a finely divided sheet, with two contacts and forces per cell, a straight fibre that is
/// slack at 0 degrees and taut from 37 degrees, and one wrapped around a cylinder. The left model mirrors the
/// right one.
store::MotionModel layered_model(const std::string& side)
{
  const double z_sign = side == "left" ? -1.0 : 1.0;
  test::ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {100, -200, 40 * z_sign};
  plan.motion = [z_sign](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{-0.05 * flexion_deg, -0.01 * flexion_deg, 0.2 * z_sign * varus_deg,
                                  0.1 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  Mesh fine = test::sheet(44, 44);
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

struct Degrees {
  double flexion = 0.0, varus = 0.0;
};
Degrees attitude_deg(const store::MotionModel& model, std::size_t cell)
{
  return {model.flexion_deg[cell / model.varus_deg.size()], model.varus_deg[cell % model.varus_deg.size()]};
}

LayerSet set_of(std::initializer_list<Layer> layers)
{
  LayerSet set;
  for (const Layer layer : layers) set.set(layer, true);
  return set;
}

/// A scene with its layers at raw poses of a model.
struct Stage {
  explicit Stage(store::MotionModel made)
      : model(std::move(made)),
        scene(scene_of(model.reference, model.moving, model.rotation_centre_mm)),
        layers(model, scene),
        motion(model, "raw")
  {
  }
  void show(const store::JointPose& pose, const LayerSet& wanted)
  {
    const JointFrames frames = frames_of(pose, held, model.rotation_centre_mm);
    place(scene, frames);
    layers.update(scene, motion, {pose, frames, wanted});
  }
  void show(const Degrees& attitude, const LayerSet& wanted)
  {
    const store::JointPose pose = motion.at({rad_from_deg(attitude.flexion), rad_from_deg(attitude.varus)});
    check(pose.status == store::PoseStatus::solved, "the model is solved everywhere");
    show(pose, wanted);
  }
  void show(const Degrees& attitude, std::initializer_list<Layer> wanted) { show(attitude, set_of(wanted)); }

  store::MotionModel model;
  Scene scene;
  JointLayers layers;
  store::Motion motion;
  BodyIndex held = BodyIndex::world;
};

LayerSet every_layer()
{
  LayerSet set;
  for (const std::string& name : layer_names()) set.set(*layer_named(name), true);
  return set;
}

/// The first drawable with that name.
const Drawable& drawable_of(const Scene& scene, const std::string& name)
{
  const auto found = std::ranges::find(scene.drawables, name, &Drawable::name);
  check(found != scene.drawables.end(), "a drawable of that name");
  return *found;
}

/// Mean of vertices, world.
Eigen::Vector3d middle_world_mm(const Drawable& drawable, std::size_t first, std::size_t n)
{
  Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
  for (std::size_t v = first; v < first + n; ++v)
    sum_mm += single_precision(drawable.mesh.vertices[v].position_mm);
  return drawable.X_world_mesh * Eigen::Vector3d(sum_mm / static_cast<double>(n));
}

/// Mean of the corners of all non-degenerate triangles, world.
Eigen::Vector3d middle_of_drawn_mm(const Drawable& drawable)
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

/// Vertex `v` of a gap sheet projected back onto the part below; canonical axes of the moving body.
Eigen::Vector3d unlifted_mm(const Stage& stage, const Drawable& sheet, std::size_t v)
{
  const RenderVertex& vertex = sheet.mesh.vertices[v];
  const double lift_mm = 0.05 * marker_scale(stage.model);
  return single_precision(vertex.position_mm) - lift_mm * single_precision(vertex.normal) + sheet.origin_mm;
}

/// Travel along world Y from a point of the moving body to the first downward face of `reference`, from 3 mm
/// of overlap on; infinite if none exists.
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

/// The largest difference of any channel.
int difference(const VertexColour& a, const VertexColour& b)
{
  int largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(int{a[k]} - int{b[k]}));
  return largest;
}

constexpr double single_rounding_mm = 1e-4;  // single precision at 100 mm, mean of about a hundred values
constexpr double rounding = 1e-12;

void expect_bodies_alone(const Scene& scene)
{
  for (const Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.layer == Layer::bodies) << drawable.name;
}

TEST(Layers, ShownOnRequest)
{
  Stage stage(layered_model("right"));
  stage.show({30, 0}, LayerSet{});
  int n_layers_drawn = 0;
  for (const Drawable& drawable : stage.scene.drawables)
    n_layers_drawn += drawable.layer == Layer::bodies ? 0 : 1;
  expect_bodies_alone(stage.scene);
  EXPECT_GT(n_layers_drawn, 8);
  for (const std::string& name : layer_names()) EXPECT_TRUE(stage.layers.available().has(*layer_named(name)));
  store::JointPose pose = stage.motion.at({});
  pose.status = store::PoseStatus::unsolved_cell;
  stage.show(pose, every_layer());
  expect_bodies_alone(stage.scene);
}

TEST(Layers, Availability)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  Stage stage(model);
  const LayerSet& available = stage.layers.available();
  EXPECT_FALSE(available.has(Layer::contacts));
  EXPECT_FALSE(available.has(Layer::normals));
  EXPECT_FALSE(available.has(Layer::ligaments));
  EXPECT_TRUE(available.has(Layer::axes));
  EXPECT_TRUE(available.has(Layer::helical_axis));
  EXPECT_TRUE(available.has(Layer::gap_map));
  // Requesting them shows nothing and does not fail.
  stage.show({30, 0}, {Layer::contacts, Layer::normals, Layer::ligaments});
  expect_bodies_alone(stage.scene);
}

TEST(Layers, ContactsOfACell)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    const store::ContactRows& rows = stage.model.contacts;
    for (const std::size_t cell : {std::size_t{1}, std::size_t{17}, std::size_t{34}}) {
      stage.show(attitude_deg(stage.model, cell), {Layer::contacts});
      const Drawable& balls = drawable_of(stage.scene, "contacts");
      ASSERT_TRUE(balls.is_shown);
      for (std::int64_t row = rows.row_start[cell]; row < rows.row_start[cell + 1]; ++row) {
        const auto solid = static_cast<std::size_t>(row - rows.row_start[cell]);
        const Eigen::Vector3d p_mm =
            middle_world_mm(balls, solid * ball_size().n_vertices, ball_size().n_vertices);
        EXPECT_LT((p_mm - rows.point_world_mm.row(row).transpose()).norm(), single_rounding_mm);
      }
    }
  }
}

// An arrow is as long as its force and presses there.
TEST(Layers, ForceArrows)
{
  Stage stage(layered_model("right"));
  const store::ForceRows& rows = stage.model.equilibrium->forces;
  const std::size_t cell = 17;
  stage.show(attitude_deg(stage.model, cell), {Layer::normals});
  const Drawable& arrows = drawable_of(stage.scene, "contact forces");
  ASSERT_TRUE(arrows.is_shown);
  std::vector<double> length_mm;
  for (std::int64_t row = rows.row_start[cell]; row < rows.row_start[cell + 1]; ++row) {
    const std::size_t first = static_cast<std::size_t>(row - rows.row_start[cell]) * arrow_size().n_vertices;
    const Eigen::Vector3d tail_mm = middle_world_mm(arrows, first, 12),
                          tip_mm = middle_world_mm(arrows, first + arrow_size().n_vertices - 12, 12);
    EXPECT_LT((tip_mm - rows.point_world_mm.row(row).transpose()).norm(), single_rounding_mm);
    const Eigen::Vector3d along = (tip_mm - tail_mm).normalized();
    EXPECT_LT((along - rows.normal_world.row(row).transpose()).norm(), 1e-4);
    length_mm.push_back((tip_mm - tail_mm).norm());
  }
  ASSERT_EQ(length_mm.size(), 2U);
  EXPECT_NEAR(length_mm[0] / length_mm[1], force_ratio, 1e-3);
}

// Axes are at the rotation centre and along their directions.
TEST(Layers, Axes)
{
  Stage stage(layered_model("right"));
  stage.show({40, 3}, {Layer::axes});
  const auto direction = [&](const char* name) {
    const Drawable& axis = drawable_of(stage.scene, name);
    EXPECT_TRUE(axis.is_shown);
    EXPECT_LT(axis.X_world_mesh.translation().norm(), rounding) << name;
    return Eigen::Vector3d(axis.X_world_mesh.linear().col(1));
  };
  const Eigen::Matrix3d R = reference_rotation({rad_from_deg(40.0), rad_from_deg(3.0)});
  EXPECT_LT((direction("anterior") - R.col(0)).norm(), rounding);
  EXPECT_LT((direction("proximal") - R.col(1)).norm(), rounding);
  EXPECT_LT((direction("right") - R.col(2)).norm(), rounding);
  // The flexion axis is fixed in the femur.
  EXPECT_LT((direction("flexion axis") - R.col(2)).norm(), rounding);
  EXPECT_LT((direction("varus axis") - Eigen::Vector3d::UnitX()).norm(), rounding);
  EXPECT_LT((direction("Delta") - Eigen::Vector3d::UnitY()).norm(), rounding);
  EXPECT_EQ(JointLayers::axis_labels().size(), 7U);
}

// The helical axis of pure flexion is the flexion axis.
TEST(Layers, HelicalAxis)
{
  test::ModelPlan plan;
  plan.rotation_centre_mm = {100, -200, 40};
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  Stage stage(model);
  for (const double flexion_deg : {0.0, 33.0, 90.0}) {
    stage.show({flexion_deg, 0}, {Layer::helical_axis});
    const Drawable& rod = drawable_of(stage.scene, "helical axis");
    EXPECT_TRUE(rod.is_shown);
    EXPECT_LT(rod.X_world_mesh.translation().norm(), 1e-9);
    EXPECT_NEAR(std::abs(rod.X_world_mesh.linear()(2, 1)), 1.0, 1e-9);
  }
}

// Fibres run from attachment to attachment and are coloured by their strain.
TEST(Layers, Fibres)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    const store::LigamentRows& rows = *stage.model.ligaments;
    int n_slack = 0, n_taut = 0;
    for (const double flexion_deg : {0.0, 37.0, 90.0}) {
      stage.show({flexion_deg, 1.0}, {Layer::ligaments});
      const store::JointPose pose = stage.motion.at({rad_from_deg(flexion_deg), rad_from_deg(1.0)});
      const Drawable& tubes = drawable_of(stage.scene, "ligaments/straight");
      ASSERT_TRUE(tubes.is_shown);
      // The first fibre is clear of both bodies; its rings follow the end ring.
      const Eigen::Vector3d from_mm = pose.X_world_reference * rows.reference_mm.row(0).transpose();
      const Eigen::Vector3d to_mm = pose.X_world_moving * rows.moving_mm.row(0).transpose();
      EXPECT_LT((middle_world_mm(tubes, n_tube_sides, n_tube_sides) - from_mm).norm(), single_rounding_mm);
      EXPECT_LT((middle_world_mm(tubes, n_tube_sides * n_rings, n_tube_sides) - to_mm).norm(),
                single_rounding_mm);
      const double strain = (to_mm - from_mm).norm() / rows.slack_length_mm[0] - 1.0;
      const Legend& legend = stage.layers.legend(Layer::ligaments);
      EXPECT_EQ(tubes.colours[n_tube_sides], colour_of(legend, 100.0 * strain));
      EXPECT_EQ(tubes.colours[n_tube_sides] == legend.below, strain < 0.0);
      EXPECT_EQ(legend.highest, 8.0) << "as on the page";
      EXPECT_EQ(colour_of(legend, 8.01), legend.beyond.value_or(legend.below));
      EXPECT_NE(colour_of(legend, 8.0), legend.beyond.value_or(legend.below));
      n_slack += strain < 0.0 ? 1 : 0;
      n_taut += strain > 0.0 ? 1 : 0;
    }
    EXPECT_GT(n_slack, 0);
    EXPECT_GT(n_taut, 0);
  }
}

// Bands of a bundle are wide towards their neighbours.
TEST(Layers, BundleOfBands)
{
  // Three straight fibres side by side along X, 3 mm apart.
  store::MotionModel model = layered_model("right");
  store::LigamentRows& rows = *model.ligaments;
  const Eigen::RowVector3d from_mm = rows.reference_mm.row(0), to_mm = rows.moving_mm.row(0);
  const std::size_t n_cells = rows.strain.size() / rows.name.size();
  rows.name = {"a", "b", "c"};
  rows.bundle = {"sheet", "sheet", "sheet"};
  rows.reference_mm.resize(3, 3);
  rows.moving_mm.resize(3, 3);
  for (Eigen::Index i = 0; i < 3; ++i) {
    rows.reference_mm.row(i) = from_mm + Eigen::RowVector3d(3.0 * static_cast<double>(i), 0, 0);
    rows.moving_mm.row(i) = to_mm + Eigen::RowVector3d(3.0 * static_cast<double>(i), 0, 0);
  }
  rows.stiffness_n.assign(3, 1000.0);
  rows.slack_length_mm.assign(3, 1.0);  // taut
  rows.wrap.assign(3, -1);
  rows.strain.assign(3 * n_cells, 0.01);
  Stage stage(model);
  stage.show({0.0, 0.0}, {Layer::ligaments});
  const Drawable& bands = drawable_of(stage.scene, "ligaments/sheet");
  Eigen::AlignedBox3d box;
  for (std::size_t k = n_tube_sides; k < 2 * n_tube_sides; ++k) {
    const std::array<float, 3>& p = bands.mesh.vertices[k].position_mm;
    box.extend(Eigen::Vector3d(p[0], p[1], p[2]));
  }
  // Neighbouring bands overlap by a fifth of their distance, at their footprints by more, and are flat.
  EXPECT_NEAR(box.sizes().x(), 1.35 * 1.2 * 3.0, 0.05 * 1.35 * 3.0);  // fibres are tilted by up to 18 degrees
  EXPECT_LT(box.sizes().z(), 0.5 * box.sizes().x());
}

// Between their attachments fibres lie on bone; slack ones wave and are drawn as long as they are.
TEST(Layers, FibresOnBone)
{
  store::MotionModel model = layered_model("right");
  store::LigamentRows& rows = *model.ligaments;
  const Eigen::RowVector3d centre_mm = model.rotation_centre_mm.transpose();
  rows.wrap.assign(2, -1);
  rows.reference_mm << centre_mm + Eigen::RowVector3d(-19, 6, 0), centre_mm + Eigen::RowVector3d(12, 0, 32);
  rows.moving_mm << centre_mm + Eigen::RowVector3d(26, 6, 0), centre_mm + Eigen::RowVector3d(3, -32, 34);
  rows.slack_length_mm = {1.0, 36.0};  // the second is slack by 3 mm of 33
  Stage stage(model);
  stage.show({0.0, 0.0}, {Layer::ligaments});
  const Drawable& bands = drawable_of(stage.scene, "ligaments/straight");
  const Drawable& slack = drawable_of(stage.scene, "ligaments/round");
  const store::JointPose pose = stage.motion.at({0.0, 0.0});
  const Eigen::Vector3d ball_mm = pose.X_world_reference * model.rotation_centre_mm;
  for (std::size_t k = 3; k + 1 < n_rings; ++k)  // the straight line comes to 6 mm
    EXPECT_GT((middle_world_mm(bands, n_tube_sides * k, n_tube_sides) - ball_mm).norm(), 20.0);
  double waved_mm = 0.0;
  for (std::size_t k = 1; k + 1 < n_rings + 1; ++k)
    waved_mm += (middle_world_mm(slack, n_tube_sides * (k + 1), n_tube_sides) -
                 middle_world_mm(slack, n_tube_sides * k, n_tube_sides))
                    .norm();
  EXPECT_NEAR(waved_mm, rows.slack_length_mm[1], 0.5);  // chords of its waves
}

// Contact paths lie on both bodies and break at jumps.
TEST(Layers, ContactPaths)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    stage.show({30.0, 1.0}, {Layer::contact_paths});
    const std::size_t n_flexion = stage.model.flexion_deg.size();
    for (const char* const body : {"reference", "moving"}) {
      const Drawable& medial = drawable_of(stage.scene, "medial path, " + std::string(body));
      const Drawable& lateral = drawable_of(stage.scene, "lateral path, " + std::string(body));
      EXPECT_TRUE(medial.is_shown && lateral.is_shown);
      EXPECT_EQ(medial.parent, body == std::string("moving") ? BodyIndex::moving : BodyIndex::reference);
      // One ring a point and two for the ends of each piece; the medial path has two pieces.
      EXPECT_EQ(lateral.mesh.vertices.size(), n_tube_sides * (n_flexion + 2));
      EXPECT_EQ(medial.mesh.vertices.size(), n_tube_sides * (n_flexion + 4));
      const auto first = Eigen::RowVector3d::Map(&stage.model.contact_paths->at(1).moving_mm[0]);
      const Eigen::Vector3d start_mm = first.transpose() - stage.model.rotation_centre_mm;
      Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
      for (std::size_t k = n_tube_sides; k < 2 * n_tube_sides; ++k) {
        const std::array<float, 3>& p = lateral.mesh.vertices[k].position_mm;
        mean_mm += Eigen::Vector3d(p[0], p[1], p[2]) / n_tube_sides;
      }
      EXPECT_LT((mean_mm - start_mm).norm(), single_rounding_mm);
    }
  }
}

TEST(Layers, BandOfSamples)
{
  for (const std::string side : {"right", "left"}) {
    for (const BodyIndex held : {BodyIndex::moving, BodyIndex::reference, BodyIndex::world}) {
      Stage stage(layered_model(side));
      stage.held = held;
      stage.show({30.0, 1.0}, {Layer::band});
      const Drawable& body = drawable_of(stage.scene, "block");
      const Drawable& low = drawable_of(stage.scene, "block, quantile_5");
      const Drawable& high = drawable_of(stage.scene, "block, quantile_95");
      EXPECT_TRUE(body.is_shown && low.is_shown && high.is_shown);
      EXPECT_LT(low.material.opacity, 1.0F);
      EXPECT_GT(low.depth_offset_mm, 0.0);
      // The samples are 1 and 3 mm anterior, at zero varus and rotation.
      const Eigen::Vector3d apart_mm = high.X_world_mesh.translation() - low.X_world_mesh.translation();
      EXPECT_NEAR(apart_mm.norm(), 2.0, 1e-9);
      const store::Motion sample(stage.model, "quantile_5");
      const JointFrames frames = frames_of(stage.motion.at({rad_from_deg(30.0), rad_from_deg(1.0)}), held,
                                           stage.model.rotation_centre_mm);
      const Pose expected =
          frames.X_world_reference * sample.at({rad_from_deg(30.0), 0.0}).X_reference_moving;
      EXPECT_LT((low.X_world_mesh.linear() - expected.linear()).norm(), 1e-12);
      EXPECT_LT((low.X_world_mesh * Eigen::Vector3d(-low.origin_mm) - expected.translation()).norm(), 1e-9);
    }
  }
}

TEST(Labels, Names)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    store::MotionModel model = layered_model(side);
    model.joint = "knee";
    model.ligaments->bundle = {"ACLam", "MCLs"};
    const std::vector<store::JointLabel> labels = store::joint_labels(model);
    std::vector<std::string> texts;
    for (const store::JointLabel& label : labels) texts.push_back(label.text);
    EXPECT_EQ(texts, (std::vector<std::string>{"femur", "tibia", "ACL", "MCL", "medial", "lateral"}));
    // The subject's right is +Z.
    const double medial_z_mm = labels[4].first_mm.z() - labels[5].first_mm.z();
    EXPECT_EQ(medial_z_mm < 0.0, side == "right");
    model.joint = "other";
    EXPECT_EQ(store::joint_labels(model)[0].text, model.reference.name);
    // In the middle of the bone, whose size is not a knee's.
    const Box box = bounding_box(model.moving.contact.mesh);
    EXPECT_EQ(store::joint_labels(model)[1].first_mm, 0.5 * (box.min_mm + box.max_mm));
  }
}

TEST(Layers, GapsByEveryFace)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    stage.show({25, 2}, {Layer::gap_map});
    const store::JointPose pose = stage.motion.at({rad_from_deg(25.0), rad_from_deg(2.0)});
    const Drawable& sheet = drawable_of(stage.scene, "gaps on sheet");
    ASSERT_TRUE(sheet.is_shown);
    const Legend& legend = stage.layers.legend(Layer::gap_map);
    const VertexColour bone = srgb_from_linear(sheet.material.colour);
    const Mesh& ball = stage.model.reference.contact.mesh;
    int n_near = 0, n_far = 0;
    for (std::size_t v = 0; v < sheet.mesh.vertices.size(); ++v) {
      const double gap_mm = gap_by_every_face_mm(ball, pose, unlifted_mm(stage, sheet, v));
      const bool is_far = gap_mm > legend.highest + 1e-3;
      const bool is_near = gap_mm < 0.69 * legend.highest;  // where fading has not started
      n_far += is_far ? 1 : 0;
      n_near += is_near ? 1 : 0;
      const VertexColour& colour = sheet.colours[v];
      EXPECT_TRUE(!is_far || colour == bone) << gap_mm;
      EXPECT_TRUE(!is_near || difference(colour, colour_of(legend, gap_mm)) <= 1) << gap_mm;
    }
    EXPECT_GT(n_near, 20);
    EXPECT_GT(n_far, 20);
  }
}

TEST(Layers, Revisions)
{
  Stage stage(layered_model("right"));
  const LayerSet all = every_layer();
  stage.show({25, 2}, all);
  std::vector<std::uint64_t> revisions;
  for (const Drawable& drawable : stage.scene.drawables) revisions.push_back(drawable.revision);
  stage.held = BodyIndex::reference;  // the same pose in another frame
  stage.show({25, 2}, all);
  for (std::size_t i = 0; i < revisions.size(); ++i)
    EXPECT_EQ(stage.scene.drawables[i].revision, revisions[i]) << stage.scene.drawables[i].name;
  stage.show({26, 2}, all);
  EXPECT_GT(drawable_of(stage.scene, "ligaments/straight").revision, 1U);
  EXPECT_GT(drawable_of(stage.scene, "gaps on sheet").revision, 1U);
  EXPECT_EQ(drawable_of(stage.scene, "Delta").revision, 0U);
}

TEST(Layers, MirroredJoint)
{
  Stage right(layered_model("right")), left(layered_model("left"));
  const LayerSet all = every_layer();
  int n_compared = 0;
  for (const double flexion_deg : {0.0, 45.0, 80.0}) {
    right.show({flexion_deg, 1.0}, all);
    left.show({flexion_deg, 1.0}, all);
    for (std::size_t i = 0; i < right.scene.drawables.size(); ++i) {
      const Drawable &a = right.scene.drawables[i], &b = left.scene.drawables[i];
      if (a.layer == Layer::bodies || a.name == "right") continue;  // the subject's right is not mirrored
      SCOPED_TRACE(a.name);
      EXPECT_EQ(a.is_shown, b.is_shown);
      if (!a.is_shown) continue;  // no gap is within the range at the box under the sheet
      ++n_compared;
      const Eigen::Vector3d middle_a = middle_of_drawn_mm(a), middle_b = middle_of_drawn_mm(b);
      EXPECT_LT((middle_a - middle_b.cwiseProduct(Eigen::Vector3d(1, 1, -1))).norm(), single_rounding_mm);
    }
  }
  EXPECT_GT(n_compared, 20);
}

TEST(Palette, SrgbRoundTrip)
{
  for (int byte = 0; byte < 256; ++byte) {
    const auto b = static_cast<std::uint8_t>(byte);
    const VertexColour colour{b, static_cast<std::uint8_t>(255 - byte), b, 255};
    EXPECT_EQ(srgb_from_linear(linear_from_srgb(colour)), colour);
  }
}

TEST(LayersAllocation, EveryLayer)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  for (const std::string side : {"right", "left"}) {
    Stage stage(layered_model(side));
    const LayerSet all = every_layer();
    stage.show(Degrees{0.0, 0.0}, all);  // creates the static circle table of the solids
    const long before = test::allocations_of_program();
    int n_shown = 0;
    for (int k = 0; k < 200; ++k) {
      stage.show(Degrees{0.45 * k, 0.02 * k - 2.0}, all);
      for (const Drawable& drawable : stage.scene.drawables) n_shown += drawable.is_shown ? 1 : 0;
    }
    EXPECT_EQ(test::allocations_of_program() - before, 0);
    EXPECT_GT(n_shown, 200 * 10);
  }
  // The counter works.
  const long before = test::allocations_of_program();
  ::operator delete(::operator new(1));
  EXPECT_GE(test::allocations_of_program() - before, 1);
}

}  // namespace vrda::view::layers_test
