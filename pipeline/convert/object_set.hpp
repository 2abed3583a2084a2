/// The three-file Object format of thesis 5.2: coordinates of all components, a normal for each vertex, and
/// the polygons as the name of their component and the numbers of their vertices. schemas/legacy-formats.md
/// has the syntax.
#pragma once

#include <string>
#include <vector>

#include "convert/text_lines.hpp"
#include "load/raw_mesh.hpp"

namespace vrda {

struct ObjectSetTexts {
  NamedText coordinates;
  NamedText normals;
  NamedText elements;
};

/// One component with the vertices it uses, in the order of the set, and their normals.
struct ObjectComponent {
  std::string name;
  RawMesh mesh;
};

inline constexpr std::size_t most_object_components = 1000;

/// The components in the order in which the elements first name them.
/// Throws InputError naming file and line.
std::vector<ObjectComponent> parse_object_set(const ObjectSetTexts& texts);

/// Reads PREFIX.coor, PREFIX.norm and PREFIX.elem. Throws InputError for a missing one of the three too.
ObjectSetTexts read_object_set(const std::string& prefix);

}  // namespace vrda
