#include "bench/measure_body.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "player/bench/bench_samples.hpp"
#include "player/setup/bench_texts.hpp"
#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::measure_body_test {

using testing::HasSubstr;

/// To a micrometre, as they are written; between two of them.
constexpr double written_mm = 2e-3;

std::string text_with(const std::string& femur)
{
  return test::bench_head() + test::display_table + "[tracker]\nport = 1\n" + femur +
         "[body.tibia]\ntool = \"tibia\"\n";
}

const std::string four_markers = "[body.femur]\nmarkers = [\"a\", \"b\", \"c\", \"d\"]\n";

BenchFile unmeasured(const std::string& places = "")
{
  return parsed_bench_file(text_with(four_markers + places), "bench.toml", MarkerPlaces::may_be_missing);
}

using Places = std::vector<Eigen::Vector3d>;
const Places tetrahedron{{10, 20, 30}, {90, 20, 30}, {10, 80, 30}, {10, 20, 80}};

std::vector<MarkerRow> frames_of(const Places& places)
{
  std::vector<MarkerRow> frames;
  for (int k = 0; k < 40; ++k) {
    MarkerRow row;
    for (const Eigen::Vector3d& p : places) row.emplace_back(test::some_pose(k % 9) * p);
    if (k % 5 == 0) row[static_cast<std::size_t>(k / 5 % 4)].reset();
    frames.push_back(row);
  }
  return frames;
}

TEST(MeasureBody, ItsLinesAreThoseOfABenchFileWithTheSameDistances)
{
  const BenchFile bench = unmeasured();
  const BuiltBody built = body_from(frames_of(tetrahedron), bench, BodyRole::femur);
  const std::string lines = body_text(built, bench, BodyRole::femur);
  EXPECT_THAT(lines, HasSubstr("# from 40 frames, 0 of fewer than three markers left out; residual 0 mm"));
  EXPECT_THAT(lines, HasSubstr("# d: 0 mm in 38 frames\n"));
  const BenchFile measured = test::bench_of(text_with(lines));
  const Places& found = measured.bodies[static_cast<std::size_t>(BodyRole::femur)]->markers_body_mm;
  ASSERT_EQ(found.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_NEAR((found[i] - found[j]).norm(), (tetrahedron[i] - tetrahedron[j]).norm(), written_mm);
}

TEST(MeasureBody, KeepsTheFrameOfPlacesThatStandThere)
{
  const BenchFile bench = unmeasured("markers_mm = [10, 20, 30, 90, 20, 30, 10, 80, 30, 10, 20, 80]\n");
  const BuiltBody built = body_from(frames_of(tetrahedron), bench, BodyRole::femur);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_LT((built.body.markers_mm.row(static_cast<Eigen::Index>(k)).transpose() - tetrahedron[k]).norm(),
              1e-6);
  EXPECT_THAT(body_text(built, bench, BodyRole::femur),
              HasSubstr("# in the frame of the bench file's markers_mm, 0 mm from them\n"));
}

TEST(MeasureBody, MarkersThatMakeNoBodyAreRefusedByName)
{
  const auto refusal = [](const std::vector<MarkerRow>& frames) {
    const InputError::Facts facts =
        test::input_error([&] { body_from(frames, unmeasured(), BodyRole::femur); });
    EXPECT_EQ(facts.file, "bench.toml");
    EXPECT_EQ(facts.field, "body.femur.markers");
    EXPECT_FALSE(facts.wanted.empty());
    return facts.found;
  };
  EXPECT_THAT(refusal(frames_of({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0}})), HasSubstr("collinear"));
  EXPECT_THAT(refusal(frames_of({{0, 0, 0}, {0, 0, 1}, {50, 0, 0}, {0, 50, 0}})),
              HasSubstr("'a' and 'b' 1 mm apart"));
  std::vector<MarkerRow> unseen = frames_of(tetrahedron), never_together = unseen;
  for (MarkerRow& row : unseen) row[2].reset();
  EXPECT_EQ(refusal(unseen), "'c' in none of 40 frames");
  for (std::size_t k = 0; k < never_together.size(); ++k) {
    if (k < 3) {
      never_together[k][0].reset();
    } else {
      never_together[k][3].reset();
    }
    if (k < 3) never_together[k][1].reset();
  }
  EXPECT_THAT(refusal(never_together), HasSubstr("'d' seen in 3 frames"));
}

TEST(MeasureBody, WhatCannotBeMeasuredIsTold)
{
  const test::Scratch scratch;
  MeasureBodyOptions options;
  options.bench = scratch.write("bench.toml", text_with(four_markers)).string();
  options.seconds = 0.1;
  const auto refusal = [&](const char* role) {
    options.role = role;
    std::ostringstream data, talk;
    const InputError::Facts facts = test::input_error([&] { measure_body(options, {data, talk}); });
    EXPECT_EQ(facts.file, options.bench);
    EXPECT_EQ(data.str(), "");
    return facts;
  };
  EXPECT_EQ(refusal("tibia").found, "no body 'tibia' of markers");
  EXPECT_EQ(refusal("tibia").wanted, "femur");
  EXPECT_THAT(refusal("femur").found, HasSubstr("none of them seen in 0.1 s (no tracker at 127.0.0.1:1"));
  options.bench = scratch.write("tools.toml", test::bench_text()).string();
  EXPECT_EQ(refusal("femur").found, "no body of markers");
}

}  // namespace vrda::measure_body_test
