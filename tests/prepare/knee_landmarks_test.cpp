#include "prepare/knee_landmarks.hpp"

#include <gmock/gmock.h>

#include "core/text.hpp"
#include "support/refusal.hpp"

namespace vrda::knee_landmarks_test {

using prepare::Bone, prepare::KneeLandmarks, prepare::LandmarkScales, prepare::TemplateJoint;
using test::refuses;

KneeLandmarks read(const std::string& text)
{
  return prepare::read_knee_landmarks("marks.toml", text);
}

InputError::Facts refused(const std::string& text)
{
  return test::input_error([&] { read(text); });
}

const TemplateJoint& generic()
{
  static const TemplateJoint joint = prepare::generic_template();
  return joint;
}

std::string list(const Eigen::Vector3d& v)
{
  return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]\n";
}

const std::vector<std::string> names{"medial_epicondyle", "lateral_epicondyle", "medial_spine",
                                     "lateral_spine",     "medial_plateau",     "lateral_plateau",
                                     "fibular_head"};

TEST(KneeLandmarks, all_tables)
{
  const KneeLandmarks marks = read(R"(
[landmarks]
medial_epicondyle = [1, 2, 3.5]
[[fibre]]
name = "ACLam1"
tibia = [4, 5, 6]
[[distance]]
from = "medial_plateau"
to = "lateral_plateau"
mm = 72.5
)");
  ASSERT_EQ(marks.points.size(), 1U);
  EXPECT_EQ(marks.points[0].name, "medial_epicondyle");
  EXPECT_EQ(marks.points[0].p, Eigen::Vector3d(1, 2, 3.5));
  EXPECT_FALSE(marks.fibres.at(0).femur.has_value());
  EXPECT_EQ(*marks.fibres.at(0).tibia, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(marks.distances.at(0).mm, 72.5);
}

// Points of Slicer in either space and another unit, for meshes of either space: one point.
TEST(KneeLandmarks, PointsOfSlicerAreInTheSpaceAndUnitOfTheMeshes)
{
  const std::string json =
      R"({"markups": [{"coordinateSystem": "LPS", "coordinateUnits": "cm", "controlPoints": [
      {"label": "medial_epicondyle", "position": [1, 2, 3.5]}, {"label": "ACLam1.tibia", "position": [4, 5, 6]},
      {"label": "later", "positionStatus": "undefined"}]}]})";
  const std::string rest = ",0,0,0,1,1,1,0,";
  const std::string rows = "# columns = id,x,y,z\r\n1,10,20,35" + rest + "medial_epicondyle,,\r\n2,40,50,60" +
                           rest + "ACLam1.tibia,,\r\n";
  struct Row {
    std::string file, text, space;
    double unit_mm;
    Eigen::Vector3d epicondyle;
  };
  for (const Row& row :
       {Row{"a.mrk.json", json, "", 1.0, {10, 20, 35}}, Row{"a.mrk.json", json, "LPS", 10.0, {1, 2, 3.5}},
        Row{"a.mrk.json", json, "RAS", 1.0, {-10, -20, 35}},
        Row{"a.fcsv", "# CoordinateSystem = LPS\n" + rows, "LPS", 1.0, {10, 20, 35}},
        Row{"a.fcsv", "# CoordinateSystem = 0\n" + rows, "LPS", 1.0, {-10, -20, 35}},
        Row{"a.fcsv", "# CoordinateSystem = 1\n" + rows, "RAS", 1.0, {-10, -20, 35}}}) {
    SCOPED_TRACE(row.text + row.space);
    const KneeLandmarks marks = prepare::read_knee_landmarks(row.file, row.text, {row.space, row.unit_mm});
    ASSERT_EQ(marks.points.size(), 1U);
    EXPECT_EQ(marks.points[0].p, row.epicondyle);
    EXPECT_EQ(marks.fibres.at(0).name, "ACLam1");
    const double sign = row.epicondyle.x() < 0.0 ? -1.0 : 1.0;
    EXPECT_EQ(*marks.fibres.at(0).tibia, Eigen::Vector3d(sign * 40, sign * 50, 60) / row.unit_mm);
  }
}

