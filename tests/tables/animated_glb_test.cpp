// Exports to glTF and to OpenSim, read by assimp and pugixml.
#include <assimp/GltfMaterial.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/mesh.hpp"
#include "store/motion.hpp"
#include "store/sample_model.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "tables/formats.hpp"
#include "tables/osim_model.hpp"

namespace vrda::tables::animated_glb_test {

using pugi::xml_node;
using testing::UnorderedElementsAre;

constexpr double rate = 30.0;
// Single precision of positions within 0.2 m and of unit quaternions, for two rotations.
constexpr double single_rounding_m = 2e-7;

/// The joint turns by more than 180 degrees, so quaternions change their hemisphere.
store::MotionModel turning_model(const std::string& side)
{
  test::ModelPlan plan;
  plan.side = side;
  plan.flexion_deg = {0, 50, 100, 150, 200, 250, 300};
  plan.rotation_centre_mm = {5, 600, -30};
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.02 * flexion_deg, -3.0, 0.5 * varus_deg, 0.9 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  return model;
}

/// A model, its motion, and the exported file as assimp reads it.
struct Exported {
  store::MotionModel model;
  FlexionMotion motion = flexion_motion(model, "knee.h5", {});
  std::string bytes = animated_glb(model, motion, rate);
  Assimp::Importer importer = {};  ///< owns the scene
  const aiScene& scene;

  explicit Exported(store::MotionModel from) : model(std::move(from)), scene(read()) {}

 private:
  const aiScene& read()
  {
    const aiScene* found = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, "glb");
    if (found == nullptr) throw InternalError(importer.GetErrorString());
    return *found;
  }
};

Eigen::Matrix4d matrix(const aiMatrix4x4& m)
{
  Eigen::Matrix4d M;
  for (unsigned r = 0; r < 4; ++r) {
    for (unsigned c = 0; c < 4; ++c) M(r, c) = static_cast<double>(m[r][c]);
  }
  return M;
}

const aiNodeAnim& channel_of(const aiScene& scene, const std::string& node)
{
  const aiAnimation& animation = *scene.mAnimations[0];
  for (unsigned k = 0; k < animation.mNumChannels; ++k) {
    if (animation.mChannels[k]->mNodeName.C_Str() == node) return *animation.mChannels[k];
  }
  throw InternalError("no channel " + node);
}

/// The node's pose at a key, as computed by a glTF viewer. A rotation without keys of its own is constant.
Eigen::Matrix4d keyed(const aiNodeAnim& channel, unsigned key)
{
  const aiVector3D place = channel.mPositionKeys[key].mValue;
  const aiQuaternion turn = channel.mRotationKeys[std::min(key, channel.mNumRotationKeys - 1)].mValue;
  const aiMatrix4x4 X(aiVector3D(1, 1, 1), turn, place);
  return matrix(X);
}

/// World coordinates to the file's: anterior X is +Z, right Z is -X, in metres.
Eigen::Vector3d scene_point(const Eigen::Vector3d& p_world_mm)
{
  return Eigen::Vector3d(-p_world_mm.z(), p_world_mm.y(), p_world_mm.x()) * 1e-3;
}

TEST(AnimatedGlb, EveryKeyPutsTheBodiesWhereThePoseDoes)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    const Exported knee(turning_model(side));
    const Eigen::Matrix4d X_scene_joint = matrix(knee.scene.mRootNode->mTransformation);
    for (const Body* body : {&knee.model.reference, &knee.model.moving}) {
      const aiNodeAnim& channel = channel_of(knee.scene, body->name);
      ASSERT_EQ(channel.mNumPositionKeys, knee.motion.frames.size());
      ASSERT_EQ(channel.mNumRotationKeys, knee.motion.frames.size());
      for (unsigned key = 0; key < channel.mNumPositionKeys; ++key) {
        const store::JointPose& pose = knee.motion.frames[key].pose;
        const Pose& X_world_body = body == &knee.model.moving ? pose.X_world_moving : pose.X_world_reference;
        const Eigen::Matrix4d X = X_scene_joint * keyed(channel, key);
        for (const Eigen::Vector3d& p_mm :
             {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, 20, 0), Eigen::Vector3d(0, 10, 100)}) {
          const Eigen::Vector3d found = (X * (p_mm * 1e-3).homogeneous()).head<3>();
          const Eigen::Vector3d wanted = scene_point(X_world_body * (p_mm + knee.model.rotation_centre_mm));
          EXPECT_LT((found - wanted).norm(), single_rounding_m);
        }
      }
    }
  }
}

