#include "view/player_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "support/models.hpp"
#include "support/real_knees.hpp"
#include "support/scratch.hpp"

namespace vrda::view::doubts_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// Flexion 0 to 40 by 10, varus -1 to 1: border contact at 20 and varus 0, dislocated at 30 and varus 1,
/// no pose at 0 and varus -1.
store::MotionModel doubtful_model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30, 40};
  plan.varus_deg = {-1, 0, 1};
  store::MotionModel model = test::model_of(plan);
  model.plausibility = store::GridB::Constant(5, 3, static_cast<std::int8_t>(Plausibility::nothing_found));
  model.plausibility(2, 1) = static_cast<std::int8_t>(Plausibility::border_contact);
  model.plausibility(3, 2) = static_cast<std::int8_t>(Plausibility::dislocated);
  test::unsolve(model, 0, 0);
  model.job.warnings = {"the femur is coarse"};
  test::add_smoothed(model, 1, [](int, int) { return store::PoseCoordinates{}; });
  return model;
}

TEST(Doubts, CellsAroundAPose)
{
  struct Row {
    const char* set;
    double flexion_deg, varus_deg;
    const char* text;
  };
  const store::MotionModel model = doubtful_model();
  const DoubtReader reader(model);
  for (const Row& row :
       {Row{"raw", 20, 0, "border contact: a contact at an edge"}, Row{"raw", 15, 0, "border contact: "},
        Row{"raw", 10, 0, ""}, Row{"raw", 20, 1, ""}, Row{"raw", 25, 0.5, "dislocated: further from"},
        Row{"raw", 0, -1, "no pose at 0 degrees: "}, Row{"raw", 5, -0.5, "no pose at 5 degrees: "},
        Row{"degree_1", 5, -0.5, "beside an attitude without a pose"},
        Row{"degree_1", 20, 0, "border contact"}, Row{"degree_1", 10, 1, ""}}) {
    SCOPED_TRACE(std::string(row.set) + " " + std::to_string(row.flexion_deg));
    const store::JointPose pose =
        store::Motion(model, row.set).at({rad_from_deg(row.flexion_deg), rad_from_deg(row.varus_deg)});
    const std::string text = doubt_text(pose, reader.at(pose), "femur").data();
    EXPECT_THAT(text, StartsWith(row.text));
    EXPECT_EQ(text.empty(), std::string(row.text).empty());
  }
}

// Are marked on the timeline between the neighbours.
TEST(Doubts, MarkedSpans)
{
  const store::MotionModel model = doubtful_model();
  const auto spans_at = [&](const char* set, double varus_deg) {
    std::string text;
    for (const MarkedSpan& span :
         DoubtReader(model).marks(store::Motion(model, set), rad_from_deg(varus_deg)))
      text += std::to_string(std::lround(deg_from_rad(span.first))) + "-" +
              std::to_string(std::lround(deg_from_rad(span.last))) + (span.has_pose ? " " : "! ");
    return text;
  };
  EXPECT_EQ(spans_at("raw", 0), "10-30 ");
  EXPECT_EQ(spans_at("raw", 1), "20-40 ");
  EXPECT_EQ(spans_at("raw", -1), "0-10! ");
  EXPECT_EQ(spans_at("degree_1", -1), "0-10 ");
}

// Of the model are counted with their reasons before the warnings of the job.
TEST(Doubts, ModelWarnings)
{
  EXPECT_THAT(model_warnings(doubtful_model()),
              ElementsAre(StartsWith("1 of 14 poses: dislocated: further"),
                          StartsWith("1 of 14 poses: border contact: a contact at an edge"),
                          "1 of 15 attitudes have no pose", "the femur is coarse"));
  EXPECT_TRUE(has_doubtful_poses(doubtful_model()));
  EXPECT_THAT(model_warnings(test::model_of({})), ElementsAre());
}

// The page has its own copy of the reasons, in the same order.
TEST(Doubts, PageHasTheSameReasons)
{
  const std::string page = test::read_bytes(test::source_directory() / "player/web/page/readings.js");
  const std::regex row("\\{ code: (\\d+), name: \"([a-z ]+)\",.* meaning: \"([^\"]+)\" \\}");
  std::vector<std::string> found, wanted;
  for (std::sregex_iterator it(page.begin(), page.end(), row); it != std::sregex_iterator(); ++it)
    found.push_back((*it)[1].str() + " " + (*it)[2].str() + ": " + (*it)[3].str());
  for (const Plausibility plausibility : doubtful_plausibilities) {
    std::string name = name_of(plausibility);
    std::ranges::replace(name, '_', ' ');
    wanted.push_back(std::to_string(static_cast<int>(plausibility)) + " " + name + ": " +
                     meaning_of(plausibility));
  }
  EXPECT_EQ(found, wanted);
}

}  // namespace vrda::view::doubts_test
