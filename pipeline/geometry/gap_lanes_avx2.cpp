// Eight floats at a time. Compiled with -mavx2; called only on processors with AVX2.
#include "geometry/gap_lanes.hpp"

namespace vrda::geometry {

constinit const BlockFunctions block_functions_avx2 = block_functions<Float8>();

}  // namespace vrda::geometry
