#include "core/body.hpp"

#include "core/error.hpp"

namespace vrda {

std::vector<std::vector<Eigen::Index>> triangles_by_component(const Body& body, const Part& part)
{
  check(part.component.size() == static_cast<std::size_t>(part.mesh.triangles.rows()),
        "every triangle of a body belongs to a component");
  std::vector<std::vector<Eigen::Index>> triangles(body.components.size());
  for (std::size_t t = 0; t < part.component.size(); ++t) {
    const auto component = static_cast<std::size_t>(part.component[t]);
    check(component < triangles.size(), "a triangle's component is one of its body");
    triangles[component].push_back(static_cast<Eigen::Index>(t));
  }
  return triangles;
}

Body mirrored_z(const Body& body)
{
  Body result = body;
  result.contact.mesh = mirrored_z(body.contact.mesh);
  result.visual.mesh = mirrored_z(body.visual.mesh);
  return result;
}

}  // namespace vrda
