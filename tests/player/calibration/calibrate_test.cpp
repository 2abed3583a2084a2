// The command `calibrate` on virtual benches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <sstream>

#include "calibration/calibration_mode.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "store/motion_model.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"

namespace vrda::calibration::calibrate_test {

using testing::HasSubstr;

struct Said {
  CalibrateEnd end = CalibrateEnd::quit;
  std::string data, messages;
};

Said calibrated(const CalibrateOptions& options)
{
  std::ostringstream data, messages;
  const CalibrateEnd end = calibrate(options, {data, messages});
  return {end, data.str(), messages.str()};
}

InputError::Facts refusal(const CalibrateOptions& options)
{
  std::ostringstream data, messages;
  return test::input_error([&] { calibrate(options, {data, messages}); });
}

class Calibrate : public testing::Test {
 protected:
  CalibrateOptions options(const std::string& step, const std::string& file = "calibration.toml") const
  {
    CalibrateOptions made;
    made.step = step;
    made.is_virtual = made.is_headless = true;
    made.calibration = in_scratch(file);
    return made;
  }
  std::string in_scratch(const std::string& name) const { return (scratch_.path() / name).string(); }
  std::string written(const std::string& name, const std::string& text) const
  {
    return scratch_.write(name, text).string();
  }

  test::Scratch scratch_;
};

TEST(KeyScript, ALineAtATime)
{
  KeyScript script(
      calibration::parse_key_script("# a trial\npress Shift+Left 3\nwait 0.5\n\npress H # help\n", "s.txt"));
  const std::vector<view::KeyPress> first = script.keys(0.0);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[2].key, view::Key::left);
  EXPECT_TRUE(first[2].has_shift);
  EXPECT_FALSE(first[2].has_control);
  for (const double now_s : {0.1, 0.4, 0.59, 0.6}) EXPECT_TRUE(script.keys(now_s).empty()) << now_s;
  EXPECT_FALSE(script.is_over());
  ASSERT_EQ(script.keys(0.7).size(), 1u);
  EXPECT_TRUE(script.is_over());
  EXPECT_TRUE(script.keys(0.8).empty());
  for (const std::string line :
       {"push Enter", "press", "press Entre", "press Right 0", "press Right 1.5", "press Alt+Left", "wait",
        "wait -1", "wait 1 2", "press Shift+Shift+Left", "press Right 20000", "press left"}) {
    EXPECT_THAT(test::input_error([&] { calibration::parse_key_script("press Enter\n\n" + line, "s.txt"); }),
                test::refuses({.file = "s.txt", .field = "line 3"}))
        << line;
  }
}

TEST(CalibrationReport, QuantilesAreByRank)
{
  std::vector<TargetError> errors;
  for (int k = 20; k > 0; --k) errors.push_back({0.1 * k, 1.0 * k});
  const TargetSummary summary = summary_of(errors);
  EXPECT_DOUBLE_EQ(summary.mm.median, 1.0);
  EXPECT_DOUBLE_EQ(summary.mm.p90, 1.8);
  EXPECT_DOUBLE_EQ(summary.mm.largest, 2.0);
  EXPECT_DOUBLE_EQ(summary.arc_min.median, 10.0);
  EXPECT_EQ(summary_of(std::span<const TargetError>()).mm.median, 0.0);
}

TEST_F(Calibrate, ManyBenchesAreCounted)
{
  CalibrateOptions many = options("all");
  many.calibration.clear();
  many.has_json = true;
  many.n_benches = 2;
  const nlohmann::json reported = nlohmann::json::parse(calibrated(many).data);
  EXPECT_EQ(reported["benches"], 2);
  EXPECT_EQ(reported["targets"]["n"], 80);
  EXPECT_EQ(reported["numbers"][0]["n"], 2);
}