TEST(AnimatedGlb, KeysTakeTheShortWayAndTheStatedTimes)
{
  const Exported knee(turning_model("right"));
  ASSERT_EQ(knee.scene.mNumAnimations, 1U);
  bool has_left_the_first_half = false;
  for (const char* node : {"femur", "tibmen"}) {
    const aiNodeAnim& channel = channel_of(knee.scene, node);
    for (unsigned key = 0; key < channel.mNumRotationKeys; ++key) {
      // assimp uses milliseconds.
      EXPECT_NEAR(channel.mRotationKeys[key].mTime, 1e3 * knee.motion.frames[key].flexion_deg / rate, 1e-3);
      const aiQuaternion q = channel.mRotationKeys[key].mValue;
      has_left_the_first_half = has_left_the_first_half || q.w < 0.0F;
      const aiQuaternion p = channel.mRotationKeys[key == 0 ? 0 : key - 1].mValue;
      EXPECT_GT(p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z, 0.0F);
    }
  }
  EXPECT_TRUE(has_left_the_first_half);
}

TEST(AnimatedGlb, ComponentsKeepTheirVerticesAndTheColoursOfTheirMaterials)
{
  const Exported knee(turning_model("right"));
  std::multiset<std::string> materials;
  unsigned n_triangles = 0;
  for (unsigned m = 0; m < knee.scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *knee.scene.mMeshes[m];
    EXPECT_TRUE(mesh.HasNormals());
    const aiMaterial& material = *knee.scene.mMaterials[mesh.mMaterialIndex];
    aiString name;
    aiColor4D colour;
    ASSERT_EQ(material.Get(AI_MATKEY_NAME, name), AI_SUCCESS);
    if (std::string(name.C_Str()).starts_with("label ")) continue;
    ASSERT_EQ(material.Get(AI_MATKEY_BASE_COLOR, colour), AI_SUCCESS);
    const Material wanted = material_of(name.C_Str());
    EXPECT_EQ(Eigen::Vector3f(colour.r, colour.g, colour.b), wanted.colour);
    EXPECT_EQ(colour.a, wanted.opacity);
    n_triangles += mesh.mNumFaces;
    materials.insert(name.C_Str());
  }
  EXPECT_THAT(materials, UnorderedElementsAre("bone", "bone", "meniscus"));
  EXPECT_EQ(n_triangles, knee.model.reference.contact.mesh.triangles.rows() +
                             knee.model.moving.contact.mesh.triangles.rows());
  EXPECT_EQ(knee.scene.mRootNode->FindNode("plate")->mNumMeshes, 1U);
}

TEST(AnimatedGlb, MeshesAreInMetresAroundTheRotationCentre)
{
  const Exported knee(turning_model("right"));
  const aiNode& ball = *knee.scene.mRootNode->FindNode("ball");
  const aiMesh& sphere = *knee.scene.mMeshes[ball.mMeshes[0]];
  for (unsigned v = 0; v < sphere.mNumVertices; ++v) {
    EXPECT_NEAR(sphere.mVertices[v].Length(), 0.020F, single_rounding_m);
    // Outward, and within the facet angle of the radial direction.
    EXPECT_GT(sphere.mNormals[v] * sphere.mVertices[v].Normalize(), 0.9F);
  }
}

