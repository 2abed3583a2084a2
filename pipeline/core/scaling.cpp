#include "core/scaling.hpp"

namespace vrda::inline core {

bool is_uniform(const Eigen::Vector3d& factor)
{
  return factor.x() == factor.y() && factor.y() == factor.z();
}

}  // namespace vrda::inline core
