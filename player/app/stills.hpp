/// Pictures of a joint at several poses, one a file.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "app/pictures.hpp"

namespace vrda {

struct Still {
  JointPose pose;
  std::string label;  ///< of the file's name: VIEW_label.png
};

/// Writes each still of each view into the folder, and a path a line to `data`.
void write_stills(const ShowOptions& options, PictureMaker& maker, const std::vector<Still>& stills,
                  std::ostream& data);

}  // namespace vrda
