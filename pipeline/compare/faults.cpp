#include "compare/faults.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

bool is_stable(const MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  return model.status(i, j) == status_stable;
}

/// The one, two or four cells around attitude (i, j) of the finer grid are solved.
bool is_surrounded(const MotionModel& model, Eigen::Index i, Eigen::Index j, Eigen::Index refine)
{
  for (const Eigen::Index row : {i / refine, (i + refine - 1) / refine}) {
    for (const Eigen::Index column : {j / refine, (j + refine - 1) / refine}) {
      if (!is_stable(model, row, column)) return false;
    }
  }
  return true;
}

/// NaN is none yet, or none here.
void raise(double& largest, double value)
{
  if (std::isnan(largest) || value > largest) largest = value;
}

void include(Faults& faults, AuditState state, double gap_mm, double penetration_mm)
{
  if (state == AuditState::no_pose) return;
  ++faults.n_attitudes;
  if (state == AuditState::overlapping) ++faults.n_overlapping;
  if (state == AuditState::nothing_ahead) ++faults.n_nothing_ahead;
  raise(faults.largest_penetration_mm, penetration_mm);
  raise(faults.largest_gap_mm, gap_mm);
}

}  // namespace

MotionFaults faults_of(const MotionModel& model, const AuditSet& audit)
{
  const auto refine = static_cast<Eigen::Index>(audit.refine);
  check(refine >= 1 && audit.state.rows() == (model.status.rows() - 1) * refine + 1 &&
            audit.state.cols() == (model.status.cols() - 1) * refine + 1,
        "an audit of a smoothed motion refines the grid of the model");
  MotionFaults result;
  for (Faults* faults : {&result.at_grid, &result.between})
    faults->largest_penetration_mm = faults->largest_gap_mm = nan;
  for (Eigen::Index i = 0; i < audit.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < audit.state.cols(); ++j) {
      if (!is_surrounded(model, i, j, refine)) continue;
      const bool is_of_grid = i % refine == 0 && j % refine == 0;
      include(is_of_grid ? result.at_grid : result.between, static_cast<AuditState>(audit.state(i, j)),
              audit.gap_mm(i, j), audit.penetration_mm(i, j));
    }
  }
  return result;
}

}  // namespace vrda