/// A script shows each task once.
TEST_F(Calibrate, AScriptShowsItsTasks)
{
  CalibrateOptions viewport = options("viewport");
  viewport.script = written("script.txt", "press Right 20\npress Enter\nwait 0.1\n");
  viewport.pictures = in_scratch("tasks");
  const Said said = calibrated(viewport);
  EXPECT_EQ(said.end, CalibrateEnd::quit);
  for (const char* name : {"task_0001.png", "task_0002.png"}) EXPECT_THAT(said.data, HasSubstr(name));
  EXPECT_EQ(view::read_png_texture(viewport.pictures + "/task_0001.png").width, 1280);
}

TEST_F(Calibrate, TheErrorAfterCalibrationIsReportedOnceAllPartsAreDone)
{
  const Said text = calibrated(options("viewport"));
  EXPECT_THAT(text.data, HasSubstr("  before  median "));
  EXPECT_THAT(text.data, HasSubstr(": distortion, rails, stop, probe, "));
  EXPECT_THAT(text.data, testing::Not(HasSubstr("after   median")));
  CalibrateOptions bench = options("bench");
  bench.has_json = true;
  const nlohmann::json some = nlohmann::json::parse(calibrated(bench).data)["targets"];
  EXPECT_EQ(some["n"], 40);
  EXPECT_TRUE(some["before"].is_object());
  EXPECT_TRUE(some["after"].is_null());
  EXPECT_EQ(some["to_be_done"], nlohmann::json({"eyepoints", "ipd", "subject", "bullseye", "leg"}));
  bench.step = "person";
  const nlohmann::json all = nlohmann::json::parse(calibrated(bench).data)["targets"];
  EXPECT_TRUE(all["after"].is_object());
  EXPECT_TRUE(all["to_be_done"].empty());
  const double before_mm = all["before"]["mm"]["median"], after_mm = all["after"]["mm"]["median"];
  EXPECT_GT(before_mm, 2.0);
  EXPECT_LT(after_mm, 2.0);
}

TEST_F(Calibrate, TheSimulatedOperatorDoesAllParts)
{
  const Said all = calibrated(options("all"));
  EXPECT_EQ(all.end, CalibrateEnd::finished);
  EXPECT_THAT(all.data, HasSubstr("leg.shift_x"));
  EXPECT_THAT(all.data, HasSubstr("  after   median "));
  EXPECT_THAT(all.data, testing::Not(HasSubstr("to be done")));

  CalibrateOptions status = options("status");
  status.has_json = true;
  const nlohmann::json reported = nlohmann::json::parse(calibrated(status).data);
  EXPECT_EQ(reported["bench"], "Virtual, seed 1");
  EXPECT_TRUE(reported["to_be_done"].empty());
  EXPECT_EQ(reported["parts"][0]["name"], "viewport");
  EXPECT_EQ(reported["parts"][0]["state"], "done");
  EXPECT_EQ(reported["parts"][0]["once"], "bench");
  EXPECT_EQ(reported["parts"][0]["date"], "2000-01-01");
  EXPECT_EQ(reported["parts"][0]["numbers"][0]["name"], "left.edge_left");
  EXPECT_GT(reported["parts"][0]["numbers"][0]["half_width_95"], 0.0);

  // Solving again from the marks gives identical numbers.
  const std::string before = test::read_bytes(options("all").calibration);
  EXPECT_EQ(calibrated(options("solve")).end, CalibrateEnd::finished);
  EXPECT_EQ(test::read_bytes(options("all").calibration), before);
}

TEST_F(Calibrate, LeftAndTakenUpAgainItIsTheSame)
{
  // The simulated operator finishes a part; a script may end within one.
  CalibrateOptions whole = options("viewport", "whole.toml"), pieces = options("viewport", "pieces.toml");
  const std::string first = "press Right 20\npress Enter\npress Left 15\npress Enter\n";
  const std::string second = "press Right 21\npress Enter\nwait 0.1\npress Left 16\npress Enter\n";
  whole.script = written("whole.txt", first + second);
  EXPECT_EQ(calibrated(whole).end, CalibrateEnd::quit);
  pieces.script = written("first.txt", first);
  EXPECT_EQ(calibrated(pieces).end, CalibrateEnd::quit);
  EXPECT_NE(test::read_bytes(pieces.calibration), test::read_bytes(whole.calibration));
  pieces.script = written("second.txt", second);
  const Said again = calibrated(pieces);
  EXPECT_EQ(again.end, CalibrateEnd::quit);
  EXPECT_THAT(again.data, HasSubstr("begun: 4 marks so far"));
  EXPECT_THAT(again.data, HasSubstr("to be done: viewport"));
  EXPECT_EQ(test::read_bytes(pieces.calibration), test::read_bytes(whole.calibration));
}

