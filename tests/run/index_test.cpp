#include "run/index.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::index_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

double number_of(const std::vector<double>& numbers, const std::string& name)
{
  for (std::size_t k = 0; k < run::index_numbers().size(); ++k) {
    if (run::index_numbers()[k].name == name) return numbers.at(k);
  }
  ADD_FAILURE() << "no column " << name;
  return 0.0;
}

run::IndexRow index_row(const std::string& name, const std::string& model_path,
                        const std::vector<std::string>& levels = {})
{
  return run::index_rows({{name, levels, model_path}}, 1).front();
}

store::MotionModel rich_model()
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  options.n_fibres = 3;
  return test::with_derived(test::sample_model(options));
}

TEST(IndexNumbers, OfAModelByItsSpine)
{
  // 4 x 3 cells, (1, 2) failed; theta is a fifth of flexion (0 to 3 degrees) at every cell.
  const store::MotionModel model = test::sample_model();
  const std::vector<double> n = run::index_numbers_of(model, 12345.0);
  EXPECT_EQ(run::index_curve_of(model), "spine");
  EXPECT_EQ(number_of(n, "flexions"), 4.0);
  EXPECT_EQ(number_of(n, "varus_columns"), 3.0);
  EXPECT_EQ(number_of(n, "flexion_last_deg"), 3.0);
  EXPECT_EQ(number_of(n, "varus_first_deg"), model.varus_deg.front());
  EXPECT_EQ(number_of(n, "attitudes"), 12.0);
  EXPECT_EQ(number_of(n, "solved"), 11.0);
  EXPECT_DOUBLE_EQ(number_of(n, "unsolved_fraction"), 1.0 / 12.0);
  EXPECT_EQ(number_of(n, "theta_determined_fraction"), 1.0);
  EXPECT_EQ(number_of(n, "triangles_reference"),
            static_cast<double>(model.reference.contact.mesh.triangles.rows()));
  EXPECT_EQ(number_of(n, "fibres"), 0.0);
  EXPECT_NEAR(number_of(n, "reference_width_mm"), 40.0, 1e-9);  // a ball of radius 20
  EXPECT_EQ(number_of(n, "internal_rotation_first_deg"), model.clinical[JointCoordinate::internal](0, 1));
  EXPECT_EQ(number_of(n, "internal_rotation_last_deg"), model.clinical[JointCoordinate::internal](3, 1));
  EXPECT_NEAR(number_of(n, "internal_rotation_range_deg"), 0.6, 1e-9);
  EXPECT_EQ(number_of(n, "smooth_degree"), 1.0);
  EXPECT_DOUBLE_EQ(number_of(n, "smooth_rms_mm"), 0.03 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(number_of(n, "smooth_rms_deg"), 0.03);
  EXPECT_DOUBLE_EQ(number_of(n, "smooth_leave_one_out_deg"), 0.04);
  EXPECT_EQ(number_of(n, "model_bytes"), 12345.0);
  // Not audited, no equilibrium, no fibres, a lateral compartment that is never in contact.
  for (const char* absent :
       {"raw_penetration_mm", "raw_gap_mm", "smooth_penetration_mm", "worst_gap_mm", "balance_residual_n",
        "several_optima", "medial_share", "largest_tension_n", "rollback_lateral_mm"}) {
    EXPECT_TRUE(std::isnan(number_of(n, absent))) << absent;
  }
}

TEST(IndexNumbers, TheSmoothedSetKeepsItsAuditBesideATwoSidedMotion)
{
  store::MotionModel model = test::with_derived(test::sample_model());
  model.two_sided.emplace();
  double penetration_mm = 0.0;
  for (const store::AuditSet& audit : model.audits)
    if (audit.name == "degree_1_recontacted")
      penetration_mm = store::summary_of(audit).largest_penetration_mm;
  EXPECT_GT(penetration_mm, 0.0);
  EXPECT_EQ(number_of(run::index_numbers_of(model, 1.0), "smooth_penetration_mm"), penetration_mm);
}

TEST(IndexNumbers, OfAModelWithoutASolvedAttitudeAreNoAnswers)
{
  const store::MotionModel model = store::with_pending_cells(test::sample_model());
  const std::vector<double> n = run::index_numbers_of(model, 1.0);
  EXPECT_EQ(run::index_curve_of(model), "");
  EXPECT_EQ(number_of(n, "solved"), 0.0);
  EXPECT_EQ(number_of(n, "unsolved_fraction"), 1.0);
  for (const char* absent :
       {"theta_determined_fraction", "internal_rotation_first_deg", "internal_rotation_range_deg",
        "varus_mean_deg", "smooth_degree", "smooth_rms_mm"}) {
    EXPECT_TRUE(std::isnan(number_of(n, absent))) << absent;
  }
}

TEST(IndexNumbers, VarusLeftFreeHasNoAxisOfVarus)
{
  test::SampleOptions options;
  options.n_varus = 1;
  options.has_failed_cell = false;
  store::MotionModel model = test::sample_model(options);
  model.varus_solved_deg.setConstant(0.4);
  const std::vector<double> n = run::index_numbers_of(model, 1.0);
  EXPECT_EQ(number_of(n, "varus_columns"), 1.0);
  EXPECT_TRUE(std::isnan(number_of(n, "varus_first_deg")));
}

TEST(IndexRow, SaysHowFarACaseIs)
{
  const test::Scratch scratch;
  const std::string output = scratch.path() / "a.h5";
  EXPECT_EQ(index_row("a", output).status, run::CaseStatus::missing);
  EXPECT_EQ(index_row("a", scratch.path() / "nowhere" / "a.h5").status, run::CaseStatus::missing);
  for (const char* left :
       {"a.h5.start.h5", "a.h5.journal", "a.h5.spine.journal", "a.h5.shard-2-of-3.journal"}) {
    const std::filesystem::path file = scratch.write(left, "");
    EXPECT_EQ(index_row("a", output).status, run::CaseStatus::partial) << left;
    std::filesystem::remove(file);
  }
  store::write_motion_model(output, test::sample_model());
  const run::IndexRow row = index_row("a", output, {"x"});
  EXPECT_EQ(row.status, run::CaseStatus::done);
  EXPECT_EQ(row.remark, "");
  EXPECT_THAT(row.levels, ElementsAre("x"));
  EXPECT_EQ(row.sha256.size(), 64U);
  EXPECT_EQ(number_of(row.numbers, "model_bytes"), static_cast<double>(std::filesystem::file_size(output)));
  EXPECT_EQ(row.times.begun, "");
  std::filesystem::resize_file(output, 1000);
  const run::IndexRow cut = index_row("a", output);
  EXPECT_EQ(cut.status, run::CaseStatus::failed);
  EXPECT_THAT(cut.remark, HasSubstr("found "));
  EXPECT_THAT(cut.numbers, IsEmpty());
}

TEST(Index, ATableThatCannotBeReplacedLeavesTheOldIndex)
{
  const test::Scratch scratch;
  scratch.write("index.h5", "\x89HDF\r\n\x1a\n old");
  std::filesystem::create_directory(scratch.path() / "index.times.csv");
  std::optional<Publication> publication = Publication::begin(run::index_file_of(scratch.path()), "the test");
  const auto publish = [&] {
    run::publish_index(*publication, scratch.path(), "One", {}, {index_row("b", scratch.path() / "b.h5")});
  };
  EXPECT_EQ(test::input_error(publish).found, "a folder");
  EXPECT_EQ(test::read_bytes(scratch.path() / "index.h5"), "\x89HDF\r\n\x1a\n old");
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "index.csv"));
}

