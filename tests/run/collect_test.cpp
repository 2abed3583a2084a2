#include "run/submission.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "store/journal.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::collect_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string key(64, 'a');

solve::SweepPlan plan_of(solve::SpineRule rule, int n_flexion = 6, int n_varus = 5)
{
  solve::SweepPlan plan;
  for (int i = 0; i < n_flexion; ++i) plan.flexion_rad.push_back(rad_from_deg(10.0 * i));
  for (int j = 0; j < n_varus; ++j) plan.varus_rad.push_back(rad_from_deg(j - (n_varus - 1) / 2));
  plan.spine = rule;
  plan.n_restarts = rule == solve::SpineRule::free_varus ? 2 : 0;
  plan.has_band = rule == solve::SpineRule::free_varus;
  plan.is_varus_free = rule == solve::SpineRule::free_varus && n_varus == 1;
  return plan;
}

// A pose that depends on the seed, which reveals any other seeding order.
StepRecord solved(const solve::StepTask& task)
{
  StepRecord record;
  record.status = StepStatus::stable;
  record.varus_rad = task.attitude.varus_rad;
  record.pose.translation_mm =
      0.5 * task.seed.translation_mm + Eigen::Vector3d(task.attitude.flexion_rad, 1, 0);
  record.pose.theta_rad = task.attitude.varus_rad + 0.1 * task.band;
  record.gap_mm[0] = 0.3 * task.attitude.flexion_rad;
  record.gap_mm[1] = task.attitude.varus_rad;
  record.balance.energy_nmm = task.seed.theta_rad;
  return record;
}

// Every step that a sweep of these rows keeps.
std::vector<StepRecord> steps_of(solve::SweepPlan plan, std::optional<std::vector<std::int32_t>> rows,
                                 const std::map<StepKey, StepRecord>& known = {})
{
  plan.rows = std::move(rows);
  std::vector<StepRecord> kept;
  solve::SweepHooks hooks;
  hooks.recall = [&](const StepKey& k) -> std::optional<StepRecord> {
    const auto found = known.find(k);
    return found == known.end() ? std::nullopt : std::optional(found->second);
  };
  hooks.keep = [&](const StepRecord& record) { kept.push_back(record); };
  EXPECT_TRUE(solve::sweep(plan, solved, hooks, 1).is_complete);
  return kept;
}

std::map<StepKey, StepRecord> by_key(const std::vector<StepRecord>& records)
{
  std::map<StepKey, StepRecord> steps;
  for (const StepRecord& r : records) steps.emplace(r.key, r);
  return steps;
}

std::string bytes_of_all(const solve::SweepResult& result)
{
  std::string bytes;
  for (const StepRecord& r : result.cells) bytes += core::bytes_of_value(r);
  for (const std::int32_t column : result.spine_column) bytes += std::to_string(column) + ' ';
  for (const solve::FreeSpineStep& step : result.free_spine)
    bytes += core::bytes_of_value(step.chosen) + core::bytes_of_value(step.band_low);
  return bytes;
}

std::string journal_with(const test::Scratch& scratch, const std::string& name,
                         const std::vector<StepRecord>& records, const std::string& job = key)
{
  const std::string path = scratch.path() / name;
  store::JournalWriter writer = store::JournalWriter::create(path, job);
  for (const StepRecord& r : records) writer.append(r);
  return path;
}

class Collect : public testing::TestWithParam<solve::SweepPlan> {};

TEST_P(Collect, SpineAndShardsTogetherAreTheWholeSweepForAnyNumberOfThem)
{
  const solve::SweepPlan& plan = GetParam();
  const auto n_rows = static_cast<std::int32_t>(plan.flexion_rad.size());
  const auto whole = by_key(steps_of(plan, std::nullopt));
  const std::string wanted = bytes_of_all(run::replay_sweep(plan, whole));
  const auto spine = by_key(steps_of(plan, std::vector<std::int32_t>{}));
  for (std::int32_t count = 1; count <= n_rows + 3; ++count) {
    std::map<StepKey, StepRecord> steps = spine;
    for (std::int32_t number = 1; number <= count; ++number) {
      for (const StepRecord& r : steps_of(plan, run::rows_of({number, count}, n_rows), spine)) {
        EXPECT_TRUE(steps.emplace(r.key, r).second) << "solved twice";
      }
    }
    EXPECT_EQ(steps.size(), whole.size());
    EXPECT_TRUE(run::missing_steps(plan, steps).is_empty());
    EXPECT_EQ(bytes_of_all(run::replay_sweep(plan, steps)), wanted) << count << " shards";
  }
}

TEST_P(Collect, WhateverStepIsTakenAwayIsMissed)
{
  const solve::SweepPlan& plan = GetParam();
  const auto whole = by_key(steps_of(plan, std::nullopt));
  for (const auto& [gone, record] : whole) {
    auto steps = whole;
    steps.erase(gone);
    const run::MissingSteps missing = run::missing_steps(plan, steps);
    // The spine's cell is derived from another step: a probe, or the equilibrium with free varus.
    const bool is_copy =
        gone.kind == StepKind::spine && (plan.spine != solve::SpineRule::free_varus || plan.is_varus_free);
    EXPECT_EQ(missing.is_empty(), is_copy) << name_of(gone.kind) << gone.flexion << ' ' << gone.varus;
    const bool is_of_row =
        gone.kind == StepKind::row || gone.kind == StepKind::band || gone.kind == StepKind::spine;
    EXPECT_EQ(missing.is_spine_complete, is_of_row);
  }
}

