#include "core/scaling.hpp"

namespace vrda {

bool is_even(const Eigen::Vector3d& factor)
{
  return factor.x() == factor.y() && factor.y() == factor.z();
}

}  // namespace vrda