TEST(Index, EqualResultsGiveEqualBytesWhereverTheyAreAndWheneverTheyWereMade)
{
  const test::Scratch one, other;
  for (const test::Scratch* scratch : {&one, &other}) {
    const bool is_second = scratch == &other;
    std::filesystem::create_directory(scratch->path() / "a");
    const std::string output = scratch->path() / "a" / "a.h5";
    store::write_motion_model(output, rich_model());
    scratch->write("a/a.h5.run.json", std::string("{\"begun\": \"2020-01-01T00:00:00Z\", \"seconds\": ") +
                                          (is_second ? "2.5" : "7") +
                                          ", \"solving_processor_seconds\": 4.5, \"threads\": 2, "
                                          "\"steps_recalled\": 0, \"host\": \"n1\", \"processors\": 4}");
    std::optional<Publication> publication =
        Publication::begin(run::index_file_of(scratch->path()), "the test");
    run::publish_index(
        *publication, scratch->path(), "Two", {"method"},
        {index_row("a", output, {"rest"}), index_row("b", scratch->path() / "b" / "b.h5", {"search"})});
  }
  for (const char* name : {"index.csv", "index.h5"})
    EXPECT_EQ(test::read_bytes(one.path() / name), test::read_bytes(other.path() / name)) << name;
  EXPECT_EQ(test::read_bytes(other.path() / "index.times.csv"),
            "case,begun,host,seconds,solving_processor_seconds,threads,processors,steps_recalled\n"
            "a,2020-01-01T00:00:00Z,n1,2.5,4.5,2,4,0\n"
            "b,,,,,,,\n");
  const std::string csv = test::read_bytes(one.path() / "index.csv");
  EXPECT_THAT(csv, StartsWith("case,method,status,remark,title,joint,side,solver,curve,flexions,"));
  EXPECT_THAT(csv, HasSubstr("\na,rest,done,,"));
  EXPECT_THAT(csv, HasSubstr("\nb,search,missing,,,,,,,,"));
  EXPECT_THAT(csv, HasSubstr(",a/a.h5\n"));
}

