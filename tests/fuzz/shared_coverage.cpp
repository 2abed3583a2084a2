// Coverage counters shared with forked processes.
#include "fuzz/ending_cause.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <vector>

#include "fuzz/outcome.hpp"

// Bounds of the counters of -fsanitize=fuzzer-no-link, one byte per edge; symbols of the linker.
extern "C" std::uint8_t __start___sancov_cntrs[];
extern "C" std::uint8_t __stop___sancov_cntrs[];

namespace vrda::test {

void share_coverage()
{
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  // Whole pages only, since other variables precede and follow.
  const std::uintptr_t first =
      (reinterpret_cast<std::uintptr_t>(__start___sancov_cntrs) + page - 1) / page * page;
  const std::uintptr_t last = reinterpret_cast<std::uintptr_t>(__stop___sancov_cntrs) / page * page;
  require(first < last, "no counters to share");
  auto* counters = reinterpret_cast<std::uint8_t*>(first);
  const std::vector<std::uint8_t> counted(counters, counters + (last - first));
  void* shared =
      mmap(counters, last - first, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
  require(shared == counters, "no memory to share");
  for (std::size_t k = 0; k < counted.size(); ++k) counters[k] = counted[k];
}

}  // namespace vrda::test
