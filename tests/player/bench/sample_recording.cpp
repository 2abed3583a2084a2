#include "player/bench/sample_recording.hpp"

#include <random>

#include "core/framed_file.hpp"

namespace vrda::test {
namespace {

bench::Sample sample_of(std::mt19937_64& random, std::int64_t now_ns)
{
  std::uniform_real_distribution<double> mm(-2000.0, 2000.0);
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(Eigen::Vector4d(mm(random), mm(random), mm(random), mm(random))).normalized();
  bench::Sample sample;
  sample.arrival_ns = now_ns - 1'000'000;
  sample.device_ns = now_ns + 1'000'000'000'000;
  sample.kind = static_cast<bench::SampleKind>(random() % 5);
  sample.state = static_cast<std::uint8_t>(random() % 3);
  sample.source = static_cast<std::uint16_t>(random() % 2);
  sample.count = static_cast<std::int32_t>(random() % 2001) - 1000;
  sample.tool_pose = {{mm(random), mm(random), mm(random)}, {q.w(), q.x(), q.y(), q.z()}};
  return sample;
}

}  // namespace

bench::RecordingFacts sample_facts()
{
  return {"bench.toml", "title = \"Desk\"\n", "anna.toml", std::string("version = 1\n\0x", 14),
          "knee.h5",    "1234 00ff",          "degree_6"};
}

std::vector<bench::RecordedFrame> sample_pictures(int n)
{
  std::mt19937_64 random(85);
  std::vector<bench::RecordedFrame> pictures;
  for (int k = 0; k < n; ++k) {
    bench::RecordedFrame& picture = pictures.emplace_back();
    picture.now_ns = k * 16'666'667LL;
    for (int key = 0; key < k % 3; ++key)
      picture.keys.push_back({key == 0 ? view::Key::left : view::key_of('P'), k % 2 == 0, k % 4 == 1});
    for (int s = 0; s < k % 5; ++s) picture.samples.push_back(sample_of(random, picture.now_ns));
  }
  return pictures;
}

std::string recording_bytes(const bench::RecordingFacts& facts,
                            const std::vector<bench::RecordedFrame>& pictures)
{
  std::string bytes = core::header_bytes("bench recording", {"VRDABREC", 1, 1U << 24, "frame"});
  bytes += core::frame_of(bench::bytes_of(facts));
  for (const bench::RecordedFrame& picture : pictures)
    bytes += core::frame_of(bench::bytes_of(picture.now_ns, picture.keys, picture.samples));
  return bytes;
}

bench::RecordingReader reader_of(const std::string& bytes, std::size_t* n_read)
{
  return {"a.log", bytes.size(), [&bytes, n_read](std::uint64_t at, std::size_t n) {
            if (n_read != nullptr) *n_read += n;
            return bytes.substr(static_cast<std::size_t>(at), n);
          }};
}

std::vector<bench::RecordedFrame> frames_of(bench::RecordingReader reader)
{
  std::vector<bench::RecordedFrame> frames;
  for (std::size_t k = 0; k < reader.n_frames(); ++k) frames.push_back(reader.frame(k));
  return frames;
}

bool is_same(const bench::RecordedFrame& a, const bench::RecordedFrame& b)
{
  return bench::bytes_of(a.now_ns, a.keys, a.samples) == bench::bytes_of(b.now_ns, b.keys, b.samples);
}

}  // namespace vrda::test
