/// Image of a loaded case from the front and from the side.
#pragma once

#include <array>
#include <map>
#include <string>

#include "job/case.hpp"

namespace vrda::job {

/// By how much smoothing moved vertices of a body, mm, by where they are now: canonical axes, in the single
/// precision of STL files.
using MovedVertices = std::map<std::array<float, 3>, double>;

struct PictureNotes {
  /// The mesh files' axes along anterior, proximal and right, e.g. "-Y"; empty without mesh files.
  std::array<std::string, 3> file_axes;
  std::size_t n_warnings = 0;
  std::string refusal;  ///< drawn in the title and instead of the warnings; empty: not refused
  /// Also from behind and from the medial side (other joints: from the left), and only what is near the
  /// rotation centre: 80 mm above it, 110 mm below.
  bool has_four_views = false;
  std::array<MovedVertices, 2> moved;  ///< of the reference and of the moving body; drawn in colour
  std::string smoothing;               ///< added to the caption
};

/// The bytes of a PNG file: bones in the pose of the mesh files, anatomical axes at the rotation centre,
/// push, followers, fibres and scale bar, from the front and from the lateral side (other joints: from the
/// right).
std::string case_picture(const job::Case& job_case, const PictureNotes& notes);

}  // namespace vrda::job
