// Recordings of the bench. Every second change has repaired checksums, as for journals.
#include "bench/recording.hpp"
#include "fuzz/checksum_mutator.hpp"
#include "fuzz/framed_checksums.hpp"

namespace {

// Accepted content is written back unchanged.
void read(const std::string& bytes)
{
  using namespace vrda;
  bench::RecordingReader recording("a.log", bytes.size(), [&bytes](std::uint64_t at, std::size_t n) {
    return bytes.substr(static_cast<std::size_t>(at), n);
  });
  test::require(recording.dropped_why().empty() == (recording.dropped_bytes() == 0),
                "bytes dropped without a reason");
  std::string again = core::frame_of(bench::bytes_of(recording.facts()));
  for (std::size_t k = 0; k < recording.n_frames(); ++k) {
    const bench::RecordedFrame& picture = recording.frame(k);
    again += core::frame_of(bench::bytes_of(picture.now_ns, picture.keys, picture.samples));
  }
  test::require(again.size() + recording.dropped_bytes() < bytes.size(),
                "bytes that are neither kept nor dropped");
  const std::size_t begin = bytes.size() - static_cast<std::size_t>(recording.dropped_bytes()) - again.size();
  test::require(bytes.compare(begin, again.size(), again) == 0, "a recording that is written otherwise");
  test::require(begin == test::fixed_header_bytes + core::u32_at(bytes, test::fixed_header_bytes - 4) + 4,
                "pictures that do not fill the valid bytes");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string bytes = vrda::test::text_of(data, size);
  vrda::test::read_or_refuse([&] { read(bytes); });
  return 0;
}
