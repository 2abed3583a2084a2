#include "analysis/rom_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "analysis/ball_in_cup.hpp"
#include "core/units.hpp"
#include "support/input_error.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::rom_files_test {

/// Three by four cells; row of flexion 0: contact, in, in, fibre.
RomDocument sample()
{
  RomDocument document;
  document.program = "vrda 1";
  document.title = "Hip </title><script>";
  document.joint = "hip";
  document.side = "left";
  document.job = "title = \"Hip\"\n";
  document.inputs = {{"a.stl", std::string(64, 'a'), true}};
  document.reference_names = {"socket"};
  document.moving_names = {"head", "neck"};
  document.fibre_names = {"round", "iliofemoral"};
  RangeOfMotion& range = document.range;
  range.axes.rad[0] = {rad_from_deg(-10.0), 0.0, rad_from_deg(10.0)};
  range.axes.rad[1] = {rad_from_deg(-20.0), rad_from_deg(-5.0), rad_from_deg(5.0), rad_from_deg(30.0)};
  range.axes.rad[2] = {0.0};
  range.neutral = {1, 1, 0};
  range.X_neutral.translation() = Eigen::Vector3d(0.1, -2.0 / 3.0, 1e-7);
  range.cells.resize(12);
  for (std::size_t k = 0; k < 12; ++k) {
    RomCell& cell = range.cells[k];
    cell.status = RomStatus::contact;
    cell.opening_mm = 0.1 * static_cast<double>(k) + 1.0 / 3.0;
    cell.translation_mm = Eigen::Vector3d(1.0 / 7.0, -static_cast<double>(k), 0.0);
    cell.component_reference = 0;
    cell.component_moving = static_cast<std::int32_t>(k % 2);
  }
  range.cells[5].status = range.cells[6].status = RomStatus::in_range;
  range.cells[5].is_connected = range.cells[6].is_connected = true;
  range.cells[7].status = RomStatus::fibre;
  range.cells[7].largest_strain = 0.12;
  range.cells[7].fibre = 1;
  return document;
}

TEST(RomFiles, TheDocumentReadsBackToTheLastBit)
{
  const RomDocument before = sample();
  const std::string text = rom_json(before);
  const RomDocument after = parse_rom("rom.json", text);
  EXPECT_EQ(after.title, before.title);
  EXPECT_EQ(after.joint, before.joint);
  EXPECT_EQ(after.moving_names, before.moving_names);
  EXPECT_EQ(after.fibre_names, before.fibre_names);
  EXPECT_EQ(after.range.neutral, before.range.neutral);
  EXPECT_EQ(after.range.X_neutral.matrix(), before.range.X_neutral.matrix());
  for (std::size_t k = 0; k < before.range.cells.size(); ++k) {
    const RomCell &a = before.range.cells[k], &b = after.range.cells[k];
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.opening_mm, b.opening_mm);
    EXPECT_EQ(a.translation_mm, b.translation_mm);
    EXPECT_EQ(std::isnan(a.largest_strain), std::isnan(b.largest_strain));
    EXPECT_EQ(a.component_moving, b.component_moving);
    EXPECT_EQ(a.fibre, b.fibre);
    EXPECT_EQ(a.is_connected, b.is_connected);
  }
}

struct Damage {
  const char* pointer;
  nlohmann::json value;
  const char* field;
};

TEST(RomFiles, ADamagedDocumentIsRefusedByKey)
{
  for (const Damage& damage :
       std::vector<Damage>{{"/version", 1, "version"},
                           {"/axes/flexion", nlohmann::json::array({0, 0, 1}), "axes/flexion"},
                           {"/joint", "elbow", "joint"},
                           {"/axes/varus", nlohmann::json::array(), "axes/varus"},
                           {"/axes/internal", nlohmann::json::array({0, 1}), "cells/status"},
                           {"/cells/status/3", 9, "cells/status"},
                           {"/cells/component_moving/0", 2, "cells/component_moving"},
                           {"/cells/fibre/7", 2, "cells/fibre"},
                           {"/cells/opening_mm/0", "x", "cells/opening_mm"},
                           {"/neutral/cell/0", 3, "neutral/cell"}}) {
    nlohmann::json json = nlohmann::json::parse(rom_json(sample()));
    json[nlohmann::json::json_pointer(damage.pointer)] = damage.value;
    EXPECT_THAT(test::input_error([&] { parse_rom("a/rom.json", json.dump()); }),
                test::refuses({.file = "a/rom.json", .field = damage.field}))
        << damage.pointer;
  }
  EXPECT_THAT(test::input_error([] { parse_rom("a/rom.json", "{}"); }),
              test::refuses({.file = "a/rom.json", .field = "format"}));
}

// Trapezoidal weights of 5, 10, 5 and 7.5, 12.5, 17.5, 12.5 degrees.
TEST(RomFiles, TheVolumeIsTheTrapezoidalRule)
{
  const RomVolume volume = volume_of(sample().range);
  EXPECT_EQ(volume.n_cells, 2u);
  EXPECT_EQ(volume.n_driven, 2);
  EXPECT_NEAR(volume.volume, 10.0 * (12.5 + 17.5), 1e-9) << "rounding of angles";
  EXPECT_NEAR(volume.driven_volume, 20.0 * 50.0, 1e-9);
}

