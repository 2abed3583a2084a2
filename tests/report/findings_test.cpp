#include "report/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "store/sample_model.hpp"

namespace vrda::findings_test {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Removes the sample's doubtful poses.
store::MotionModel undoubted(store::MotionModel model)
{
  model.plausibility.setConstant(static_cast<std::int8_t>(Plausibility::nothing_found));
  return model;
}

report::ReportModel whole_entry()
{
  test::SampleOptions options;
  options.has_failed_cell = false;
  return {"sample", undoubted(test::sample_model(options)), {}, {}, {}};
}

report::ReportModel equilibrium_entry()
{
  test::SampleOptions options;
  options.has_failed_cell = false;
  options.is_equilibrium = true;
  options.n_fibres = 4;
  report::ReportModel entry{"sample", undoubted(test::sample_model(options)), {}, {}, {}};
  entry.model.equilibrium->spine.n_optima.assign(4, 1);
  return entry;
}

TEST(Findings, NothingToWarnOfIsNoWarning)
{
  EXPECT_THAT(report::warnings_of(whole_entry()), IsEmpty());
  EXPECT_THAT(report::warnings_of(equilibrium_entry()), IsEmpty());
}

TEST(Findings, DoubtfulPosesAreCountedByKind)
{
  report::ReportModel entry = whole_entry();
  entry.model.plausibility(1, 1) = static_cast<std::int8_t>(Plausibility::unstable_balance);
  EXPECT_THAT(report::warnings_of(entry),
              ElementsAre(HasSubstr("1 stable attitudes are doubtful, unstable_balance")));
}

TEST(Findings, NoDegreeIsAWarningWithItsReason)
{
  report::ReportModel entry = whole_entry();
  entry.comparison.emplace();
  entry.comparison->recommendation.reason = "the raw motion jumps";
  EXPECT_THAT(report::warnings_of(entry),
              ElementsAre("No smoothing degree meets the criteria: the raw motion jumps."));
  entry.comparison->recommendation.degree = 4;
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
}

TEST(Findings, NameEveryStatusThatIsNotStable)
{
  const store::MotionModel model = test::sample_model();
  EXPECT_THAT(report::warnings_of({"sample", model, {}, {}, {}}),
              Contains(HasSubstr("1 of 12 attitudes ended as no_clearance")));
  for (const StepStatus status : all_step_statuses) {
    SCOPED_TRACE(name_of(status));
    report::ReportModel entry = whole_entry();
    entry.model.status(3, 1) = static_cast<std::int8_t>(status);
    const bool is_stable = status == StepStatus::stable;
    EXPECT_EQ(report::warnings_of(entry).size(),
              is_stable ? 0u : 2u);  // the status, and the hole in the spine
    const std::vector<std::string> lines = report::warnings_of(entry);
    const auto n_named = std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.find(std::string("ended as ") + name_of(status)) != std::string::npos;
    });
    EXPECT_EQ(n_named, is_stable ? 0 : 1);
  }
}

TEST(Findings, RawGapsAndPenetrationsCountFromWhatCanBeSeen)
{
  report::ReportModel entry = whole_entry();
  entry.raw = {7, 0.14, 0.14};
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
  entry.raw = {7, 0.25, 0.5};
  EXPECT_THAT(report::warnings_of(entry), AllOf(Contains(HasSubstr("overlaps by up to 0.25 mm (7 attitudes")),
                                                Contains(HasSubstr("gap of up to 0.5 mm"))));
  entry.raw = {0, 0.0, std::numeric_limits<double>::infinity()};
  EXPECT_THAT(report::warnings_of(entry), Contains(HasSubstr("no contact is ahead along Delta")));
}

TEST(Findings, AnAuditThatCanBeSeenIsNamed)
{
  report::ReportModel entry = whole_entry();
  store::AuditSet audit;
  audit.name = "degree_1";
  audit.state = store::GridB::Constant(4, 3, static_cast<std::int8_t>(store::AuditState::free));
  audit.penetration_mm = store::GridD::Zero(4, 3);
  audit.state(1, 2) = static_cast<std::int8_t>(store::AuditState::overlapping);
  audit.penetration_mm(1, 2) = 0.3;
  entry.model.audits = {audit, audit};
  entry.model.audits[1].name = "degree_2";
  entry.model.audits[1].penetration_mm(1, 2) = 0.2;
  EXPECT_THAT(
      report::warnings_of(entry),
      ElementsAre(HasSubstr("degree_1 by up to 0.3 mm (1 of 12 attitudes overlap), degree_2 by up to 0.2")));
  entry.model.audits[0].penetration_mm(1, 2) = 0.1;
  EXPECT_THAT(report::warnings_of(entry), ElementsAre(HasSubstr("degree_2")));
  entry.model.audits[1].penetration_mm(1, 2) = 0.1;
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
}

