#include "rom/rom_journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rom/ball_in_cup.hpp"
#include "rom/rom_files.hpp"
#include "support/input_error.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::rom_journal_test {

using test::cup::ball_in_cup;
using test::cup::cup_plan;

rom::RomPlan plan_with(rom::RomLines& lines)
{
  rom::RomPlan plan = cup_plan(1, 3.0 * test::cup::step_rad);
  plan.recall = [&lines](std::int8_t axis, const std::array<std::int32_t, 3>& at) {
    const auto found = lines.find({axis, at});
    return found == lines.end() ? std::nullopt : std::optional(found->second);
  };
  plan.keep = [&lines](const rom::RomLine& line) { lines.insert_or_assign({line.axis, line.at}, line); };
  return plan;
}

std::string json_of(const load::Case& joint, const rom::RomPlan& plan)
{
  return rom::rom_json(rom::rom_document(joint, rom::range_of_motion(joint, plan), "vrda"));
}

TEST(RomJournal, ALineReadsBackToTheLastBit)
{
  rom::RomLines lines;
  rom::range_of_motion(ball_in_cup(), plan_with(lines));
  ASSERT_GT(lines.size(), 10u);
  for (const auto& [at, line] : lines) {
    const std::optional<rom::RomLine> back = rom::line_of(rom::line_bytes(line));
    ASSERT_TRUE(back);
    EXPECT_EQ(rom::line_bytes(*back), rom::line_bytes(line));
    EXPECT_EQ(back->at, line.at);
    EXPECT_FALSE(rom::line_of(rom::line_bytes(line).substr(1)));
    EXPECT_FALSE(rom::line_of(rom::line_bytes(line) + "x"));
  }
}

// A kill after any number of lines loses none of them and no byte of the result.
TEST(RomJournal, AnInterruptedRunGivesTheBytesOfAWholeOne)
{
  const load::Case joint = ball_in_cup();
  rom::RomLines all;
  const std::string whole = json_of(joint, plan_with(all));
  for (const std::size_t n_kept : {std::size_t{1}, all.size() / 2, all.size()}) {
    rom::RomLines lines;
    for (const auto& [at, line] : all) {
      if (lines.size() < n_kept) lines.emplace(at, line);
    }
    rom::RomPlan plan = plan_with(lines);
    std::size_t n_new = 0;
    const auto keep = plan.keep;
    plan.keep = [&](const rom::RomLine& line) {
      ++n_new;
      keep(line);
    };
    EXPECT_EQ(json_of(joint, plan), whole);
    EXPECT_EQ(n_new, all.size() - n_kept);
  }
}

TEST(RomJournal, ShardsGiveTheBytesOfAWholeRun)
{
  const load::Case joint = ball_in_cup();
  rom::RomLines none, joined;
  const std::string whole = json_of(joint, plan_with(none));
  for (std::int32_t number = 1; number <= 3; ++number) {
    rom::RomLines own;
    rom::RomPlan plan = plan_with(own);
    plan.shard = journal::Shard{number, 3};
    EXPECT_TRUE(rom::range_of_motion(joint, plan).cells.empty());
    joined.merge(own);
  }
  EXPECT_EQ(joined.size(), none.size());
  rom::RomPlan plan = plan_with(joined);
  plan.keep = [](const rom::RomLine&) { ADD_FAILURE() << "every line is known"; };
  EXPECT_EQ(json_of(joint, plan), whole);
}

TEST(RomJournal, ATornLineIsDroppedAndAnotherKeyRefused)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "rom.json.journal").string();
  rom::RomLines lines, read;
  rom::range_of_motion(ball_in_cup(), plan_with(lines));
  {
    journal::FrameWriter writer = rom::open_lines(path, "key", false, read);
    for (const auto& [at, line] : lines) writer.append(rom::line_bytes(line));
    writer.close();
  }
  const std::string bytes = test::read_bytes(path);
  scratch.write("rom.json.journal", bytes.substr(0, bytes.size() - 3));
  rom::open_lines(path, "key", false, read).close();
  EXPECT_EQ(read.size(), lines.size() - 1);
  EXPECT_THAT(test::input_error([&] { rom::open_lines(path, "other", false, read); }),
              test::refuses({.file = "rom.json.journal", .field = "key"}));
}

TEST(RomJournal, TheKeyDependsOnJobRotationsAndLimits)
{
  const load::Case joint = ball_in_cup();
  const rom::RomPlan plan = cup_plan(1, 0.2);
  const std::string key = rom::rom_key(joint, plan);
  rom::RomPlan other = plan;
  other.limits.opening_mm *= 2.0;
  EXPECT_NE(rom::rom_key(joint, other), key);
  other = plan;
  other.axes.rad[1].back() += 0.01;
  EXPECT_NE(rom::rom_key(joint, other), key);
  other = plan;
  other.delta_body = rom::DeltaBody::moving;
  EXPECT_NE(rom::rom_key(joint, other), key);
  load::Case changed = joint;
  changed.steps_job_text = "another";
  EXPECT_NE(rom::rom_key(changed, plan), key);
}

}  // namespace vrda::rom_journal_test
