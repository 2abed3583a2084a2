/// The three-file Object format of thesis 5.2: coordinates of all components, a normal for each vertex, and
/// the polygons as component name and vertex numbers. Syntax: schemas/legacy-formats.md.
#pragma once

#include <string>
#include <vector>

#include "job/text_lines.hpp"
#include "job/raw_mesh.hpp"

namespace vrda::job {

struct ObjectSetTexts {
  NamedText coordinates;
  NamedText normals;
  NamedText elements;
};

/// One component with its vertices, in the order of the set, and their normals.
struct ObjectComponent {
  std::string name;
  job::RawMesh mesh;
};

inline constexpr std::size_t max_object_components = 1000;

/// The components in the order of their first polygons. Throws InputError with file and line.
std::vector<ObjectComponent> parse_object_set(const ObjectSetTexts& texts);

/// Reads PREFIX.coor, PREFIX.norm and PREFIX.elem. Throws InputError if one of them is missing.
ObjectSetTexts read_object_set(const std::string& prefix);

}  // namespace vrda::job
