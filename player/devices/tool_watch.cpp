#include "devices/tool_watch.hpp"

namespace vrda {

ToolWatch::Heard ToolWatch::hear(std::int64_t device_ns, std::int64_t now_ns)
{
  if (device_ns != 0 && device_ns == counted_ns_) return Heard::repeated;
  if (device_ns != 0 && device_ns < counted_ns_) {
    if (n_behind_ == 0 || device_ns < last_behind_ns_) {
      n_behind_ = 1;
    } else if (device_ns > last_behind_ns_) {
      ++n_behind_;
    }
    last_behind_ns_ = device_ns;
    if (n_behind_ < n_to_believe) return Heard::behind;
  }
  counted_ns_ = device_ns;
  n_behind_ = 0;
  last_news_ns_ = now_ns;
  return Heard::counts;
}

bool ToolWatch::falls_stale(std::int64_t now_ns)
{
  if (now_ns - last_news_ns_ < stale_after_ns_) return false;
  last_news_ns_ = now_ns;
  return true;
}

}  // namespace vrda
