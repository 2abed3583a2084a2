#include "core/material.hpp"

namespace vrda {

Material material_of(const std::string& name)
{
  if (name == "bone") return {Eigen::Vector3f(0.839F, 0.745F, 0.591F), 1.0F, 0.10F, 24.0F, 0.13F};
  if (name == "cartilage") return {Eigen::Vector3f(0.617F, 0.730F, 0.776F), 1.0F, 0.30F, 60.0F, 0.03F};
  if (name == "meniscus") return {Eigen::Vector3f(0.552F, 0.138F, 0.107F), 0.6F, 0.25F, 50.0F, 0.04F};
  return {Eigen::Vector3f(0.402F, 0.456F, 0.503F), 1.0F, 0.12F, 30.0F, 0.0F};
}

}  // namespace vrda
