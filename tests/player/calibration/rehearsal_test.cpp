#include "calibration/rehearsal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calibration/parts.hpp"
#include "calibration/truth.hpp"

namespace vrda::calibration::rehearsal_test {

constexpr std::uint64_t seed = 3;

/// The numbers of "name: dial 12.25 px, dial -3 px".
std::vector<double> numbers_in(const std::string& words, const Task& task)
{
  std::vector<double> values;
  std::size_t from = 0;
  for (const Dial& dial : task.dials) {
    const std::size_t at = words.find(dial.name + " ", from);
    if (at == std::string::npos) return {};
    values.push_back(std::stod(words.substr(at + dial.name.size())));
    from = at + dial.name.size();
  }
  return values;
}

/// A person who turns the dials by keys to what the rehearsal prints.
void set_dials(CalibrationSession& session, const std::vector<double>& wanted)
{
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const Dial dial = session.task()->dials[k];
    // A number that is right as it is must be touched.
    session.take(view::KeyPress{k == 0 ? view::Key::right : view::Key::up});
    session.take(view::KeyPress{k == 0 ? view::Key::left : view::Key::down});
    const bool is_cross = session.task()->kind->traits().is_cross;
    for (long n = std::lround((wanted[k] - session.values()[k]) / dial.step); n != 0;) {
      const long size = std::abs(n) >= 100 ? 100 : std::abs(n) >= 10 ? 10 : 1;
      const bool is_more = n > 0;
      const view::Key key = k == 0                ? (is_more ? view::Key::right : view::Key::left)
                            : is_more != is_cross ? view::Key::up
                                                  : view::Key::down;
      session.take(view::KeyPress{key, size == 10, size == 100});
      n -= is_more ? size : -size;
    }
  }
}

/// The whole procedure with the messages that `simulate --rehearse` sends, as devices would receive them.
TEST(Rehearsal, EveryTaskCanBeDoneWithWhatItSendsAndPrints)
{
  for (const HeadKind head : {HeadKind::stage, HeadKind::tracker}) {
    const BenchFile bench = bench::parse_bench_file(virtual_bench_text(head), "bench.toml");
    const std::vector<CalibrationPart> parts = parts_of_step("all", bench);
    Rehearsal rehearsal(bench, parts, seed);
    CalibrationSession session(bench, bench::nominal_calibration(bench), {parts, false, "", "c.toml"});
    double now_s = 0.0;
    std::uint64_t tick = 0;
    bool is_zeroed = false;
    const auto send = [&] {
      now_s += 0.01;
      bench::Sample sample;
      sample.arrival_ns = sample.device_ns = static_cast<std::int64_t>(1e9 * now_s);
      if (has_stage(bench)) {
        sample.kind = bench::SampleKind::stage;
        sample.count = rehearsal.stage_count(now_s);
        sample.state = is_zeroed ? bench::stage_zeroed : 0;
        session.take(sample);
      }
      const bench::IgtlMessage message = rehearsal.message(tick++, now_s);
      sample.kind = bench::SampleKind::tool_pose;
      for (std::size_t k = 0; k < bench.tracker->tools.size(); ++k) {
        const auto tool = std::ranges::find(message.tools, bench.tracker->tools[k], &bench::IgtlTool::name);
        sample.source = static_cast<std::uint16_t>(k);
        sample.state = static_cast<std::uint8_t>(tool == message.tools.end() ? bench::ToolVisibility::missing
                                                                             : bench::ToolVisibility::seen);
        if (tool != message.tools.end()) sample.tool_pose = bench::place_of(tool->X_tracker_tool);
        session.take(sample);
      }
    };
    int n_tasks = 0;
    while (session.task() != nullptr) {
      ASSERT_LT(++n_tasks, 1000);
      const Task task = *session.task();
      SCOPED_TRACE(task.name);
      const std::string said = rehearsal.follow(session.calibration(), now_s);
      if (n_tasks > 1) {
        EXPECT_NE(said.find(task.name), std::string::npos) << said;
        set_dials(session, numbers_in(said, task));
      } else {
        set_dials(session, {static_cast<double>(std::lround(virtual_truth(bench, seed).edges_px[0].left))});
      }
      if (task.name.ends_with("rail"))
        while (rehearsal.prompt(now_s).empty()) send();
      for (int k = 0; k < 3; ++k) send();
      session.take(view::KeyPress{view::Key::enter});
      for (int k = 0; k < 2000 && session.progress().is_sampling; ++k) send();
      ASSERT_FALSE(session.progress().has_error) << session.progress().messages.front();
      if (session.take_zero_request()) is_zeroed = true;
    }
    EXPECT_EQ(rehearsal.follow(session.calibration(), now_s), "all parts are done");
    // The display's errors are those of the aligned lines: the eyes are found as by the simulated operator.
    const VirtualTruth truth = virtual_truth(bench, seed);
    EXPECT_NEAR(session.calibration().eyes.left.distance_px, truth.calibration.eyes.left.distance_px, 15.0);
    EXPECT_NEAR(session.calibration().subject_scale, truth.calibration.subject_scale, 0.03);
  }
}

}  // namespace vrda::calibration::rehearsal_test
