#include <gtest/gtest.h>

#include "core/text.hpp"
#include "core/units.hpp"
#include "player/view/layer_models.hpp"
#include "view/layers.hpp"
#include "view/scene.hpp"

namespace vrda::layers_test {

using test::drawable_of;
using test::layered_model;
using test::middle_world_mm;
using test::Stage;

constexpr double single_rounding_mm = 1e-4;  // single precision at 100 mm, mean of about a hundred values
constexpr double rounding = 1e-12;

void expect_bodies_alone(const view::Scene& scene)
{
  for (const view::Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.layer == view::Layer::bodies) << drawable.name;
}

TEST(Layers, NothingIsShownUntilItIsWanted)
{
  Stage stage(layered_model("right"));
  stage.show({30, 0}, view::LayerSet{});
  int n_layers_drawn = 0;
  for (const view::Drawable& drawable : stage.scene.drawables)
    n_layers_drawn += drawable.layer == view::Layer::bodies ? 0 : 1;
  expect_bodies_alone(stage.scene);
  EXPECT_GT(n_layers_drawn, 8);
  for (const std::string& name : view::layer_names())
    EXPECT_TRUE(stage.layers.available().has(*view::layer_named(name)));
}

TEST(Layers, AModelWithoutContactsAndFibresSaysSo)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  Stage stage(model);
  const view::LayerSet& available = stage.layers.available();
  EXPECT_FALSE(available.has(view::Layer::contacts));
  EXPECT_FALSE(available.has(view::Layer::normals));
  EXPECT_FALSE(available.has(view::Layer::ligaments));
  EXPECT_TRUE(available.has(view::Layer::axes));
  EXPECT_TRUE(available.has(view::Layer::helical_axis));
  EXPECT_TRUE(available.has(view::Layer::gap_map));
  // Requesting them shows nothing and does not fail.
  stage.show({30, 0}, {view::Layer::contacts, view::Layer::normals, view::Layer::ligaments});
  expect_bodies_alone(stage.scene);
}

TEST(Layers, NothingIsShownWithoutAPose)
{
  Stage stage(layered_model("right"));
  store::JointPose pose = stage.motion.at({});
  pose.status = store::PoseStatus::unsolved_cell;
  stage.show(pose, test::every_layer());
  expect_bodies_alone(stage.scene);
}

TEST(Layers, ContactsLieWhereTheCellSays)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    const store::ContactRows& rows = stage.model.contacts;
    for (const std::size_t cell : {std::size_t{1}, std::size_t{17}, std::size_t{34}}) {
      stage.show(test::attitude_deg(stage.model, cell), {view::Layer::contacts});
      const view::Drawable& balls = drawable_of(stage.scene, "contacts");
      ASSERT_TRUE(balls.is_shown);
      for (std::int64_t row = rows.row_start[cell]; row < rows.row_start[cell + 1]; ++row) {
        const auto solid = static_cast<std::size_t>(row - rows.row_start[cell]);
        const Eigen::Vector3d p_mm =
            middle_world_mm(balls, solid * view::ball_size().n_vertices, view::ball_size().n_vertices);
        EXPECT_LT((p_mm - rows.point_world_mm.row(row).transpose()).norm(), single_rounding_mm);
      }
    }
  }
}

TEST(Layers, BetweenCellsContactsStayOnTheMovingObject)
{
  Stage stage(layered_model("right"));
  stage.show({30, 0}, {view::Layer::contacts});
  const view::Drawable& balls = drawable_of(stage.scene, "contacts");
  const std::vector<RenderVertex> vertices = balls.mesh.vertices;
  const std::uint64_t revision = balls.revision;
  stage.show({34, 0.4}, {view::Layer::contacts});  // the same nearest cell
  EXPECT_EQ(balls.revision, revision);
  EXPECT_EQ(balls.mesh.vertices.front().position_mm, vertices.front().position_mm);
  EXPECT_EQ(balls.X_world_mesh.matrix(), drawable_of(stage.scene, "block").X_world_mesh.matrix());
  stage.show({41, 0}, {view::Layer::contacts});
  EXPECT_GT(balls.revision, revision);
}