TEST(KneeLandmarks, WhatIsNotOneIsRefusedByLineAndKey)
{
  EXPECT_THAT(refused(""), refuses({"marks.toml", "", "no point", "[landmarks]"}));
  EXPECT_THAT(refused("[landmarks]\nmedial_epicondile = [1, 2, 3]\n"),
              refuses({"marks.toml", "line 2, landmarks.medial_epicondile", "", "medial_epicondyle"}));
  EXPECT_THAT(refused("[landmarks]\nmedial_spine = [1, 2]\n"),
              refuses({"marks.toml", "line 2, landmarks.medial_spine", "[1, 2]"}));
  EXPECT_THAT(refused("[[fibre]]\nname = \"A\"\n"),
              refuses({.field = "line 1, fibre.0", .found = "neither"}));
  EXPECT_THAT(refused("[[fibre]]\nname = \"A\"\nfemur = [1,2,3]\n[[fibre]]\nname = \"A\"\nfemur = [1,2,3]\n"),
              refuses({.field = "line 5, fibre.1.name", .found = "\"A\""}));
  EXPECT_THAT(
      refused("[[distance]]\nfrom = \"medial_spine\"\nto = \"medial_epicondyle\"\nmm = 40\n"),
      refuses({.field = "line 3, distance.0.to", .found = "medial_epicondyle", .wanted = "same bone"}));
  EXPECT_THAT(refused("[[distance]]\nfrom = \"medial_spine\"\nto = \"medial_spine\"\nmm = 40\n"),
              refuses({.field = "line 3, distance.0.to", .found = "medial_spine"}));
  EXPECT_THAT(refused("[[distance]]\nfrom = \"medial_spine\"\nto = \"lateral_spine\"\nmm = 0\n"),
              refuses({.field = "line 4, distance.0.mm", .found = "0", .wanted = "1"}));
  const KneeLandmarks other = read("[[fibre]]\nname = \"ACLan1\"\nfemur = [1, 2, 3]\n");
  EXPECT_THAT(test::input_error([&] { check_fibre_names(other, generic().joint.ligaments); }),
              refuses({"marks.toml", "line 2, fibre.0.name", "\"ACLan1\"", "\"ACLam1\""}));
}

TEST(LandmarksOfTheTemplate, anatomy)
{
  const auto at = [](const std::string& name) { return *landmark_mm(generic(), name); };
  // Attachments of the collateral ligaments are at the epicondyles and at the fibular head.
  EXPECT_LT((at("medial_epicondyle") - Eigen::Vector3d(4, 9, -41)).norm(), 8.0);
  EXPECT_LT((at("lateral_epicondyle") - Eigen::Vector3d(0, 4, 38)).norm(), 8.0);
  EXPECT_LT((at("fibular_head") - Eigen::Vector3d(-13, -48, 40)).norm(), 15.0);
  for (const char* spine : {"medial_spine", "lateral_spine"}) {
    EXPECT_GT(at(spine).y(), at("medial_plateau").y());
    EXPECT_LT(std::abs(at(spine).z()), 18.0);
  }
  EXPECT_LT(at("medial_spine").z(), at("lateral_spine").z());
  EXPECT_NEAR(at("lateral_plateau").z() - at("medial_plateau").z(), 74.0, 6.0);
}

TEST(LandmarksOfTheTemplate, mirrored)
{
  const TemplateJoint left = mirrored(generic());
  for (const std::string& name : names) {
    const Eigen::Vector3d right_mm = *landmark_mm(generic(), name), left_mm = *landmark_mm(left, name);
    EXPECT_EQ(right_mm, Eigen::Vector3d(left_mm.x(), left_mm.y(), -left_mm.z())) << name;
  }
  TemplateJoint bare = generic();
  bare.fibula = {};
  bare.knee.surfaces.femur.bone = {};
  EXPECT_FALSE(landmark_mm(bare, "fibular_head").has_value());
  EXPECT_FALSE(landmark_mm(bare, "medial_epicondyle").has_value());
}

TEST(LandmarkResiduals, AreThoseOfTheFitAndOtherCoordinatesAreRefused)
{
  geometry::KneeFit fit;
  fit.unit_mm = 10.0;
  fit.femur.t_mm = Eigen::Vector3d(100, 0, 0);
  const Eigen::Vector3d p_mm = *landmark_mm(generic(), "medial_epicondyle") + Eigen::Vector3d(100, 3, 4);
  const KneeLandmarks near = read("[landmarks]\nmedial_epicondyle = " + list(0.1 * p_mm));
  EXPECT_NEAR(landmark_residuals_mm(near, generic(), fit).at(0), 5.0, 1e-4);
  const KneeLandmarks far = read("[landmarks]\n\nmedial_epicondyle = " + list(p_mm));
  EXPECT_THAT(test::input_error([&] { landmark_residuals_mm(far, generic(), fit); }),
              refuses({"marks.toml", "line 3, landmarks.medial_epicondyle", "mm", "unit"}));
}

