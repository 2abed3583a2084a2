#include <gtest/gtest.h>

#include "guide/parts.hpp"
#include "guide/session.hpp"
#include "guide/solve_part.hpp"
#include "support/input_error.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda {
namespace {

BenchFile virtual_bench(HeadKind head, const std::string& changed = "", const std::string& into = "")
{
  std::string text = virtual_bench_text(head);
  const std::size_t at = changed.empty() ? std::string::npos : text.find(changed);
  EXPECT_EQ(at == std::string::npos, changed.empty()) << changed;
  if (at != std::string::npos) text.replace(at, changed.size(), into);
  return parsed_bench_file(text, "bench.toml");
}

GuideOptions all_of(const BenchFile& bench)
{
  GuideOptions options;
  options.parts = parts_of_step("all", bench);
  options.date = "2026-11-22";
  options.path = "c.toml";
  return options;
}

/// Every part from its first task to its last.
class WholeProcedure : public testing::TestWithParam<HeadKind> {
 protected:
  const BenchFile bench = virtual_bench(GetParam());
  const VirtualTruth truth = virtual_truth(bench, 1);
  VirtualOperator somebody{bench, truth, VirtualNoise()};

  Calibration done()
  {
    GuideSession session(bench, nominal_calibration(bench), all_of(bench));
    while (session.task() != nullptr) somebody.do_task(session);
    return session.calibration();
  }
};

TEST_P(WholeProcedure, EveryPartIsDoneAndTheFileReads)
{
  const Calibration found = done();
  for (const CalibrationPart part : parts_of(bench)) {
    SCOPED_TRACE(name_of(part));
    ASSERT_TRUE(is_done(found, part));
  }
  const std::string text = calibration_text(found, bench);
  EXPECT_EQ(calibration_text(parsed_calibration(text, "c.toml", bench), bench), text);
}

INSTANTIATE_TEST_SUITE_P(Heads, WholeProcedure, testing::Values(HeadKind::stage, HeadKind::tracker),
                         [](const auto& head) {
                           return head.param == HeadKind::stage ? "OnAStage" : "Tracked";
                         });

}  // namespace
}  // namespace vrda