TEST(Layers, AnArrowIsAsLongAsItsForceAndPressesThere)
{
  Stage stage(layered_model("right"));
  const store::ForceRows& rows = stage.model.equilibrium->forces;
  const std::size_t cell = 17;
  stage.show(test::attitude_deg(stage.model, cell), {view::Layer::normals});
  const view::Drawable& arrows = drawable_of(stage.scene, "contact forces");
  ASSERT_TRUE(arrows.is_shown);
  std::vector<double> length_mm;
  for (std::int64_t row = rows.row_start[cell]; row < rows.row_start[cell + 1]; ++row) {
    const std::size_t first =
        static_cast<std::size_t>(row - rows.row_start[cell]) * view::arrow_size().n_vertices;
    const Eigen::Vector3d tail_mm = middle_world_mm(arrows, first, 12),
                          tip_mm = middle_world_mm(arrows, first + view::arrow_size().n_vertices - 12, 12);
    EXPECT_LT((tip_mm - rows.point_world_mm.row(row).transpose()).norm(), single_rounding_mm);
    const Eigen::Vector3d along = (tip_mm - tail_mm).normalized();
    EXPECT_LT((along - rows.normal_world.row(row).transpose()).norm(), 1e-4);
    length_mm.push_back((tip_mm - tail_mm).norm());
  }
  ASSERT_EQ(length_mm.size(), 2U);
  EXPECT_NEAR(length_mm[0] / length_mm[1], test::force_ratio, 1e-3);
}

TEST(Layers, AxesAreAtTheRotationCentreAndAlongTheirDirections)
{
  Stage stage(layered_model("right"));
  stage.show({40, 3}, {view::Layer::axes});
  const auto direction = [&](const char* name) {
    const view::Drawable& axis = drawable_of(stage.scene, name);
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
  EXPECT_EQ(view::JointLayers::axis_labels().size(), 7U);
}

TEST(Layers, HeldReferenceTurnsTheWorldsAxesWithTheRest)
{
  Stage stage(layered_model("left"));
  stage.held = view::FixedObject::reference;
  stage.show({40, 3}, {view::Layer::axes});
  EXPECT_LT(
      (drawable_of(stage.scene, "anterior").X_world_mesh.linear().col(1) - Eigen::Vector3d::UnitX()).norm(),
      rounding);
  const view::Drawable& moving = drawable_of(stage.scene, "block");
  const Eigen::Vector3d delta = drawable_of(stage.scene, "Delta").X_world_mesh.linear().col(1);
  // Theta rotates about Delta, so Delta is fixed in the moving object.
  EXPECT_LT((delta - moving.X_world_mesh.linear() * Eigen::Vector3d::UnitY()).norm(), rounding);
}

TEST(Layers, TheHelicalAxisOfPureFlexionIsTheFlexionAxis)
{
  test::ModelPlan plan;
  plan.rotation_centre_mm = {100, -200, 40};
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  const store::Motion motion(model, "raw");
  for (const double flexion_deg : {0.0, 33.0, 90.0}) {
    const std::optional<HelicalAxis> axis =
        view::helical_axis_at(motion, {rad_from_deg(flexion_deg), 0.0}, plan.rotation_centre_mm);
    ASSERT_TRUE(axis.has_value());
    EXPECT_LT((axis->point_mm - plan.rotation_centre_mm).norm(), 1e-9);
    EXPECT_LT((axis->direction + Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(axis->rotation_rad, rad_from_deg(flexion_deg == 33.0 ? 2.0 : 1.0), 1e-9);
  }
  Stage stage(model);
  stage.show({33, 0}, {view::Layer::helical_axis});
  const view::Drawable& rod = drawable_of(stage.scene, "helical axis");
  EXPECT_TRUE(rod.is_shown);
  EXPECT_LT(rod.X_world_mesh.translation().norm(), 1e-9);
  EXPECT_NEAR(std::abs(rod.X_world_mesh.linear()(2, 1)), 1.0, 1e-9);
}

TEST(Layers, FibresRunFromAttachmentToAttachmentAndAreColouredByTheirStrain)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    const store::LigamentRows& rows = *stage.model.ligaments;
    int n_slack = 0, n_taut = 0;
    for (const double flexion_deg : {0.0, 37.0, 90.0}) {
      stage.show({flexion_deg, 1.0}, {view::Layer::ligaments});
      const store::JointPose pose = stage.motion.at({rad_from_deg(flexion_deg), rad_from_deg(1.0)});
      const view::Drawable& tubes = drawable_of(stage.scene, "ligaments");
      ASSERT_TRUE(tubes.is_shown);
      // The first fibre is straight with four points; its rings follow the end ring.
      const Eigen::Vector3d from_mm = pose.X_world_reference * rows.reference_mm.row(0).transpose();
      const Eigen::Vector3d to_mm = pose.X_world_moving * rows.moving_mm.row(0).transpose();
      EXPECT_LT((middle_world_mm(tubes, 12, 12) - from_mm).norm(), single_rounding_mm);
      EXPECT_LT((middle_world_mm(tubes, 48, 12) - to_mm).norm(), single_rounding_mm);
      const double strain = (to_mm - from_mm).norm() / rows.slack_length_mm[0] - 1.0;
      const view::Legend& legend = stage.layers.strain_legend();
      EXPECT_EQ(tubes.colours[12], view::colour_of(legend, 100.0 * strain));
      EXPECT_EQ(tubes.colours[12] == legend.below, strain < 0.0);
      n_slack += strain < 0.0 ? 1 : 0;
      n_taut += strain > 0.0 ? 1 : 0;
    }
    EXPECT_GT(n_slack, 0);
    EXPECT_GT(n_taut, 0);
  }
}

TEST(Layers, BandsOfABundleAreWideTowardsTheirNeighbours)
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
  stage.show({0.0, 0.0}, {view::Layer::ligaments});
  const view::Drawable& bands = drawable_of(stage.scene, "ligaments");
  Eigen::AlignedBox3d box;
  for (std::size_t k = 12; k < 24; ++k) {
    const std::array<float, 3>& p = bands.mesh.vertices[k].position_mm;
    box.extend(Eigen::Vector3d(p[0], p[1], p[2]));
  }
  // Neighbouring bands overlap by a fifth of their distance, and are flat.
  EXPECT_NEAR(box.sizes().x(), 1.2 * 3.0, 0.05 * 3.0);  // fibres are tilted by up to 18 degrees
  EXPECT_LT(box.sizes().z(), 0.5 * box.sizes().x());
}

