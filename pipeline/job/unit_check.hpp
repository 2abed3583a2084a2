/// Plausibility of frame.unit: the mesh files must have the size of a joint.
#pragma once

#include <string>
#include <vector>

#include "job/axis_map.hpp"
#include "job/job.hpp"

namespace vrda::job {

/// Range of component sizes (diagonals of bounding boxes) without a warning.
struct SizeRange {
  double least_mm = 0.0, most_mm = 0.0;
};

SizeRange usual_size_range(const Job& job);

/// The unit in which a component of `size_mm` in `unit` would be within these sizes; empty if none.
std::string suggested_unit(const std::string& unit, double size_mm, const SizeRange& sizes);

double diagonal_mm(const Box& box);

/// Throws InputError if the largest mesh file of an object is implausible in the unit of its frame: below 1
/// mm (a knee: 3 mm) or above 3 m. `survey` has the components in the order of the job.
void check_unit(const Job& job, const std::vector<ComponentSurvey>& survey);

}  // namespace vrda::job