/// Part of a text from one word to the next occurrence of another one.
std::string between(const std::string& text, const std::string& from, const std::string& to)
{
  const std::size_t begin = text.find(from), end = text.find(to, begin);
  return text.substr(begin, end - begin);
}

TEST_F(Calibrate, TheNextPersonBeginsWithTheBenchAndNothingOfThePersonBefore)
{
  CalibrateOptions anna = options("bench", "anna.toml"), bob = options("person", "bob.toml");
  bob.bench_from = anna.calibration;
  EXPECT_EQ(refusal(bob).file, anna.calibration);  // does not exist yet
  EXPECT_EQ(calibrated(anna).end, CalibrateEnd::finished);
  const std::string bench_alone = test::read_bytes(anna.calibration);
  EXPECT_THAT(bench_alone, testing::Not(HasSubstr("[per_person")));
  anna.step = "person";
  EXPECT_EQ(calibrated(anna).end, CalibrateEnd::finished);

  // One task of the first part per person, by a script.
  bob.script = written("script.txt", "press Left 4\npress Down 4\npress Enter\nwait 0.1\n");
  EXPECT_EQ(calibrated(bob).end, CalibrateEnd::quit);
  const std::string annas = test::read_bytes(anna.calibration), bobs = test::read_bytes(bob.calibration);
  EXPECT_EQ(between(bobs, "[per_bench", "[per_person"), between(annas, "[per_bench", "[per_person"));
  EXPECT_THAT(bobs, HasSubstr("[[per_person.eyepoints.mark]]"));
  for (const char* part : {"ipd", "subject", "bullseye", "leg"})
    EXPECT_THAT(bobs, testing::Not(HasSubstr(std::string("[per_person.") + part)));
  EXPECT_THAT(bobs, HasSubstr("subject_scale = 1.0"));
  EXPECT_THAT(annas, testing::Not(HasSubstr("subject_scale = 1.0 ")));
  for (const std::string& table : {std::string("[eyes]"), std::string("[leg]")})
    EXPECT_NE(between(bobs, table, "\n\n"), between(annas, table, "\n\n"));
  // As after the per-bench parts only: without the refinement by her bull's-eyes.
  for (const std::string& table : {std::string("[left]"), std::string("[right]"), std::string("[table]")})
    EXPECT_EQ(between(bobs, table, "\n\n"), between(bench_alone, table, "\n\n"));

  // The same command resumes, also without --bench-from.
  bob.script.clear();
  EXPECT_EQ(calibrated(bob).end, CalibrateEnd::finished);
  bob.bench_from.clear();
  EXPECT_EQ(calibrated(bob).end, CalibrateEnd::finished);
  // Her per-bench parts now differ: an edge was measured again.
  anna.step = "viewport";
  anna.is_repeated = true;
  anna.script = written("restart.txt", "press Right 20\npress Enter\nwait 0.1\n");
  EXPECT_EQ(calibrated(anna).end, CalibrateEnd::quit);
  bob.bench_from = anna.calibration;
  EXPECT_EQ(refusal(bob).file, bob.calibration);
  EXPECT_EQ(refusal(bob).field, "per_bench");
}

TEST_F(Calibrate, TheStartOfTheNextPersonMustBeComplete)
{
  CalibrateOptions anna = options("viewport", "anna.toml"), bob = options("person", "bob.toml");
  EXPECT_EQ(calibrated(anna).end, CalibrateEnd::finished);
  bob.bench_from = anna.calibration;
  EXPECT_THAT(refusal(bob), test::refuses({anna.calibration, "per_bench.distortion", "nothing"}));
  EXPECT_FALSE(std::filesystem::exists(in_scratch("bob.toml")));
}

