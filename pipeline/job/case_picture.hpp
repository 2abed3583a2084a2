/// Image of a loaded case from the front and from the side.
#pragma once

#include <array>
#include <string>

#include "job/case.hpp"

namespace vrda::job {

struct PictureNotes {
  /// The mesh files' axes along anterior, proximal and right, e.g. "-Y"; empty without mesh files.
  std::array<std::string, 3> file_axes;
  std::size_t n_warnings = 0;
  std::string refusal;  ///< drawn in the title and instead of the warnings; empty: not refused
  /// Also from behind and from the medial side (other joints: from the left), and only what is near the
  /// rotation centre: 80 mm above it, 110 mm below.
  bool has_four_views = false;
};

/// The bytes of a PNG file: bones in the pose of the mesh files, anatomical axes at the rotation centre,
/// push, fibres and scale bar, from the front and from the lateral side (other joints: from the right).
std::string case_picture(const job::Case& job_case, const PictureNotes& notes);

}  // namespace vrda::job
