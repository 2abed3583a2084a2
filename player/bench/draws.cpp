#include "bench/draws.hpp"

namespace vrda::bench {
namespace {

/// Bit mixer for consecutive numbers. Source: Steele, Lea, Flood (2014) OOPSLA, SplitMix64's finaliser.
std::uint64_t mixed(std::uint64_t x)
{
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

}  // namespace

RandomSequence::RandomSequence(std::uint64_t seed, RandomPurpose purpose, std::uint64_t index)
    : bits_(mixed(mixed(mixed(seed) + static_cast<std::uint64_t>(purpose)) + index))
{
}

double RandomSequence::uniform()
{
  constexpr double unit = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(bits_() >> 11U) * unit;
}

double RandomSequence::normal()
{
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

Eigen::Vector3d RandomSequence::normal_vector()
{
  const double x = normal(), y = normal(), z = normal();
  return {x, y, z};
}

}  // namespace vrda::bench