TEST_F(Calibrate, WithoutAScreenTheSimulatedOperatorDoesARunThatIsNotStored)
{
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  CalibrateOptions shown = options("viewport");
  shown.is_headless = false;
  EXPECT_THAT(refusal(shown), test::refuses({.field = "display", .wanted = "--headless"}));
  shown.calibration.clear();
  const Said said = calibrated(shown);
  EXPECT_EQ(said.end, CalibrateEnd::finished);
  EXPECT_THAT(said.data, HasSubstr("viewport    done"));
  EXPECT_THAT(said.messages, HasSubstr("no screen"));
}

TEST_F(Calibrate, TheCalibrationOfAnotherBenchIsRefused)
{
  CalibrateOptions first = options("bench");
  EXPECT_EQ(calibrated(first).end, CalibrateEnd::finished);
  CalibrateOptions second = first, person = options("person", "bob.toml");
  second.seed = person.seed = 2;
  person.bench_from = first.calibration;
  for (const CalibrateOptions& other : {second, person}) {
    SCOPED_TRACE(other.step);
    EXPECT_THAT(refusal(other),
                test::refuses({first.calibration, "bench", "'Virtual, seed 1'", "'Virtual, seed 2'"}));
  }
  EXPECT_FALSE(std::filesystem::exists(person.calibration));
  // A calibration of a virtual bench is not valid for a real one, or for a display of another size.
  CalibrateOptions real = options("viewport", "real.toml");
  std::string text = virtual_bench_text();
  real.bench = written("bench.toml", text);
  EXPECT_EQ(calibrated(real).end, CalibrateEnd::finished);
  CalibrateOptions wide = real;
  const std::string size = "width = 1280";
  wide.bench = written("wide.toml", text.replace(text.find(size), size.size(), "width = 1600"));
  EXPECT_THAT(refusal(wide), test::refuses({wide.calibration, "display"}));
  real.is_virtual = false;
  real.step = "status";
  EXPECT_THAT(refusal(real),
              test::refuses({.field = "line 3, bench", .found = "'Virtual, virtual, seed 1'"}));
}

TEST_F(Calibrate, APlaceByEyeWantsTheModel)
{
  std::string text = virtual_bench_text();
  const std::string table = "[calibration]\n";
  text.insert(text.find(table) + table.size(), "model = \"adjust\"\n");
  CalibrateOptions adjust = options("all");
  adjust.bench = written("bench.toml", text);
  EXPECT_EQ(calibrated(adjust).end,
            CalibrateEnd::finished);  // the simulated operator needs no picture
  adjust.is_repeated = true;
  adjust.script = written("script.txt", "press Enter\n");
  EXPECT_EQ(calibrated(adjust).end, CalibrateEnd::quit);  // an operator sees points
  adjust.bench = written("bare.toml", text.substr(0, text.find("point = [")));
  EXPECT_EQ(refusal(adjust).field, "calibration.point");
  adjust.is_virtual = false;
  adjust.calibration = in_scratch("real.toml");
  EXPECT_EQ(refusal(adjust).file, "--model");
}

TEST_F(Calibrate, PicturesShowWhatWasFound)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  CalibrateOptions all = options("all");
  all.model = in_scratch("knee.h5");
  all.pictures = in_scratch("pictures");
  store::write_motion_model(all.model, model);
  const Said said = calibrated(all);
  for (const std::string name : {"viewport", "distortion", "rectangles", "bullseye", "overlay"}) {
    SCOPED_TRACE(name);
    const std::string path = all.pictures + "/" + name + ".png";
    EXPECT_THAT(said.messages, HasSubstr(path));
    EXPECT_GT(view::read_png_texture(path).width, 100);
  }
}

// The step `calibrate functional` on virtual legs, and the noise of virtual benches.

std::string report_of(const CalibrateOptions& options)
{
  std::ostringstream data, messages;
  EXPECT_EQ(calibrate(options, {data, messages}), CalibrateEnd::finished);
  return data.str();
}

