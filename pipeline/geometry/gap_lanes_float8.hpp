/// Eight floats of AVX. Included only by files compiled with -mavx2 or more; the anonymous namespace gives
/// each file its own copy.
#pragma once

#include <immintrin.h>

#include "geometry/gap_lanes.hpp"

namespace vrda::geometry {
namespace {

struct Float8 {
  static constexpr int width = 8;
  __m256 v;
  static Float8 load(const float* from) { return {_mm256_load_ps(from)}; }
  static Float8 all(float value) { return {_mm256_set1_ps(value)}; }
  static Float8 least(Float8 a, Float8 b) { return {_mm256_min_ps(a.v, b.v)}; }
  static Float8 most(Float8 a, Float8 b) { return {_mm256_max_ps(a.v, b.v)}; }
  static Float8 choose(Float8 mask, Float8 yes, Float8 no) { return {_mm256_blendv_ps(no.v, yes.v, mask.v)}; }
  static Float8 root(Float8 a) { return {_mm256_sqrt_ps(a.v)}; }
  static float absolute(float value) { return value < 0.0F ? -value : value; }
  static unsigned bits(Float8 mask) { return static_cast<unsigned>(_mm256_movemask_ps(mask.v)); }
  void store(float* to) const { _mm256_store_ps(to, v); }
  friend Float8 operator+(Float8 a, Float8 b) { return {_mm256_add_ps(a.v, b.v)}; }
  friend Float8 operator-(Float8 a, Float8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
  friend Float8 operator*(Float8 a, Float8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
  friend Float8 operator/(Float8 a, Float8 b) { return {_mm256_div_ps(a.v, b.v)}; }
  friend Float8 operator<=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
  friend Float8 operator>=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
  friend Float8 operator&(Float8 a, Float8 b) { return {_mm256_and_ps(a.v, b.v)}; }
};

}  // namespace
}  // namespace vrda::geometry
