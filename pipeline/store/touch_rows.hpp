/// Contacts and contact forces of all cells as the motion model keeps them.
#pragma once

#include <span>
#include <vector>

#include "core/step_record.hpp"
#include "store/solved_cells.hpp"

namespace vrda {

/// Compressed rows, cell by cell, of the touches that `touches_of(record)` names (a span of ContactRecord or
/// ContactForce), in W; `measure` and `measures` are the number that each kind has of its own.
template <typename Rows, typename Touch, typename TouchesOf>
Rows touch_rows(const MotionModel& model, const std::vector<StepRecord>& cells, const TouchesOf& touches_of,
                double Touch::*measure, std::vector<double> Rows::*measures)
{
  std::size_t n = 0;
  for (const StepRecord& r : cells) n += touches_of(r).size();
  Rows rows;
  rows.point_world_mm.resize(static_cast<Eigen::Index>(n), 3);
  rows.normal_world.resize(static_cast<Eigen::Index>(n), 3);
  rows.row_start.push_back(0);
  Eigen::Index row = 0;
  for (const StepRecord& r : cells) {
    const SolverFrame frame = solver_frame(model, r.key.flexion);
    for (const Touch& touch : touches_of(r)) {
      rows.point_world_mm.row(row) = world_from_solver(frame, touch.point_solver_mm).transpose();
      rows.normal_world.row(row) = world_from_solver(frame, touch.normal_solver).transpose();
      (rows.*measures).push_back(touch.*measure);
      rows.triangle_reference.push_back(touch.triangle_reference);
      rows.triangle_moving.push_back(touch.triangle_moving);
      rows.compartment.push_back(touch.compartment);
      ++row;
    }
    rows.row_start.push_back(row);
  }
  return rows;
}

}  // namespace vrda