class FunctionalStep : public testing::Test {
 protected:
  /// A model that rolls back by 10 mm and turns by 12 degrees while it bends by 90.
  std::string model(const std::function<void(store::MotionModel&)>& change = {}) const
  {
    test::ModelPlan plan;
    plan.motion = [](double flexion_deg, double) {
      const double share = flexion_deg / 90.0;
      return store::PoseCoordinates{-10.0 * share * share, 2.0 * share, 1.0, 12.0 * share};
    };
    store::MotionModel made = test::model_of(plan);
    test::add_bodies(made);
    if (change) change(made);
    store::write_motion_model(in_scratch("knee.h5"), made);
    return in_scratch("knee.h5");
  }
  CalibrateOptions legs(int n) const
  {
    CalibrateOptions made;
    made.step = "functional";
    made.is_virtual = made.is_headless = true;
    made.bench = VRDA_JOBS "/bench-desk.toml";
    made.model = model();
    made.n_benches = n;
    made.noise = "touch_mm=5,tracker_mm=0.3,tracker_deg=0.3";
    made.has_json = true;
    return made;
  }
  std::string in_scratch(const std::string& name) const { return (scratch_.path() / name).string(); }

  test::Scratch scratch_;
};

TEST_F(FunctionalStep, ReportsTheErrorsOfVirtualLegs)
{
  const nlohmann::json found = nlohmann::json::parse(report_of(legs(2)));
  EXPECT_EQ(found.at("joint").at("n"), 2);
  EXPECT_LT(found.at("joint").at("by_motion_mm").at("largest"),
            found.at("joint").at("by_landmarks_mm").at("largest"));
  int n = 0;
  for (const nlohmann::json& number : found.at("numbers")) n += number.at("part") == "functional" ? 1 : 0;
  EXPECT_EQ(n, 12);
  CalibrateOptions text = legs(2);
  text.has_json = false;
  EXPECT_THAT(report_of(text), HasSubstr("at least halved in "));
}

TEST_F(FunctionalStep, NeedsAMotionOfFlexion)
{
  CalibrateOptions without = legs(1);
  without.model.clear();
  EXPECT_THAT(refusal(without), test::refuses({.file = "--model"}));
  CalibrateOptions unsolved = legs(1);
  unsolved.model = model([](store::MotionModel& made) { test::unsolve(made, 3, 2); });
  unsolved.set = "raw";
  EXPECT_THAT(refusal(unsolved),
              test::refuses({.file = unsolved.model, .field = "flexion", .wanted = "--set"}));
  CalibrateOptions live = legs(0);
  live.is_virtual = false;
  EXPECT_THAT(refusal(live), test::refuses({.file = "--noise"}));
}

// Practice on a virtual bench.

/// Each confirmed task ends with its distance from the truth. Above 10 px it must be done again.
TEST(Practice, ReportsTheErrorOfATask)
{
  const BenchFile bench = bench::parse_bench_file(virtual_bench_text(), "virtual bench");
  const double left = virtual_truth(bench, 1).edges_px[0].low_px.x();
  const std::vector<Task> tasks =
      calibration::tasks_of(CalibrationPart::viewport, bench, bench::nominal_calibration(bench));
  const double start = tasks.front().dials[0].value;
  const test::Scratch scratch;
  for (const int off_px : {0, 1, 5, 100}) {
    SCOPED_TRACE(off_px);
    CalibrateOptions wanted;
    wanted.step = "viewport";
    wanted.is_virtual = wanted.is_headless = true;
    const long n = std::lround(start - left) - off_px;
    wanted.script =
        scratch.write("keys.txt", "press Left " + std::to_string(n) + "\npress Enter\nwait 0.1\n").string();
    std::ostringstream data, messages, sentence;
    calibration::calibrate(wanted, {data, messages});
    sentence.precision(1);
    sentence << std::fixed << "viewport left eye, left edge, 1: You were "
             << std::abs(start - static_cast<double>(n) - left) << " px from the truth";
    EXPECT_THAT(messages.str(), testing::HasSubstr(sentence.str()));
    EXPECT_EQ(messages.str().find(": again") != std::string::npos, off_px > 10) << messages.str();
  }
}

}  // namespace vrda::calibration::calibrate_test
