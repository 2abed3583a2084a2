// Four floats at a time: SSE2, available on every x86-64 processor.
#include <emmintrin.h>

#include "geometry/gap_lanes.hpp"

namespace vrda::geometry {
namespace {

struct Float4 {
  static constexpr int width = 4;
  __m128 v;
  static Float4 load(const float* from) { return {_mm_load_ps(from)}; }
  static Float4 all(float value) { return {_mm_set1_ps(value)}; }
  static Float4 least(Float4 a, Float4 b) { return {_mm_min_ps(a.v, b.v)}; }
  static Float4 most(Float4 a, Float4 b) { return {_mm_max_ps(a.v, b.v)}; }
  static Float4 choose(Float4 mask, Float4 yes, Float4 no)
  {
    return {_mm_or_ps(_mm_and_ps(mask.v, yes.v), _mm_andnot_ps(mask.v, no.v))};
  }
  static Float4 root(Float4 a) { return {_mm_sqrt_ps(a.v)}; }
  static float absolute(float value) { return value < 0.0F ? -value : value; }
  static unsigned bits(Float4 mask) { return static_cast<unsigned>(_mm_movemask_ps(mask.v)); }
  void store(float* to) const { _mm_store_ps(to, v); }
  friend Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend Float4 operator/(Float4 a, Float4 b) { return {_mm_div_ps(a.v, b.v)}; }
  friend Float4 operator<=(Float4 a, Float4 b) { return {_mm_cmple_ps(a.v, b.v)}; }
  friend Float4 operator>=(Float4 a, Float4 b) { return {_mm_cmpge_ps(a.v, b.v)}; }
  friend Float4 operator&(Float4 a, Float4 b) { return {_mm_and_ps(a.v, b.v)}; }
};

}  // namespace

constinit const BlockFunctions block_functions_baseline = block_functions<Float4>();

}  // namespace vrda::geometry
