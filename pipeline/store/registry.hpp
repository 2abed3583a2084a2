/// Registry of the motion model's datasets: one row per dataset, in the order of the file (registry.cpp and
/// registry_*.cpp). Writing, reading, checking, scaling and comparing motion models all visit it. A new
/// dataset is a new row there. The tables of the specification, schemas/motion-model.md, are generated from
/// these rows.
#pragma once

#include "store/motion_model.hpp"
#include "store/registry_visitor.hpp"

namespace vrda::store {

void visit_rows(MotionModel& model, RowVisitor& visit);

/// Visits every row of a motion model: const for writing, non-const for reading.
template <typename Model, typename Visitor>
void visit_motion_model(Model& model, Visitor&& visitor)
{
  RowVisitorOf<std::remove_reference_t<Visitor>, std::is_const_v<Model>> rows(visitor);
  visit_rows(const_cast<MotionModel&>(model), rows);  // a const one is passed on as const
}

}  // namespace vrda::store
