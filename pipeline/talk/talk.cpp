#include "talk/talk.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "core/utf8.hpp"

namespace vrda {
namespace {

spdlog::logger& talker()
{
  static const std::shared_ptr<spdlog::logger> logger = [] {
    auto made = spdlog::stderr_logger_mt("vrda");
    made->set_pattern("%v");
    return made;
  }();
  return *logger;
}

}  // namespace

void be_quiet()
{
  talker().set_level(spdlog::level::warn);
}
void say(const std::string& line)
{
  talker().info(printable(line));
}
void warn(const std::string& line)
{
  talker().warn("warning: " + printable(line));
}

}  // namespace vrda
