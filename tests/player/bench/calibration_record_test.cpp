#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "bench/calibration_file.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/input_error.hpp"

namespace vrda::calibration_record_test {

/// `named`: the first names.
bench::Estimate random_estimate(std::mt19937_64& random, const std::vector<std::string>& named,
                                Eigen::Index n_more)
{
  std::normal_distribution<double> any;
  bench::Estimate estimate;
  const auto n_named = static_cast<Eigen::Index>(named.size());
  const Eigen::Index n = n_named + n_more;
  estimate.values.resize(n);
  const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return any(random); });
  estimate.covariance = A * A.transpose();
  for (Eigen::Index k = 0; k < n; ++k) {
    estimate.names.push_back(k < n_named ? named[static_cast<std::size_t>(k)]
                                         : "number \"" + std::to_string(k) + "\"");
    estimate.units.push_back(k % 2 == 0 ? "" : "mm");
    estimate.values[k] = any(random);
    estimate.residuals.push_back(any(random));
  }
  estimate.dof = n % 2 == 0 ? std::numeric_limits<double>::infinity() : 12.5;
  if (n > 0) estimate.residual_unit = "px";
  estimate.residual_rms = 0.25;
  if (n > 2) estimate.remarks = {"a line", "another"};
  return estimate;
}

bench::CalibrationRecord random_record(std::mt19937_64& random, bench::CalibrationPart part)
{
  const int number = static_cast<int>(part);
  std::normal_distribution<double> any;
  bench::CalibrationRecord record;
  record.date = "2026-11-22";
  record.is_outdated = number % 3 == 1;
  for (int k = 0; k < number % 5; ++k) record.made_with.push_back(any(random));
  for (int mark = 0; mark < number % 4; ++mark) {
    bench::CalibrationMark& made = record.marks.emplace_back();
    made.task = "task " + std::to_string(mark);
    // Row 0 is empty, as for a look.
    for (int row = 0; row <= mark; ++row) {
      made.rows.emplace_back();
      for (int k = 0; k < row; ++k) made.rows.back().push_back(any(random));
    }
  }
  if (number % 2 == 0) record.estimate = random_estimate(random, bench::shared_estimate_names(part), number);
  return record;
}

void expect_equal(const bench::Estimate& a, const bench::Estimate& b)
{
  EXPECT_EQ(a.names, b.names);
  EXPECT_EQ(a.units, b.units);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.dof, b.dof);
  EXPECT_EQ(a.residuals, b.residuals);
  EXPECT_EQ(a.residual_unit, b.residual_unit);
  EXPECT_EQ(a.residual_rms, b.residual_rms);
  EXPECT_EQ(a.remarks, b.remarks);
}

void expect_equal(const bench::CalibrationRecord& a, const bench::CalibrationRecord& b)
{
  EXPECT_EQ(a.date, b.date);
  EXPECT_EQ(a.is_outdated, b.is_outdated);
  EXPECT_EQ(a.made_with, b.made_with);
  ASSERT_EQ(a.marks.size(), b.marks.size());
  for (std::size_t k = 0; k < a.marks.size(); ++k) {
    EXPECT_EQ(a.marks[k].task, b.marks[k].task);
    EXPECT_EQ(a.marks[k].rows, b.marks[k].rows);
  }
  ASSERT_EQ(a.estimate.has_value(), b.estimate.has_value());
  expect_equal(a.estimate.value_or(bench::Estimate{}), b.estimate.value_or(bench::Estimate{}));
}

TEST(CalibrationRecord, ReadsBackWhatWasWrittenToTheLastBit)
{
  std::mt19937_64 random(7);
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  bench::Calibration made = bench::nominal_calibration(bench);
  made.subject_scale = 1.0 / 3.0;
  for (std::size_t k = 0; k < bench::n_calibration_parts; ++k) {
    const auto part = static_cast<bench::CalibrationPart>(k);
    made.records[part] = random_record(random, part);
  }
  const std::string text = bench::calibration_text(made, bench);
  const bench::Calibration read = bench::parse_calibration(text, "c.toml", bench);
  EXPECT_EQ(read.subject_scale, made.subject_scale);
  ASSERT_EQ(read.records.size(), bench::n_calibration_parts);
  for (const auto& [part, record] : made.records) {
    SCOPED_TRACE(bench::name_of(part));
    expect_equal(read.records.at(part), record);
  }
  EXPECT_EQ(bench::calibration_text(read, bench), text);
}

