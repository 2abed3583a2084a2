// A serial line's bytes: the first selects how the rest is split into pieces. Every second change has
// repaired frame checksums.
#include <algorithm>

#include "bench/protocols.hpp"
#include "fuzz/checksum_mutator.hpp"
#include "fuzz/outcome.hpp"

#include "bench/board.h"

namespace {

using namespace vrda;
using Bytes = std::span<const std::uint8_t>;

void mend_checksums(std::span<std::uint8_t> bytes)
{
  for (std::size_t at = 0; at + 4 <= bytes.size(); ++at) {
    if (bytes[at] != board_frame_start_0 || bytes[at + 1] != board_frame_start_1) continue;
    const std::size_t end = at + 4 + bytes[at + 3];
    if (bytes[at + 3] > board_most_payload || end + 2 > bytes.size()) continue;
    const std::uint16_t crc = crc16(&bytes[at + 2], end - at - 2);
    bytes[end] = static_cast<std::uint8_t>(crc & 0xFF);
    bytes[end + 1] = static_cast<std::uint8_t>(crc >> 8);
    at = end + 1;
  }
}

struct Found {
  std::vector<bench::SerialFrame> frames;
  std::uint64_t n_noises = 0;
  bool operator==(const Found&) const = default;
};

Found read_in_pieces(Bytes bytes, std::size_t n)
{
  bench::SerialFrameParser line;
  Found found;
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(n, bytes.size()))) {
    line.add(bytes.first(std::min(n, bytes.size())));
    while (const std::optional<bench::SerialFrame> frame = line.next()) found.frames.push_back(*frame);
  }
  found.n_noises = line.n_noise_runs();
  return found;
}

// As the client: processes each piece and sends due requests. Half a period passes between pieces.
void protocol(Bytes bytes, std::size_t n)
{
  bench::BoardProtocol protocol({}, 0);
  for (std::int64_t now_ns = 0; !bytes.empty() && protocol.phase() != bench::BoardProtocol::Phase::failed;
       now_ns += 5'000'000) {
    test::require(protocol.due(now_ns).size() <= 3, "more requests than there are");
    test::require(protocol.phase() == bench::BoardProtocol::Phase::failed || protocol.next_due_ns() > now_ns,
                  "a request that stays due");
    for (const bench::Sample& sample : protocol.receive(bytes.first(std::min(n, bytes.size())), now_ns))
      test::require(
          sample.kind != bench::SampleKind::potentiometer || (sample.count >= 0 && sample.count <= 1023),
          "ten bits");
    bytes = bytes.subspan(std::min(n, bytes.size()));
  }
  test::require(
      (protocol.phase() == bench::BoardProtocol::Phase::failed) == !protocol.error_message().empty(),
      "given up without a reason");
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
  const Found at_once = read_in_pieces(bytes, std::max<std::size_t>(bytes.size(), 1));
  test::require(at_once == read_in_pieces(bytes, data[0] % 32U + 1U), "bytes that read otherwise in pieces");
  std::size_t n_bytes = 0;
  for (const bench::SerialFrame& frame : at_once.frames) {
    test::require(frame.n <= board_most_payload, "a payload longer than it may be");
    n_bytes += frame.n + 6U;
  }
  test::require(n_bytes <= bytes.size(), "frames of more bytes than came");
  protocol(bytes, data[0] % 32U + 1U);
  return 0;
}
