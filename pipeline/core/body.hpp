/// One of the two objects of a joint: components that touch, components that are only drawn.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

struct Component {
  std::string name;      ///< unique within its body
  std::string material;  ///< "bone", "cartilage", "meniscus", ...
};

/// Triangles of several components in one mesh.
struct Part {
  Mesh mesh;                            ///< canonical axes, mm, not recentred
  std::vector<std::int32_t> component;  ///< [n_triangles] index into Body::components
};

struct Body {
  std::string name;
  std::vector<Component> components;
  Part contact;  ///< takes part in contact
  Part visual;   ///< drawn only
};

/// Rows of part.mesh.triangles by the component they belong to, in order: one list a component of `body`.
std::vector<std::vector<Eigen::Index>> triangles_by_component(const Body& body, const Part& part);

/// Both parts of `body` reflected in Z = 0.
Body mirrored_z(const Body& body);

}  // namespace vrda
