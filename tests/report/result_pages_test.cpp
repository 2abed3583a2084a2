#include "report/result_pages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace vrda::result_pages_test {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;

// The data in a page; every other part is that of a report.
Json data_of(const std::string& page)
{
  const std::string begin = "id=\"report-data\">";
  const std::size_t from = page.find(begin) + begin.size();
  return Json::parse(page.substr(from, page.find("</script>", from) - from));
}

std::string title_in(const std::string& page)
{
  return page.substr(page.find("<title>"), page.find("</title>") - page.find("<title>"));
}

analysis::LaxityCurve loaded(analysis::LaxityTest test, double moved_mm)
{
  analysis::LaxityCurve curve;
  curve.test = test;
  for (const double share : {0.0, 1.0}) {
    analysis::LoadedPose pose;
    pose.load = 100.0 * share;
    pose.status = StepStatus::stable;
    pose.coordinates.setZero();
    pose.coordinates(3) = moved_mm * share;
    curve.poses.push_back(pose);
  }
  curve.bundles = {{"<ACL>", 80.0, 0.8}};
  curve.contact = {"contact", 20.0, 0.2};
  return curve;
}

TEST(LaxityPage, HasTheDocumentAndWhatTheCutsRemove)
{
  analysis::LaxityDocument document;
  document.title = "knee & co";
  document.result.loads.flexion_deg = {0.0};
  document.result.loads.anterior_force_n = 100.0;
  document.result.loads.cuts = {{"ACL", {"<ACL>"}}};
  document.result.states = {"intact"};
  document.result.curves = {loaded(analysis::LaxityTest::anterior, 6.0),
                            loaded(analysis::LaxityTest::posterior, -5.0)};
  document.compared = analysis::compared(document.result, {{"anterior", 0.0, nan, 9.0, 2.0, "Author"}});
  const std::string page = report::laxity_page(document);
  EXPECT_THAT(title_in(page), HasSubstr("knee &amp; co: laxity"));
  const Json data = data_of(page).at("laxity");
  EXPECT_EQ(data.at("cuts"), Json({{"<ACL>"}}));
  EXPECT_EQ(data.at("loads").at("anterior"), 100.0);
  EXPECT_EQ(data.at("document").at("curves")[0].at("laxity"), 6.0);
  EXPECT_EQ(data.at("document").at("published")[0].at("difference"), -3.0);
}

analysis::RomDocument small_range()
{
  analysis::RomDocument document;
  document.title = "Hip </title>";
  document.joint = "hip";
  document.reference_names = {"acetabulum"};
  document.moving_names = {"head"};
  document.range.axes.rad = {std::vector{0.0, 0.1}, std::vector{-0.2, 0.0, 0.2}, std::vector{0.0}};
  document.range.cells.resize(6);
  for (analysis::RomCell& cell : document.range.cells) {
    cell.status = analysis::RomStatus::contact;
    cell.component_reference = cell.component_moving = 0;
  }
  document.range.neutral = {0, 1, 0};
  analysis::RomCell& neutral = document.range.cells[analysis::cell_at(document.range.axes, 0, 1, 0)];
  neutral.status = analysis::RomStatus::in_range;
  neutral.is_connected = true;
  return document;
}

TEST(RangePage, HasMapsVolumesAndEnds)
{
  const std::string page = report::range_page(small_range());
  EXPECT_THAT(title_in(page), HasSubstr("Hip &lt;/title&gt;: range of motion"));
  const Json data = data_of(page).at("range");
  EXPECT_EQ(data.at("maps").at("cells"), Json({{{2, 0, 2}, {2, 2, 2}}})) << "[slice, x, y] of the legend";
  EXPECT_EQ(data.at("maps").at("outlines")[0].size(), 3U) << "above, below, and to the right";
  EXPECT_EQ(data.at("volumes")[0].at("cells"), 1);
  EXPECT_TRUE(data.at("ranges")[0].at("limits").contains("opening_mm"));
  const Json along_varus = data.at("ends")[1];
  EXPECT_NEAR(along_varus.at("low").at("deg").get<double>(), 0.0, 1e-6);
  EXPECT_EQ(along_varus.at("high").at("cause"), "contact: acetabulum on head");
}

TEST(RangePage, ComparesTwo)
{
  const Json data = data_of(report::range_comparison_page(small_range(), small_range())).at("range");
  ASSERT_EQ(data.at("volumes").size(), 5U);
  EXPECT_EQ(data.at("volumes")[2].at("cells"), 1) << "both";
  EXPECT_EQ(data.at("volumes")[3].at("cells"), 0) << "the first only";
  EXPECT_FALSE(data.contains("ends"));
}

}  // namespace vrda::result_pages_test
