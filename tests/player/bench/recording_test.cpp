#include "bench/recording.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "core/framed_file.hpp"
#include "player/bench/sample_recording.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::recording_test {

constexpr core::FrameFormat format{"VRDABREC", 1, 1U << 24, "picture"};

bench::Recording read(const std::string& bytes)
{
  return bench::parsed_recording("a.log", bytes);
}

/// Sizes of a file after its header, its header record, and each frame.
std::vector<std::size_t> frame_ends(const std::string& bytes)
{
  std::vector<std::size_t> ends{core::parse_header(bytes, format).n_bytes};
  while (ends.back() < bytes.size())
    ends.push_back(ends.back() +
                   core::parse_frame(std::string_view(bytes).substr(ends.back()), format).n_bytes);
  return ends;
}

void expect_same(const std::vector<bench::RecordedFrame>& read, const std::vector<bench::RecordedFrame>& made,
                 std::size_t n)
{
  ASSERT_EQ(read.size(), n);
  for (std::size_t k = 0; k < n; ++k) EXPECT_TRUE(test::is_same(read[k], made[k])) << k;
}

TEST(Recording, ReadsBackEveryBit)
{
  const std::vector<bench::RecordedFrame> made = test::sample_pictures(40);
  const test::Scratch scratch;
  const std::string file = scratch.write("a.log", test::recording_bytes(test::sample_facts(), made)).string();
  const bench::Recording recording = bench::read_recording(file);
  EXPECT_EQ(recording.facts, test::sample_facts());
  EXPECT_EQ(recording.dropped_bytes, 0u);
  EXPECT_EQ(recording.dropped_why, "");
  ASSERT_EQ(recording.frames.size(), made.size());
  for (std::size_t k = 0; k < made.size(); ++k) {
    const bench::RecordedFrame &a = recording.frames[k], &b = made[k];
    EXPECT_EQ(a.now_ns, b.now_ns);
    ASSERT_EQ(a.keys.size(), b.keys.size());
    for (std::size_t i = 0; i < a.keys.size(); ++i) {
      EXPECT_EQ(a.keys[i].key, b.keys[i].key);
      EXPECT_EQ(a.keys[i].has_shift, b.keys[i].has_shift);
      EXPECT_EQ(a.keys[i].has_control, b.keys[i].has_control);
    }
    ASSERT_EQ(a.samples.size(), b.samples.size());
    const std::size_t n_bytes = a.samples.size() * sizeof(bench::Sample);
    EXPECT_TRUE(n_bytes == 0 || std::memcmp(a.samples.data(), b.samples.data(), n_bytes) == 0) << k;
  }
}

TEST(Recording, CutAnywhereItIsReadUpToTheLastWholePicture)
{
  const std::vector<bench::RecordedFrame> made = test::sample_pictures(6);
  const std::string bytes = test::recording_bytes(test::sample_facts(), made);
  const std::vector<std::size_t> ends = frame_ends(bytes);
  ASSERT_EQ(ends.size(), made.size() + 2);
  for (std::size_t n = 0; n < ends[1]; ++n)
    EXPECT_EQ(test::input_error([&] { read(bytes.substr(0, n)); }).file, "a.log") << n;
  std::size_t n_whole = 0;
  for (std::size_t n = ends[1]; n <= bytes.size(); ++n) {
    while (n_whole + 2 < ends.size() && ends[n_whole + 2] <= n) ++n_whole;
    const bench::Recording recording = read(bytes.substr(0, n));
    expect_same(recording.frames, made, n_whole);
    EXPECT_EQ(recording.dropped_bytes, n - ends[n_whole + 1]);
    EXPECT_EQ(recording.dropped_why.empty(), recording.dropped_bytes == 0);
  }
  EXPECT_EQ(n_whole, made.size());
}

TEST(Recording, AFlippedBitDropsWhatFollows)
{
  const std::vector<bench::RecordedFrame> made = test::sample_pictures(6);
  const std::string bytes = test::recording_bytes(test::sample_facts(), made);
  const std::vector<std::size_t> ends = frame_ends(bytes);
  for (std::size_t at = 0; at < ends[1]; ++at) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    EXPECT_EQ(test::input_error([&] { read(flipped); }).file, "a.log") << at;
  }
  std::size_t n_whole = 0;
  for (std::size_t at = ends[1]; at < bytes.size(); ++at) {
    while (ends[n_whole + 2] <= at) ++n_whole;
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    const bench::Recording recording = read(flipped);
    expect_same(recording.frames, made, n_whole);
    EXPECT_EQ(recording.dropped_bytes, bytes.size() - ends[n_whole + 1]);
    EXPECT_FALSE(recording.dropped_why.empty());
  }
  EXPECT_EQ(n_whole + 1, made.size());
}

TEST(Recording, AWrongHeadIsNamed)
{
  struct Row {
    std::string bytes, field, found = {};
  };
  const std::string header = core::header_bytes("bench recording", format);
  for (const Row& row : {
           Row{header, "", "record"},
           Row{header + core::frame_of("no facts"), "", "header record"},
           Row{header + core::frame_of(test::recording_bytes(test::sample_facts(), {})), "", "header record"},
       }) {
    EXPECT_THAT(test::input_error([&] { read(row.bytes); }),
                test::refuses({"a.log", row.field, row.found, "1"}));
  }
  const core::FrameFormat journal{"VRDAJRNL", 1, 1U << 24, "record"};
  const core::FrameFormat newer{"VRDABREC", 2, 1U << 24, "picture"};
  for (const Row& row :
       {Row{"", "header"}, Row{"\x89PNG\r\n", "header"}, Row{core::header_bytes("k", journal), "header"},
        Row{core::header_bytes("bench recording", newer), "format version"}}) {
    EXPECT_THAT(test::input_error([&] { read(row.bytes + core::frame_of("x")); }),
                test::refuses({"a.log", row.field, "", "1"}));
  }
  EXPECT_EQ(test::input_error([] { bench::read_recording("/nowhere/a.log"); }).file, "/nowhere/a.log");
}