TEST_P(Collect, WithoutAShardItsRowsAreMissing)
{
  const solve::SweepPlan& plan = GetParam();
  const auto spine = by_key(steps_of(plan, std::vector<std::int32_t>{}));
  auto steps = spine;
  for (const StepRecord& r : steps_of(plan, std::vector<std::int32_t>{0, 1, 3, 4}, spine))
    steps.emplace(r.key, r);
  EXPECT_THAT(run::missing_steps(plan, steps).rows, ElementsAre(2, 5));
  EXPECT_THAT(run::missing_steps(plan, {}).rows, testing::SizeIs(plan.flexion_rad.size()));
  EXPECT_FALSE(run::missing_steps(plan, {}).is_spine_complete);
  solve::SweepPlan some = plan;
  some.rows = std::vector<std::int32_t>{1, 3};
  EXPECT_TRUE(run::missing_steps(some, steps).is_empty());
}

INSTANTIATE_TEST_SUITE_P(Rules, Collect,
                         testing::Values(plan_of(solve::SpineRule::walk_to_balance),
                                         plan_of(solve::SpineRule::nearest_zero),
                                         plan_of(solve::SpineRule::free_varus),
                                         plan_of(solve::SpineRule::free_varus, 6, 1)));

TEST(CollectJournals, CountsDuplicatesAndRefusesTwoResults)
{
  const test::Scratch scratch;
  std::vector<StepRecord> records = steps_of(plan_of(solve::SpineRule::walk_to_balance), std::nullopt);
  const std::string all = journal_with(scratch, "all.journal", records);
  const std::string some = journal_with(scratch, "some.journal", {records.back(), records[0]});
  const run::CollectedSteps collected = run::collect_steps({all, some}, key);
  EXPECT_EQ(collected.n_duplicates, 2);
  EXPECT_THAT(collected.duplicate_rows, ElementsAre(0, 5));
  EXPECT_THAT(collected.duplicate_journals, ElementsAre(all, some));
  EXPECT_EQ(collected.steps.size(), by_key(records).size());
  EXPECT_THAT(collected.warnings, IsEmpty());

  records[3].pose.theta_rad += 1e-15;
  const std::string other = journal_with(scratch, "other.journal", {records[3]});
  EXPECT_THAT(test::input_error([&] {
                run::collect_steps({all, other}, key);
              }),
              test::refuses({other, "spine step at flexion 0, varus 2 of the grid", all}));
}

TEST(CollectJournals, RefusesAnotherJobAndReportsADamagedEnd)
{
  const test::Scratch scratch;
  const std::vector<StepRecord> records = steps_of(plan_of(solve::SpineRule::walk_to_balance), std::nullopt);
  const std::string foreign = journal_with(scratch, "foreign.journal", records, std::string(64, 'b'));
  EXPECT_THAT(test::input_error([&] { run::collect_steps({foreign}, key); }),
              test::refuses({foreign, "key", "", "leave"}));

  const std::string whole = journal_with(scratch, "whole.journal", records);
  const std::string bytes = test::read_bytes(whole);
  const std::string torn = scratch.write("torn.journal", bytes.substr(0, bytes.size() - 1));
  const run::CollectedSteps collected = run::collect_steps({torn}, key);
  EXPECT_EQ(collected.steps.size(), by_key(records).size() - 1);
  ASSERT_THAT(collected.warnings, testing::SizeIs(1));
  EXPECT_THAT(collected.warnings[0], HasSubstr(torn));
}

TEST(CollectJournals, MissingAttitudesAreListedByFlexionAndForIncompleteRowsByVarus)
{
  const solve::SweepPlan plan = plan_of(solve::SpineRule::nearest_zero);
  const std::vector<double> flexion_deg{0, 10, 20, 30, 40, 50}, varus_deg{-2, -1, 0, 1, 2};
  const auto spine = by_key(steps_of(plan, std::vector<std::int32_t>{}));
  auto steps = spine;
  for (const StepRecord& r : steps_of(plan, std::vector<std::int32_t>{0, 2, 3, 4}, spine))
    steps.emplace(r.key, r);
  const auto said = [&] {
    return run::missing_text(run::missing_steps(plan, steps), flexion_deg, varus_deg);
  };
  // The spine cell of each row is present.
  EXPECT_EQ(said(), "no result for 8 of 30 attitudes, at flexion 10 and 50");
  steps.erase({StepKind::row, 3, 0});
  EXPECT_EQ(said(), "no result for 9 of 30 attitudes, at flexion 10 and 50, and at flexion 30 of varus -2");
  for (const StepRecord& r : steps_of(plan, std::vector<std::int32_t>{1, 5}, spine)) steps.emplace(r.key, r);
  EXPECT_EQ(said(), "no result for 1 of 30 attitudes, at flexion 30 of varus -2");
  steps = by_key(steps_of(plan, std::nullopt));
  EXPECT_EQ(said(), "");
}

// With free varus every attitude may be present, but a rotation band missing.
TEST(CollectJournals, MissingBandsAreListed)
{
  const solve::SweepPlan plan = plan_of(solve::SpineRule::free_varus);
  auto steps = by_key(steps_of(plan, std::nullopt));
  ASSERT_EQ(steps.erase({StepKind::band, 2, 0}), 1u);
  EXPECT_EQ(run::missing_text(run::missing_steps(plan, steps), {0, 10, 20, 30, 40, 50}, {-2, -1, 0, 1, 2}),
            "no rotation band at flexion 20");
}

}  // namespace vrda::collect_test
