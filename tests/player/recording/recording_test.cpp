#include "recording/recording.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "journal/frame_bytes.hpp"
#include "sample_recording.hpp"
#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::recording_test {

constexpr FrameFormat format{"VRDABREC", 1, 1U << 24, "picture"};

Recording read(const std::string& bytes)
{
  return parsed_recording("a.log", bytes);
}

/// Sizes of a file after its header, its header record, and each frame.
std::vector<std::size_t> frame_ends(const std::string& bytes)
{
  std::vector<std::size_t> ends{header_in(bytes, format).n_bytes};
  while (ends.back() < bytes.size())
    ends.push_back(ends.back() + take_frame(std::string_view(bytes).substr(ends.back()), format).n_bytes);
  return ends;
}

void expect_same(const std::vector<RecordedPicture>& read, const std::vector<RecordedPicture>& made,
                 std::size_t n)
{
  ASSERT_EQ(read.size(), n);
  for (std::size_t k = 0; k < n; ++k) EXPECT_TRUE(test::is_same(read[k], made[k])) << k;
}

TEST(Recording, ReadsBackEveryBit)
{
  const std::vector<RecordedPicture> made = test::sample_pictures(40);
  const test::Scratch scratch;
  const std::string file = scratch.write("a.log", test::recording_bytes(test::sample_facts(), made)).string();
  const Recording recording = read_recording(file);
  EXPECT_EQ(recording.facts, test::sample_facts());
  EXPECT_EQ(recording.dropped_bytes, 0u);
  EXPECT_EQ(recording.dropped_why, "");
  ASSERT_EQ(recording.pictures.size(), made.size());
  for (std::size_t k = 0; k < made.size(); ++k) {
    const RecordedPicture &a = recording.pictures[k], &b = made[k];
    EXPECT_EQ(a.now_ns, b.now_ns);
    ASSERT_EQ(a.keys.size(), b.keys.size());
    for (std::size_t i = 0; i < a.keys.size(); ++i) {
      EXPECT_EQ(a.keys[i].key, b.keys[i].key);
      EXPECT_EQ(a.keys[i].has_shift, b.keys[i].has_shift);
      EXPECT_EQ(a.keys[i].has_control, b.keys[i].has_control);
    }
    ASSERT_EQ(a.samples.size(), b.samples.size());
    const std::size_t n_bytes = a.samples.size() * sizeof(Sample);
    EXPECT_TRUE(n_bytes == 0 || std::memcmp(a.samples.data(), b.samples.data(), n_bytes) == 0) << k;
  }
}

TEST(Recording, CutAnywhereItIsReadUpToTheLastWholePicture)
{
  const std::vector<RecordedPicture> made = test::sample_pictures(6);
  const std::string bytes = test::recording_bytes(test::sample_facts(), made);
  const std::vector<std::size_t> ends = frame_ends(bytes);
  ASSERT_EQ(ends.size(), made.size() + 2);
  for (std::size_t n = 0; n < ends[1]; ++n)
    EXPECT_EQ(test::input_error([&] { read(bytes.substr(0, n)); }).file, "a.log") << n;
  std::size_t n_whole = 0;
  for (std::size_t n = ends[1]; n <= bytes.size(); ++n) {
    while (n_whole + 2 < ends.size() && ends[n_whole + 2] <= n) ++n_whole;
    const Recording recording = read(bytes.substr(0, n));
    expect_same(recording.pictures, made, n_whole);
    EXPECT_EQ(recording.dropped_bytes, n - ends[n_whole + 1]);
    EXPECT_EQ(recording.dropped_why.empty(), recording.dropped_bytes == 0);
  }
  EXPECT_EQ(n_whole, made.size());
}

TEST(Recording, AFlippedBitDropsWhatFollows)
{
  const std::vector<RecordedPicture> made = test::sample_pictures(6);
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
    const Recording recording = read(flipped);
    expect_same(recording.pictures, made, n_whole);
    EXPECT_EQ(recording.dropped_bytes, bytes.size() - ends[n_whole + 1]);
    EXPECT_FALSE(recording.dropped_why.empty());
  }
  EXPECT_EQ(n_whole + 1, made.size());
}

