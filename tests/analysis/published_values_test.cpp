// Tables of published laxities, their comparison, and the files of a result.
#include "analysis/laxity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::published_values_test {

using analysis::LaxityTest;

// 10 mm forward and 4 back at 0 degrees, 20 and 8 at 30, half of it at half of the load.
analysis::LaxityResult sample()
{
  analysis::LaxityResult result;
  result.loads.flexion_deg = {0.0, 30.0};
  result.loads.anterior_force_n = 100.0;
  result.states = {analysis::whole_state};
  for (std::size_t flexion = 0; flexion < 2; ++flexion) {
    for (const LaxityTest test : {LaxityTest::anterior, LaxityTest::posterior}) {
      analysis::LaxityCurve curve;
      curve.flexion = flexion;
      curve.test = test;
      const double whole_mm = (test == LaxityTest::anterior ? 10.0 : -4.0) * (flexion == 0 ? 1.0 : 2.0);
      for (const double load : {0.0, 50.0, 100.0}) {
        JointCoordinates at = JointCoordinates::Zero();
        at(row_of(JointCoordinate::anterior)) = 1.0 + whole_mm * load / 100.0;
        curve.poses.push_back({load, StepStatus::stable, at});
      }
      curve.bundles = {{"<ACL>", 80.0, 0.8}};
      curve.contact = {"contact", 20.0, 0.2};
      result.curves.push_back(curve);
    }
  }
  return result;
}

TEST(PublishedValues, AreComparedAtTheirFlexionAndLoad)
{
  const std::vector<analysis::Compared> rows =
      analysis::compared(sample(), analysis::published_values("book.csv",
                                                              "# from a book\n"
                                                              "test,flexion_deg,load,value,sd,source\n"
                                                              "anterior,0,100,9,2,Author 1990\n"
                                                              "anterior,15,50,9,,\n"
                                                              "anterior-posterior,30,,30,5,\n"
                                                              "anterior,45,,9,,\n"
                                                              "anterior,0,200,9,,\n"
                                                              "varus,0,,9,,\n"));
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_DOUBLE_EQ(rows[0].found, 10.0);
  EXPECT_DOUBLE_EQ(rows[0].difference(), 1.0);
  EXPECT_EQ(rows[0].published.source, "Author 1990");
  EXPECT_DOUBLE_EQ(rows[1].found, 7.5);   // half the load, between 10 and 20
  EXPECT_DOUBLE_EQ(rows[2].found, 28.0);  // 20 + 8
  for (const std::size_t outside : {3u, 4u, 5u}) {
    EXPECT_TRUE(std::isnan(rows[outside].found)) << outside;
    EXPECT_FALSE(rows[outside].missing.empty());
  }
}

TEST(PublishedValues, ReadsTheTableOfAResult)
{
  analysis::LaxityDocument document;
  document.result = sample();
  const std::string csv = analysis::laxity_csv(document);
  const std::vector<analysis::PublishedValue> rows = analysis::published_values("laxity.csv", csv);
  ASSERT_EQ(rows.size(), 6u);
  for (const analysis::Compared& row : analysis::compared(sample(), rows))
    EXPECT_NEAR(row.difference(), 0.0, 1e-12);
}

TEST(PublishedValues, RefusesOtherTables)
{
  const auto refused = [](const std::string& text) {
    return test::input_error([&] { analysis::published_values("book.csv", text); });
  };
  EXPECT_THAT(refused("test,value\nanterior,1\n"), test::refuses({.field = "flexion_deg"}));
  EXPECT_THAT(
      refused("test,flexion_deg,value\nforward,0,1\n"),
      test::refuses({.file = "book.csv", .field = "line 2, test", .found = "forward", .wanted = "valgus"}));
  EXPECT_THAT(refused("test,flexion_deg,value\nanterior,0,x\n"),
              test::refuses({.field = "line 2, value", .found = "x"}));
  EXPECT_THAT(refused("test,flexion_deg,value,load\nanterior,0,1,-5\n"),
              test::refuses({.field = "load", .found = "-5", .wanted = "0"}));
  EXPECT_THAT(refused("test,flexion_deg,value,lod\nanterior,0,1,5\n"),
              test::refuses({.field = "line 1", .found = "lod", .wanted = "load"}));
  EXPECT_THAT(refused("test,test,flexion_deg,value\nanterior,anterior,0,1\n"),
              test::refuses({.field = "test", .found = "twice"}));
}

TEST(LaxityFiles, SharesAreRowsOfBundles)
{
  analysis::LaxityDocument document;
  document.result = sample();
  EXPECT_THAT(analysis::share_csv(document), testing::HasSubstr("intact,anterior,0,<ACL>,80,N,0.8\n"));
}

}  // namespace vrda::published_values_test