TEST(Layers, ContactPathsLieOnBothBodiesAndBreakAtJumps)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    stage.show({30.0, 1.0}, {view::Layer::contact_paths});
    const std::size_t n_flexion = stage.model.flexion_deg.size();
    for (const char* const body : {"reference", "moving"}) {
      const view::Drawable& medial = drawable_of(stage.scene, "medial path, " + std::string(body));
      const view::Drawable& lateral = drawable_of(stage.scene, "lateral path, " + std::string(body));
      EXPECT_TRUE(medial.is_shown && lateral.is_shown);
      EXPECT_EQ(medial.parent,
                body == std::string("moving") ? view::ParentFrame::moving : view::ParentFrame::reference);
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

TEST(Labels, NameBonesLigamentsAndSides)
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
    EXPECT_LT((view::place_of(labels[2], view::frames_of(pose)) - wanted_mm).norm(), 1e-9);
    model.joint = "other";
    EXPECT_EQ(store::joint_labels(model)[0].text, model.reference.name);
    // In the middle of the bone, whose size is not a knee's.
    const Box box = bounding_box(model.moving.contact.mesh);
    EXPECT_EQ(store::joint_labels(model)[1].first_mm, 0.5 * (box.min_mm + box.max_mm));
  }
}

TEST(Layers, StrainsAreThoseOfTheLigamentRoom)
{
  const store::MotionModel model = layered_model("right");
  const model::Ligaments ligaments = store::ligaments_of(model);
  view::Scene scene = view::scene_of(model.reference, model.moving, model.rotation_centre_mm);
  view::LigamentLayer layer(model, scene);
  const store::Motion motion(model, "raw");
  const SolverFrame frame{Side::right, model.rotation_centre_mm, model.delta};
  int n_wrapped = 0;
  for (const double flexion_deg : {0.0, 20.0, 75.0}) {
    const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(-1.0)});
    layer.update(scene, pose);
    const Eigen::Vector3d shift_mm = pose.X_world_moving * model.rotation_centre_mm;
    const std::vector<model::FibreState> states =
        model::fibre_states(model::solver_ligaments(ligaments, frame), pose.attitude,
                            {solver_translation_mm(frame, shift_mm), pose.theta_rad});
    for (std::size_t i = 0; i < states.size(); ++i) {
      EXPECT_NEAR(layer.strain()[i], states[i].strain, 1e-9);
      n_wrapped += states[i].is_wrapped ? 1 : 0;
    }
  }
  EXPECT_GT(n_wrapped, 0);
}

