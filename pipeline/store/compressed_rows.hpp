/// Compressed rows of contacts and contact forces, as in the motion model.
#pragma once

#include <span>
#include <vector>

#include "model/step_record.hpp"
#include "store/solved_cells.hpp"

namespace vrda::store {

/// Compressed rows, cell by cell, of the contacts that `contacts_of(record)` returns (a span of ContactRecord
/// or ContactForce), in W; `measure` and `measures` are the member specific to that type.
template <typename Rows, typename Contact, typename ContactsOf>
Rows compressed_rows(const MotionModel& model, const std::vector<StepRecord>& cells,
                     const ContactsOf& contacts_of, double Contact::*measure,
                     std::vector<double> Rows::*measures)
{
  std::size_t n = 0;
  for (const StepRecord& r : cells) n += contacts_of(r).size();
  Rows rows;
  rows.point_world_mm.resize(static_cast<Eigen::Index>(n), 3);
  rows.normal_world.resize(static_cast<Eigen::Index>(n), 3);
  rows.row_start.push_back(0);
  Eigen::Index row = 0;
  for (const StepRecord& r : cells) {
    const SolverFrame frame = solver_frame(model, r.key.flexion);
    for (const Contact& contact : contacts_of(r)) {
      rows.point_world_mm.row(row) = world_from_solver(frame, contact.point_solver_mm).transpose();
      rows.normal_world.row(row) = world_from_solver(frame, contact.normal_solver).transpose();
      (rows.*measures).push_back(contact.*measure);
      rows.triangle_reference.push_back(contact.triangle_reference);
      rows.triangle_moving.push_back(contact.triangle_moving);
      rows.compartment.push_back(contact.compartment);
      ++row;
    }
    rows.row_start.push_back(row);
  }
  return rows;
}

}  // namespace vrda::store
