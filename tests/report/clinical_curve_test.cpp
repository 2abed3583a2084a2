#include "report/clinical_curve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "store/sample_model.hpp"
#include "store/solved_cells.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "tables/formats.hpp"

namespace vrda::clinical_curve_test {

using testing::ElementsAre;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
// Rounding of angles up to 100 degrees converted to a rotation matrix and back.
constexpr double rounding = 1e-12;

report::ClinicalCurve curve_of(std::vector<double> flexion_deg, std::vector<double> internal_deg)
{
  report::ClinicalCurve curve;
  curve.flexion_deg = std::move(flexion_deg);
  curve.values_of(report::Quantity::internal) = std::move(internal_deg);
  return curve;
}

report::CurveDifference internal_difference(const report::ClinicalCurve& curve,
                                            const report::ClinicalCurve& other)
{
  return report::difference(curve, other, report::Quantity::internal);
}

TEST(CurveDifference, OfLinesIsThatOfTheirEnds)
{
  // 2 f - (2 f + 1) = -1 at every flexion of the other curve within the range of the curve
  const report::CurveDifference d =
      internal_difference(curve_of({0, 10}, {0, 20}), curve_of({-5, 0, 2.5, 10, 11}, {0, 1, 6, 21, 0}));
  EXPECT_EQ(d.n, 3u);
  EXPECT_NEAR(d.rms, 1.0, rounding);
  EXPECT_NEAR(d.largest, 1.0, rounding);
  EXPECT_NEAR(d.mean, -1.0, rounding);
  EXPECT_NEAR(d.rms_about_mean, 0.0, rounding);
}

TEST(CurveDifference, SplitsIntoMeanAndRest)
{
  // differences 3 and -1: mean 1, rms sqrt(5), about the mean 2
  const report::CurveDifference d =
      internal_difference(curve_of({0, 10}, {3, -1}), curve_of({10, 0}, {0, 0}));
  EXPECT_EQ(d.n, 2u);
  EXPECT_NEAR(d.mean, 1.0, rounding);
  EXPECT_NEAR(d.rms, std::sqrt(5.0), rounding);
  EXPECT_NEAR(d.rms_about_mean, 2.0, rounding);
  EXPECT_NEAR(d.largest, 3.0, rounding);
  EXPECT_NEAR(d.rms * d.rms, d.mean * d.mean + d.rms_about_mean * d.rms_about_mean, rounding);
}

TEST(CurveDifference, LeavesOutWhatHasNoAnswer)
{
  // linear across the hole; frames of a cycle may have any order and repeat
  const report::CurveDifference d =
      internal_difference(curve_of({0, 5, 10}, {0, none, 10}), curve_of({6, 4, 6, 7}, {5, 3, 5, none}));
  EXPECT_EQ(d.n, 3u);
  EXPECT_NEAR(d.rms, 1.0, rounding);
}

TEST(CurveDifference, WithoutACommonRangeIsNotKnown)
{
  for (const report::ClinicalCurve& other :
       {curve_of({20, 30}, {1, 1}), curve_of({}, {}), curve_of({5}, {none})}) {
    const report::CurveDifference d = internal_difference(curve_of({0, 10}, {0, 0}), other);
    EXPECT_EQ(d.n, 0u);
    EXPECT_TRUE(std::isnan(d.rms));
    EXPECT_TRUE(std::isnan(d.largest));
  }
  EXPECT_EQ(report::difference(curve_of({0}, {0}), curve_of({0}, {0}), report::Quantity::varus).n, 0u);
}

const report::ClinicalCurve& named(const std::vector<report::ClinicalCurve>& curves, const std::string& name)
{
  for (const report::ClinicalCurve& curve : curves) {
    if (curve.name == name) return curve;
  }
  throw std::runtime_error("no curve " + name);
}

std::vector<report::ClinicalCurve> curves_of(const store::MotionModel& model)
{
  return report::clinical_curves(model, model.rotation_centre_mm);
}

TEST(ClinicalCurves, TheRawOneIsTheClinicalNumbersOfTheSpine)
{
  const store::MotionModel model = test::sample_model();
  const report::ClinicalCurve raw = named(curves_of(model), "raw");
  ASSERT_EQ(raw.flexion_deg, model.flexion_deg);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t k = 0; k < 5; ++k) {
      const std::size_t coordinate = k == 0 ? 2 : k == 1 ? 1 : k + 1;  // internal, varus and translations
      EXPECT_NEAR(raw.values[k][i], model.clinical[coordinate](row, 1), rounding)
          << joint_coordinate_names[coordinate];
    }
    EXPECT_EQ(raw.values_of(report::Quantity::origin_anterior)[i],
              model.X_reference_moving[16 * (3 * i + 1) + 3]);
    EXPECT_EQ(raw.values_of(report::Quantity::origin_lateral)[i],
              model.X_reference_moving[16 * (3 * i + 1) + 11]);
  }
}

