#include "cluster/index_processes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "store/motion_model_file.hpp"
#include "store/sample_derived.hpp"
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
  for (std::size_t k = 0; k < index_numbers().size(); ++k) {
    if (index_numbers()[k].name == name) return numbers.at(k);
  }
  ADD_FAILURE() << "no column " << name;
  return 0.0;
}

CampaignCase case_named(const std::string& name, std::vector<std::string> levels = {})
{
  return {{name, "/knee.toml", "", {}}, std::move(levels)};
}

MotionModel rich_model()
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  options.n_fibres = 3;
  return test::with_derived(test::sample_model(options));
}

TEST(IndexNumbers, OfAModelByItsSpine)
{
  // 4 x 3 cells, (1, 2) failed; theta is a fifth of flexion (0 to 3 degrees) at every cell.
  const MotionModel model = test::sample_model();
  const std::vector<double> n = index_numbers_of(model, 12345.0);
  EXPECT_EQ(index_curve_of(model), "spine");
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
  EXPECT_EQ(number_of(n, "internal_rotation_first_deg"), model.clinical.internal_rotation_deg(0, 1));
  EXPECT_EQ(number_of(n, "internal_rotation_last_deg"), model.clinical.internal_rotation_deg(3, 1));
  EXPECT_NEAR(number_of(n, "internal_rotation_range_deg"), 0.6, 1e-9);
  EXPECT_EQ(number_of(n, "smooth_degree"), 1.0);
  EXPECT_DOUBLE_EQ(number_of(n, "smooth_rms_mm"), 0.03 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(number_of(n, "smooth_rms_deg"), 0.03);
  EXPECT_DOUBLE_EQ(number_of(n, "smooth_leave_one_out_deg"), 0.04);
  EXPECT_EQ(number_of(n, "model_bytes"), 12345.0);
  // Not audited, no equilibrium, no fibres, a lateral compartment that never bears.
  for (const char* absent :
       {"raw_penetration_mm", "raw_gap_mm", "smooth_penetration_mm", "worst_gap_mm", "balance_residual_n",
        "several_optima", "medial_share", "largest_tension_n", "rollback_lateral_mm"}) {
    EXPECT_TRUE(std::isnan(number_of(n, absent))) << absent;
  }
}

TEST(IndexNumbers, OfAModelWithoutASolvedAttitudeAreNoAnswers)
{
  const MotionModel model = with_pending_cells(test::sample_model());
  const std::vector<double> n = index_numbers_of(model, 1.0);
  EXPECT_EQ(index_curve_of(model), "");
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
  MotionModel model = test::sample_model(options);
  model.varus_solved_deg.setConstant(0.4);
  const std::vector<double> n = index_numbers_of(model, 1.0);
  EXPECT_EQ(number_of(n, "varus_columns"), 1.0);
  EXPECT_TRUE(std::isnan(number_of(n, "varus_first_deg")));
}

TEST(IndexRow, SaysHowFarACaseIs)
{
  const test::Scratch scratch;
  const std::string output = scratch.path() / "a.h5";
  EXPECT_EQ(index_row(case_named("a"), output).status, CaseStatus::missing);
  EXPECT_EQ(index_row(case_named("a"), scratch.path() / "nowhere" / "a.h5").status, CaseStatus::missing);
  for (const char* left :
       {"a.h5.start.h5", "a.h5.journal", "a.h5.spine.journal", "a.h5.shard-2-of-3.journal"}) {
    const std::filesystem::path file = scratch.write(left, "");
    EXPECT_EQ(index_row(case_named("a"), output).status, CaseStatus::partial) << left;
    std::filesystem::remove(file);
  }
  write_motion_model(output, test::sample_model());
  const IndexRow row = index_row(case_named("a", {"x"}), output);
  EXPECT_EQ(row.status, CaseStatus::done);
  EXPECT_EQ(row.remark, "");
  EXPECT_THAT(row.levels, ElementsAre("x"));
  EXPECT_EQ(row.sha256.size(), 64U);
  EXPECT_EQ(number_of(row.numbers, "model_bytes"), static_cast<double>(std::filesystem::file_size(output)));
  EXPECT_FALSE(row.times);
  std::filesystem::resize_file(output, 1000);
  const IndexRow cut = index_row(case_named("a"), output);
  EXPECT_EQ(cut.status, CaseStatus::failed);
  EXPECT_THAT(cut.remark, HasSubstr("found "));
  EXPECT_THAT(cut.numbers, IsEmpty());
}

TEST(Index, EqualResultsGiveEqualBytesWhereverTheyAreAndWheneverTheyWereMade)
{
  const test::Scratch one, other;
  for (const test::Scratch* scratch : {&one, &other}) {
    const bool is_second = scratch == &other;
    std::filesystem::create_directory(scratch->path() / "a");
    const std::string output = scratch->path() / "a" / "a.h5";
    write_motion_model(output, rich_model());
    scratch->write("a/a.h5.run.json", std::string("{\"begun\": \"2020-01-01T00:00:00Z\", \"seconds\": ") +
                                          (is_second ? "2.5" : "7") +
                                          ", \"solving_processor_seconds\": 4.5, \"threads\": 2, "
                                          "\"steps_recalled\": 0, \"host\": \"n1\", \"processors\": 4}");
    write_index(scratch->path(), "Two", {"method"},
                {index_row(case_named("a", {"rest"}), output),
                 index_row(case_named("b", {"search"}), scratch->path() / "b" / "b.h5")});
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

TEST(IndexProcesses, ARowAsTextIsTheSameRow)
{
  const test::Scratch scratch;
  const std::string output = scratch.path() / "a.h5";
  write_motion_model(output, test::sample_model());
  IndexRow row = index_row(case_named("a", {"x", "y"}), output);
  row.remark = "two\nlines, \"quoted\"";
  row.times = CaseTimes{"2020-01-01T00:00:00Z", "n1", 0.1, 1e-7, 2, 4, 17};
  const IndexRow back = row_of_text(text_of_row(row));
  EXPECT_EQ(text_of_row(back), text_of_row(row));
  EXPECT_EQ(back.remark, row.remark);
  EXPECT_EQ(back.times->seconds, 0.1);
  EXPECT_EQ(back.times->n_recalled, 17);
  for (std::size_t k = 0; k < row.numbers.size(); ++k) {
    const bool is_same = back.numbers[k] == row.numbers[k];
    EXPECT_TRUE(std::isnan(row.numbers[k]) ? std::isnan(back.numbers[k]) : is_same) << k;
  }
}

TEST(IndexProcesses, RowsAreInOrderByAnyNumberOfThem)
{
  const auto row_of = [](std::size_t k) {
    IndexRow row;
    row.name = "case " + std::to_string(k);
    row.numbers = {1.0 / static_cast<double>(k + 1)};
    return row;
  };
  for (const int n_processes : {1, 2, 3, 50}) {
    const std::vector<IndexRow> rows = rows_by_processes(23, row_of, n_processes);
    ASSERT_EQ(rows.size(), 23U);
    for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_EQ(text_of_row(rows[k]), text_of_row(row_of(k)));
  }
  EXPECT_THAT(rows_by_processes(0, row_of, 4), IsEmpty());
}

TEST(IndexProcesses, OneThatFailsIsOurMistake)
{
  const auto row_of = [](std::size_t k) {
    check(k != 5, "the sixth row fails");
    return IndexRow{};
  };
  EXPECT_THROW(rows_by_processes(8, row_of, 2), InternalError);
  EXPECT_THROW(rows_by_processes(8, row_of, 1), InternalError);
}

// The page is what a reader of the table has.
TEST(Index, ThePageDescribesEveryColumn)
{
  const std::string page = test::read_bytes(VRDA_CAMPAIGN_PAGE);
  for (const IndexNumber& number : index_numbers())
    EXPECT_THAT(page, HasSubstr(std::string("| `") + number.name + "` | " + number.units + " |"));
  for (const char* text :
       {"case", "status", "remark", "title", "joint", "side", "solver", "curve", "sha256", "file"})
    EXPECT_THAT(page, HasSubstr(std::string("| `") + text + "` |"));
}

}  // namespace vrda::index_test
