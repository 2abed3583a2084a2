#include "geometry/instruction_set.hpp"

#include <algorithm>
#include <atomic>

#include "core/text.hpp"

namespace vrda::geometry {
namespace {

std::atomic<InstructionSet>& chosen()
{
  static std::atomic<InstructionSet> set{instruction_sets().back()};
  return set;
}

}  // namespace

std::vector<InstructionSet> instruction_sets()
{
  std::vector<InstructionSet> sets{InstructionSet::baseline};
  if (__builtin_cpu_supports("avx2")) sets.push_back(InstructionSet::avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    sets.push_back(InstructionSet::avx512);
  }
  return sets;
}

void set_instruction_set(InstructionSet set)
{
  const std::vector<InstructionSet> sets = instruction_sets();
  check(std::find(sets.begin(), sets.end(), set) != sets.end(), "the processor supports the instruction set");
  chosen() = set;
}

InstructionSet instruction_set()
{
  return chosen();
}

}  // namespace vrda::geometry
