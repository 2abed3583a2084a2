/// Pictures of a joint at several poses.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "app/show.hpp"
#include "motion/poses.hpp"

namespace vrda {

struct Still {
  JointPose pose;
  std::string label;  ///< of the file's name: VIEW_label.png
};

/// Writes each still of each view, with one camera a view for all of them, and a path a line to `data`.
/// Of `options` counts how to draw, and the folder. `motion` is what the poses are of.
void write_stills(const ShowOptions& options, const MotionModel& model, const Motion& motion,
                  const std::vector<Still>& stills, std::ostream& data);

}  // namespace vrda
