/// Wrapping surfaces of ligaments in a JSON file: schemas/ligaments.md.
#pragma once

#include <string>
#include <vector>

#include "model/ligaments.hpp"

namespace vrda::job {

/// Names of the two objects in the job. A wrap names the object it is fixed to.
struct BodyNames {
  std::string reference;
  std::string moving;
};

/// The wraps of a file, in order, with poses in the axes of the mesh files and mm.
/// Throws InputError naming file, wrap and key.
std::vector<model::Wrap> read_wraps(const std::string& file, const std::string& text,
                                       const BodyNames& bodies);

}  // namespace vrda::job
