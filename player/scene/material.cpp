#include "scene/material.hpp"

#include <cmath>

#include "core/error.hpp"

namespace vrda {
namespace {

float linear_channel(int code)
{
  const float value = static_cast<float>(code) / 255.0F;
  // A picture's colour, not a result: the last bit of std::pow does not matter after rounding to 8 bits.
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

}  // namespace

Eigen::Vector3f linear_from_srgb(int red, int green, int blue)
{
  return {linear_channel(red), linear_channel(green), linear_channel(blue)};
}

Material material_of(const std::string& name)
{
  if (name == "bone") return {linear_from_srgb(233, 220, 196), 1.0F, 0.10F, 24.0F, 0.10F};
  if (name == "cartilage") return {linear_from_srgb(206, 222, 228), 1.0F, 0.30F, 60.0F, 0.03F};
  if (name == "meniscus") return {linear_from_srgb(196, 104, 92), 0.6F, 0.25F, 50.0F, 0.04F};
  return {linear_from_srgb(170, 180, 188), 1.0F, 0.12F, 30.0F, 0.0F};
}

Lighting studio_lighting()
{
  Lighting lighting;
  lighting.sky = {0.26F, 0.28F, 0.32F};
  lighting.ground = {0.13F, 0.11F, 0.09F};
  lighting.lights.push_back({Eigen::Vector3f(-0.45F, 0.65F, 0.75F).normalized(), {0.74F, 0.71F, 0.66F}});
  lighting.lights.push_back({Eigen::Vector3f(0.85F, 0.05F, 0.50F).normalized(), {0.16F, 0.19F, 0.24F}});
  lighting.lights.push_back({Eigen::Vector3f(0.25F, 0.55F, -0.80F).normalized(), {0.30F, 0.31F, 0.34F}});
  return lighting;
}

Background background_of(Backdrop backdrop)
{
  switch (backdrop) {
    case Backdrop::studio:
      return {linear_from_srgb(240, 243, 246), linear_from_srgb(198, 206, 214)};
    case Backdrop::night:
      return {linear_from_srgb(52, 60, 70), linear_from_srgb(20, 24, 30)};
    case Backdrop::black:
      return {};
  }
  throw InternalError("a backdrop has colours");
}

}  // namespace vrda
