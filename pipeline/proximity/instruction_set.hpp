/// Which vector instructions the gap queries use. Every set gives the same bits; only the time differs.
#pragma once

#include <vector>

namespace vrda {

enum class InstructionSet {
  baseline,  ///< SSE2, which x86-64-v1 and -v2 processors run
  avx2,
  avx512,  ///< F, VL and DQ
};

/// What this processor has, slowest first; never empty.
std::vector<InstructionSet> instruction_sets();

/// The set that GapQuery objects made from now on use; at the start the last of instruction_sets(). For tests
/// and benchmarks. Expects one of instruction_sets().
void set_instruction_set(InstructionSet set);
InstructionSet instruction_set();

}  // namespace vrda
