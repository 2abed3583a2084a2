/// The signals that end a program in an orderly way.
#pragma once

#include <csignal>
#include <vector>

namespace vrda::inline core {

/// SIGINT, SIGTERM and, unless it is ignored (nohup), SIGHUP of a closed terminal.
inline std::vector<int> stop_signals()
{
  struct sigaction hangup {};
  const bool is_ignored = sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler == SIG_IGN;
  return is_ignored ? std::vector<int>{SIGINT, SIGTERM} : std::vector<int>{SIGINT, SIGTERM, SIGHUP};
}

}  // namespace vrda::inline core