TEST(ClinicalCurves, AreOverTheJointsOwnFlexionWhereDeltaIsNotProximal)
{
  test::SampleOptions options;
  options.is_equilibrium = true;  // its Delta turns over flexion
  const store::MotionModel model = test::sample_model(options);
  ASSERT_TRUE(store::has_turned_axes(model));
  const report::ClinicalCurve raw = named(curves_of(model), "raw");
  for (std::size_t i = 0; i < raw.flexion_deg.size(); ++i)
    EXPECT_NEAR(raw.flexion_deg[i], model.clinical[JointCoordinate::flexion](static_cast<Eigen::Index>(i), 1),
                rounding);
  EXPECT_GT(std::abs(raw.flexion_deg.back() - model.flexion_deg.back()), 1e-6);
}

TEST(ClinicalCurves, HaveHolesWhereTheSpineHas)
{
  store::MotionModel model = test::sample_model();
  model.status(2, 1) = static_cast<std::int8_t>(StepStatus::no_contact);
  EXPECT_THAT(store::solved_spine(model), ElementsAre(1, 4, -1, 10));
  const report::ClinicalCurve raw = named(curves_of(model), "raw");
  EXPECT_TRUE(std::isnan(raw.values_of(report::Quantity::internal)[2]));
  EXPECT_FALSE(std::isnan(raw.values_of(report::Quantity::internal)[3]));
}

TEST(ClinicalCurves, AMirroredJointHasTheSame)
{
  const store::MotionModel right = test::sample_model();
  store::MotionModel left = right;
  left.side = "left";
  left.rotation_centre_mm.z() = -left.rotation_centre_mm.z();
  for (std::size_t k = 0; k < left.X_reference_moving.size(); ++k) {
    const bool is_row_z = k % 16 / 4 == 2, is_column_z = k % 4 == 2;
    if (is_row_z != is_column_z) left.X_reference_moving[k] = -left.X_reference_moving[k];
  }
  const report::ClinicalCurve a = named(curves_of(right), "raw"), b = named(curves_of(left), "raw");
  for (const report::QuantityName& q : report::quantity_names) {
    SCOPED_TRACE(q.key);
    EXPECT_EQ(a.values_of(q.quantity), b.values_of(q.quantity));
  }
}

TEST(ClinicalCurves, ASmoothedSetRunsAtTheVarusWhereTheCompartmentsBalance)
{
  const store::MotionModel model = test::sample_model();
  const report::ClinicalCurve smoothed = named(curves_of(model), "degree_1");
  for (std::size_t i = 0; i < 4; ++i) {
    // Delta is along Y: theta of the set is the internal rotation, the spine's varus is the varus.
    EXPECT_NEAR(smoothed.values_of(report::Quantity::varus)[i], 0.0, rounding);
    EXPECT_NEAR(smoothed.values_of(report::Quantity::internal)[i],
                model.smoothed[0].surfaces[3].values(static_cast<Eigen::Index>(i), 1), rounding);
  }
}

using testing::IsEmpty;