TEST(Findings, RotationThatIsNotCertainIsSaid)
{
  report::ReportModel entry = equilibrium_entry();
  entry.model.theta_determined(0, 0) = entry.model.theta_determined(0, 1) =
      entry.model.theta_determined(0, 2) = 0;
  entry.model.equilibrium->spine.n_optima[1] = 3;
  entry.model.theta_deg(2, 1) += 5.0;
  const std::vector<std::string> lines = report::warnings_of(entry);
  EXPECT_THAT(lines, Contains(HasSubstr("in 25 % of the solved")));
  EXPECT_THAT(lines, Contains(HasSubstr("1 of 4 flexions have several equilibria, up to 6.5 degrees")));
  // Theta of an attitude whose axes turn with Delta follows the other rotations too.
  EXPECT_THAT(lines, testing::Not(Contains(HasSubstr("jumps by"))));
  Points& delta = entry.model.push.delta;
  delta = Eigen::RowVector3d::UnitY().replicate(delta.rows(), 1);
  EXPECT_THAT(report::warnings_of(entry),
              Contains(HasSubstr("jumps by 5.2 degrees")));  // 0.2 per degree of flexion without the jump
}

TEST(Findings, ForcesOutOfBalanceAreSaid)
{
  report::ReportModel entry = equilibrium_entry();
  const double allowed_n = 1e-2 * report::motion_summary(entry.model).push_n;
  entry.model.equilibrium->balance_residual_n(2, 2) = 0.99 * allowed_n;
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
  entry.model.equilibrium->balance_residual_n(2, 2) = 1.5 * allowed_n;
  EXPECT_THAT(report::warnings_of(entry), Contains(HasSubstr("The balance of forces has a residual")));
}

TEST(Findings, ASpineAtTheBorderAsksForMoreVarus)
{
  report::ReportModel entry = whole_entry();
  entry.model.is_spine(3, 1) = 0;
  entry.model.is_spine(3, 2) = 1;
  EXPECT_THAT(report::warnings_of(entry),
              Contains(HasSubstr("At 1 flexions the compartments balance at the border")));
}

TEST(Findings, ZeroVarusSaysWhereItIsNotMeasured)
{
  report::ReportModel entry = whole_entry();
  entry.model.zero_varus.emplace();
  entry.model.zero_varus->source = {0, 1, 1, -1};
  entry.model.zero_varus->is_cut_off = {1, 0, 0, 0};
  EXPECT_THAT(report::warnings_of(entry),
              AllOf(Contains(HasSubstr("Zero varus at 1 of 4 flexions: the band with both contacts reaches")),
                    Contains(HasSubstr("interpolated between two varus columns at 2 of 4")),
                    Contains(HasSubstr("1 of 4 flexions have no zero-varus pose"))));
}

TEST(Findings, NumbersAreThoseOfTheModel)
{
  const report::MotionSummary n = report::motion_summary(equilibrium_entry().model);
  EXPECT_EQ(n.n_cells, 12);
  EXPECT_EQ(n.n_stable, 12);
  EXPECT_EQ(n.theta_undetermined_share, 0.0);
  EXPECT_NEAR(n.balance_residual_n, 1e-4 * 12, 1e-15);
  EXPECT_NEAR(n.worst_gap_mm, -1e-6 * 11, 1e-15);
  EXPECT_NEAR(n.largest_strain, 0.001, 1e-15);
  EXPECT_EQ(n.n_several_optima, 0);
  const report::MotionSummary search = report::motion_summary(whole_entry().model);
  EXPECT_TRUE(std::isnan(search.balance_residual_n));
  EXPECT_TRUE(std::isnan(search.largest_strain));
  // theta is 0.2 degrees per degree of flexion
  EXPECT_NEAR(search.rotation.net_deg, 0.6, 1e-12);
  EXPECT_NEAR(search.rotation.change_deg, 0.6, 1e-12);
  EXPECT_NEAR(search.spine_jump.change_deg, 0.2, 1e-12);
}

}  // namespace vrda::findings_test
