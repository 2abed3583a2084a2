// The keyword configuration. An accepted one gives an accepted job: errors must name a line of the
// configuration.
#include "fuzz/outcome.hpp"
#include "job/job.hpp"
#include "job/thesis_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  test::read_or_refuse([&] {
    const job::KeywordConfiguration configuration =
        job::parse_configuration({"knee.cfg", test::text_of(data, size)});
    const std::string text = job::job_text(configuration, {"knee", "knee.cfg", "models", "m"});
    test::require_no_throw([&] { job::parse_job("knee.toml", text); });
  });
  return 0;
}
