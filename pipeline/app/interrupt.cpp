#include "app/interrupt.hpp"

#include <csignal>

#include <atomic>

namespace vrda {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch a lock-free flag");

extern "C" void on_signal(int signal)
{
  interrupted = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void watch_for_interrupts()
{
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool is_interrupted()
{
  return interrupted;
}

}  // namespace vrda
