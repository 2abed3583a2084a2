// `vrda reduce`, and the zero-varus motion written by `vrda run`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"
#include "support/small_disk.hpp"

namespace vrda::reduce_test {

using nlohmann::json;

class Reduce : public test::CommandTest {};

std::vector<std::vector<std::string>> fields_of(const std::string& text)
{
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::string field;
    for (const char c : line + ",") {
      if (c == ',') rows.back().push_back(std::exchange(field, ""));
      if (c != ',') field += c;
    }
  }
  return rows;
}

TEST_F(Reduce, ARunLeavesWhatReduceWouldMake)
{
  const std::string file = solved_knee("right"), left_by_run = test::text_of(file);
  ASSERT_TRUE(store::read_motion_model(file).zero_varus);
  for (int twice = 0; twice < 2; ++twice) {
    const test::Ended ended = test::run_vrda({"reduce", file});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.err, test::reports(file, {"raw", "7"}));
    EXPECT_EQ(test::text_of(file), left_by_run);
  }
  EXPECT_EQ(test::run_vrda({"validate", file}).exit_code, 0);
  EXPECT_EQ(test::run_vrda({"reduce", file, "--quiet"}).err, "");
}

// Printing needs no write access: on a read-only disk the numbers are the same, and nothing is stored.
TEST_F(Reduce, ReduceAndAuditPrintWithoutWriteAccess)
{
  if (!test::mount_refusal().empty()) GTEST_SKIP() << "a disk of its own, missing: " << test::mount_refusal();
  const std::string made = solved_knee("right");
  const std::filesystem::path folder = scratch_.path() / "read-only";
  std::filesystem::create_directory(folder);
  test::SmallDisk disk(folder, 8 << 20);
  const std::string file = (folder / "knee.h5").string();
  std::filesystem::copy_file(made, file);
  const std::string before = test::text_of(file);
  for (const std::string command : {"reduce", "audit"}) {
    SCOPED_TRACE(command);
    disk.forbid_writing();
    const test::Ended ended = test::run_vrda({command, file, "--json"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.err, test::warns(file, {"write access", "stored"}));
    EXPECT_EQ(test::text_of(file), before);
    disk.permit_writing();
    EXPECT_EQ(json::parse(ended.out), json::parse(test::run_vrda({command, made, "--json"}).out));
  }
}

TEST_F(Reduce, TableAndJsonSayWhatTheFileHolds)
{
  const std::string file = solved_knee("right");
  const auto rows = fields_of(test::run_vrda({"reduce", file}).out);
  const json all = json::parse(test::run_vrda({"reduce", file, "--json"}).out);
  const store::ZeroVarus z = *store::read_motion_model(file).zero_varus;
  ASSERT_EQ(rows.size(), 8u);
  ASSERT_EQ(all.at("flexions").size(), 7u);
  ASSERT_EQ(all.at("steps").size(), 6u);
  EXPECT_EQ(all.at("set"), "raw");
  const Eigen::Vector3d centre_mm = store::read_motion_model(file).rotation_centre_mm;
  EXPECT_EQ(all.at("rotation_centre_mm")[1], centre_mm.y());
  const auto column = [&](const std::string& name) {
    const auto found = std::find(rows[0].begin(), rows[0].end(), name);
    EXPECT_NE(found, rows[0].end()) << name;
    return static_cast<std::size_t>(found - rows[0].begin());
  };
  const double printed = 0.5e-6;  // half of the last digit
  for (std::size_t i = 0; i < 7; ++i) {
    ASSERT_EQ(rows[i + 1].size(), rows[0].size());
    EXPECT_EQ(rows[i + 1][column("source")], all.at("flexions")[i].at("source"));
    EXPECT_NEAR(std::stod(rows[i + 1][column("centre_z_mm")]), centre_mm.z(), printed);
    EXPECT_EQ(all.at("flexions")[i].at("is_cut_off"), z.is_cut_off[i] == 1);
    EXPECT_EQ(all.at("flexions")[i].at("internal_rotation_deg"), z.internal_rotation_deg[i]);
    EXPECT_NEAR(std::stod(rows[i + 1][column("internal_rotation_deg")]), z.internal_rotation_deg[i], printed);
    EXPECT_NEAR(std::stod(rows[i + 1][column("lateral_moving_z_mm")]), z.lateral_moving_mm[3 * i + 2],
                printed);
  }
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(all.at("steps")[k].at("from_deg"), 2.0 * static_cast<double>(k));
    EXPECT_EQ(all.at("steps")[k].at("helical_direction")[2], z.helical_direction[3 * k + 2]);
    EXPECT_EQ(all.at("steps")[k].at("medial_rolling_mm"), z.medial_rolling_mm[k]);
    EXPECT_NEAR(std::stod(rows[k + 1][column("instant_centre_proximal_mm")]), z.instant_centre_mm[2 * k + 1],
                printed);
  }
  EXPECT_EQ(rows[7][column("helical_rotation_deg")], "");
}

TEST_F(Reduce, ABandThatTheGridCutsOffIsAWarning)
{
  // One column in contact on both sides at its border, at three flexions.
  const std::string file = solved_knee("right");
  store::MotionModel model = store::read_motion_model(file);
  model.contact_medial.setZero();
  model.contact_lateral.setOnes();
  model.contact_medial.topRightCorner(3, 1).setOnes();
  store::write_motion_model(file, model);
  EXPECT_THAT(test::run_vrda({"reduce", file}).err, test::warns(file, {"3", "7", "grid.varus"}));
  EXPECT_THAT(test::run_vrda({"info", file}).out, test::reports("", {"3", "7", "grid.varus"}));
  EXPECT_EQ(json::parse(test::run_vrda({"info", file, "--json"}).out).at("zero_varus_cut_off"), 3);
}

TEST_F(Reduce, PosesOfASmoothedSet)
{
  const std::string file = solved_knee("right");
  const store::ZeroVarus raw = *store::read_motion_model(file).zero_varus;
  const test::Ended ended = test::run_vrda({"reduce", file, "--set", "degree_2", "--json"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(json::parse(ended.out).at("set"), "degree_2");
  const store::ZeroVarus smoothed = *store::read_motion_model(file).zero_varus;
  EXPECT_EQ(smoothed.varus_deg, raw.varus_deg);
  EXPECT_NE(smoothed.ty_mm, raw.ty_mm);
  EXPECT_EQ(test::run_vrda({"validate", file}).exit_code, 0);
}

TEST_F(Reduce, AnAuditOfPosesThatAreNoMoreIsDropped)
{
  const std::string file = solved_knee("right");
  store::MotionModel model = store::read_motion_model(file);
  store::AuditSet audit;
  audit.name = "zero_varus";
  audit.flexion_deg = model.flexion_deg;
  audit.varus_deg = {0.0};
  audit.state = store::GridB::Zero(7, 1);
  audit.gap_mm = audit.gap_medial_mm = audit.gap_lateral_mm = audit.penetration_mm = store::GridD::Zero(7, 1);
  model.audits.push_back(audit);
  store::write_motion_model(file, model);
  EXPECT_EQ(test::run_vrda({"reduce", file}).exit_code, 0);
  EXPECT_EQ(store::read_motion_model(file).audits.size(), 1u);
  EXPECT_EQ(test::run_vrda({"reduce", file, "--set", "degree_2"}).exit_code, 0);
  EXPECT_TRUE(store::read_motion_model(file).audits.empty());
}

}  // namespace vrda::reduce_test