TEST(Recording, PicturesThatNoDeviceGaveAreDropped)
{
  const std::vector<bench::RecordedFrame> made = test::sample_pictures(3);
  const std::string start = test::recording_bytes(test::sample_facts(), {made[0]});
  const auto picture = [](const auto& change) {
    bench::Sample sample;
    sample.kind = bench::SampleKind::tool_pose;
    change(sample);
    return bench::bytes_of(1, {}, std::vector<bench::Sample>{sample});
  };
  const std::string sound = picture([](bench::Sample&) {});
  std::string huge = bench::bytes_of(1, {}, {});
  huge[12] = '\x7f';
  std::string flags = bench::bytes_of(1, std::vector<view::KeyPress>{{view::Key::left}}, {});
  flags[16] = '\x04';
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string& record : {
           picture([&](bench::Sample& s) { s.tool_pose.position_mm[1] = nan; }),
           picture([&](bench::Sample& s) { s.tool_pose.rotation[0] = nan; }),
           picture([](bench::Sample& s) { s.tool_pose.rotation[0] = 1.01; }),
           picture([](bench::Sample& s) { s.state = 4; }),
           picture([](bench::Sample& s) { s.kind = static_cast<bench::SampleKind>(5); }),
           picture([&](bench::Sample& s) {
             s.kind = bench::SampleKind::offset;
             s.tool_pose.position_mm[0] = nan;
           }),
           picture([](bench::Sample& s) { s.kind = bench::SampleKind::link, s.state = 3; }),
           picture([](bench::Sample& s) { s.kind = bench::SampleKind::link, s.source = 2; }),
           sound + "x",
           sound.substr(0, sound.size() - 1),
           std::string(),
           huge,
           flags,
       }) {
    const bench::Recording recording = read(start + core::frame_of(record) + core::frame_of(sound));
    expect_same(recording.frames, made, 1);
    EXPECT_EQ(recording.dropped_why.empty(), false);
    EXPECT_EQ(recording.dropped_bytes, core::frame_of(record).size() + core::frame_of(sound).size());
  }
  EXPECT_EQ(read(start + core::frame_of(sound)).frames.size(), 2u);
}

TEST(Recording, AFileThatIsThereIsNotWrittenOver)
{
  const test::Scratch scratch;
  const std::string file = scratch.write("a.log", "dear").string();
  EXPECT_THAT(test::input_error([&] { bench::Recorder(file, test::sample_facts()); }),
              test::refuses({file, "", "existing"}));
  EXPECT_EQ(test::read_bytes(file), "dear");
  const std::string nowhere = (scratch.path() / "no" / "a.log").string();
  std::filesystem::create_directories(scratch.path() / "no" / "a.log");
  EXPECT_EQ(test::input_error([&] { bench::Recorder(nowhere, test::sample_facts()); }).file, nowhere);
}

TEST(Recording, WhatWasAddedIsThereWithoutAnEnd)
{
  const std::vector<bench::RecordedFrame> made = test::sample_pictures(5);
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "a.log").string();
  bench::Recorder recorder(file, test::sample_facts());
  EXPECT_TRUE(bench::read_recording(file).frames.empty());
  for (std::size_t k = 0; k < made.size(); ++k) {
    recorder.add(made[k].now_ns, made[k].keys, made[k].samples);
    expect_same(bench::read_recording(file).frames, made, k + 1);
  }
}

/// A recording of any length is read in blocks, and any frame is reached without reading those before it.
TEST(RecordingReader, ReachesEveryFrameAndKeepsABoundedPart)
{
  constexpr std::size_t n_frames = 40'000, most_bytes = std::size_t{1} << 20;  // the index is thinned twice
  const std::vector<bench::RecordedFrame> made = test::sample_pictures(40);
  std::string bytes = test::recording_bytes(test::sample_facts(), {});
  const auto frame_at = [&made](std::size_t k) {
    bench::RecordedFrame frame = made[k % made.size()];
    frame.now_ns = static_cast<std::int64_t>(k) * 16'666'667;
    return frame;
  };
  for (std::size_t k = 0; k < n_frames; ++k) {
    const bench::RecordedFrame frame = frame_at(k);
    bytes += core::frame_of(bench::bytes_of(frame.now_ns, frame.keys, frame.samples));
  }
  std::size_t n_read = 0;
  bench::RecordingReader reader("a.log", bytes.size(), [&](std::uint64_t at, std::size_t n) {
    EXPECT_LE(n, most_bytes);
    n_read += n;
    return bytes.substr(static_cast<std::size_t>(at), n);
  });
  ASSERT_EQ(reader.n_frames(), n_frames);
  EXPECT_EQ(reader.facts(), test::sample_facts());
  EXPECT_LT(n_read, 2 * bytes.size());
  for (const std::size_t k : {0UL, 39'999UL, 20'000UL, 19'999UL, 20'001UL, 7UL, 8UL, 9UL, 39'998UL}) {
    n_read = 0;
    EXPECT_TRUE(test::is_same(reader.frame(k), frame_at(k))) << k;
    EXPECT_LE(n_read, most_bytes) << k;
    const double s = reader.seconds(k);
    EXPECT_EQ(reader.index_at(s), k);
    EXPECT_EQ(reader.index_at(s + 1e-3), k + 1);
    EXPECT_TRUE(test::is_same(reader.frame(k), frame_at(k))) << k;
  }
}

}  // namespace vrda::recording_test
