// A connection's bytes: the first selects how the rest is split into pieces. Most changes fail a checksum, so
// every second change has repaired checksums.
#include <algorithm>

#include "bench/igtl_message.hpp"
#include "bench/protocols.hpp"
#include "fuzz/checksum_mutator.hpp"
#include "fuzz/outcome.hpp"

namespace {

using namespace vrda;
using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t crc_at = bench::igtl_header_bytes - 8;

// Follows the sizes like the reader; stops where they exceed the data.
void mend_checksums(std::span<std::uint8_t> bytes)
{
  while (bytes.size() >= bench::igtl_header_bytes) {
    const std::uint64_t n = bench::header_of(bytes.first(bench::igtl_header_bytes)).body_bytes;
    if (n > bytes.size() - bench::igtl_header_bytes) return;
    const std::uint64_t crc = bench::igtl_crc(bytes.subspan(bench::igtl_header_bytes, n));
    for (std::size_t k = 0; k < 8; ++k) bytes[crc_at + k] = static_cast<std::uint8_t>(crc >> (56 - 8 * k));
    bytes = bytes.subspan(bench::igtl_header_bytes + n);
  }
}

void look_at(const bench::IgtlMessage& message)
{
  for (const bench::IgtlTool& tool : message.tools) {
    test::require(tool.X_tracker_tool.matrix().allFinite(), "a place that is not finite");
    const Eigen::Matrix3d R = tool.X_tracker_tool.linear();
    test::require((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-12 &&
                      R.determinant() > 0.0,
                  "an invalid rotation");
    test::require(tool.name.size() <= 20, "a name longer than its field");
  }
}

// Names are those of the seeds.
bench::TrackerProtocol protocol()
{
  bench::TrackerSettings settings;
  settings.tools = {"Femur", "Tibia"};
  return {settings, 0};
}

bench::IgtlStream read_in_pieces(Bytes bytes, std::size_t n, std::vector<bench::IgtlMessage>& messages)
{
  bench::IgtlStream stream;
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(n, bytes.size()))) {
    stream.add(bytes.first(std::min(n, bytes.size())));
    while (std::optional<bench::IgtlMessage> message = stream.next()) messages.push_back(*std::move(message));
  }
  return stream;
}

}  // namespace

void vrda::test::repair_checksums(std::uint8_t* data, std::size_t size)
{
  if (size > 1) mend_checksums({data + 1, size - 1});
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0) return 0;
  const Bytes bytes(data + 1, size - 1);
  std::vector<bench::IgtlMessage> at_once, in_pieces;
  const bench::IgtlStream whole = read_in_pieces(bytes, std::max<std::size_t>(bytes.size(), 1), at_once);
  const bench::IgtlStream cut = read_in_pieces(bytes, data[0] + 1U, in_pieces);
  test::require(at_once.size() == in_pieces.size() && whole.error_message() == cut.error_message() &&
                    whole.n_skipped() == cut.n_skipped() && whole.n_malformed() == cut.n_malformed(),
                "bytes that read otherwise in pieces");
  bench::TrackerProtocol tools = protocol();
  std::int64_t now_ns = 0;
  for (const bench::IgtlMessage& message : at_once) {
    look_at(message);
    now_ns += 10'000'000;
    test::require(tools.receive(message, now_ns).size() <= 2, "more samples than tools");
    tools.stale_samples(now_ns);
    for (const char c : bench::error_text_of(message))
      test::require(static_cast<unsigned char>(c) >= 0x20, "a message of more than one line");
  }
  return 0;
}
