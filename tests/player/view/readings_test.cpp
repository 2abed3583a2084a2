#include "view/readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/units.hpp"

namespace vrda::view::readings_test {

constexpr double rounding_mm = 1e-12;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Attitude at_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

/// 3 x 2 cells, 10 degrees apart; one is unsolved.
store::MotionModel sample_model()
{
  store::MotionModel model;
  model.flexion_deg = {0, 10, 20};
  model.varus_deg = {-5, 5};
  model.gap_mm[0].resize(3, 2);
  model.gap_mm[0] << 0, 1, 2, 3, 4, nan;
  model.gap_mm[1] = store::GridD::Constant(3, 2, 0.5);
  store::SmoothedSet set;
  set.degree = 4;
  set.recontact_mm = store::GridD(3, 2);
  *set.recontact_mm << 0.1, 0.1, -0.3, -0.3, 0.1, nan;
  model.smoothed = {set};
  return model;
}

TEST(GapReading, RawCells)
{
  const store::MotionModel model = sample_model();
  const GapReader reader(model, "raw");
  EXPECT_EQ(reader.at(at_deg(0, -5)).source, GapSource::cells);
  EXPECT_NEAR(reader.at(at_deg(5, 0)).compartment_mm[0], 1.5, rounding_mm);
  EXPECT_NEAR(reader.at(at_deg(5, 0)).compartment_mm[1], 0.5, rounding_mm);
  EXPECT_NEAR(reader.at(at_deg(20, -5)).compartment_mm[0], 4.0, rounding_mm);
  EXPECT_TRUE(std::isnan(reader.at(at_deg(15, 0)).compartment_mm[0]));
}

// The way into contact is a gap forward and a penetration back.
TEST(GapReading, TravelIntoContact)
{
  const store::MotionModel model = sample_model();
  const GapReader reader(model, "degree_4");
  const GapReading gap = reader.at(at_deg(2.5, 0));
  EXPECT_EQ(gap.source, GapSource::travel);
  EXPECT_NEAR(gap.gap_mm, 0.0, rounding_mm);
  EXPECT_NEAR(reader.at(at_deg(0, 0)).gap_mm, 0.1, rounding_mm);
  EXPECT_EQ(reader.at(at_deg(0, 0)).penetration_mm, 0.0);
  EXPECT_NEAR(reader.at(at_deg(10, 2)).penetration_mm, 0.3, rounding_mm);
  EXPECT_EQ(reader.at(at_deg(10, 2)).gap_mm, 0.0);
  EXPECT_TRUE(std::isnan(reader.at(at_deg(20, 5)).gap_mm));
  const GapReading none = GapReader(model, "degree_4_recontacted").at(at_deg(7, 1));
  EXPECT_EQ(none.source, GapSource::recontacted);
  EXPECT_EQ(none.gap_mm, 0.0);
}

TEST(GapReading, AuditBeforeTravel)
{
  store::MotionModel model = sample_model();
  store::AuditSet audit;
  audit.name = "degree_4";
  audit.flexion_deg = {0, 20};
  audit.varus_deg = {0};
  audit.state.resize(2, 1);
  audit.state << static_cast<std::int8_t>(store::AuditState::overlapping),
      static_cast<std::int8_t>(store::AuditState::free);
  audit.gap_mm.resize(2, 1);
  audit.gap_mm << nan, 0.25;
  audit.penetration_mm.resize(2, 1);
  audit.penetration_mm << 0.75, 0.0;
  model.audits = {audit};
  const GapReader reader(model, "degree_4");
  const GapReading deep = reader.at(at_deg(9, 3)), apart = reader.at(at_deg(11, -3));
  EXPECT_EQ(deep.source, GapSource::audit);
  EXPECT_EQ(deep.gap_mm, 0.0);
  EXPECT_EQ(deep.penetration_mm, 0.75);
  EXPECT_EQ(apart.gap_mm, 0.25);
  EXPECT_EQ(apart.penetration_mm, 0.0);
}

TEST(GapReading, TwoSided)
{
  store::MotionModel model = sample_model();
  model.two_sided.emplace();
  model.two_sided->flexion_deg = {0, 10, 20};
  model.two_sided->gap_mm[0] = {0.0, 0.5, nan};
  model.two_sided->gap_mm[1] = {0.25, -0.75, nan};
  const GapReader reader(model, "two_sided");
  const GapReading at_row = reader.at(at_deg(10, 3)), between = reader.at(at_deg(5, 3));
  EXPECT_EQ(at_row.source, GapSource::two_sided);
  EXPECT_EQ(at_row.compartment_mm[0], 0.5);
  EXPECT_EQ(at_row.compartment_mm[1], -0.75);
  EXPECT_DOUBLE_EQ(between.compartment_mm[0], 0.25);
  EXPECT_DOUBLE_EQ(between.compartment_mm[1], -0.25);
  EXPECT_TRUE(std::isnan(reader.at(at_deg(20, 0)).compartment_mm[0]));
  model.two_sided.reset();
  EXPECT_EQ(GapReader(model, "two_sided").at(at_deg(5, 0)).source, GapSource::none);
}

TEST(GapReading, NoData)
{
  store::MotionModel model = sample_model();
  EXPECT_EQ(GapReader(model, "zero_varus").at(at_deg(5, 0)).source, GapSource::none);
  model.has_compartments = false;
  EXPECT_EQ(GapReader(model, "raw").at(at_deg(5, 0)).source, GapSource::none);
  // An audited attitude without a pose has no number.
  store::AuditSet audit;
  audit.name = "zero_varus";
  audit.flexion_deg = {0, 20};
  audit.varus_deg = {0};
  audit.state = store::GridB::Constant(2, 1, static_cast<std::int8_t>(store::AuditState::no_pose));
  audit.gap_mm = audit.penetration_mm = store::GridD::Constant(2, 1, nan);
  model.audits = {audit};
  EXPECT_TRUE(std::isnan(GapReader(model, "zero_varus").at(at_deg(9, 3)).gap_mm));
}

TEST(GapReading, Sequence)
{
  store::MotionModel model = sample_model();
  model.smoothed.clear();
  model.varus_deg = {0};
  model.flexion_deg = {20, 0, 20};
  model.frames = store::FrameSequence{"time_s", {0.0, 1.0, 3.0}};
  model.gap_mm[0] = model.gap_mm[0].leftCols(1).eval();
  model.gap_mm[1] = model.gap_mm[1].leftCols(1).eval();
  const GapReader reader(model, "raw");
  store::JointPose pose;
  pose.attitude = at_deg(20, 0);
  for (const auto& [key, medial_mm] :
       {std::pair(0.0, 0.0), std::pair(1.0, 2.0), std::pair(2.0, 3.0), std::pair(3.0, 4.0)}) {
    pose.key = key;
    EXPECT_NEAR(reader.at(pose).compartment_mm[0], medial_mm, rounding_mm);
  }
}

}  // namespace vrda::view::readings_test
