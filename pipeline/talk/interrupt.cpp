#include "talk/interrupt.hpp"

#include <csignal>

#include <atomic>

namespace vrda {
namespace {

std::atomic<bool> interrupted = false;
std::atomic<bool> bears_terms = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch a lock-free flag");

extern "C" void on_signal(int signal)
{
  interrupted = true;
  if (signal != SIGTERM || !bears_terms) std::signal(signal, SIG_DFL);
}

}  // namespace

void watch_for_interrupts()
{
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

void bear_repeated_terms()
{
  bears_terms = true;
}

bool is_interrupted()
{
  return interrupted;
}

}  // namespace vrda
