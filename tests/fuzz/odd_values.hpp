/// Special numbers that may break readers.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace vrda::test {

inline constexpr std::array<double, 14> odd_reals{0.0,
                                                  -0.0,
                                                  1.0,
                                                  -1.0,
                                                  1e-300,
                                                  1e300,
                                                  -1e300,
                                                  1e18,
                                                  1e9,
                                                  -1e9,
                                                  0.5,
                                                  90.0,
                                                  std::numeric_limits<double>::quiet_NaN(),
                                                  std::numeric_limits<double>::infinity()};
inline constexpr std::array<std::uint64_t, 14> odd_integers{0,
                                                            1,
                                                            2,
                                                            3,
                                                            0x7f,
                                                            0xff,
                                                            0x7fff,
                                                            0xffff,
                                                            0x7fffffff,
                                                            0xffffffff,
                                                            0x100000000,
                                                            0x7fffffffffffffff,
                                                            0xffffffffffffffff,
                                                            0x1000};

}  // namespace vrda::test