TEST(CurveFile, ReadsTheColumnsOfThePublishedCurves)
{
  const report::CurveFile file =
      report::curve_from_text("folder/walker.v2.csv",
                              "# cadavers, passive\r\n#convention: internal +\n\n"
                              "frame,flexion_deg, varus_deg ,internal_deg,ant_mm,prox_mm,lat_mm,T11,T34\r\n"
                              "1,0,0.5,-1,1e1,2,-3,0,zero\r\n"
                              "2, 10.5 ,,+2,11,3,-4,0,0\n");
  EXPECT_EQ(file.curve.name, "walker.v2");
  EXPECT_THAT(file.comments, ElementsAre("cadavers, passive", "convention: internal +"));
  EXPECT_THAT(file.curve.flexion_deg, ElementsAre(0.0, 10.5));
  EXPECT_THAT(file.curve.values_of(report::Quantity::internal), ElementsAre(-1.0, 2.0));
  EXPECT_THAT(file.curve.values_of(report::Quantity::origin_anterior), ElementsAre(10.0, 11.0));
  EXPECT_THAT(file.curve.values_of(report::Quantity::origin_proximal), ElementsAre(2.0, 3.0));
  EXPECT_THAT(file.curve.values_of(report::Quantity::origin_lateral), ElementsAre(-3.0, -4.0));
  EXPECT_THAT(file.curve.values_of(report::Quantity::anterior), IsEmpty());
  ASSERT_EQ(file.curve.values_of(report::Quantity::varus).size(), 2u);
  EXPECT_EQ(file.curve.values_of(report::Quantity::varus)[0], 0.5);
  EXPECT_TRUE(std::isnan(file.curve.values_of(report::Quantity::varus)[1]));
}

TEST(CurveFile, ReadsWhatIsExported)
{
  const tables::FlexionMotion motion = tables::flexion_motion(test::sample_model(), "knee.h5", {});
  const report::CurveFile file = report::curve_from_text("knee.csv", tables::flexion_csv(motion));
  ASSERT_EQ(file.curve.flexion_deg.size(), motion.frames.size());
  for (const report::Quantity quantity :
       {report::Quantity::internal, report::Quantity::varus, report::Quantity::anterior,
        report::Quantity::proximal, report::Quantity::lateral}) {
    EXPECT_EQ(file.curve.values_of(quantity).size(), motion.frames.size());
  }
  ASSERT_TRUE(file.point_mm);
  EXPECT_EQ(*file.point_mm, motion.rotation_centre_mm);
  EXPECT_THAT(file.curve.values_of(report::Quantity::origin_anterior), IsEmpty());
}

// One motion about another point, from the mesh origin's translations and from those of a third point.
TEST(CurveFile, MovesTranslationsToAnotherPoint)
{
  for (const char* side : {"right", "left"}) {
    SCOPED_TRACE(side);
    test::ModelPlan plan;
    plan.side = side;
    plan.rotation_centre_mm = {10, -950, 40};
    plan.motion = [](double flexion_deg, double) {
      return store::PoseCoordinates{0.05 * flexion_deg, -3.0, 1.0, 0.2 * flexion_deg};
    };
    const store::MotionModel model = test::model_of(plan);
    const Side side_of_model = model.side == "left" ? Side::left : Side::right;
    const Eigen::Vector3d other_mm(-20, -900, 15);
    const report::ClinicalCurve wanted = named(report::clinical_curves(model, other_mm), "raw");
    report::CurveFile of_origin, of_centre;
    of_origin.curve = named(curves_of(model), "raw");
    of_centre.curve = of_origin.curve;
    of_centre.point_mm = model.rotation_centre_mm;
    for (const auto q : {report::Quantity::anterior, report::Quantity::proximal, report::Quantity::lateral})
      of_origin.curve.values_of(q).clear();
    for (const report::CurveFile& given : {of_origin, of_centre}) {
      const report::CurveFile found = report::about_point(given, side_of_model, other_mm);
      EXPECT_FALSE(found.is_incomplete);
      for (const auto q :
           {report::Quantity::anterior, report::Quantity::proximal, report::Quantity::lateral}) {
        for (std::size_t i = 0; i < wanted.flexion_deg.size(); ++i)
          EXPECT_NEAR(found.curve.values_of(q)[i], wanted.values_of(q)[i], 1e-9) << i;
      }
    }
    of_origin.curve.values_of(report::Quantity::varus).clear();
    const report::CurveFile incomplete = report::about_point(of_origin, side_of_model, other_mm);
    EXPECT_TRUE(incomplete.is_incomplete);
    EXPECT_THAT(incomplete.curve.values_of(report::Quantity::anterior), IsEmpty());
  }
}

