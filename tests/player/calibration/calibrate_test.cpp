// The command `calibrate` on virtual benches.
#include "calibration/calibrate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calibration/calibration_mode.hpp"
#include "calibration/truth.hpp"
#include "store/motion_model.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"

namespace vrda::calibrate_test {

using testing::HasSubstr;

struct Said {
  calibration::CalibrateEnd end = calibration::CalibrateEnd::quit;
  std::string data, messages;
};

Said calibrated(const calibration::CalibrateOptions& options)
{
  std::ostringstream data, messages;
  const calibration::CalibrateEnd end = calibration::calibrate(options, {data, messages});
  return {end, data.str(), messages.str()};
}

InputError::Facts refusal(const calibration::CalibrateOptions& options)
{
  std::ostringstream data, messages;
  return test::input_error([&] { calibration::calibrate(options, {data, messages}); });
}

class Calibrate : public testing::Test {
 protected:
  calibration::CalibrateOptions options(const std::string& step,
                                        const std::string& file = "calibration.toml") const
  {
    calibration::CalibrateOptions made;
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
  calibration::KeyScript script(
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
}

TEST(KeyScript, AnInvalidLineIsRefusedWithItsNumber)
{
  for (const std::string line :
       {"push Enter", "press", "press Entre", "press Right 0", "press Right 1.5", "press Alt+Left", "wait",
        "wait -1", "wait 1 2", "press Shift+Shift+Left", "press Right 20000", "press left"}) {
    SCOPED_TRACE(line);
    const InputError::Facts facts =
        test::input_error([&] { calibration::parse_key_script("press Enter\n\n" + line, "s.txt"); });
    EXPECT_EQ(facts.file, "s.txt");
    EXPECT_EQ(facts.field, "line 3");
  }
}

TEST(CalibrationReport, QuantilesAreByRank)
{
  std::vector<calibration::TargetError> errors;
  for (int k = 20; k > 0; --k) errors.push_back({0.1 * k, 1.0 * k});
  const calibration::TargetSummary summary = calibration::summary_of(errors);
  EXPECT_DOUBLE_EQ(summary.mm.median, 1.0);
  EXPECT_DOUBLE_EQ(summary.mm.p90, 1.8);
  EXPECT_DOUBLE_EQ(summary.mm.largest, 2.0);
  EXPECT_DOUBLE_EQ(summary.arc_min.median, 10.0);
  EXPECT_EQ(calibration::summary_of(std::span<const calibration::TargetError>()).mm.median, 0.0);
}

TEST_F(Calibrate, InvalidOptionsAreRefusedByName)
{
  calibration::CalibrateOptions real;
  real.step = "all";
  EXPECT_EQ(refusal(real).file, "--bench");
  real.bench = written("bench.toml", calibration::virtual_bench_text());
  EXPECT_EQ(refusal(real).file, "--calibration");
  real.calibration = in_scratch("c.toml");
  real.is_headless = true;
  EXPECT_EQ(refusal(real).file, "--headless");
  real.pictures = in_scratch("pictures");
  EXPECT_EQ(refusal(real).file, "--pictures");
  real.n_benches = 2;
  EXPECT_EQ(refusal(real).file, "--benches");

  EXPECT_THAT(refusal(options("viewprot")),
              test::refuses({.field = "STEP", .found = "viewprot", .wanted = "distortion"}));
  EXPECT_EQ(refusal(options("status")).file, in_scratch("calibration.toml"));
  calibration::CalibrateOptions scripted = options("viewport");
  scripted.script = written("script.txt", "press Entre\n");
  EXPECT_EQ(refusal(scripted).field, "line 1");
  calibration::CalibrateOptions headed = options("viewport");
  headed.head = "hat";
  EXPECT_EQ(refusal(headed).file, "--head");
  calibration::CalibrateOptions pictured = options("viewport");
  pictured.is_headless = false;
  pictured.pictures = in_scratch("pictures");
  EXPECT_EQ(refusal(pictured).file, "--pictures");
}

TEST_F(Calibrate, WhatManyBenchesWouldNotDoIsRefused)
{
  const auto refused = [&](const std::function<void(calibration::CalibrateOptions&)>& add) {
    calibration::CalibrateOptions many = options("all");
    many.calibration.clear();
    many.n_benches = 2;
    add(many);
    const InputError::Facts facts = refusal(many);
    EXPECT_EQ(facts.file, "--benches");
    return facts.found;
  };
  EXPECT_THAT(refused([](calibration::CalibrateOptions& o) { o.calibration = "q.toml"; }),
              HasSubstr("--calibration"));
  EXPECT_THAT(refused([](calibration::CalibrateOptions& o) { o.script = "keys.txt"; }),
              HasSubstr("--script"));
  EXPECT_THAT(refused([](calibration::CalibrateOptions& o) { o.pictures = "p"; }), HasSubstr("--pictures"));
  EXPECT_THAT(refused([](calibration::CalibrateOptions& o) { o.step = "viewport"; }), HasSubstr("viewport"));
}

TEST_F(Calibrate, TheErrorAfterCalibrationIsReportedOnceAllPartsAreDone)
{
  const Said text = calibrated(options("viewport"));
  EXPECT_THAT(text.data, HasSubstr("  before  median "));
  EXPECT_THAT(text.data, HasSubstr(": distortion, rails, stop, probe, "));
  EXPECT_THAT(text.data, testing::Not(HasSubstr("after   median")));
  calibration::CalibrateOptions bench = options("bench");
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
}

TEST_F(Calibrate, TheSimulatedOperatorDoesAllParts)
{
  const Said all = calibrated(options("all"));
  EXPECT_EQ(all.end, calibration::CalibrateEnd::finished);
  EXPECT_THAT(all.data, HasSubstr("leg.shift_x"));
  EXPECT_THAT(all.data, HasSubstr("  after   median "));
  EXPECT_THAT(all.data, testing::Not(HasSubstr("to be done")));

  calibration::CalibrateOptions status = options("status");
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
  EXPECT_EQ(calibrated(options("solve")).end, calibration::CalibrateEnd::finished);
  EXPECT_EQ(test::read_bytes(options("all").calibration), before);
}

TEST_F(Calibrate, TheVirtualBenchReportsItsErrors)
{
  calibration::CalibrateOptions one = options("all");
  one.calibration.clear();
  one.has_json = true;
  one.head = "tracker";
  const nlohmann::json reported = nlohmann::json::parse(calibrated(one).data);
  EXPECT_EQ(reported["seed"], 1);
  EXPECT_EQ(reported["targets"]["n"], 40);
  const double before_mm = reported["targets"]["before"]["mm"]["median"];
  const double after_mm = reported["targets"]["after"]["mm"]["median"];
  EXPECT_GT(before_mm, 2.0);
  EXPECT_LT(after_mm, 2.0);

  one.n_benches = 2;
  one.head = "stage";
  const nlohmann::json many = nlohmann::json::parse(calibrated(one).data);
  EXPECT_EQ(many["benches"], 2);
  EXPECT_EQ(many["targets"]["n"], 80);
  EXPECT_EQ(many["numbers"][0]["n"], 2);
}

TEST_F(Calibrate, LeftAndTakenUpAgainItIsTheSame)
{
  // The simulated operator finishes a part; a script may end within one.
  calibration::CalibrateOptions whole = options("viewport", "whole.toml"),
                                pieces = options("viewport", "pieces.toml");
  const std::string first = "press Right 20\npress Enter\npress Left 15\npress Enter\n";
  const std::string second = "press Right 21\npress Enter\nwait 0.1\npress Left 16\npress Enter\n";
  whole.script = written("whole.txt", first + second);
  EXPECT_EQ(calibrated(whole).end, calibration::CalibrateEnd::quit);
  pieces.script = written("first.txt", first);
  EXPECT_EQ(calibrated(pieces).end, calibration::CalibrateEnd::quit);
  EXPECT_NE(test::read_bytes(pieces.calibration), test::read_bytes(whole.calibration));
  pieces.script = written("second.txt", second);
  const Said again = calibrated(pieces);
  EXPECT_EQ(again.end, calibration::CalibrateEnd::quit);
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
  calibration::CalibrateOptions anna = options("bench", "anna.toml"), bob = options("person", "bob.toml");
  bob.bench_from = anna.calibration;
  EXPECT_EQ(refusal(bob).file, anna.calibration);  // does not exist yet
  EXPECT_EQ(calibrated(anna).end, calibration::CalibrateEnd::finished);
  const std::string bench_alone = test::read_bytes(anna.calibration);
  EXPECT_THAT(bench_alone, testing::Not(HasSubstr("[per_person")));
  anna.step = "person";
  EXPECT_EQ(calibrated(anna).end, calibration::CalibrateEnd::finished);

  // One task of the first part per person, by a script.
  bob.script = written("script.txt", "press Left 4\npress Down 4\npress Enter\nwait 0.1\n");
  EXPECT_EQ(calibrated(bob).end, calibration::CalibrateEnd::quit);
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
  EXPECT_EQ(calibrated(bob).end, calibration::CalibrateEnd::finished);
  bob.bench_from.clear();
  EXPECT_EQ(calibrated(bob).end, calibration::CalibrateEnd::finished);
  // Her per-bench parts now differ: an edge was measured again.
  anna.step = "viewport";
  anna.is_repeated = true;
  anna.script = written("restart.txt", "press Right 20\npress Enter\nwait 0.1\n");
  EXPECT_EQ(calibrated(anna).end, calibration::CalibrateEnd::quit);
  bob.bench_from = anna.calibration;
  EXPECT_EQ(refusal(bob).file, bob.calibration);
  EXPECT_EQ(refusal(bob).field, "per_bench");
}

TEST_F(Calibrate, TheStartOfTheNextPersonMustBeCompleteAndOfThisBench)
{
  calibration::CalibrateOptions anna = options("viewport", "anna.toml"), bob = options("person", "bob.toml");
  EXPECT_EQ(calibrated(anna).end, calibration::CalibrateEnd::finished);
  bob.bench_from = anna.calibration;
  EXPECT_EQ(refusal(bob).file, anna.calibration);
  EXPECT_EQ(refusal(bob).field, "per_bench.distortion");
  EXPECT_EQ(refusal(bob).found, "nothing");
  anna.step = "bench";
  EXPECT_EQ(calibrated(anna).end, calibration::CalibrateEnd::finished);
  const std::string own = "title = \"Virtual\"";
  std::string text = calibration::virtual_bench_text();
  bob.bench = written("other.toml", text.replace(text.find(own), own.size(), "title = \"B\""));
  EXPECT_EQ(refusal(bob).field, "bench");
  bob.bench.clear();
  bob.step = "status";
  EXPECT_EQ(refusal(bob).file, "--bench-from");
  bob.step = "person";
  bob.calibration.clear();
  EXPECT_THAT(refusal(bob), test::refuses({.found = "--calibration"}));
  EXPECT_FALSE(std::filesystem::exists(in_scratch("bob.toml")));
}

TEST_F(Calibrate, TheCalibrationOfAnotherBenchIsRefused)
{
  calibration::CalibrateOptions viewport = options("viewport");
  const std::string text = calibration::virtual_bench_text();
  viewport.bench = written("own.toml", text);
  EXPECT_EQ(calibrated(viewport).end, calibration::CalibrateEnd::finished);
  const std::string own = "title = \"Virtual\"", size = "width = 1280";
  viewport.bench =
      written("other.toml", std::string(text).replace(text.find(own), own.size(), "title = \"B\""));
  EXPECT_EQ(refusal(viewport).file, viewport.calibration);
  EXPECT_EQ(refusal(viewport).field, "bench");
  viewport.bench =
      written("wide.toml", std::string(text).replace(text.find(size), size.size(), "width = 1600"));
  EXPECT_EQ(refusal(viewport).file, viewport.calibration);
  EXPECT_EQ(refusal(viewport).field, "display");
}

TEST_F(Calibrate, WithoutAScreenTheSimulatedOperatorDoesARunThatIsNotStored)
{
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  calibration::CalibrateOptions shown = options("viewport");
  shown.is_headless = false;
  EXPECT_THAT(refusal(shown), test::refuses({.field = "display", .wanted = "--headless"}));
  shown.calibration.clear();
  const Said said = calibrated(shown);
  EXPECT_EQ(said.end, calibration::CalibrateEnd::finished);
  EXPECT_THAT(said.data, HasSubstr("viewport    done"));
  EXPECT_THAT(said.messages, HasSubstr("no screen"));
}

TEST_F(Calibrate, TheCalibrationOfAnotherSeedIsRefused)
{
  calibration::CalibrateOptions first = options("bench");
  EXPECT_EQ(calibrated(first).end, calibration::CalibrateEnd::finished);
  calibration::CalibrateOptions second = first, person = options("person", "bob.toml");
  second.seed = person.seed = 2;
  person.bench_from = first.calibration;
  for (const calibration::CalibrateOptions& other : {second, person}) {
    SCOPED_TRACE(other.step);
    EXPECT_THAT(refusal(other),
                test::refuses({first.calibration, "bench", "'Virtual, seed 1'", "'Virtual, seed 2'"}));
  }
  EXPECT_FALSE(std::filesystem::exists(person.calibration));
  // A calibration of a virtual bench is not valid for a real one.
  calibration::CalibrateOptions real = options("viewport", "real.toml");
  real.bench = written("bench.toml", calibration::virtual_bench_text());
  EXPECT_EQ(calibrated(real).end, calibration::CalibrateEnd::finished);
  real.is_virtual = false;
  real.step = "status";
  EXPECT_THAT(refusal(real),
              test::refuses({.field = "line 3, bench", .found = "'Virtual, virtual, seed 1'"}));
}

TEST_F(Calibrate, APlaceByEyeWantsTheModel)
{
  std::string text = calibration::virtual_bench_text();
  const std::string table = "[calibration]\n";
  text.insert(text.find(table) + table.size(), "model = \"adjust\"\n");
  calibration::CalibrateOptions adjust = options("all");
  adjust.bench = written("bench.toml", text);
  EXPECT_EQ(calibrated(adjust).end,
            calibration::CalibrateEnd::finished);  // the simulated operator needs no picture
  adjust.is_repeated = true;
  adjust.script = written("script.txt", "press Enter\n");
  EXPECT_EQ(calibrated(adjust).end, calibration::CalibrateEnd::quit);  // an operator sees points
  adjust.bench = written("bare.toml", text.substr(0, text.find("point = [")));
  EXPECT_EQ(refusal(adjust).field, "calibration.point");
  adjust.is_virtual = false;
  adjust.calibration = in_scratch("real.toml");
  EXPECT_EQ(refusal(adjust).file, "--model");
}

/// Number of pixels of an area of a PNG picture that are not black.
int n_lit(const view::Texture& picture, int left, int top, int right, int bottom)
{
  int n = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                  static_cast<std::size_t>(x));
      n += picture.rgb[at] > 20 || picture.rgb[at + 1] > 20 || picture.rgb[at + 2] > 20 ? 1 : 0;
    }
  }
  return n;
}

