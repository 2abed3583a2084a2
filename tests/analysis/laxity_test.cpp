// A plate on a plate, held by horizontal fibres: laxity, shares and cuts in closed form; published values.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include "analysis/laxity.hpp"
#include "analysis/plates.hpp"
#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::laxity_test {

using test::slack_mm;

constexpr double transition = 0.06;
constexpr double strong_n = 1000.0, weak_n = 500.0;  // stiffness of each of two fibres, per strain

job::Case plates()
{
  job::Case plates = test::two_plates();
  for (const double z_mm : {-10.0, 10.0}) {
    for (const bool is_front : {false, true}) {
      const std::string end = is_front ? "_front" : "_back";
      test::add_fibre(plates, "strong" + end, is_front, z_mm, strong_n);
      test::add_fibre(plates, "weak" + end, is_front, z_mm, weak_n);
    }
  }
  return plates;
}

LaxityPlan plan_of(double force_n, double moment_nmm)
{
  LaxityPlan plan;
  plan.loads.flexion_deg = {0.0};
  plan.loads.anterior_force_n = force_n;
  plan.loads.internal_moment_nmm = moment_nmm;
  plan.loads.cuts = {{"weak", {"weak_back", "weak_front"}}};
  return plan;
}

// In the linear part of the tension law the strain is force / stiffness + transition / 2.
double travel_mm(double force_n, double stiffness_n)
{
  return slack_mm * (force_n / stiffness_n + 0.5 * transition);
}

// Equilibria are solved to 1e-4 mm along Delta; the fibres' forces to the residual of the certificate.
constexpr double tolerance_mm = 1e-3;

TEST(Laxity, ForceIsResistedByTheFibresBehind)
{
  constexpr double force_n = 150.0;
  const LaxityResult result = laxity_of(plates(), plan_of(force_n, 0.0));
  ASSERT_EQ(result.curves.size(), 4u);
  const double whole_mm = travel_mm(force_n, 2.0 * (strong_n + weak_n));
  const double cut_mm = travel_mm(force_n, 2.0 * strong_n);
  for (const LaxityTest test : {LaxityTest::anterior, LaxityTest::posterior}) {
    const LaxityCurve& whole = *curve_of(result, 0, 0, test);
    const LaxityCurve& cut = *curve_of(result, 1, 0, test);
    EXPECT_NEAR(whole.laxity(), whole_mm, tolerance_mm);
    EXPECT_NEAR(cut.laxity(), cut_mm, tolerance_mm);
    // The toe's curve at a fifth of the load: force = k e^2 / (2 t).
    const double toe = std::sqrt(2.0 * transition * 0.2 * force_n / (2.0 * (strong_n + weak_n)));
    EXPECT_NEAR(laxity_at_load(whole, 0.2 * force_n), slack_mm * toe, tolerance_mm);
    // Forward the fibres behind are stretched, with two thirds of the load in the strong ones.
    const std::string end = test == LaxityTest::anterior ? "_back" : "_front";
    double sum = whole.contact.share;
    for (const BundleResistance& bundle : whole.bundles) {
      const double share = bundle.bundle == "strong" + end ? 2.0 / 3.0
                           : bundle.bundle == "weak" + end ? 1.0 / 3.0
                                                           : 0.0;
      EXPECT_NEAR(bundle.share, share, 1e-3) << bundle.bundle;
      EXPECT_NEAR(bundle.force, share * force_n, 1e-3 * force_n) << bundle.bundle;
      sum += bundle.share;
    }
    EXPECT_NEAR(sum, 1.0, 1e-3);
    // With the cut fibres' own forces in their place the plate stays.
    EXPECT_LT(cut.replaced_mm, tolerance_mm);
    EXPECT_LT(cut.replaced_rad, 1e-4);
  }
}

TEST(Laxity, MomentTurnsBetweenTheFibres)
{
  constexpr double moment_nmm = 1000.0;
  const LaxityResult result = laxity_of(plates(), plan_of(0.0, moment_nmm));
  const LaxityCurve& inward = *curve_of(result, 0, 0, LaxityTest::internal);
  const LaxityCurve& outward = *curve_of(result, 0, 0, LaxityTest::external);
  // Both ways are mirror images.
  EXPECT_NEAR(inward.laxity(), outward.laxity(), 1e-5);
  EXPECT_GT(inward.laxity(), 0.0);
  double sum = inward.contact.share;
  for (const BundleResistance& bundle : inward.bundles) sum += bundle.share;
  EXPECT_NEAR(sum, 1.0, 1e-3);
  EXPECT_GT(curve_of(result, 1, 0, LaxityTest::internal)->laxity(), inward.laxity());
}

TEST(Laxity, SameForAnyNumberOfThreadsAndFromNearbyEquilibria)
{
  LaxityPlan plan = plan_of(100.0, 1000.0);
  LaxityDocument document;
  document.result = laxity_of(plates(), plan);
  const std::string alone = laxity_json(document);
  plan.n_threads = 2;
  document.result = laxity_of(plates(), plan);
  EXPECT_EQ(laxity_json(document), alone);
  plan.loads.cuts.clear();
  plan.unloaded = document.result.unloaded;
  const LaxityResult near = laxity_of(plates(), plan);
  EXPECT_NEAR(near.curves[0].laxity(), document.result.curves[0].laxity(), tolerance_mm);
}

TEST(Laxity, ALoadThatNothingResistsIsNamed)
{
  job::Case loose = plates();
  std::erase_if(loose.ligaments.fibres,
                [](const model::Fibre& fibre) { return fibre.bundle.ends_with("_back"); });
  // So far in front that the plate leaves the other one before they are stretched.
  for (model::Fibre& fibre : loose.ligaments.fibres) {
    fibre.reference_mm.x() = 1000.0;
    fibre.slack_length_mm = 1000.0;
  }
  LaxityPlan plan = plan_of(150.0, 0.0);
  plan.loads.cuts.clear();
  const LaxityResult result = laxity_of(loose, plan);
  const LaxityCurve& forward = *curve_of(result, 0, 0, LaxityTest::anterior);
  EXPECT_FALSE(forward.is_complete());
  EXPECT_TRUE(std::isnan(forward.laxity()));
  EXPECT_NE(forward.poses.back().status, StepStatus::stable);
  EXPECT_TRUE(curve_of(result, 0, 0, LaxityTest::posterior)->is_complete());
}

TEST(Laxity, UnknownBundlesAreRefused)
{
  LaxityPlan plan = plan_of(150.0, 0.0);
  plan.loads.cuts = {{"weak", {"weak"}}};
  EXPECT_THAT(test::input_error([&] { laxity_of(plates(), plan); }),
              test::refuses({.field = "laxity.cut.0.bundles", .found = "weak", .wanted = "weak_front"}));
  job::Case bare = plates();
  bare.ligaments.fibres.clear();
  EXPECT_THAT(test::input_error([&] { laxity_of(bare, plan_of(1.0, 0.0)); }),
              test::refuses({.field = "ligaments"}));
}

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

}  // namespace vrda::analysis::laxity_test