// Two runs of one knee about different centres: 66 mm apart by their own centres, equal by one.
TEST(ClinicalCurves, OneKneeSolvedTwiceIsComparedByOnePoint)
{
  test::ModelPlan plan;
  plan.motion = [](double flexion_deg, double) {
    return store::PoseCoordinates{0.0, -3.0, 0.0, 0.2 * flexion_deg};
  };
  const store::MotionModel first = test::model_of(plan);
  store::MotionModel second = first;
  second.rotation_centre_mm += Eigen::Vector3d(40, -60, 0);
  const Eigen::Vector3d point_mm = report::comparison_point_mm(first, second);
  EXPECT_EQ(point_mm, first.rotation_centre_mm);
  const report::ClinicalCurve a = named(curves_of(first), "raw"), own = named(curves_of(second), "raw");
  const report::ClinicalCurve b = named(report::clinical_curves(second, point_mm), "raw");
  EXPECT_GT(report::difference(own, a, report::Quantity::anterior).largest, 30.0);
  for (const auto q : {report::Quantity::anterior, report::Quantity::proximal, report::Quantity::lateral})
    EXPECT_LT(report::difference(b, a, q).largest, 1e-9);
  second.moving.contact.mesh.vertices_mm.setOnes(3, 3);  // another knee
  EXPECT_EQ(report::comparison_point_mm(first, second), second.rotation_centre_mm);
}

TEST(CurveFile, RefusesWhatItWouldHaveToGuess)
{
  struct Row {
    const char* text;
    const char* field;
    test::Values found = {};
    test::Values wanted = {};
  };
  const Row rows[] = {
      {"flexion_deg,fx_n\n0,1\n", "line 1", "fx_n", {"internal_deg", "varus_deg", "ant_mm"}},
      {"internal_deg\n1\n", "line 1", "flexion_deg", "flexion_deg"},
      {"flexion_deg,frame\n0,1\n", "line 1", "clinical", "internal_deg"},
      {"flexion_deg,varus_deg,varus_deg\n0,1,1\n", "line 1, varus_deg", "twice"},
      {"flexion_deg,varus_deg,centre_x_mm,centre_x_mm\n0,1,1,1\n", "line 1, centre_x_mm", "twice"},
      {"flexion_deg,varus_deg\n0,1\n5\n", "line 3", "1", "2"},
      {"flexion_deg,varus_deg\n0,1,2\n", "line 2", "3", "2"},
      {"flexion_deg,varus_deg\n0,one\n", "line 2, varus_deg", "\"one\""},
      {"flexion_deg,varus_deg\n0,inf\n", "line 2, varus_deg", "\"inf\""},
      {"flexion_deg,varus_deg\n,1\n", "line 2, flexion_deg", "nothing"},
      {"flexion_deg,varus_deg,centre_x_mm\n0,1,2\n", "line 1", "centre_x_mm", "all three"},
      {"flexion_deg,centre_x_mm,varus_deg,centre_y_mm,centre_z_mm\n0,1,0,0,0\n1,2,0,0,0\n",
       "line 3, centre_x_mm", "2"},
      {"flexion_deg,varus_deg\n", "line 1", "no row"},
      {"# only words\n", "", "", "flexion_deg"},
      {"", "", "", "flexion_deg"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::input_error([&] { report::curve_from_text("curve.csv", row.text); }),
                test::refuses({"curve.csv", row.field, row.found, row.wanted}));
  }
}

TEST(CurveFile, RefusesAFileThatIsNotThere)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "none.csv").string();
  EXPECT_EQ(test::input_error([&] { report::read_curve_file(path); }).file, path);
  const std::string there = scratch.write("curve.csv", "flexion_deg,varus_deg\n0,1\n").string();
  EXPECT_EQ(report::read_curve_file(there).curve.name, "curve");
}

}  // namespace vrda::clinical_curve_test