TEST(Layers, GapsAreThoseOfEveryFaceInTurn)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    Stage stage(layered_model(side));
    stage.show({25, 2}, {view::Layer::gap_map});
    const store::JointPose pose = stage.motion.at({rad_from_deg(25.0), rad_from_deg(2.0)});
    const view::Drawable& sheet = drawable_of(stage.scene, "gaps on sheet");
    ASSERT_TRUE(sheet.is_shown);
    const view::Legend& legend = stage.layers.gap_legend();
    const view::VertexColour bone = view::srgb_from_linear(sheet.material.colour);
    const Mesh& ball = stage.model.reference.contact.mesh;
    int n_near = 0, n_far = 0;
    for (std::size_t v = 0; v < sheet.mesh.vertices.size(); ++v) {
      const double gap_mm = test::gap_by_every_face_mm(ball, pose, test::unlifted_mm(stage, sheet, v));
      const bool is_far = gap_mm > legend.highest + 1e-3;
      const bool is_near = gap_mm < 0.69 * legend.highest;  // where fading has not started
      n_far += is_far ? 1 : 0;
      n_near += is_near ? 1 : 0;
      const view::VertexColour& colour = sheet.colours[v];
      EXPECT_TRUE(!is_far || colour == bone) << gap_mm;
      EXPECT_TRUE(!is_near || test::difference(colour, view::colour_of(legend, gap_mm)) <= 1) << gap_mm;
    }
    EXPECT_GT(n_near, 20);
    EXPECT_GT(n_far, 20);
  }
}

TEST(Layers, TrianglesBeyondTheRangeAreLeftOutAndSizesStay)
{
  Stage stage(layered_model("right"));
  const view::Drawable& sheet = drawable_of(stage.scene, "gaps on sheet");
  const std::size_t n_indices = sheet.mesh.triangles.size();
  stage.show({25, 2}, {view::Layer::gap_map});
  EXPECT_EQ(sheet.mesh.triangles.size(), n_indices);
  const auto n_drawn = [&] {
    int n = 0;
    for (std::size_t t = 0; t < n_indices; t += 3)
      n += sheet.mesh.triangles[t] != sheet.mesh.triangles[t + 1] ? 1 : 0;
    return n;
  };
  EXPECT_GT(n_drawn(), 10);
  EXPECT_LT(n_drawn(), static_cast<int>(n_indices / 3));
}

TEST(Layers, ARevisionRisesOnlyWhenSomethingChanges)
{
  Stage stage(layered_model("right"));
  const view::LayerSet all = test::every_layer();
  stage.show({25, 2}, all);
  std::vector<std::uint64_t> revisions;
  for (const view::Drawable& drawable : stage.scene.drawables) revisions.push_back(drawable.revision);
  stage.held = view::FixedObject::reference;  // the same pose in another frame
  stage.show({25, 2}, all);
  for (std::size_t i = 0; i < revisions.size(); ++i)
    EXPECT_EQ(stage.scene.drawables[i].revision, revisions[i]) << stage.scene.drawables[i].name;
  stage.show({26, 2}, all);
  EXPECT_GT(drawable_of(stage.scene, "ligaments").revision, 1U);
  EXPECT_GT(drawable_of(stage.scene, "gaps on sheet").revision, 1U);
  EXPECT_EQ(drawable_of(stage.scene, "Delta").revision, 0U);
}

