#include "analysis/rom_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "analysis/ball_in_cup.hpp"
#include "support/input_error.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::rom_journal_test {

using test::cup::ball_in_cup;
using test::cup::cup_plan;

analysis::RomPlan plan_with(analysis::RomLines& lines)
{
  analysis::RomPlan plan = cup_plan(1, 3.0 * test::cup::step_rad);
  plan.recall = [&lines](std::int8_t axis, const std::array<std::int32_t, 3>& at) {
    const auto found = lines.find({axis, at});
    return found == lines.end() ? std::nullopt : std::optional(found->second);
  };
  plan.keep = [&lines](const analysis::RomLine& line) { lines.insert_or_assign({line.axis, line.at}, line); };
  return plan;
}

std::string json_of(const job::Case& joint, const analysis::RomPlan& plan)
{
  return analysis::rom_json(analysis::rom_document(joint, analysis::range_of_motion(joint, plan), "vrda"));
}

TEST(RomJournal, ALineReadsBackToTheLastBit)
{
  analysis::RomLines lines;
  analysis::range_of_motion(ball_in_cup(), plan_with(lines));
  ASSERT_GT(lines.size(), 10u);
  for (const auto& [at, line] : lines) {
    const std::optional<analysis::RomLine> back = analysis::line_of(analysis::line_bytes(line));
    ASSERT_TRUE(back);
    EXPECT_EQ(analysis::line_bytes(*back), analysis::line_bytes(line));
    EXPECT_EQ(back->at, line.at);
    EXPECT_FALSE(analysis::line_of(analysis::line_bytes(line).substr(1)));
    EXPECT_FALSE(analysis::line_of(analysis::line_bytes(line) + "x"));
  }
}

// A kill after any number of lines loses none of them and no byte of the result.
TEST(RomJournal, AnInterruptedRunGivesTheBytesOfAWholeOne)
{
  const job::Case joint = ball_in_cup();
  analysis::RomLines all;
  const std::string whole = json_of(joint, plan_with(all));
  for (const std::size_t n_kept : {std::size_t{1}, all.size() / 2, all.size()}) {
    analysis::RomLines lines;
    for (const auto& [at, line] : all) {
      if (lines.size() < n_kept) lines.emplace(at, line);
    }
    analysis::RomPlan plan = plan_with(lines);
    std::size_t n_new = 0;
    const auto keep = plan.keep;
    plan.keep = [&](const analysis::RomLine& line) {
      ++n_new;
      keep(line);
    };
    EXPECT_EQ(json_of(joint, plan), whole);
    EXPECT_EQ(n_new, all.size() - n_kept);
  }
}

TEST(RomJournal, ShardsGiveTheBytesOfAWholeRun)
{
  const job::Case joint = ball_in_cup();
  analysis::RomLines none, joined;
  const std::string whole = json_of(joint, plan_with(none));
  for (std::int32_t number = 1; number <= 3; ++number) {
    analysis::RomLines own;
    analysis::RomPlan plan = plan_with(own);
    plan.shard = store::Shard{number, 3};
    EXPECT_TRUE(analysis::range_of_motion(joint, plan).cells.empty());
    joined.merge(own);
  }
  EXPECT_EQ(joined.size(), none.size());
  analysis::RomPlan plan = plan_with(joined);
  plan.keep = [](const analysis::RomLine&) { ADD_FAILURE() << "every line is known"; };
  EXPECT_EQ(json_of(joint, plan), whole);
}

TEST(RomJournal, ATornLineIsDroppedAndAnotherKeyRefused)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "rom.json.journal").string();
  analysis::RomLines lines, read;
  analysis::range_of_motion(ball_in_cup(), plan_with(lines));
  {
    core::FrameWriter writer = analysis::open_lines(path, "key", false, read);
    for (const auto& [at, line] : lines) writer.append(analysis::line_bytes(line));
    writer.close();
  }
  const std::string bytes = test::read_bytes(path);
  scratch.write("rom.json.journal", bytes.substr(0, bytes.size() - 3));
  analysis::open_lines(path, "key", false, read).close();
  EXPECT_EQ(read.size(), lines.size() - 1);
  EXPECT_THAT(test::input_error([&] { analysis::open_lines(path, "other", false, read); }),
              test::refuses({.file = "rom.json.journal", .field = "key"}));
}

TEST(RomJournal, TheKeyDependsOnJobRotationsAndLimits)
{
  const job::Case joint = ball_in_cup();
  const analysis::RomPlan plan = cup_plan(1, 0.2);
  const std::string key = analysis::rom_key(joint, plan);
  analysis::RomPlan other = plan;
  other.limits.opening_mm *= 2.0;
  EXPECT_NE(analysis::rom_key(joint, other), key);
  other = plan;
  other.axes.rad[1].back() += 0.01;
  EXPECT_NE(analysis::rom_key(joint, other), key);
  other = plan;
  other.delta_body = analysis::DeltaBody::moving;
  EXPECT_NE(analysis::rom_key(joint, other), key);
  job::Case changed = joint;
  changed.steps_job_text = "another";
  EXPECT_NE(analysis::rom_key(changed, plan), key);
}

}  // namespace vrda::rom_journal_test
