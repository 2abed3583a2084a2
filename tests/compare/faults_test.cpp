#include "compare/faults.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::faults_test {

MotionModel solved_model(int n_flexion, int n_varus)
{
  MotionModel model;
  model.status = GridB::Zero(n_flexion, n_varus);
  return model;
}

/// Free everywhere, with no gap.
AuditSet touching(const MotionModel& model, int refine)
{
  AuditSet audit;
  audit.refine = refine;
  const Eigen::Index rows = (model.status.rows() - 1) * refine + 1;
  const Eigen::Index columns = (model.status.cols() - 1) * refine + 1;
  audit.state = GridB::Zero(rows, columns);
  audit.gap_mm = audit.penetration_mm = GridD::Zero(rows, columns);
  return audit;
}

void overlap(AuditSet& audit, int i, int j, double depth_mm)
{
  audit.state(i, j) = static_cast<std::int8_t>(AuditState::overlapping);
  audit.gap_mm(i, j) = nan;
  audit.penetration_mm(i, j) = depth_mm;
}

TEST(Faults, AreSortedByWhereTheyStand)
{
  const MotionModel model = solved_model(3, 2);
  AuditSet audit = touching(model, 3);
  overlap(audit, 3, 0, 0.25);
  overlap(audit, 4, 0, 0.75);
  audit.gap_mm(6, 3) = 0.5;
  audit.gap_mm(6, 2) = 0.125;
  audit.state(0, 3) = audit.state(0, 1) = static_cast<std::int8_t>(AuditState::nothing_ahead);
  audit.gap_mm(0, 3) = audit.gap_mm(0, 1) = nan;
  const MotionFaults faults = faults_of(model, audit);
  EXPECT_EQ(faults.at_grid.n_attitudes, 6);
  EXPECT_EQ(faults.between.n_attitudes, 7 * 4 - 6);
  EXPECT_EQ(faults.at_grid.n_overlapping, 1);
  EXPECT_EQ(faults.between.n_overlapping, 1);
  EXPECT_EQ(faults.at_grid.n_nothing_ahead, 1);
  EXPECT_EQ(faults.between.n_nothing_ahead, 1);
  EXPECT_EQ(faults.at_grid.largest_penetration_mm, 0.25);
  EXPECT_EQ(faults.between.largest_penetration_mm, 0.75);
  EXPECT_EQ(faults.at_grid.largest_gap_mm, 0.5);
  EXPECT_EQ(faults.between.largest_gap_mm, 0.125);
}

TEST(Faults, BesideAFailedCellDoNotCount)
{
  MotionModel model = solved_model(3, 3);
  model.status(0, 0) = static_cast<std::int8_t>(StepStatus::no_contact);
  AuditSet audit = touching(model, 2);
  // In the cell's own patch and on its edges, but not on the far ones.
  for (const auto& [i, j] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}}) overlap(audit, i, j, 9.0);
  MotionFaults faults = faults_of(model, audit);
  EXPECT_EQ(faults.at_grid.n_attitudes, 8);
  EXPECT_EQ(faults.between.n_attitudes, 16 - 3);
  EXPECT_EQ(faults.between.largest_penetration_mm, 0.0);
  overlap(audit, 1, 2, 0.5);
  faults = faults_of(model, audit);
  EXPECT_EQ(faults.between.largest_penetration_mm, 0.5);
}

TEST(Faults, WithoutAnAttitudeAreNotNumbers)
{
  const MotionModel model = solved_model(4, 1);
  AuditSet audit = touching(model, 1);
  audit.state.setConstant(static_cast<std::int8_t>(AuditState::no_pose));
  audit.gap_mm.setConstant(nan);
  audit.penetration_mm.setConstant(nan);
  for (const Faults& faults : {faults_of(model, audit).at_grid, faults_of(model, audit).between}) {
    EXPECT_EQ(faults.n_attitudes, 0);
    EXPECT_TRUE(std::isnan(faults.largest_penetration_mm));
    EXPECT_TRUE(std::isnan(faults.largest_gap_mm));
  }
  audit.refine = 2;
  EXPECT_THROW(faults_of(model, audit), InternalError);
}

}  // namespace vrda::faults_test
