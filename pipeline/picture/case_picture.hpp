/// A case as it was understood, drawn from the front and from the side.
#pragma once

#include <array>
#include <string>

#include "load/case.hpp"

namespace vrda {

struct PictureNotes {
  /// The files' axes along anterior, proximal and right, as "-Y"; empty where no component is a file.
  std::array<std::string, 3> file_axes;
  std::size_t n_warnings = 0;
};

/// The bytes of a PNG file: bones on the pose of the mesh files, anatomical axes at the rotation centre, the
/// push, fibres and a scale, from the front and from the lateral side (of another joint from the right).
std::string case_picture(const Case& job_case, const PictureNotes& notes);

}  // namespace vrda
