/// What a tracker's messages say of the tools that are asked for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/devices.hpp"
#include "devices/tool_watch.hpp"
#include "igtl/message.hpp"

namespace vrda {

/// Pure: times are handed in.
/// - Tools are known by name: the device of a TRANSFORM or POSITION, an element's of TDATA and QTDATA.
/// - A tool that a list leaves out is missing, unless its places come from elsewhere: by another device's
/// list, or by messages
///   of its own.
/// - A STATUS other than OK whose device is a tool says that it is missing; of any other device it is told as
/// trouble.
class TrackerTalk {
 public:
  TrackerTalk(const TrackerSettings& settings, std::int64_t now_ns);

  std::vector<Sample> hear(const IgtlMessage& message, std::int64_t now_ns);
  /// Those that have fallen stale.
  std::vector<Sample> pass_time(std::int64_t now_ns);

 private:
  struct Tool {
    std::string name;
    ToolWatch watch;
    bool is_heard = false;
    std::optional<std::string> list = std::nullopt;  ///< device of the list that told of it last
  };
  Sample sample_of(const Tool& tool, SeenState state, std::int64_t now_ns) const;
  Sample heard(Tool& tool, const IgtlTool& said, const IgtlMessage& message, std::int64_t now_ns) const;

  std::vector<Tool> tools_;
};

/// What a STATUS says that is worth telling, empty for OK and other messages.
std::string trouble_of(const IgtlMessage& message);

}  // namespace vrda