/// A straight fibre and one that bends over a cylinder of the reference.
store::LigamentRows two_fibres()
{
  store::LigamentRows rows;
  rows.name = {"straight", "over"};
  rows.bundle = {"ACLam", "MCLs"};
  rows.reference_mm.resize(2, 3);
  rows.reference_mm << 0, 610, -30, 30, 605, -30;
  rows.moving_mm.resize(2, 3);
  rows.moving_mm << 5, 570, -25, 0, 560, -30;
  rows.stiffness_n = {1000, 1000};
  rows.slack_length_mm = {40, 40};
  rows.wrap = {-1, 0};
  rows.wrap_name = {"drum"};
  rows.wrap_shape = {0};
  rows.wrap_body = {0};
  Pose X_body_wrap = Pose::Identity();
  X_body_wrap.translation() = Eigen::Vector3d(5, 600, -30);
  for (Eigen::Index k = 0; k < 16; ++k) rows.X_body_wrap.push_back(X_body_wrap.matrix()(k / 4, k % 4));
  rows.wrap_radii_mm.resize(1, 3);
  rows.wrap_radii_mm << 15, 15, 100;
  return rows;
}

/// The transform of a link at a key, scale included.
/// assimp's own constructor scales the rows instead of the columns.
Eigen::Matrix4d keyed_link(const aiNodeAnim& channel, unsigned key)
{
  const aiVector3D scale = channel.mScalingKeys[key].mValue;
  return keyed(channel, key) * Eigen::Vector4d(static_cast<double>(scale.x), static_cast<double>(scale.y),
                                               static_cast<double>(scale.z), 1.0)
                                   .asDiagonal();
}

TEST(AnimatedGlb, LinksOfFibresFollowTheirPath)
{
  store::MotionModel model = turning_model("right");
  model.ligaments = two_fibres();
  const Exported knee(std::move(model));
  const Eigen::Matrix4d X_scene_joint = matrix(knee.scene.mRootNode->mTransformation);
  const aiNodeAnim& femur = channel_of(knee.scene, knee.model.reference.name);
  const model::Ligaments ligaments = store::ligaments_of(knee.model);
  int n_wrapped = 0;
  for (std::size_t fibre = 0; fibre < ligaments.fibres.size(); ++fibre) {
    std::vector<const aiNodeAnim*> links;
    for (unsigned k = 0; k < knee.scene.mAnimations[0]->mNumChannels; ++k) {
      const aiNodeAnim& channel = *knee.scene.mAnimations[0]->mChannels[k];
      // assimp numbers nodes of equal names.
      if (std::string(channel.mNodeName.C_Str()).starts_with(ligaments.fibres[fibre].name))
        links.push_back(&channel);
    }
    ASSERT_EQ(links.size(), fibre == 0 ? 1U : 7U);
    for (unsigned key = 0; key < knee.motion.frames.size(); ++key) {
      const store::JointPose& pose = knee.motion.frames[key].pose;
      const Eigen::Matrix4d X_scene_femur = X_scene_joint * keyed(femur, key);
      Eigen::Vector3d at = scene_point(pose.X_world_reference * ligaments.fibres[fibre].reference_mm);
      double length_mm = 0.0;
      for (const aiNodeAnim* link : links) {
        const Eigen::Matrix4d X = X_scene_femur * keyed_link(*link, key);
        EXPECT_LT((X.col(3).head<3>() - at).norm(), single_rounding_m);
        at = (X * Eigen::Vector4d(0, -1, 0, 1)).head<3>();
        length_mm += X.col(1).norm() * 1e3;
      }
      EXPECT_LT((at - scene_point(pose.X_world_moving * ligaments.fibres[fibre].moving_mm)).norm(),
                single_rounding_m);
      // The chords of an arc are shorter than it: by 1 - sin(x) / x for half of 26 degrees, below 1 %.
      const model::FibrePath path =
          model::fibre_path(ligaments.fibres[fibre], ligaments.wraps,
                            {Eigen::Matrix3d::Identity(), pose.X_reference_moving.linear(),
                             pose.X_reference_moving.translation()});
      EXPECT_LT(length_mm, path.length_mm + 1e-3);
      EXPECT_GT(length_mm, 0.99 * path.length_mm);
      n_wrapped += path.is_wrapped ? 1 : 0;
    }
  }
  EXPECT_GT(n_wrapped, 0);
}

