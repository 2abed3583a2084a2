// Journals of steps and of traces. Most changes fail a checksum and test little, so every second change has
// repaired checksums.
#include "fuzz/checksum_mutator.hpp"
#include "fuzz/framed_checksums.hpp"
#include "store/journal.hpp"

namespace {

void read_steps(const std::string& bytes)
{
  using namespace vrda;
  const store::JournalContent content = store::parse_journal("a.journal", bytes);
  test::require(content.valid_bytes + content.dropped_bytes == bytes.size(),
                "bytes that are neither kept nor dropped");
  test::require(content.dropped_reason.empty() == (content.dropped_bytes == 0),
                "bytes dropped without a reason");
  std::size_t at = test::fixed_header_bytes + content.key.size() + 4;
  for (const StepRecord& record : content.records) {
    const std::string again = core::bytes_of_value(record);
    test::require(bytes.compare(at + core::frame_head_bytes, again.size(), again) == 0,
                  "a record that is written otherwise");
    at += core::frame_head_bytes + again.size();
  }
  test::require(at == content.valid_bytes, "records that do not fill the valid bytes");
}

void read_traces(const std::string& bytes)
{
  using namespace vrda;
  const store::TraceJournalContent content = store::parse_trace_journal("a.trace.journal", bytes);
  test::require(content.valid_bytes + content.dropped_bytes == bytes.size(),
                "bytes that are neither kept nor dropped");
  for (const auto& [key, search] : content.searches)
    test::require(bytes.find(core::bytes_of_value(search)) != std::string::npos,
                  "a trace that is written otherwise");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string bytes = vrda::test::text_of(data, size);
  vrda::test::read_or_refuse([&] { read_steps(bytes); });
  vrda::test::read_or_refuse([&] { read_traces(bytes); });
  return 0;
}