TEST(CalibrationRecord, AFileWithoutRecordsStillReads)
{
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  std::string text = bench::calibration_text(bench::nominal_calibration(bench), bench);
  const std::size_t at = text.find("subject_scale");
  text.erase(at, text.find('\n', at) + 1 - at);
  const bench::Calibration read = bench::parse_calibration(text, "c.toml", bench);
  EXPECT_EQ(read.subject_scale, 1.0);
  EXPECT_TRUE(read.records.empty());
}

TEST(CalibrationRecord, PartsHaveNamesAndAFile)
{
  int n_bench = 0;
  for (std::size_t k = 0; k < bench::n_calibration_parts; ++k) {
    const auto part = static_cast<bench::CalibrationPart>(k);
    n_bench += bench::is_per_bench(part) ? 1 : 0;
  }
  EXPECT_EQ(n_bench, 5);
}

TEST(CalibrationRecord, WhatIsDamagedIsNamed)
{
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  const std::string whole = bench::calibration_text(bench::nominal_calibration(bench), bench);
  const std::string dated = "date = \"2026-11-22\"\n";
  const std::string place = "per_person.ipd", head = "[" + place + "]\n" + dated;
  const std::string result = head + "[" + place + ".result]\n";
  const std::string names = "names = [\"ipd\"]\nunits = [\"mm\"]\n", values = names + "values = [64]\n";
  const std::string mark = head + "[[" + place + ".mark]]\n", rest = "residuals = []\nresidual_rms = 0\n";
  const std::string covariance = values + "covariance = [[0.25]]\n";
  struct Row {
    std::string text, field, found;
  };
  for (const Row& row : {
           Row{"[per_bench.eyes]\n" + dated, "per_bench.eyes", "an unknown key"},
           Row{"[per_bench.ipd]\n" + dated, "per_bench.ipd", "an unknown key"},
           Row{"[per_person.rails]\n" + dated, "per_person.rails", "an unknown key"},
           Row{"[per_person]\nipd = 1\n", "per_person.ipd", "1"},
           Row{"[" + place + "]\n", place + ".date", "nothing"},
           Row{head + "marks = 1\n", place + ".marks", "an unknown key"},
           Row{mark, place + ".mark.0.task", "nothing"},
           Row{mark + "task = \"a\"\nrows = []\n[[" + place + ".mark]]\ntask = \"a\"\nrows = []\n",
               place + ".mark.1.task", "'a'"},
           Row{result + "names = [\"ipd\"]\nunits = []\nvalues = [64]\ndof = inf\n" + rest,
               place + ".result.units", "0 units"},
           Row{result + names + "values = [1, 2]\ndof = inf\n" + rest, place + ".result.values", "2 numbers"},
           Row{result + values + "dof = inf\n" + rest, place + ".result.covariance", "0 rows"},
           Row{result + values + "covariance = [[1], [2]]\ndof = inf\n" + rest, place + ".result.covariance",
               "2 rows"},
           Row{result + values + "covariance = [[1, 2]]\ndof = inf\n" + rest, place + ".result.covariance.0",
               "2 numbers"},
           Row{result + values + "covariance = [[-1]]\ndof = inf\n" + rest, place + ".result.covariance",
               "negative"},
           Row{result +
                   "names = [\"pd\"]\nunits = [\"mm\"]\nvalues = [64]\ncovariance = [[0.25]]\ndof = inf\n" +
                   rest,
               place + ".result.names", "no 'ipd'"},
       }) {
    SCOPED_TRACE(row.text);
    const InputError::Facts facts =
        test::input_error([&] { bench::parse_calibration(whole + row.text, "c.toml", bench); });
    EXPECT_EQ(facts.file, "c.toml");
    EXPECT_EQ(facts.field, row.field);
    EXPECT_THAT(facts.found, testing::HasSubstr(row.found));
  }
  const bench::Calibration read =
      bench::parse_calibration(whole + result + covariance + "dof = inf\n" + rest, "c.toml", bench);
  EXPECT_EQ(read.records.at(bench::CalibrationPart::ipd).estimate->values[0], 64.0);
}

}  // namespace vrda::calibration_record_test
