// The layers of a joint.
#include <gtest/gtest.h>

#include "core/text.hpp"
#include "core/units.hpp"
#include "player/view/layer_models.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"
#include "view/layers.hpp"
#include "view/scene.hpp"

namespace vrda::view::layers_test {

using test::drawable_of;
using test::layered_model;
using test::middle_world_mm;
using test::Stage;

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
  stage.show(pose, test::every_layer());
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
      stage.show(test::attitude_deg(stage.model, cell), {Layer::contacts});
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
  stage.show(test::attitude_deg(stage.model, cell), {Layer::normals});
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
  EXPECT_NEAR(length_mm[0] / length_mm[1], test::force_ratio, 1e-3);
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
      const Drawable& tubes = drawable_of(stage.scene, "ligaments");
      ASSERT_TRUE(tubes.is_shown);
      // The first fibre is straight with four points; its rings follow the end ring.
      const Eigen::Vector3d from_mm = pose.X_world_reference * rows.reference_mm.row(0).transpose();
      const Eigen::Vector3d to_mm = pose.X_world_moving * rows.moving_mm.row(0).transpose();
      EXPECT_LT((middle_world_mm(tubes, 12, 12) - from_mm).norm(), single_rounding_mm);
      EXPECT_LT((middle_world_mm(tubes, 48, 12) - to_mm).norm(), single_rounding_mm);
      const double strain = (to_mm - from_mm).norm() / rows.slack_length_mm[0] - 1.0;
      const Legend& legend = stage.layers.legend(Layer::ligaments);
      EXPECT_EQ(tubes.colours[12], colour_of(legend, 100.0 * strain));
      EXPECT_EQ(tubes.colours[12] == legend.below, strain < 0.0);
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
  const Drawable& bands = drawable_of(stage.scene, "ligaments");
  Eigen::AlignedBox3d box;
  for (std::size_t k = 12; k < 24; ++k) {
    const std::array<float, 3>& p = bands.mesh.vertices[k].position_mm;
    box.extend(Eigen::Vector3d(p[0], p[1], p[2]));
  }
  // Neighbouring bands overlap by a fifth of their distance, and are flat.
  EXPECT_NEAR(box.sizes().x(), 1.2 * 3.0, 0.05 * 3.0);  // fibres are tilted by up to 18 degrees
  EXPECT_LT(box.sizes().z(), 0.5 * box.sizes().x());
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
      EXPECT_EQ(medial.parent, body == std::string("moving") ? ParentFrame::moving : ParentFrame::reference);
      // One ring a point and two for the ends of each piece; the medial path has two pieces.
      EXPECT_EQ(lateral.mesh.vertices.size(), 12 * (n_flexion + 2));
      EXPECT_EQ(medial.mesh.vertices.size(), 12 * (n_flexion + 4));
      const auto first = Eigen::RowVector3d::Map(&stage.model.contact_paths->lateral_moving_mm[0]);
      const Eigen::Vector3d start_mm = first.transpose() - stage.model.rotation_centre_mm;
      Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
      for (std::size_t k = 12; k < 24; ++k) {
        const std::array<float, 3>& p = lateral.mesh.vertices[k].position_mm;
        mean_mm += Eigen::Vector3d(p[0], p[1], p[2]) / 12.0;
      }
      EXPECT_LT((mean_mm - start_mm).norm(), single_rounding_mm);
    }
  }
}

TEST(Layers, BandOfSamples)
{
  for (const std::string side : {"right", "left"}) {
    for (const FixedObject held : {FixedObject::moving, FixedObject::reference, FixedObject::push}) {
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
    // A ligament's label is midway between its attachments at every pose.
    const store::JointPose pose = store::Motion(model, "raw").at({rad_from_deg(40.0), 0.0});
    const Eigen::Vector3d wanted_mm =
        0.5 * (pose.X_world_reference * model.ligaments->reference_mm.row(0).transpose() +
               pose.X_world_moving * model.ligaments->moving_mm.row(0).transpose());
    EXPECT_LT((place_of(labels[2], frames_of(pose)) - wanted_mm).norm(), 1e-9);
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
      const double gap_mm = test::gap_by_every_face_mm(ball, pose, test::unlifted_mm(stage, sheet, v));
      const bool is_far = gap_mm > legend.highest + 1e-3;
      const bool is_near = gap_mm < 0.69 * legend.highest;  // where fading has not started
      n_far += is_far ? 1 : 0;
      n_near += is_near ? 1 : 0;
      const VertexColour& colour = sheet.colours[v];
      EXPECT_TRUE(!is_far || colour == bone) << gap_mm;
      EXPECT_TRUE(!is_near || test::difference(colour, colour_of(legend, gap_mm)) <= 1) << gap_mm;
    }
    EXPECT_GT(n_near, 20);
    EXPECT_GT(n_far, 20);
  }
}

TEST(Layers, Revisions)
{
  Stage stage(layered_model("right"));
  const LayerSet all = test::every_layer();
  stage.show({25, 2}, all);
  std::vector<std::uint64_t> revisions;
  for (const Drawable& drawable : stage.scene.drawables) revisions.push_back(drawable.revision);
  stage.held = FixedObject::reference;  // the same pose in another frame
  stage.show({25, 2}, all);
  for (std::size_t i = 0; i < revisions.size(); ++i)
    EXPECT_EQ(stage.scene.drawables[i].revision, revisions[i]) << stage.scene.drawables[i].name;
  stage.show({26, 2}, all);
  EXPECT_GT(drawable_of(stage.scene, "ligaments").revision, 1U);
  EXPECT_GT(drawable_of(stage.scene, "gaps on sheet").revision, 1U);
  EXPECT_EQ(drawable_of(stage.scene, "Delta").revision, 0U);
}

TEST(Layers, MirroredJoint)
{
  Stage right(layered_model("right")), left(layered_model("left"));
  const LayerSet all = test::every_layer();
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
      const Eigen::Vector3d middle_a = test::middle_of_drawn_mm(a), middle_b = test::middle_of_drawn_mm(b);
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
    test::Stage stage(test::layered_model(side));
    const LayerSet all = test::every_layer();
    stage.show(test::Degrees{0.0, 0.0}, all);  // creates the static circle table of the solids
    const long before = test::allocations_of_program();
    int n_shown = 0;
    for (int k = 0; k < 200; ++k) {
      stage.show(test::Degrees{0.45 * k, 0.02 * k - 2.0}, all);
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
