/// The programs of the player in a folder of their own, with a motion model, bench files and recordings.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/bench_show.hpp"
#include "bench/recording.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"
#include "support/models.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

class PlayerPrograms : public testing::Test {
 protected:
  PlayerPrograms() { write_model(model_, {}); }

  void write_model(const std::string& file, const ModelPlan& plan) const
  {
    store::MotionModel model = model_of(plan);
    add_bodies(model);
    store::write_motion_model(file, model);
  }
  /// Of a file in the folder.
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }
  Command command(std::vector<std::string> words) const
  {
    return {VRDA_PLAYER_PROGRAM, std::move(words), {}, scratch_.path()};
  }
  Ended run(std::vector<std::string> words) const { return test::run(command(std::move(words))); }

  Scratch scratch_;
  std::string model_ = path("knee.h5");
};

struct BenchPlan {
  std::string leg = "two-bodies";  ///< or "rigid"
  std::string keys = {};           ///< more of the file
  std::string display = {};        ///< more of the display
  int width = 320, height = 256;
  std::string tracker = "[tracker]\nport = 1\n";
  std::string tables = {};  ///< after all others
};

/// The text of a bench file whose tools have the names of their bodies.
inline std::string bench_text(const BenchPlan& plan)
{
  const std::string bodies = plan.leg == "rigid"
                                 ? "[body.leg]\ntool = \"leg\"\n"
                                 : "[body.femur]\ntool = \"femur\"\n[body.tibia]\ntool = \"tibia\"\n";
  return "title = \"Test\"\nleg = \"" + plan.leg + "\"\nhead = \"stage\"\n" + plan.keys +
         "[display]\nwidth = " + std::to_string(plan.width) + "\nheight = " + std::to_string(plan.height) +
         "\nlayout = \"quarters\"\n" + plan.display + plan.tracker + bodies + plan.tables;
}

/// The frames that a bench with the motion model showed, from its recording. Throws InputError as its reader.
inline std::vector<bench::BenchFrame> frames_of(const std::string& log, const std::string& model)
{
  bench::RecordingReader recording(log);
  bench::BenchOptions options;
  options.file = model;
  const bench::BenchSetup setup = bench::recorded_setup(recording.facts(), options);
  bench::BenchState state(setup.bench, setup.calibration, setup.motion, setup.frame);
  std::vector<bench::BenchFrame> frames;
  for (std::size_t k = 0; k < recording.n_frames(); ++k) {
    const bench::RecordedFrame& picture = recording.frame(k);
    bench::PanelContent panel;
    bench::apply_input(state, panel, picture.keys, picture.samples);
    frames.push_back(state.frame(picture.now_ns));
  }
  return frames;
}

}  // namespace vrda::test
