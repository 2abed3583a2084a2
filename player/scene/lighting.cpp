#include "scene/lighting.hpp"

#include "core/error.hpp"

namespace vrda::scene {

Lighting studio_lighting()
{
  Lighting lighting;
  lighting.sky = {0.19F, 0.21F, 0.25F};
  lighting.ground = {0.075F, 0.065F, 0.060F};
  lighting.lights.push_back({Eigen::Vector3f(-0.50F, 0.70F, 0.70F).normalized(), {0.80F, 0.775F, 0.72F}});
  lighting.lights.push_back({Eigen::Vector3f(0.85F, 0.05F, 0.50F).normalized(), {0.19F, 0.22F, 0.27F}});
  lighting.lights.push_back({Eigen::Vector3f(0.25F, 0.55F, -0.80F).normalized(), {0.40F, 0.42F, 0.46F}});
  return lighting;
}

Background background_of(Backdrop backdrop)
{
  switch (backdrop) {
    case Backdrop::studio:
      return {Eigen::Vector3f(0.745F, 0.791F, 0.839F), Eigen::Vector3f(0.371F, 0.434F, 0.503F)};
    case Backdrop::night:
      return {Eigen::Vector3f(0.034F, 0.045F, 0.061F), Eigen::Vector3f(0.007F, 0.009F, 0.013F)};
    case Backdrop::black:
      return {};
  }
  throw InternalError("unknown backdrop");
}

}  // namespace vrda::scene