TEST(IndexRows, AreInOrderHoweverManyModelsAreReadAtOnce)
{
  const test::Scratch scratch;
  std::vector<run::IndexedCase> cases;
  for (const std::string name : {"a", "b", "c", "d", "e"})
    cases.push_back({name, {}, (scratch.path() / (name + ".h5")).string()});
  for (const std::size_t k : {0U, 1U, 3U}) {
    test::SampleOptions options;
    options.n_varus = static_cast<int>(3 + k);
    store::write_motion_model(cases[k].model_path, test::sample_model(options));
  }
  scratch.write("e.h5", "no model");
  for (const int n_processes : {0, 1, 2, 50}) {
    const std::vector<run::IndexRow> rows = run::index_rows(cases, n_processes);
    ASSERT_EQ(rows.size(), 5U);
    for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_EQ(rows[k].name, cases[k].name);
    for (const std::size_t k : {0U, 1U, 3U}) {
      EXPECT_EQ(rows[k].status, run::CaseStatus::done);
      EXPECT_EQ(number_of(rows[k].numbers, "varus_columns"), static_cast<double>(3 + k));
    }
    EXPECT_EQ(rows[2].status, run::CaseStatus::missing);
    EXPECT_EQ(rows[4].status, run::CaseStatus::failed);
  }
  EXPECT_THAT(run::index_rows({}, 4), IsEmpty());
}

// schemas/campaign.md must describe every column.
TEST(Index, ThePageDescribesEveryColumn)
{
  const std::string page = test::read_bytes(VRDA_CAMPAIGN_PAGE);
  for (const run::IndexNumber& number : run::index_numbers())
    EXPECT_THAT(page, HasSubstr(std::string("| `") + number.name + "` | " + number.units + " |"));
  for (const char* text :
       {"case", "status", "remark", "title", "joint", "side", "solver", "curve", "sha256", "file"})
    EXPECT_THAT(page, HasSubstr(std::string("| `") + text + "` |"));
}

}  // namespace vrda::index_test
