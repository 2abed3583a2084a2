
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <functional>

#include "core/units.hpp"
#include "player/bench/bench_samples.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::recording_test {

using bench::Sample, bench::SampleKind, test::frames_of, test::reader_of, test::recording_bytes,
    test::sample_facts, test::sample_pictures;

constexpr core::FrameFormat format{"VRDABREC", 1, 1U << 24, "frame"};

/// Sizes of a file after its header, its header record, and each frame.
std::vector<std::size_t> frame_ends(const std::string& bytes)
{
  std::vector<std::size_t> ends{core::parse_header(bytes, format).n_bytes};
  while (ends.back() < bytes.size())
    ends.push_back(ends.back() +
                   core::parse_frame(std::string_view(bytes).substr(ends.back()), format).n_bytes);
  return ends;
}

/// The first `n` pictures are read, and why the rest is not is said if it has `n_dropped` bytes.
void expect_read(const std::string& bytes, const std::vector<bench::RecordedFrame>& made, std::size_t n,
                 std::size_t n_dropped)
{
  const bench::RecordingReader reader = reader_of(bytes);
  EXPECT_EQ(reader.dropped_bytes(), n_dropped);
  EXPECT_EQ(reader.dropped_why().empty(), n_dropped == 0);
  const std::vector<bench::RecordedFrame> read = frames_of(reader);
  ASSERT_EQ(read.size(), n);
  for (std::size_t k = 0; k < n; ++k) EXPECT_TRUE(test::is_same(read[k], made[k])) << k;
}

TEST(Recording, ReadsBackEveryBit)
{
  const std::vector<bench::RecordedFrame> made = sample_pictures(40);
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "a.log").string();
  bench::Recorder recorder(file, sample_facts());
  for (const bench::RecordedFrame& picture : made) {
    recorder.add(picture.now_ns, picture.keys, picture.samples);
    // What was added is there without an end.
    EXPECT_TRUE(test::is_same(frames_of(bench::RecordingReader(file)).back(), picture));
  }
  recorder.close();
  EXPECT_EQ(test::read_bytes(file), recording_bytes(sample_facts(), made));
  const bench::RecordingReader reader(file);
  EXPECT_EQ(reader.facts(), sample_facts());
  const std::vector<bench::RecordedFrame> read = frames_of(reader);
  ASSERT_EQ(read.size(), made.size());
  for (std::size_t k = 0; k < made.size(); ++k) {
    EXPECT_EQ(read[k].now_ns, made[k].now_ns);
    ASSERT_EQ(read[k].samples.size(), made[k].samples.size());
    const std::size_t n_bytes = made[k].samples.size() * sizeof(Sample);
    EXPECT_TRUE(n_bytes == 0 || std::memcmp(read[k].samples.data(), made[k].samples.data(), n_bytes) == 0);
    ASSERT_EQ(read[k].keys.size(), made[k].keys.size());
    for (std::size_t i = 0; i < made[k].keys.size(); ++i) {
      EXPECT_EQ(read[k].keys[i].key, made[k].keys[i].key);
      EXPECT_EQ(read[k].keys[i].has_shift, made[k].keys[i].has_shift);
      EXPECT_EQ(read[k].keys[i].has_control, made[k].keys[i].has_control);
    }
  }
}

/// Cut or damaged anywhere, it is read up to the last whole picture.
TEST(Recording, DamagedAnywhere)
{
  const std::vector<bench::RecordedFrame> made = sample_pictures(6);
  const std::string bytes = recording_bytes(sample_facts(), made);
  const std::vector<std::size_t> ends = frame_ends(bytes);
  ASSERT_EQ(ends.size(), made.size() + 2);
  std::size_t n_whole = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    SCOPED_TRACE(at);
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    if (at < ends[1]) {
      EXPECT_EQ(test::input_error([&] { reader_of(bytes.substr(0, at)); }).file, "a.log");
      EXPECT_EQ(test::input_error([&] { reader_of(flipped); }).file, "a.log");
      continue;
    }
    while (ends[n_whole + 2] <= at) ++n_whole;
    expect_read(bytes.substr(0, at), made, n_whole, at - ends[n_whole + 1]);
    expect_read(flipped, made, n_whole, bytes.size() - ends[n_whole + 1]);
  }
  EXPECT_EQ(n_whole + 1, made.size());
}