TEST(AnimatedGlb, LabelsAreBesideWhatTheyName)
{
  store::MotionModel model = turning_model("left");
  model.ligaments = two_fibres();
  const Exported knee(std::move(model));
  EXPECT_EQ(knee.scene.mNumTextures, store::joint_labels(knee.model).size());
  const Eigen::Matrix4d X_scene_joint = matrix(knee.scene.mRootNode->mTransformation);
  for (const store::JointLabel& label : store::joint_labels(knee.model)) {
    SCOPED_TRACE(label.text);
    const aiNodeAnim& channel = channel_of(knee.scene, "label " + label.text);
    for (unsigned key = 0; key < knee.motion.frames.size(); ++key) {
      const store::JointPose& pose = knee.motion.frames[key].pose;
      const auto placed = [&](BodyIndex body, const Eigen::Vector3d& p_mm) -> Eigen::Vector3d {
        return (body == BodyIndex::reference ? pose.X_world_reference : pose.X_world_moving) * p_mm;
      };
      const Eigen::Vector3d point =
          scene_point(0.5 * (placed(label.first, label.first_mm) + placed(label.second, label.second_mm)));
      const Eigen::Vector3d found = (X_scene_joint * keyed(channel, key)).col(3).head<3>();
      // At the same height, outward from the joint's axis.
      EXPECT_NEAR(found.y(), point.y(), single_rounding_m);
      EXPECT_GT(std::hypot(found.x(), found.z()), std::hypot(point.x(), point.z()) - single_rounding_m);
      // In its direction; points within 2 mm of the axis have none, and labels are 62 mm away: 0.002 x 0.062.
      EXPECT_NEAR(found.x() * point.z(), found.z() * point.x(), 1.3e-4);
    }
  }
}

TEST(AnimatedGlb, EqualModelsGiveEqualBytes)
{
  store::MotionModel model = turning_model("left");
  model.title = "no \xff UTF-8";
  const Exported knee(model);
  EXPECT_EQ(Exported(model).bytes, knee.bytes);
  EXPECT_EQ(knee.bytes.size() % 4, 0U);
}

const OsimOptions knee{"knee.h5", "knee_flex_r", "knee"};

std::vector<double> numbers(const xml_node& node, const char* name)
{
  std::istringstream text(node.child(name).text().get());
  std::vector<double> values;
  for (double value = 0.0; text >> value;) values.push_back(value);
  return values;
}

FlexionMotion motion_of(const store::MotionModel& model)
{
  FlexionPlan plan;
  plan.set = "raw";
  return flexion_motion(model, "knee.h5", plan);
}

pugi::xml_document parsed(const store::MotionModel& model)
{
  pugi::xml_document document;
  EXPECT_TRUE(document.load_string(osim_model(model, motion_of(model), knee).xml.c_str()));
  return document;
}

