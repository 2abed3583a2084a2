// `vrda-player show --trace`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <sstream>

#include "core/text.hpp"
#include "show/show.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "support/traces.hpp"

namespace vrda::show::show_trace_test {

using testing::ElementsAre;
using testing::HasSubstr;

class ShowTrace : public testing::Test {
 protected:
  ShowTrace()
  {
    test::ModelPlan plan;
    plan.flexion_deg = {0, 10};
    plan.varus_deg = {-1, 0, 1};
    store::MotionModel model = test::model_of(plan);
    test::add_bodies(model);
    store::write_motion_model(options_.file, model);
    store::write_trace(options_.trace, test::trace_beside(model));
    options_.size = "64x48";
    options_.views = "front";
  }

  int run(const ShowOptions& options)
  {
    data_.str("");
    return show(options, {data_, messages_}).n_images;
  }

  std::vector<std::string> names() const
  {
    std::vector<std::string> names;
    std::istringstream lines(data_.str());
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(std::filesystem::exists(line));
      names.push_back(std::filesystem::path(line).filename());
    }
    return names;
  }

  std::string still(const std::string& name) const { return test::read_bytes(options_.folder + "/" + name); }

  test::Scratch scratch_;
  std::ostringstream data_, messages_;
  ShowOptions options_ = [this] {
    ShowOptions options;
    options.file = (scratch_.path() / "knee.h5").string();
    options.trace = (scratch_.path() / "knee.trace.h5").string();
    options.folder = (scratch_.path() / "film").string();
    return options;
  }();
};

TEST_F(ShowTrace, EveryMove)
{
  EXPECT_EQ(run(options_), 1 + test::n_moves_of_a_cell);
  const std::vector<std::string> frames = names();
  EXPECT_EQ(frames.front(), "front_frame_0000.png");
  EXPECT_EQ(frames.back(), "front_frame_0008.png");
  EXPECT_TRUE(std::is_sorted(frames.begin(), frames.end()));
  EXPECT_THAT(messages_.str(), HasSubstr("flexion 0, varus 0, 9 frames, 9 "));
  // The last free trial and the step that ends there have the same pose; seed and end differ.
  EXPECT_EQ(still("front_frame_0004.png"), still("front_frame_0005.png"));
  EXPECT_NE(still("front_frame_0000.png"), still("front_frame_0008.png"));
}

TEST_F(ShowTrace, ContactOnly)
{
  options_.contact_only = true;
  options_.views = "front,top";
  options_.flexion = "10";
  options_.varus_deg = 1.0;
  EXPECT_EQ(run(options_), 2 * test::n_touches_of_a_cell);
  EXPECT_THAT(names(), ElementsAre("front_frame_0000.png", "front_frame_0001.png", "front_frame_0002.png",
                                   "top_frame_0000.png", "top_frame_0001.png", "top_frame_0002.png"));
}

// What does not fit is one error before any picture.
TEST_F(ShowTrace, Refusals)
{
  struct Row {
    std::string file, field, found;
    std::function<void(ShowOptions&)> change;
  };
  for (const Row& row : {
           Row{"--every", "", "0", [](ShowOptions& o) { o.every = 0; }},
           Row{"--every", "", "no --trace", [](ShowOptions& o) { o.trace.clear(), o.every = 2; }},
           Row{"--contact-only", "", "no --trace",
               [](ShowOptions& o) { o.trace.clear(), o.contact_only = true; }},
           Row{"--set", "", "raw", [](ShowOptions& o) { o.set = "raw"; }},
           Row{"--flexion", "", "0:10:5", [](ShowOptions& o) { o.flexion = "0:10:5"; }},
           Row{options_.trace, "attitude", "flexion 5", [](ShowOptions& o) { o.flexion = "5"; }},
           Row{options_.file, "/@format", "motion model", [](ShowOptions& o) { o.trace = o.file; }},
           Row{options_.trace, "/@format", "search trace", [](ShowOptions& o) { o.file = o.trace; }},
       }) {
    SCOPED_TRACE(row.file + row.found);
    ShowOptions given = options_;
    row.change(given);
    EXPECT_THAT(test::input_error([&] { run(given); }), test::refuses({row.file, row.field, row.found}));
  }
  EXPECT_FALSE(std::filesystem::exists(options_.folder));
}

}  // namespace vrda::show::show_trace_test