TEST(Recording, AWrongHeadIsNamed)
{
  const std::string wanted = "a recording of vrda-player bench --record, format version 1";
  struct Row {
    std::string bytes, found;
  };
  const std::string header = header_bytes("bench recording", format);
  for (const Row& row : {
           Row{header, "no record"},
           Row{header + frame_of("no facts"), "header record"},
           Row{header + frame_of(test::recording_bytes(test::sample_facts(), {})), "header record"},
       }) {
    const InputError::Facts facts = test::input_error([&] { read(row.bytes); });
    EXPECT_EQ(facts.file, "a.log");
    EXPECT_NE(facts.found.find(row.found), std::string::npos) << facts.found;
    EXPECT_EQ(facts.wanted, wanted);
  }
  const FrameFormat journal{"VRDAJRNL", 1, 1U << 24, "record"};
  const FrameFormat newer{"VRDABREC", 2, 1U << 24, "picture"};
  for (const std::string& bytes : {std::string(), std::string("\x89PNG\r\n"), header_bytes("k", journal),
                                   header_bytes("bench recording", newer)}) {
    const InputError::Facts facts = test::input_error([&] { read(bytes + frame_of("x")); });
    EXPECT_EQ(facts.file, "a.log");
    EXPECT_FALSE(facts.found.empty());
    EXPECT_EQ(facts.wanted, wanted);
  }
  EXPECT_EQ(test::input_error([] { read_recording("/nowhere/a.log"); }).file, "/nowhere/a.log");
}

TEST(Recording, PicturesThatNoDeviceGaveAreDropped)
{
  const std::vector<RecordedPicture> made = test::sample_pictures(3);
  const std::string start = test::recording_bytes(test::sample_facts(), {made[0]});
  const auto picture = [](const auto& change) {
    Sample sample;
    sample.kind = SampleKind::place;
    change(sample);
    return bytes_of(1, {}, std::vector<Sample>{sample});
  };
  const std::string sound = picture([](Sample&) {});
  std::string huge = bytes_of(1, {}, {});
  huge[12] = '\x7f';
  std::string flags = bytes_of(1, std::vector<KeyPress>{{Key::left}}, {});
  flags[16] = '\x04';
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string& record : {
           picture([&](Sample& s) { s.place.position_mm[1] = nan; }),
           picture([&](Sample& s) { s.place.rotation[0] = nan; }),
           picture([](Sample& s) { s.place.rotation[0] = 1.01; }),
           picture([](Sample& s) { s.state = 4; }),
           picture([](Sample& s) { s.kind = static_cast<SampleKind>(4); }),
           picture([](Sample& s) { s.kind = SampleKind::link, s.state = 3; }),
           picture([](Sample& s) { s.kind = SampleKind::link, s.source = 2; }),
           sound + "x",
           sound.substr(0, sound.size() - 1),
           std::string(),
           huge,
           flags,
       }) {
    const Recording recording = read(start + frame_of(record) + frame_of(sound));
    expect_same(recording.pictures, made, 1);
    EXPECT_EQ(recording.dropped_why.empty(), false);
    EXPECT_EQ(recording.dropped_bytes, frame_of(record).size() + frame_of(sound).size());
  }
  EXPECT_EQ(read(start + frame_of(sound)).pictures.size(), 2u);
}

TEST(Recording, AFileThatIsThereIsNotWrittenOver)
{
  const test::Scratch scratch;
  const std::string file = scratch.write("a.log", "dear").string();
  const InputError::Facts facts = test::input_error([&] { Recorder(file, test::sample_facts()); });
  EXPECT_EQ(facts.file, file);
  EXPECT_EQ(facts.found, "an existing file");
  EXPECT_EQ(test::read_bytes(file), "dear");
  const std::string nowhere = (scratch.path() / "no" / "a.log").string();
  std::filesystem::create_directories(scratch.path() / "no" / "a.log");
  EXPECT_EQ(test::input_error([&] { Recorder(nowhere, test::sample_facts()); }).file, nowhere);
}

TEST(Recording, WhatWasAddedIsThereWithoutAnEnd)
{
  const std::vector<RecordedPicture> made = test::sample_pictures(5);
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "a.log").string();
  Recorder recorder(file, test::sample_facts());
  EXPECT_TRUE(read_recording(file).pictures.empty());
  for (std::size_t k = 0; k < made.size(); ++k) {
    recorder.add(made[k].now_ns, made[k].keys, made[k].samples);
    expect_same(read_recording(file).pictures, made, k + 1);
  }
}

}  // namespace vrda::recording_test