TEST_F(Calibrate, PicturesShowWhatWasFound)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  calibration::CalibrateOptions all = options("all");
  all.model = in_scratch("knee.h5");
  all.pictures = in_scratch("pictures");
  store::write_motion_model(all.model, model);
  const Said said = calibrated(all);
  for (const std::string name : {"viewport", "distortion", "rectangles", "bullseye", "overlay"}) {
    SCOPED_TRACE(name);
    const std::string path = all.pictures + "/" + name + ".png";
    EXPECT_THAT(said.messages, HasSubstr(path));
    const view::Texture picture = view::read_png_texture(path);
    EXPECT_GT(n_lit(picture, 0, 0, picture.width, picture.height), 1000);
  }
  // Figure 22 for the quarters: the left half of the frame buffer is empty; both windows are filled.
  const view::Texture viewport = view::read_png_texture(all.pictures + "/viewport.png");
  EXPECT_EQ(n_lit(viewport, 30, 300, 280, 700), 0);
  EXPECT_EQ(n_lit(viewport, 520, 100, 860, 300), 340 * 200);
  EXPECT_EQ(n_lit(viewport, 520, 450, 860, 680), 340 * 230);
}

TEST_F(Calibrate, TheOverlayDrawsNoSkinButShowsItAsTheLeg)
{
  const auto overlay = [&](const std::string& material) {
    store::MotionModel model = test::model_of({});
    test::add_bodies(model);
    for (Body* body : {&model.reference, &model.moving}) {
      body->components.push_back({"surface", material});
      body->visual = body->contact;
      body->visual.mesh.vertices_mm *= 1.5;
      std::fill(body->visual.component.begin(), body->visual.component.end(),
                static_cast<std::int32_t>(body->components.size() - 1));
    }
    calibration::CalibrateOptions all = options("all", material + ".toml");
    all.model = in_scratch(material + ".h5");
    all.pictures = in_scratch(material);
    store::write_motion_model(all.model, model);
    calibrated(all);
    return view::read_png_texture(all.pictures + "/overlay.png");
  };
  const auto n_bright = [](const view::Texture& picture) {
    return std::count_if(picture.rgb.begin(), picture.rgb.end(),
                         [](std::uint8_t code) { return code > 160; });
  };
  const view::Texture bone = overlay("bone"), skin = overlay("skin");
  EXPECT_GT(n_lit(skin, 0, 50, skin.width, skin.height), 1000);
  // The displayed light covers the contact parts only, of 1 / 1.5 of the size.
  EXPECT_GT(n_bright(skin), 500);
  EXPECT_LT(n_bright(skin), 0.75 * static_cast<double>(n_bright(bone)));
}

