#include "run/announced_case.hpp"

#include "run/scaling_text.hpp"
#include "talk/talk.hpp"

namespace vrda {

Case announced_case(const std::string& job_file, const LoadOptions& options)
{
  Case job_case = load_case(job_file, options);
  for (const std::string& line : job_case.warnings) warn(line);
  if (const std::string line = scaling_line(job_case); !line.empty()) say(line);
  return job_case;
}

}  // namespace vrda
