// Jobs: TOML against the schema, with overrides. Lines at the top that begin with "#--set " are overrides.
#include <vector>

#include "fuzz/outcome.hpp"
#include "job/component_loader.hpp"

namespace {

std::vector<std::string> overrides_of(const std::string& text)
{
  const std::string mark = "#--set ";
  std::vector<std::string> overrides;
  for (std::size_t at = 0; text.compare(at, mark.size(), mark) == 0;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    overrides.push_back(text.substr(at + mark.size(), end - at - mark.size()));
    at = std::min(end + 1, text.size());
  }
  return overrides;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  test::read_or_refuse([&] {
    const std::string text = test::text_of(data, size);
    const job::Job job = job::parse_job("job.toml", text, overrides_of(text));
    // The resolved job must be a valid job that resolves to itself: motion models store it, journals use its
    // digest.
    test::require_no_throw([&] {
      const job::Job again = job::parse_job("resolved.toml", job.resolved_text);
      test::require(again.resolved_text == job.resolved_text, "a resolved job that resolves to another");
    });
    job::axis_map(job);
  });
  return 0;
}