// Closed form: the translations are those of the rotation centre, wherever the meshes have their origin.
TEST(OsimModel, TranslationsAreThoseOfTheRotationCentre)
{
  test::ModelPlan plan;
  plan.rotation_centre_mm = {400, -900, 80};
  plan.motion = [](double flexion_deg, double) {
    return store::PoseCoordinates{0.0, -3.0, 0.0, 0.2 * flexion_deg};
  };
  const store::MotionModel model = test::model_of(plan);
  const pugi::xml_document document = parsed(model);
  const xml_node joint = document.select_node("//CustomJoint").node();
  for (const pugi::xpath_node& frame : joint.select_nodes("frames/PhysicalOffsetFrame"))
    EXPECT_THAT(numbers(frame.node(), "translation"), testing::ElementsAre(0.4, -0.9, 0.08));
  double longest_m = 0.0;
  for (const pugi::xpath_node& axis : joint.select_nodes("SpatialTransform/TransformAxis/SimmSpline")) {
    if (std::string(axis.node().parent().attribute("name").value()).find("translation") != 0) continue;
    for (const double m : numbers(axis.node(), "y")) longest_m = std::max(longest_m, std::abs(m));
  }
  // 3 mm along Delta; the solver's rounding at coordinates of 1 m.
  EXPECT_NEAR(longest_m, 0.003, 1e-12);
}

TEST(OsimModel, WrapsHaveTheirAnglesRadiiAndBodies)
{
  test::SampleOptions options;
  options.has_failed_cell = false;
  options.is_equilibrium = true;
  options.n_fibres = 4;
  options.n_wraps = 2;
  const store::MotionModel model = test::sample_model(options);
  const pugi::xml_document document = parsed(model);
  const store::LigamentRows& ligaments = *model.ligaments;
  const std::vector<std::string> paths{"//Body[1]//WrapCylinder", "//Body[2]//WrapEllipsoid"};
  for (std::size_t row = 0; row < paths.size(); ++row) {
    const xml_node wrap = document.select_node(paths[row].c_str()).node();
    ASSERT_TRUE(wrap) << paths[row];
    const Pose X = store::pose_in(ligaments.X_body_wrap, row);
    const std::vector<double> angles = numbers(wrap, "xyz_body_rotation");
    ASSERT_EQ(angles.size(), 3u);
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(angles[0], Eigen::Vector3d::UnitX()) *
                               Eigen::AngleAxisd(angles[1], Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(angles[2], Eigen::Vector3d::UnitZ()))
                                  .toRotationMatrix();
    EXPECT_LT((R - X.linear()).norm(), 1e-12) << "rounding";
    const std::vector<double> at_m = numbers(wrap, "translation");
    for (int k = 0; k < 3; ++k)
      EXPECT_DOUBLE_EQ(at_m[static_cast<std::size_t>(k)], 1e-3 * X.translation()[k]);
  }
  EXPECT_THAT(numbers(document.select_node(paths[0].c_str()).node(), "radius"), testing::ElementsAre(0.02));
  EXPECT_THAT(numbers(document.select_node(paths[0].c_str()).node(), "length"), testing::ElementsAre(0.06));
  EXPECT_THAT(numbers(document.select_node(paths[1].c_str()).node(), "dimensions"),
              testing::ElementsAre(0.02, 0.02, 0.03));
  // Blanks are no part of OpenSim's names.
  EXPECT_STREQ(document.select_node("//PathWrap/wrap_object").node().text().get(), "condyle_1");
}

// The splines are of flexion, whatever numbers the frames.
TEST(OsimModel, ASequenceWhoseFlexionRisesIsTheJointOfItsFlexions)
{
  const store::MotionModel model = test::model_of({});
  FlexionMotion motion = motion_of(model);
  const std::string joint = osim_joint(model, motion, knee);
  motion.key_name = "time_s";
  EXPECT_EQ(osim_joint(model, motion, knee), joint);
}

TEST(OsimModel, FlexionMustRise)
{
  const store::MotionModel model = test::model_of({});
  FlexionMotion motion = motion_of(model);
  motion.frames[1].clinical.flexion_rad = motion.frames[0].clinical.flexion_rad;
  EXPECT_THAT(test::input_error([&] { osim_joint(model, motion, knee); }),
              test::refuses({.file = "knee.h5", .field = "flexion"}));
  motion.frames.resize(1);
  EXPECT_THAT(test::input_error([&] { osim_joint(model, motion, knee); }),
              test::refuses({.file = "knee.h5", .field = "flexion"}));
}

}  // namespace vrda::tables::animated_glb_test
