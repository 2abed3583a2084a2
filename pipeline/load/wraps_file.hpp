/// Wrapping surfaces in a JSON file: schemas/ligaments.md.
#pragma once

#include <string>
#include <vector>

#include "ligament/ligaments.hpp"

namespace vrda {

/// What the job calls its two objects; a wrap names the one it is fixed to.
struct BodyNames {
  std::string reference;
  std::string moving;
};

/// The wraps of a file, in its order, with poses in the mesh files' axes and mm.
/// Throws InputError naming the file, wrap and key.
std::vector<Wrap> read_wraps(const std::string& file, const std::string& text, const BodyNames& bodies);

}  // namespace vrda
