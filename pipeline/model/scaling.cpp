#include "model/scaling.hpp"

namespace vrda::inline model {

bool is_uniform(const Eigen::Vector3d& factor)
{
  return factor.x() == factor.y() && factor.y() == factor.z();
}

}  // namespace vrda::inline model
