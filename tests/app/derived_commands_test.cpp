// `vrda smooth`, `audit`, `compare` and `reduce`: what they print and add to a motion model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/audit.hpp"
#include "app/commands.hpp"
#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "support/input_error.hpp"
#include "support/messages.hpp"
#include "support/small_disk.hpp"

namespace vrda::derived_commands_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Rounding of a gap that is measured again with another order of summation.
constexpr double margin_mm = 2.0 * analysis::contact_margin_mm;

/// Two balls under a plate with two dents, 7 x 5 attitudes, with the sets "raw", "degree_2" and its
/// recontacted one.
class DerivedCommands : public test::CommandTest {
 protected:
  std::string file_ = solved_knee("left");
};

TEST_F(DerivedCommands, ARunRecontactsItsSmoothedSetsUnlessDisabled)
{
  const store::MotionModel model = store::read_motion_model(file_);
  ASSERT_EQ(model.smoothed.size(), 1u);
  EXPECT_TRUE(model.smoothed.front().recontact_mm.has_value());
  EXPECT_FALSE(model.smoothed.front().is_robust);
  const std::string job = test::small_knee_job(scratch_, "right").string();
  const std::string plain = (scratch_.path() / "plain.h5").string();
  const test::Ended ended = test::run_vrda(
      {"run", job, "-o", plain, "--set", "smooth.recontact=false", "--set", "smooth.robust=true"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  const store::MotionModel other = store::read_motion_model(plain);
  EXPECT_FALSE(other.smoothed.front().recontact_mm.has_value());
  EXPECT_TRUE(other.smoothed.front().is_robust);
}

TEST_F(DerivedCommands, RecontactLeavesNoOverlapAndTheMarginAtTheAttitudes)
{
  const Json sets = test::json_of({"audit", file_});
  ASSERT_EQ(sets.size(), 5u);
  const Json &recontacted = sets[1], &smoothed = sets[2], &raw = sets[3];
  EXPECT_EQ(sets[0].at("set"), "two_sided");
  EXPECT_EQ(sets[0].at("overlapping"), 0);
  EXPECT_EQ(sets[0].at("two_sided").at("both_in_contact"), sets[0].at("poses"));
  EXPECT_LE(sets[0].at("two_sided").at("largest_gap_medial_mm").get<double>(), margin_mm);
  EXPECT_EQ(recontacted.at("two_sided").at("poses"), 35);
  EXPECT_LT(recontacted.at("two_sided").at("both_in_contact").get<int>(), 35) << "varus from -10 to 10";
  EXPECT_EQ(recontacted.at("set"), "degree_2_recontacted");
  EXPECT_EQ(recontacted.at("poses"), 35);
  EXPECT_EQ(recontacted.at("overlapping"), 0);
  EXPECT_EQ(recontacted.at("nothing_ahead"), 0);
  EXPECT_TRUE(recontacted.at("largest_penetration").is_null());
  EXPECT_LE(recontacted.at("largest_gap").at("mm").get<double>(), margin_mm);
  EXPECT_EQ(smoothed.at("set"), "degree_2");
  EXPECT_GT(smoothed.at("overlapping"), 0);
  EXPECT_GT(smoothed.at("largest_penetration").at("mm").get<double>(), 0.01);
  EXPECT_EQ(raw.at("set"), "raw");
  EXPECT_EQ(raw.at("overlapping"), 0);
  EXPECT_EQ(sets[4].at("set"), "zero_varus");
  const Json info = test::json_of({"info", file_});
  EXPECT_EQ(info.at("remeasured").at("largest_gap_mm"), raw.at("largest_gap").at("mm"));
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_EQ(info.at("two_sided").at(sets[k].at("set").get<std::string>()), sets[k].at("two_sided"));

  const Json fine = test::json_of({"audit", file_, "--set", "degree_2_recontacted", "--refine", "3"});
  ASSERT_EQ(fine.size(), 1u);
  EXPECT_EQ(fine[0].at("attitudes"), 19 * 13);
  EXPECT_GT(fine[0].at("largest_gap").at("mm").get<double>(), margin_mm);
  const store::MotionModel model = store::read_motion_model(file_);
  ASSERT_EQ(model.audits.size(), 5u);  // the last of the two grids of that set
  EXPECT_EQ(model.audits[1].name, "degree_2_recontacted");
  EXPECT_EQ(model.audits[1].refine, 3);
  EXPECT_EQ(test::run_vrda({"validate", file_}).exit_code, 0);
}

TEST_F(DerivedCommands, AnalysesOverFlexionAreInInfoTheTableAndTheReport)
{
  const Json curve = test::json_of({"info", file_}).at("curves").at("contact_area_medial_mm2");
  EXPECT_EQ(curve.at("spine").size(), 7u);
  EXPECT_GT(curve.at("max").get<double>(), 0.0);
  EXPECT_THAT(test::run_vrda({"info", file_}).out, HasSubstr("Contact area, medial: "));
  succeed({"export", file_, "--to", "csv", "-o", path("motion.csv")});
  EXPECT_THAT(test::text_of(path("motion.csv")),
              HasSubstr(",contact_area_medial_mm2,contact_area_lateral_mm2"));
  succeed({"report", file_, "-o", path("page")});
  EXPECT_THAT(test::text_of(path("page") + "/index.html"), HasSubstr("{\"title\":\"Contact area\""));
}

TEST_F(DerivedCommands, TheVerdictIsInInfoAndTheReport)
{
  const Json info = test::json_of({"info", file_}), &verdict = info.at("verdict");
  const std::string sentence = verdict.at("sentence");
  EXPECT_THAT(sentence, HasSubstr("more than 30 degrees"));  // the grid ends there
  EXPECT_EQ(verdict.at("set"), info.at("default_motion").at("set"));
  EXPECT_THAT(test::run_vrda({"info", file_}).out, HasSubstr(sentence));
  succeed({"report", file_, "-o", path("verdict")});
  EXPECT_THAT(test::text_of(path("verdict") + "/index.html"), HasSubstr(sentence));
}

TEST_F(DerivedCommands, TheTableNamesSetsAndWhereTheirWorstIs)
{
  const test::Ended ended = test::run_vrda({"audit", file_});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, IsEmpty());
  EXPECT_EQ(test::n_lines(ended.out), 2 + 5 + 2 + 5);
  EXPECT_THAT(ended.out, test::reports("", {"degree_2_recontacted", "1", "35", "0"}));
  EXPECT_THAT(ended.out, test::reports("", "penetration"));
  EXPECT_THAT(ended.out, test::reports("", "0.145 mm"));
}

TEST_F(DerivedCommands, ASecondTimeLeavesTheSameBytesForAnyNumberOfThreads)
{
  const std::vector<std::vector<std::string>> commands{
      {"smooth", file_, "--degree", "3", "--recontact"},
      {"smooth", file_, "--degree", "3", "--recontact", "--robust"},
      {"smooth", file_, "--degree", "2"},
      {"audit", file_, "--refine", "2"},
  };
  for (std::vector<std::string> words : commands) {
    words.insert(words.end(), {"--threads", "1"});
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
    const std::string once = test::sha256_of_file(file_);
    words.back() = "5";
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
    EXPECT_EQ(test::sha256_of_file(file_), once) << words.front();
  }
}

TEST_F(DerivedCommands, SmoothReplacesItsDegreeAndDropsAuditsOfWhatChanged)
{
  test::json_of({"audit", file_});
  const Json same = test::json_of({"smooth", file_, "--degree", "2", "--recontact"});
  EXPECT_EQ(same.at("degree"), 2);
  EXPECT_EQ(same.at("surfaces").size(), 4u);
  EXPECT_EQ(same.at("surfaces").at("ty").at("cells"), 35);
  EXPECT_EQ(same.at("recontact").at("without_contact"), 0);
  EXPECT_EQ(store::read_motion_model(file_).audits.size(), 5u);

  EXPECT_TRUE(test::json_of({"smooth", file_, "--degree", "3"}).at("recontact").is_null());
  EXPECT_EQ(store::read_motion_model(file_).audits.size(), 5u);
  EXPECT_EQ(store::read_motion_model(file_).smoothed.size(), 2u);

  const test::Ended ended = test::run_vrda({"smooth", file_, "--degree", "2"});
  EXPECT_THAT(ended.err, test::reports("", "/audit/degree_2_recontacted"));
  EXPECT_THAT(ended.out, test::reports("", {"degree 2", "6 terms"}));
  const store::MotionModel model = store::read_motion_model(file_);
  EXPECT_FALSE(model.smoothed.front().recontact_mm.has_value());
  ASSERT_EQ(model.audits.size(), 4u);
  EXPECT_EQ(model.audits.front().name, "degree_2");
}

TEST(DegreesOf, ReadsRangesAndLists)
{
  EXPECT_THAT(app::parse_degrees("3"), ElementsAre(3));
  EXPECT_THAT(app::parse_degrees("1..4"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(app::parse_degrees("6,2,4,2"), ElementsAre(2, 4, 6));
  EXPECT_THAT(app::parse_degrees("0..1,20"), ElementsAre(0, 1, 20));
}

/// A small knee of 7 x 5 attitudes, solved.
class CompareCommand : public test::CommandTest {
 protected:
  test::Ended compare(const std::vector<std::string>& more) const
  {
    return succeed({"compare", file_}, more);
  }
  std::string file_ = solved_knee("right");
};

TEST_F(CompareCommand, PrintsARowADegreeAndTheRecommendation)
{
  const std::string before = test::sha256_of_file(file_);
  const test::Ended ended = compare({"--degrees", "1..3"});
  EXPECT_EQ(test::n_lines(ended.out), 2 + 3 + 1);
  EXPECT_THAT(ended.out, test::reports("", "penetration"));
  EXPECT_THAT(ended.out, AnyOf(test::reports("recommended", "degree"), test::reports("", "no degree")));
  EXPECT_THAT(ended.err, test::reports("", "degree_3"));
  EXPECT_EQ(test::sha256_of_file(file_), before) << "the file is unchanged";
  const test::Ended quiet = compare({"--degrees", "1..3", "--quiet", "--threads", "1"});
  EXPECT_THAT(quiet.err, IsEmpty());
  EXPECT_EQ(quiet.out, ended.out) << "for any number of threads";
}

TEST_F(CompareCommand, JsonHasEverything)
{
  const auto json = test::json_of({"compare", file_, "--degrees", "1,3", "--refine", "2"});
  EXPECT_EQ(json.at("perceptible").at("mm"), 0.145);
  EXPECT_EQ(json.at("perceptible").at("degree"), 0.27);
  EXPECT_EQ(json.at("degrees").size(), 2u);
  const auto& row = json.at("degrees").at(1);
  EXPECT_EQ(row.at("degree"), 3);
  EXPECT_EQ(row.at("terms"), 10);
  EXPECT_EQ(row.at("converged"), true);
  for (const std::string name : {"tx", "ty", "tz", "theta"}) {
    const auto& surface = row.at("surfaces").at(name);
    EXPECT_EQ(surface.at("cells"), 35);
    for (const std::string key :
         {"rms", "largest_residual", "leave_one_out_rms", "roughness", "condition_number"})
      EXPECT_TRUE(surface.at(key).is_number()) << name << ' ' << key;
  }
  EXPECT_EQ(row.at("surfaces").at("theta").at("unit"), "degree");
  EXPECT_EQ(row.at("at_grid").at("attitudes"), 35);
  EXPECT_EQ(row.at("between").at("attitudes"), 13 * 9 - 35);
  EXPECT_GT(row.at("at_grid").at("largest_penetration_mm").get<double>(), 0.0);
  EXPECT_TRUE(row.at("left_out").at("error").is_number());
  EXPECT_TRUE(row.at("second_difference").is_number());
  EXPECT_EQ(row.at("contact").at("two_sided").at("both_in_contact"), row.at("contact").at("poses"));
  EXPECT_LE(row.at("contact").at("largest_gap_mm").get<double>(), 1e-3);
  EXPECT_EQ(row.at("contact").at("largest_overlap_mm"), 0.0);
  const auto& recommendation = json.at("recommendation");
  EXPECT_GE(recommendation.at("left_out").at("flexions").get<int>(), 1);
  EXPECT_FALSE(recommendation.at("reason").get<std::string>().empty());
  const bool is_any_good = json.at("degrees").at(0).at("fault") == "none" || row.at("fault") == "none";
  EXPECT_EQ(recommendation.at("status") == "recommended", is_any_good);
  EXPECT_EQ(recommendation.at("degree").is_number(), is_any_good);
}

TEST_F(CompareCommand, SaysWhichDegreesTheCellsCannotCarry)
{
  const test::Ended ended = compare({"--refine", "0"});
  EXPECT_EQ(test::n_lines(ended.out), 2 + 4 + 1) << "five columns determine degree 4";
  EXPECT_THAT(ended.out, Not(test::reports("", "penetration")));
  EXPECT_THAT(ended.err, test::reports(file_, "5"));
}

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
    EXPECT_EQ(Json::parse(ended.out), test::json_of({command, made}));
  }
}

TEST_F(Reduce, TableAndJsonSayWhatTheFileHolds)
{
  const std::string file = solved_knee("right");
  const auto rows = fields_of(test::run_vrda({"reduce", file}).out);
  const Json all = test::json_of({"reduce", file});
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
    EXPECT_EQ(all.at("flexions")[i].at("internal_rotation_deg"), z.clinical[JointCoordinate::internal][i]);
    EXPECT_NEAR(std::stod(rows[i + 1][column("internal_rotation_deg")]),
                z.clinical[JointCoordinate::internal][i], printed);
    EXPECT_NEAR(std::stod(rows[i + 1][column("lateral_moving_z_mm")]), z.centres[1].moving_mm[3 * i + 2],
                printed);
  }
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(all.at("steps")[k].at("from_deg"), 2.0 * static_cast<double>(k));
    EXPECT_EQ(all.at("steps")[k].at("helical_direction")[2], z.helical_direction[3 * k + 2]);
    EXPECT_EQ(all.at("steps")[k].at("medial_rolling_mm"), z.rolling[0].rolling_mm[k]);
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
  model.is_in_contact[0].setZero();
  model.is_in_contact[1].setOnes();
  model.is_in_contact[0].topRightCorner(3, 1).setOnes();
  store::write_motion_model(file, model);
  EXPECT_THAT(test::run_vrda({"reduce", file}).err, test::warns(file, {"3", "7", "grid.varus"}));
  EXPECT_THAT(test::run_vrda({"info", file}).out, test::reports("", {"3", "7", "grid.varus"}));
  EXPECT_EQ(test::json_of({"info", file}).at("zero_varus_cut_off"), 3);
}

TEST_F(Reduce, PosesOfASmoothedSet)
{
  const std::string file = solved_knee("right");
  const store::ZeroVarus raw = *store::read_motion_model(file).zero_varus;
  const test::Ended ended = test::run_vrda({"reduce", file, "--set", "degree_2", "--json"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(Json::parse(ended.out).at("set"), "degree_2");
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
  audit.gap_mm = audit.compartment_gap_mm[0] = audit.compartment_gap_mm[1] = audit.penetration_mm =
      store::GridD::Zero(7, 1);
  model.audits.push_back(audit);
  store::write_motion_model(file, model);
  EXPECT_EQ(test::run_vrda({"reduce", file}).exit_code, 0);
  EXPECT_EQ(store::read_motion_model(file).audits.size(), 1u);
  EXPECT_EQ(test::run_vrda({"reduce", file, "--set", "degree_2"}).exit_code, 0);
  EXPECT_TRUE(store::read_motion_model(file).audits.empty());
}

}  // namespace vrda::derived_commands_test