// The template with eight fibres between the corners of two cubes of 60 mm.
TemplateJoint with_spread_fibres()
{
  TemplateJoint joint = generic();
  joint.joint.ligaments.fibres.clear();
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner_mm(i % 2 * 60.0, i / 2 % 2 * 60.0, i / 4 * 60.0);
    joint.joint.ligaments.fibres.push_back(
        {"F" + std::to_string(i), "F", corner_mm, -corner_mm, 100, 30, -1});
  }
  return joint;
}

// The subject's points, turned: only distances count.
std::string scaled_points(const TemplateJoint& joint, const Eigen::Vector3d& femur,
                          const Eigen::Vector3d& tibia)
{
  const Eigen::Matrix3d R = Eigen::Quaterniond(1, 2, -1, 2).normalized().toRotationMatrix();
  std::string text = "[landmarks]\n";
  for (const std::string& name : names) {
    const Eigen::Vector3d& scale = prepare::bone_of(name) == Bone::femur ? femur : tibia;
    text += name + " = " + list(R * scale.cwiseProduct(*landmark_mm(joint, name)));
  }
  for (const model::Fibre& fibre : joint.joint.ligaments.fibres)
    text += "[[fibre]]\nname = \"" + fibre.name +
            "\"\nfemur = " + list(R * femur.cwiseProduct(fibre.reference_mm)) +
            "tibia = " + list(R * tibia.cwiseProduct(fibre.moving_mm));
  return text;
}

TEST(LandmarkScales, three_factors)
{
  const TemplateJoint joint = with_spread_fibres();
  const Eigen::Vector3d femur(1.08, 1.0, 0.94), tibia(0.97, 1.05, 1.02);
  const LandmarkScales scales = landmark_scales(read(scaled_points(joint, femur, tibia)), joint, 1.0);
  // The weight on equal factors is that of one of the dozen distances along each axis.
  EXPECT_LT((scales.femur.factor - femur).cwiseAbs().maxCoeff(), 0.008);
  EXPECT_LT((scales.tibia.factor - tibia).cwiseAbs().maxCoeff(), 0.008);
  EXPECT_LT(scales.femur.residual_rms_mm, 0.3);
  EXPECT_THAT(scales.warnings, testing::IsEmpty());
}

TEST(LandmarkScales, missing_factor)
{
  // The femur's own landmarks and attachments lie along one axis.
  const Eigen::Vector3d femur(1.0, 1.0, 0.9), one = Eigen::Vector3d::Ones();
  const LandmarkScales scales = landmark_scales(read(scaled_points(generic(), femur, one)), generic(), 1.0);
  EXPECT_NEAR(scales.femur.factor.z(), 0.9, 0.01);
  EXPECT_LT(scales.femur.factor.maxCoeff(), 1.0);
  EXPECT_LT((scales.tibia.factor - one).norm(), 1e-6);
}

TEST(LandmarkScales, one_distance)
{
  const double width_mm =
      (*landmark_mm(generic(), "medial_epicondyle") - *landmark_mm(generic(), "lateral_epicondyle")).norm();
  const LandmarkScales scales =
      landmark_scales(read("[[distance]]\nfrom = \"medial_epicondyle\"\nto = \"lateral_epicondyle\"\nmm = " +
                           std::to_string(1.1 * width_mm)),
                      generic(), 1.0);
  EXPECT_LT((scales.femur.factor - Eigen::Vector3d::Constant(1.1)).norm(), 1e-6);
  EXPECT_LT((scales.tibia.factor - Eigen::Vector3d::Constant(1.1)).norm(), 1e-6);
  EXPECT_THAT(scales.warnings, testing::ElementsAre(testing::HasSubstr("tibia: no distance")));
}

TEST(LandmarkScales, NoDistanceAWrongUnitAndAMisfit)
{
  const auto refusal_of = [](const std::string& text, double unit_mm) {
    return test::input_error([&] { landmark_scales(read(text), generic(), unit_mm); });
  };
  EXPECT_THAT(refusal_of("[landmarks]\nmedial_spine = [1, 2, 3]\nmedial_epicondyle = [4, 5, 6]\n", 1.0),
              refuses({"marks.toml", "", "no distance"}));
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  EXPECT_THAT(refusal_of(scaled_points(generic(), one, one), 10.0),
              refuses({"marks.toml", "", "femur", "--unit"}));
  std::string text = scaled_points(generic(), one, one);
  text.replace(text.find("medial_epicondyle"),
               text.find('\n', text.find("medial_epicondyle")) - text.find("medial_epicondyle"),
               "medial_epicondyle = [0, 0, 0]");
  EXPECT_THAT(landmark_scales(read(text), generic(), 1.0).warnings,
              testing::ElementsAre(testing::HasSubstr("femur: the residual")));
}

}  // namespace vrda::knee_landmarks_test