TEST(RomFiles, BoundariesSayWhatEndsTheRange)
{
  const RomDocument document = sample();
  std::vector<RangeAlong> through_neutral;
  for (const RangeAlong& along : boundaries_of(document.range)) {
    if (along.at == document.range.neutral) through_neutral.push_back(along);
  }
  ASSERT_EQ(through_neutral.size(), 2u);  // the third rotation is not driven
  EXPECT_EQ(through_neutral[0].low.beyond, RomStatus::contact);
  EXPECT_NEAR(through_neutral[0].high.deg, 0.0, 1e-12);
  EXPECT_NEAR(through_neutral[1].low.deg, -5.0, 1e-12);
  EXPECT_NEAR(through_neutral[1].high.deg, 5.0, 1e-12);
  EXPECT_EQ(through_neutral[1].high.beyond, RomStatus::fibre);
  EXPECT_EQ(through_neutral[1].high.component_moving, 1);
  EXPECT_EQ(cause_of(document, through_neutral[1].high), "fibre: iliofemoral");
  EXPECT_EQ(cause_of(document, through_neutral[0].low), "contact: socket on neck");
}

TEST(RomFiles, TablesHaveOneRowPerAttitudeAndPerLine)
{
  const auto n_lines = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  EXPECT_EQ(n_lines(rom_csv(sample())), 1 + 12);
  EXPECT_EQ(n_lines(boundary_csv(sample())), 1 + 4 + 3);
  const std::string csv = rom_csv(sample());
  EXPECT_THAT(csv, testing::HasSubstr(",0,fibre,0,"));
  EXPECT_THAT(csv, testing::HasSubstr(",0.12,iliofemoral,socket,neck\n"));
}

TEST(RomFiles, ComparisonCountsCellsOfEachAndOfBoth)
{
  const RomDocument a = sample();
  RomDocument b = a;
  b.range.cells[6].status = RomStatus::contact;
  b.range.cells[9].status = RomStatus::in_range;
  const RomComparison found = compare_ranges(a.range, b.range, "b.json");
  EXPECT_EQ(found.both.n_cells, 1u);
  EXPECT_EQ(found.only_a.n_cells, 1u);
  EXPECT_EQ(found.only_b.n_cells, 1u);
  EXPECT_NEAR(found.both.volume + found.only_a.volume, found.a.volume, 1e-9);
  EXPECT_NEAR(found.both.volume + found.only_b.volume, found.b.volume, 1e-9);
  const std::string csv = comparison_csv(a, b);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 12);
  EXPECT_THAT(csv, testing::HasSubstr(",in_range,contact,"));
  EXPECT_THAT(csv, testing::HasSubstr(",contact,in_range,"));
  b.range.axes.rad[0][0] *= 2.0;
  EXPECT_THAT(test::input_error([&] { compare_ranges(a.range, b.range, "b.json"); }),
              test::refuses({.file = "b.json", .field = "axes.flexion"}));
}

// In range are two cells at flexion 0 and varus -5 and 5: a box with four sides, two of them of two cells.
TEST(RomFiles, TheBoundaryCurveRunsAroundTheConnectedRange)
{
  double along_flexion = 0.0, along_varus = 0.0;
  const RomMaps maps = status_maps(sample());
  for (const RomMaps::Line& line : maps.outlines[0]) {
    along_flexion += line[2] - line[0];
    along_varus += line[3] - line[1];
    EXPECT_NEAR(std::abs(line[0]), 5.0, 1e-9) << "half way to the neighbours in flexion";
    EXPECT_TRUE(line[1] > -12.6 && line[3] < 17.6);
  }
  EXPECT_NEAR(along_flexion, 2.0 * 10.0, 1e-9);
  EXPECT_NEAR(along_varus, 2.0 * 30.0, 1e-9);
}

TEST(RomFiles, AComparisonMapCountsEachAttitudeOnce)
{
  const RomDocument a = sample();
  RomDocument b = a;
  b.title = "After surgery";
  b.range.cells[6].status = RomStatus::contact;
  b.range.cells[9].status = RomStatus::in_range;
  const RomMaps maps = comparison_maps(a, b);
  EXPECT_THAT(maps.legend[2].second, testing::HasSubstr("After surgery"));
  std::vector<int> n_of(maps.legend.size(), 0);
  for (const auto& slice : maps.cells)
    for (const auto& column : slice)
      for (const std::size_t row : column) ++n_of.at(row);
  EXPECT_THAT(n_of, testing::ElementsAre(1, 1, 1, 9)) << "both, the first only, the second only, neither";
}

TEST(RomJournal, TheKeyDependsOnJobRotationsAndLimits)
{
  const job::Case joint = test::cup::ball_in_cup();
  const RomPlan plan = test::cup::cup_plan(1, 0.2);
  const std::string key = rom_key(joint, plan);
  RomPlan other = plan;
  other.limits.opening_mm *= 2.0;
  EXPECT_NE(rom_key(joint, other), key);
  other = plan;
  other.axes.rad[1].back() += 0.01;
  EXPECT_NE(rom_key(joint, other), key);
  other = plan;
  other.delta_body = BodyIndex::moving;
  EXPECT_NE(rom_key(joint, other), key);
  job::Case changed = joint;
  changed.steps_job_text = "another";
  EXPECT_NE(rom_key(changed, plan), key);
}

}  // namespace vrda::analysis::rom_files_test
