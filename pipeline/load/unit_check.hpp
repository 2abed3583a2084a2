/// Whether the mesh files, in the unit that the job gives them, have the size of a joint.
#pragma once

#include <string>
#include <vector>

#include "load/axis_map.hpp"
#include "load/job.hpp"

namespace vrda {

/// Sizes (diagonals of bounding boxes) of components of which nothing is said.
struct UsualSizes {
  double least_mm = 0.0, most_mm = 0.0;
};

UsualSizes usual_sizes(const Job& job);

/// The unit in which what measures `size_mm` in frame.unit would have one of these sizes; empty when none.
std::string likelier_unit(const Job& job, double size_mm, const UsualSizes& sizes);

/// Length of the diagonal of a box.
double diagonal_mm(const Box& box);

/// Throws InputError where the largest mesh file of an object cannot be a bone in frame.unit: below 1 mm (of
/// a knee 3 mm) or above 3 m, which no solver setting fits. `survey` has the components in the job's order.
void check_unit(const Job& job, const std::vector<ComponentSurvey>& survey);

}  // namespace vrda