TEST(Recording, AWrongHeadIsNamed)
{
  const std::string header = core::header_bytes("bench recording", format);
  const core::FrameFormat journal{"VRDAJRNL", 1, 1U << 24, "record"}, newer{"VRDABREC", 2, 1U << 24, "frame"};
  struct Row {
    std::string bytes, field, found = {};
  };
  for (const Row& row :
       {Row{header, "", "record"}, Row{header + core::frame_of("no facts"), "", "header record"},
        Row{header + core::frame_of(recording_bytes(sample_facts(), {})), "", "header record"},
        Row{"\x89PNG\r\n", "header"}, Row{core::header_bytes("k", journal) + core::frame_of("x"), "header"},
        Row{core::header_bytes("bench recording", newer) + core::frame_of("x"), "format version"}}) {
    EXPECT_THAT(test::input_error([&] { reader_of(row.bytes); }),
                test::refuses({"a.log", row.field, row.found, "1"}));
  }
  EXPECT_EQ(test::input_error([] { bench::RecordingReader("/nowhere/a.log"); }).file, "/nowhere/a.log");
}

TEST(Recording, PicturesThatNoDeviceGaveAreDropped)
{
  const std::vector<bench::RecordedFrame> made = sample_pictures(1);
  const std::string start = recording_bytes(sample_facts(), made);
  const auto picture = [](const std::function<void(Sample&)>& change) {
    Sample sample;
    sample.kind = SampleKind::tool_pose;
    change(sample);
    return bench::bytes_of(1, {}, std::vector<Sample>{sample});
  };
  const std::string sound = picture([](Sample&) {});
  std::string huge = bench::bytes_of(1, {}, {});
  huge[12] = '\x7f';
  std::string flags = bench::bytes_of(1, std::vector<view::KeyPress>{{view::Key::left}}, {});
  flags[16] = '\x04';
  for (const std::string& record :
       {picture([](Sample& s) { s.tool_pose.position_mm[1] = core::nan; }),
        picture([](Sample& s) { s.tool_pose.rotation[0] = core::nan; }),
        picture([](Sample& s) { s.tool_pose.rotation[0] = 1.01; }), picture([](Sample& s) { s.state = 4; }),
        picture([](Sample& s) { s.kind = static_cast<SampleKind>(5); }),
        picture([](Sample& s) { s.kind = SampleKind::offset, s.tool_pose.position_mm[0] = core::nan; }),
        picture([](Sample& s) { s.kind = SampleKind::link, s.state = 3; }),
        picture([](Sample& s) { s.kind = SampleKind::link, s.source = 2; }), sound + "x",
        sound.substr(0, sound.size() - 1), std::string(), huge, flags}) {
    const std::string rest = core::frame_of(record) + core::frame_of(sound);
    expect_read(start + rest, made, 1, rest.size());
  }
  EXPECT_EQ(reader_of(start + core::frame_of(sound)).n_frames(), 2u);
}

TEST(Recording, AFileThatIsThereIsNotWrittenOver)
{
  const test::Scratch scratch;
  const std::string file = scratch.write("a.log", "dear").string(), folder = scratch.path().string();
  EXPECT_THAT(test::input_error([&] { bench::Recorder(file, sample_facts()); }),
              test::refuses({file, "", "existing"}));
  EXPECT_EQ(test::read_bytes(file), "dear");
  EXPECT_EQ(test::input_error([&] { bench::Recorder(folder, sample_facts()); }).file, folder);
}

/// A recording of any length is read in blocks, and any frame is reached without reading those before it.
TEST(RecordingReader, ReachesEveryFrameAndKeepsABoundedPart)
{
  constexpr std::size_t n_frames = 40'000, most_bytes = std::size_t{1} << 20;  // the index is thinned twice
  const std::vector<bench::RecordedFrame> made = sample_pictures(40);
  std::vector<bench::RecordedFrame> all;
  for (std::size_t k = 0; k < n_frames; ++k) {
    all.push_back(made[k % made.size()]);
    all.back().now_ns = static_cast<std::int64_t>(k) * 16'666'667;
  }
  const std::string bytes = recording_bytes(sample_facts(), all);
  std::size_t n_read = 0;
  bench::RecordingReader reader = reader_of(bytes, &n_read);
  ASSERT_EQ(reader.n_frames(), n_frames);
  EXPECT_LT(n_read, 2 * bytes.size());
  for (const std::size_t k : {0UL, 39'999UL, 20'000UL, 19'999UL, 20'001UL, 7UL, 8UL, 9UL, 39'998UL}) {
    n_read = 0;
    EXPECT_TRUE(test::is_same(reader.frame(k), all[k])) << k;
    EXPECT_LE(n_read, most_bytes) << k;
    const double s = reader.seconds(k);
    EXPECT_EQ(reader.index_at(s), k);
    EXPECT_EQ(reader.index_at(s + 1e-3), k + 1);
    EXPECT_TRUE(test::is_same(reader.frame(k), all[k])) << k;
  }
}

}  // namespace vrda::recording_test