TEST(Layers, AMirroredJointShowsTheMirrorImage)
{
  Stage right(layered_model("right")), left(layered_model("left"));
  const view::LayerSet all = test::every_layer();
  int n_compared = 0;
  for (const double flexion_deg : {0.0, 45.0, 80.0}) {
    right.show({flexion_deg, 1.0}, all);
    left.show({flexion_deg, 1.0}, all);
    for (std::size_t i = 0; i < right.scene.drawables.size(); ++i) {
      const view::Drawable &a = right.scene.drawables[i], &b = left.scene.drawables[i];
      if (a.layer == view::Layer::bodies || a.name == "right")
        continue;  // the subject's right is not mirrored
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

TEST(Layers, LayersTakeNoPartInFraming)
{
  Stage stage(layered_model("right"));
  stage.show({25, 2}, view::LayerSet{});
  const std::size_t n_points = view::points_within(stage.scene, {}).size();
  const view::Sphere sphere = view::joint_sphere(stage.scene);
  stage.show({25, 2}, test::every_layer());
  EXPECT_EQ(view::points_within(stage.scene, {}).size(), n_points);
  EXPECT_EQ(view::joint_sphere(stage.scene).radius_mm, sphere.radius_mm);
}

TEST(LayerSet, NamesAndLayersGoTogether)
{
  for (const std::string& name : view::layer_names())
    EXPECT_EQ(view::name_of(*view::layer_named(name)), name);
  EXPECT_EQ(view::layer_names().size(), view::n_layers - 1);
  EXPECT_EQ(view::layer_named("gaps"), view::Layer::gap_map);
  EXPECT_EQ(view::layer_named("bodies"), std::nullopt);
  EXPECT_THROW(view::name_of(view::Layer::bodies), InternalError);
}

view::Legend legend()
{
  view::Legend made;
  made.lowest = 2.0;
  made.highest = 12.0;
  made.palette = view::gap_palette();
  return made;
}

/// Relative luminance; perceived lightness increases monotonically with it.
double luminance(const view::VertexColour& colour)
{
  return Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F).dot(view::linear_from_srgb(colour));
}

TEST(Palette, ColoursAreThoseOfThePaletteAndMixedBetween)
{
  const view::Legend l = legend();
  for (std::size_t k = 0; k < l.palette.size(); ++k)
    EXPECT_EQ(view::colour_of(l, 2.0 + static_cast<double>(k)), l.palette[k]);
  EXPECT_EQ(view::colour_of(l, 2.5), view::interpolated_colour(l.palette[0], l.palette[1], 0.5));
  EXPECT_EQ(view::colour_of(l, -50.0), l.palette.front());
  EXPECT_EQ(view::colour_of(l, 1e9), l.palette.back());
}

TEST(Palette, ValuesBelowHaveTheirOwnColourWhereTheLegendSaysSo)
{
  view::Legend l = legend();
  l.below = {1, 2, 3, 255};
  l.below_label = "slack";
  EXPECT_EQ(view::colour_of(l, 1.999), l.below);
  EXPECT_EQ(view::colour_of(l, 2.0), l.palette.front());
}

TEST(Palette, ClosenessDarkensWithEveryStep)
{
  for (std::size_t k = 1; k < view::gap_palette().size(); ++k)
    EXPECT_LT(luminance(view::gap_palette()[k]), luminance(view::gap_palette()[k - 1])) << k;
}

TEST(Palette, TensionIsLightestInTheMiddle)
{
  const view::Palette& palette = view::strain_palette();
  for (std::size_t k = 1; k < palette.size(); ++k) {
    const bool is_rising = k <= palette.size() / 2;
    EXPECT_EQ(luminance(palette[k]) > luminance(palette[k - 1]), is_rising) << k;
  }
}

TEST(Palette, EncodingAndDecodingAreARoundTrip)
{
  for (int byte = 0; byte < 256; ++byte) {
    const auto b = static_cast<std::uint8_t>(byte);
    const view::VertexColour colour{b, static_cast<std::uint8_t>(255 - byte), b, 255};
    EXPECT_EQ(view::srgb_from_linear(view::linear_from_srgb(colour)), colour);
  }
}

}  // namespace vrda::layers_test
