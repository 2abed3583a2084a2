// Tables of published laxities, their comparison, and the files of a result.
#include "analysis/laxity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::published_values_test {

// 10 mm forward and 4 back at 0 degrees, 20 and 8 at 30, half of it at half of the load.
LaxityResult sample()
{
  LaxityResult result;
  result.loads.flexion_deg = {0.0, 30.0};
  result.loads.anterior_force_n = 100.0;
  result.states = {whole_state};
  for (std::size_t flexion = 0; flexion < 2; ++flexion) {
    for (const LaxityTest test : {LaxityTest::anterior, LaxityTest::posterior}) {
      LaxityCurve curve;
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
  const std::vector<Compared> rows =
      analysis::compared(sample(), published_values("book.csv",
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
  LaxityDocument document;
  document.result = sample();
  const std::string csv = laxity_csv(document);
  const std::vector<PublishedValue> rows = published_values("laxity.csv", csv);
  ASSERT_EQ(rows.size(), 6u);
  for (const Compared& row : analysis::compared(sample(), rows)) EXPECT_NEAR(row.difference(), 0.0, 1e-12);
}

TEST(LaxityFiles, SharesAreRowsOfBundles)
{
  LaxityDocument document;
  document.result = sample();
  EXPECT_THAT(share_csv(document), testing::HasSubstr("intact,anterior,0,<ACL>,80,N,0.8\n"));
}

}  // namespace vrda::analysis::published_values_test
