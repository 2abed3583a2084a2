// Derived data in a motion model: order, replacement and removal.
#include "core/units.hpp"
#include "store/motion_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "store/sample_model.hpp"

namespace vrda::derived_test {

std::vector<std::string> names_of(const std::vector<store::AuditSet>& audits)
{
  std::vector<std::string> names;
  names.reserve(audits.size());
  for (const store::AuditSet& audit : audits) names.push_back(audit.name);
  return names;
}

std::vector<std::string> names_after(const store::MotionModel& model, const store::SmoothedSet& set)
{
  return names_of(store::with_smoothed(model, set).audits);
}

TEST(AuditSummary, IsTheLargestNumberOrNaN)
{
  store::AuditSet audit;
  audit.gap_mm = store::GridD::Constant(2, 2, nan);
  audit.penetration_mm = store::GridD::Zero(2, 2);
  EXPECT_TRUE(std::isnan(store::summary_of(audit).largest_gap_mm));
  EXPECT_EQ(store::summary_of(audit).largest_penetration_mm, 0.0);
  audit.gap_mm << nan, 0.5, 0.25, nan;
  audit.penetration_mm << 0.0, 0.0, 0.0, 1.5;
  EXPECT_EQ(store::summary_of(audit).largest_gap_mm, 0.5);
  EXPECT_EQ(store::summary_of(audit).largest_penetration_mm, 1.5);
  EXPECT_TRUE(std::isnan(store::summary_of(store::AuditSet()).largest_penetration_mm));
}

TEST(TwoSidedFigures, CountsPosesWithBothGapsWithinThePerceptible)
{
  store::AuditSet audit;
  audit.state = store::GridB::Zero(1, 7);
  audit.state(0, 6) = store::code_of(store::AuditState::no_pose);
  audit.gap_medial_mm.resize(1, 7);
  audit.gap_lateral_mm.resize(1, 7);
  // Both sides at the limits; either side beyond, in either direction; a side that faces nothing; no pose.
  audit.gap_medial_mm << 0.145, 0.15, 0.0, -0.15, 0.0, nan, 9.0;
  audit.gap_lateral_mm << -0.145, 0.0, 0.3, 0.0, -0.4, 0.0, 0.0;
  const store::TwoSidedFigures f = store::two_sided_figures(audit);
  EXPECT_EQ(f.n_poses, 6);
  EXPECT_EQ(f.n_both_in_contact, 1);
  EXPECT_EQ(f.largest_gap_medial_mm, 0.15);
  EXPECT_EQ(f.largest_overlap_medial_mm, 0.15);
  EXPECT_EQ(f.largest_gap_lateral_mm, 0.3);
  EXPECT_EQ(f.largest_overlap_lateral_mm, 0.4);
  audit.gap_medial_mm.resize(0, 0);
  EXPECT_EQ(store::two_sided_figures(audit).n_poses, 0) << "without compartments";
}

TEST(WithAudit, KeepsTheOrderAndReplacesTheSameName)
{
  std::vector<store::AuditSet> audits;
  for (const char* name : {"raw", "degree_6", "zero_varus", "degree_10", "degree_6_recontacted"}) {
    store::AuditSet audit;
    audit.name = name;
    audits = store::with_audit(audits, audit);
  }
  const std::vector<std::string> wanted{"degree_10", "degree_6", "degree_6_recontacted", "raw", "zero_varus"};
  EXPECT_EQ(names_of(audits), wanted);
  store::AuditSet finer;
  finer.name = "degree_6";
  finer.refine = 4;
  audits = store::with_audit(audits, finer);
  EXPECT_EQ(names_of(audits), wanted);
  EXPECT_EQ(audits[1].refine, 4);
}

TEST(WithSmoothed, KeepsTheOrderOfDegrees)
{
  store::MotionModel model;
  for (const std::int32_t degree : {6, 2, 10, 4}) {
    store::SmoothedSet set;
    set.degree = degree;
    model = store::with_smoothed(model, set);
  }
  ASSERT_EQ(model.smoothed.size(), 4u);
  EXPECT_EQ(model.smoothed[0].degree, 2);
  EXPECT_EQ(model.smoothed[1].degree, 4);
  EXPECT_EQ(model.smoothed[2].degree, 6);
  EXPECT_EQ(model.smoothed[3].degree, 10);
}

TEST(WithSmoothed, AddingTheSameSetAgainChangesNothing)
{
  const store::MotionModel model = test::with_derived(test::sample_model());
  test::expect_equal(store::with_smoothed(model, model.smoothed[0]), model);
}

TEST(WithSmoothed, AnAuditOfAnotherMotionGoes)
{
  store::MotionModel model = test::with_derived(test::sample_model());
  model.zero_varus->set = "raw";
  ASSERT_EQ(names_of(model.audits),
            (std::vector<std::string>{"degree_1", "degree_1_recontacted", "raw", "zero_varus"}));
  const std::vector<std::string> none_of_it{"raw", "zero_varus"};
  const std::vector<std::string> as_smoothed{"degree_1", "raw", "zero_varus"};
  store::SmoothedSet set = model.smoothed[0];
  set.surfaces[3].coefficients[0] += 1e-12;
  EXPECT_EQ(names_after(model, set), none_of_it);
  set = model.smoothed[0];
  (*set.recontact_mm)(1, 1) += 1e-12;
  EXPECT_EQ(names_after(model, set), as_smoothed);
  (*set.recontact_mm)(1, 1) = nan;
  EXPECT_EQ(names_after(model, set), as_smoothed);
  set.recontact_mm.reset();
  EXPECT_EQ(names_after(model, set), as_smoothed);
  set.degree = 2;
  EXPECT_EQ(names_after(model, set), names_of(model.audits));
}

TEST(WithSmoothed, AZeroVarusMotionMadeOfAnotherGoesWithItsAudit)
{
  store::MotionModel model = test::with_derived(test::sample_model());
  ASSERT_EQ(model.zero_varus.value_or(store::ZeroVarus()).set, "degree_1");
  store::SmoothedSet set = model.smoothed[0];
  EXPECT_TRUE(store::with_smoothed(model, set).zero_varus.has_value());
  set.recontact_mm.reset();
  EXPECT_TRUE(store::with_smoothed(model, set).zero_varus.has_value())
      << "derived from the set without recontact";
  set.surfaces[0].coefficients[0] += 1e-12;
  const store::MotionModel changed = store::with_smoothed(model, set);
  EXPECT_FALSE(changed.zero_varus.has_value());
  EXPECT_EQ(names_of(changed.audits), std::vector<std::string>{"raw"});
  model.zero_varus->set = "degree_1_recontacted";
  set = model.smoothed[0];
  set.recontact_mm.reset();
  EXPECT_FALSE(store::with_smoothed(model, set).zero_varus.has_value());
}

}  // namespace vrda::derived_test
