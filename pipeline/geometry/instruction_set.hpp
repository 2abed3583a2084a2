/// Vector instruction set of the gap queries. All sets give the same bits; only the run time differs.
#pragma once

#include <vector>

namespace vrda::geometry {

enum class InstructionSet {
  baseline,  ///< SSE2: x86-64-v1 and -v2 processors
  avx2,
  avx512,  ///< F, VL and DQ
};

/// The sets that this processor supports, slowest first; never empty.
std::vector<InstructionSet> instruction_sets();

/// Sets the instruction set of GapQuery objects created from now on; the default is the last of
/// instruction_sets(). For tests and benchmarks. Expects one of instruction_sets().
void set_instruction_set(InstructionSet set);
InstructionSet instruction_set();

}  // namespace vrda::geometry
