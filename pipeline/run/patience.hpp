/// How long a run waits for another process that writes the same journal.
#pragma once

#include <chrono>
#include <functional>

namespace vrda {

struct Patience {
  std::chrono::milliseconds longest{0};
  std::function<void()> begins = [] {};  ///< told once when there is something to wait for
};

}  // namespace vrda
