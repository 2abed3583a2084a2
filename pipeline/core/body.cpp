#include "core/body.hpp"

namespace vrda {

Body mirrored_z(const Body& body)
{
  Body result = body;
  result.contact.mesh = mirrored_z(body.contact.mesh);
  result.visual.mesh = mirrored_z(body.visual.mesh);
  return result;
}

}  // namespace vrda