TEST_F(Calibrate, AScriptShowsItsTasks)
{
  calibration::CalibrateOptions viewport = options("viewport");
  viewport.script = written("script.txt", "press Right 20\npress Enter\nwait 0.1\n");
  viewport.pictures = in_scratch("tasks");
  const Said said = calibrated(viewport);
  EXPECT_EQ(said.end, calibration::CalibrateEnd::quit);
  EXPECT_THAT(said.data, HasSubstr("task_0001.png"));
  EXPECT_THAT(said.data, HasSubstr("task_0002.png"));
  // Text in the operator's area, left of the quarters; lines in the left eye's window.
  const view::Texture picture = view::read_png_texture(viewport.pictures + "/task_0001.png");
  ASSERT_EQ(picture.width, 1280);
  EXPECT_GT(n_lit(picture, 0, 0, 640, 200), 100);
  EXPECT_GT(n_lit(picture, 640, 0, 1280, 512), 500);
  EXPECT_EQ(n_lit(picture, 640, 520, 1280, 1024), 0);
}

/// Practice by keys: each confirmed task ends with its distance from the truth.
TEST_F(Calibrate, PracticeReportsTheErrorOfEachTask)
{
  calibration::CalibrateOptions wanted = options("viewport");
  wanted.calibration.clear();
  const bench::BenchFile bench = bench::parse_bench_file(calibration::virtual_bench_text(), "virtual bench");
  const double left = calibration::virtual_truth(bench, 1).edges_px[0].left;
  const auto start =
      calibration::tasks_of(bench::CalibrationPart::viewport, bench, bench::nominal_calibration(bench))
          .front()
          .dials[0]
          .value;
  const long n = std::lround(start - std::round(left));
  ASSERT_GT(n, 0) << "the line starts inside the edge";
  wanted.script = written("keys.txt", "press Left " + std::to_string(n) + "\npress Enter\npress Escape\n");
  const Said said = calibrated(wanted);
  std::ostringstream sentence;
  sentence.precision(1);
  sentence << std::fixed << "viewport left eye, left edge, 1: You were " << std::abs(std::round(left) - left)
           << " px from the truth.";
  EXPECT_THAT(said.messages, HasSubstr(sentence.str()));
}

}  // namespace vrda::calibrate_test
