// Rotation as with AVX; tests two moving lanes against eight reference lanes at a time. Compiled with AVX-512
// F, VL and DQ; called only on processors that have them.

// False positive in GCC 12 on the undefined initial value of its own intrinsics (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include "geometry/gap_lanes.hpp"

namespace vrda::geometry {
namespace {

__m512 twice(const BlockRow& r)
{
  return _mm512_broadcast_f32x8(_mm256_load_ps(r.lane));
}

// Lanes `lane` and `lane` + 1, eight times each.
__m512 pair_of(const BlockRow& r, __m512i lanes)
{
  return _mm512_permutexvar_ps(lanes, twice(r));
}

unsigned test_two(const PlacedBlock& r, const PlacedBlock& m, int lane, __m512 limit, BlockPairs& pairs)
{
  const __m512i lanes = _mm512_inserti32x8(_mm512_set1_epi32(lane), _mm256_set1_epi32(lane + 1), 1);
  const __m512 x_low = _mm512_max_ps(twice(r.x_low), pair_of(m.x_low, lanes));
  const __m512 x_high = _mm512_min_ps(twice(r.x_high), pair_of(m.x_high, lanes));
  const __m512 z_low = _mm512_max_ps(twice(r.z_low), pair_of(m.z_low, lanes));
  const __m512 z_high = _mm512_min_ps(twice(r.z_high), pair_of(m.z_high, lanes));
  const __mmask16 overlap =
      _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(x_low, x_high, _CMP_LE_OQ), z_low, z_high, _CMP_LE_OQ);

  const __m512 a = _mm512_sub_ps(twice(r.a), pair_of(m.a, lanes));
  const __m512 b = _mm512_sub_ps(twice(r.b), pair_of(m.b, lanes));
  const __m512 c = _mm512_sub_ps(twice(r.c), pair_of(m.c, lanes));
  const __m512 along_x = _mm512_min_ps(_mm512_mul_ps(b, x_low), _mm512_mul_ps(b, x_high));
  const __m512 along_z = _mm512_min_ps(_mm512_mul_ps(c, z_low), _mm512_mul_ps(c, z_high));
  const __m512 plane = _mm512_add_ps(_mm512_add_ps(a, along_x), along_z);
  const __m512 bound = _mm512_max_ps(plane, _mm512_sub_ps(twice(r.flat), pair_of(m.flat, lanes)));
  _mm256_store_ps(pairs.bound[lane].lane, _mm512_castps512_ps256(bound));
  _mm256_store_ps(pairs.bound[lane + 1].lane, _mm512_extractf32x8_ps(bound, 1));
  return _mm512_mask_cmp_ps_mask(overlap, bound, limit, _CMP_LE_OQ);
}

bool test(const PlacedBlock& r, const PlacedBlock& m, float limit, BlockPairs& pairs)
{
  const __m512 limits = _mm512_set1_ps(limit);
  unsigned any = 0;
  for (int lane = 0; lane < block_lanes; lane += 2) {
    const unsigned hits = test_two(r, m, lane, limits, pairs);
    pairs.hits[lane] = static_cast<std::uint8_t>(hits & 255U);
    pairs.hits[lane + 1] = static_cast<std::uint8_t>(hits >> 8U);
    any |= hits;
  }
  return any != 0;
}

}  // namespace

// Constant-initialized: dynamic initialization would run AVX-512 code on every processor.
constinit const BlockFunctions block_functions_avx512 = [] {
  BlockFunctions functions = block_functions<Float8>();
  functions.test = test;
  return functions;
}();

}  // namespace vrda::geometry
