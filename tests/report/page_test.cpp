#include "report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "report/model_json.hpp"
#include "store/sample_model.hpp"
#include "support/meshes.hpp"

namespace vrda::page_test {

report::Report sample_report(const test::SampleOptions& options = {})
{
  report::Report report;
  report.program = "vrda 1.2.3";
  report.models = {{"sample", test::sample_model(options), {}, {}, {}}};
  return report;
}

report::Json data_of(const report::Report& report)
{
  return report::Json::parse(report::report_json(report));
}

std::string between(const std::string& text, const std::string& begin, const std::string& end)
{
  const std::size_t from = text.find(begin);
  EXPECT_NE(from, std::string::npos);
  const std::size_t to = text.find(end, from + begin.size());
  EXPECT_NE(to, std::string::npos);
  return text.substr(from + begin.size(), to - from - begin.size());
}

// A failed match of the whole page would print megabytes.
bool holds(const std::string& page, const std::string& text)
{
  return page.find(text) != std::string::npos;
}

// Axes around a knee whose meshes have their origin at the feet are as near to the rotation centre as any.
TEST(Page, AxesAreFromTheRotationCentre)
{
  report::Report report = sample_report();
  store::MotionModel& model = report.models[0].model;
  model = test::whole_model();
  const report::Json near = data_of(report).at("models")[0].at("axes");
  const Eigen::Vector3d offset_mm(0, 900, 0);
  model.rotation_centre_mm += offset_mm;
  for (std::size_t k = 0; k < model.zero_varus->helical_point_mm.size(); ++k)
    model.zero_varus->helical_point_mm[k] += offset_mm[static_cast<Eigen::Index>(k % 3)];
  for (std::size_t k = 0; k < model.zero_varus->instant_centre_mm.size(); ++k)
    model.zero_varus->instant_centre_mm[k] += offset_mm[static_cast<Eigen::Index>(k % 2)];
  const report::Json far = data_of(report).at("models")[0].at("axes");
  for (const char* key : {"point_mm", "instant_centre_mm"}) {
    ASSERT_EQ(far.at(key).size(), near.at(key).size());
    int n_compared = 0;
    for (std::size_t i = 0; i < far.at(key).size(); ++i) {
      for (std::size_t k = 0; k < far.at(key)[i].size(); ++k) {
        if (near.at(key)[i][k].is_null()) continue;
        ++n_compared;
        EXPECT_NEAR(far.at(key)[i][k].get<double>(), near.at(key)[i][k].get<double>(), 1e-6) << key;
      }
    }
    EXPECT_GT(n_compared, 0) << key;
  }
}

TEST(Page, TextOfAModelCannotLeaveItsPlace)
{
  const std::string nasty = "</script><img src=x onerror=alert(1)> & {{data}} \"quoted\" <!--<script>";
  report::Report report = sample_report();
  report.models[0].model.title = nasty;
  report.models[0].model.job.text = nasty;
  report.models[0].model.reference.name = nasty;
  report.models[0].name = nasty;
  const std::string page = report::report_page(report);
  EXPECT_FALSE(holds(page, "<img src=x"));
  EXPECT_FALSE(holds(page, "<!--<script>"));
  EXPECT_TRUE(holds(
      page, "<title>&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt; &amp; {{data}} &quot;quoted&quot;"));
  const report::Json data = report::Json::parse(between(page, "id=\"report-data\">", "</script>"));
  EXPECT_EQ(data.at("models")[0].at("title"), nasty);
  EXPECT_EQ(data.at("models")[0].at("provenance").at("job"), nasty);
}

TEST(Page, AScaledJointSaysHowWellItFits)
{
  report::Report report = sample_report();
  EXPECT_TRUE(data_of(report).at("models")[0].at("provenance").at("scaling").is_null());
  Scaling& scaling = report.models[0].model.job.scaling.emplace();
  scaling.factor.setConstant(1.07);
  scaling.landmark = {"epicondyles"};
  scaling.model_mm = {80};
  scaling.subject_mm = {85.6};
  scaling.residual_mm = {0};
  scaling.residual_rms_mm = 0.0;
  const report::Json json = data_of(report).at("models")[0].at("provenance").at("scaling");
  EXPECT_EQ(json.at("factor"), report::Json({1.07, 1.07, 1.07}));
  EXPECT_TRUE(json.at("standard_error").is_null()) << "unknown for one pair";
  EXPECT_EQ(json.at("landmarks"), report::Json({"epicondyles"}));
  EXPECT_EQ(json.at("subject_mm"), report::Json({85.6}));
}

TEST(Page, BytesThatAreNoTextDoNotStopIt)
{
  report::Report report = sample_report();
  report.models[0].model.title = "knee \xff\xfe";
  EXPECT_EQ(data_of(report).at("models")[0].at("title"), "knee \uFFFD\uFFFD");
}

TEST(Page, NeedsNoOtherFileAndNoNetwork)
{
  const std::string page = report::report_page(sample_report());
  for (const char* wanted : {"default-src 'none'", "Plots by uPlot", "Leon Sorokin"})
    EXPECT_TRUE(holds(page, wanted)) << wanted;
  for (const char* unwanted : {"<link", "src=\"http", "@import"})
    EXPECT_FALSE(holds(page, unwanted)) << unwanted;
}

TEST(Page, PiecesCannotEndTheirElement)
{
  const std::string_view script = report::page_code();
  EXPECT_GT(script.size(), 1000u);
  EXPECT_EQ(script.find("</script"), std::string_view::npos);
  EXPECT_EQ(script.find("<!--"), std::string_view::npos);
  for (const std::string_view style : {report::page_style(), report::plot_style()})
    EXPECT_EQ(style.find("</style"), std::string_view::npos);
  EXPECT_EQ(report::plot_licence().find("--"), std::string_view::npos);
}

TEST(Page, EqualReportsHaveEqualBytes)
{
  EXPECT_EQ(report::report_page(sample_report()), report::report_page(sample_report()));
}

TEST(PageData, WritesNullForNumbersThatAreNotFinite)
{
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(report::data_text({1.23456789, std::nan(""), infinity, -infinity, 3}),
            "[1.234568,null,null,null,3]");
  const report::Json model = data_of(sample_report()).at("models")[0];
  EXPECT_TRUE(model.at("surfaces")[0].at("tx")[1][2].is_null());  // the failed cell
  EXPECT_EQ(model.at("status_grid")[1][2], 2);
  EXPECT_EQ(model.at("contact_grid")[1][2], -1);
  EXPECT_EQ(model.at("contact_grid")[0][0], 1);  // medial only
  EXPECT_TRUE(model.at("forces").is_null());
  EXPECT_TRUE(model.at("fibres").is_null());
  EXPECT_TRUE(model.at("axes").is_null());
}

TEST(PageData, AddsForcesByCompartmentAndFibresByBundle)
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  options.n_fibres = 5;
  const report::Json model = data_of(sample_report(options)).at("models")[0];
  // Spine cells are 1, 4, 7, 10; the even ones carry 15 N medially and 5 N laterally along Delta.
  EXPECT_EQ(model.at("forces").at("medial_n").dump(), "[0.0,15.0,0.0,15.0]");
  EXPECT_EQ(model.at("forces").at("lateral_n").dump(), "[0.0,5.0,0.0,5.0]");
  const report::Json bundles = model.at("fibres");
  ASSERT_EQ(bundles.size(), 2u);
  EXPECT_EQ(bundles[0].at("name"), "ACL");
  EXPECT_EQ(bundles[0].at("n_fibres"), 3);
  EXPECT_EQ(bundles[0].at("largest_strain").dump(), "[0.002,0.002,0.002,0.002]");
  // Only fibre 4 of that bundle is taut: 0.25 * 1004 N * 0.002^2 / 0.05
  EXPECT_NEAR(bundles[0].at("tension_n")[0].get<double>(), 0.02008, 1e-6);
  EXPECT_EQ(bundles[1].at("largest_strain")[0], 0.001);
  EXPECT_EQ(model.at("spine").at("n_optima").dump(), "[1,2,1,0]");
  const auto& branches = model.at("spine").at("branches");
  EXPECT_EQ(branches.at("is_chosen").dump(), "[1,1,0,1]");
  EXPECT_EQ(branches.at("flexion").at(1), branches.at("flexion").at(2)) << "two at the second flexion";
  EXPECT_EQ(branches.at("energy").at(2).get<double>() - branches.at("energy").at(1).get<double>(), 1.75);
}

TEST(PageData, FixedCoordinatesHaveLoadsAndFreeOnesWhetherTheyAreDetermined)
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  options.has_frames = true;
  options.n_varus = 1;
  const store::MotionModel model = sample_report(options).models[0].model;
  const report::Json list = data_of(sample_report(options)).at("models")[0].at("coordinates");
  ASSERT_EQ(list.size(), 6u);
  EXPECT_EQ(list[0].at("name"), "flexion");
  EXPECT_EQ(list[0].at("role"), "given");
  EXPECT_EQ(list[1].at("role"), "free");
  EXPECT_DOUBLE_EQ(list[2].at("holding_load")[1].get<double>(),
                   model.coordinates->holding_moment_nmm[3 * 1 + 2]);
  EXPECT_DOUBLE_EQ(list[3].at("holding_load")[2].get<double>(),
                   model.coordinates->holding_force_n[3 * 2 + 0]);
  EXPECT_NE(list[2].at("holding_load")[1], list[3].at("holding_load")[1]);
  EXPECT_TRUE(list[1].at("holding_load")[1].is_null());
  EXPECT_EQ(list[1].at("determined"), list[1].at("solved"));
  EXPECT_EQ(list[5].at("determined"), 0);
  EXPECT_TRUE(data_of(sample_report()).at("models")[0].at("coordinates").is_null());
}

TEST(PageData, PicturesAreBase64)
{
  report::Report report = sample_report();
  for (const char* bytes : {"M", "Ma", "Man", "Many"})
    report.models[0].images.images.push_back({"front", bytes, bytes});
  report.models[0].images.images.push_back({"front", "high", std::string("\xff\x00\xfe", 3)});
  const report::Json stills = data_of(report).at("models")[0].at("stills").at("stills");
  const char* expected[] = {"TQ==", "TWE=", "TWFu", "TWFueQ==", "/wD+"};  // RFC 4648
  ASSERT_EQ(stills.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(stills[k].at("png"), expected[k]);
}

TEST(PageData, ComparesEveryCurveWithEveryFileAndTheFirstModel)
{
  report::Report report = sample_report();
  report.models.push_back({"other", test::sample_model(), {}, {}, {}});
  report.against = {report::curve_from_text("line.csv", "flexion_deg,internal_deg\n0,1\n3,1.6\n")};
  const report::Json data = data_of(report);
  EXPECT_FALSE(data.at("models")[0].contains("surfaces"));
  // Two curves per model against the file; those of the second also against the first model's first curve.
  ASSERT_EQ(data.at("differences").size(), 6u);
  int n_raw = 0;
  for (const report::Json& d : data.at("differences")) {
    if (d.at("curve") != "raw" || d.at("against") != "line") continue;
    ++n_raw;
    // theta is 0.2 degrees per degree of flexion, the file has 1 more
    EXPECT_NEAR(d.at("by_quantity").at("internal").at("mean").get<double>(), -1.0, 1e-6);
    EXPECT_NEAR(d.at("by_quantity").at("internal").at("rms_about_mean").get<double>(), 0.0, 1e-6);
    EXPECT_FALSE(d.at("by_quantity").contains("varus"));
  }
  EXPECT_EQ(n_raw, 2);
}

constexpr double rounding = 1e-9;

TEST(Outline, OfABoxIsItsRectangle)
{
  const auto rim = report::projected_outline(test::box({5, 0, -3}, {8, 2, 6}),
                                             {.from_mm = -1, .to_mm = 1, .n_directions = 36});
  ASSERT_EQ(rim.size(), 36u);
  for (const Eigen::Vector2d& p : rim) {
    const double x = std::fabs(p.x() - 5.0) / 4.0, z = std::fabs(p.y() + 3.0) / 3.0;
    EXPECT_NEAR(std::max(x, z), 1.0, rounding);
  }
}

TEST(Outline, OfABallIsItsCircle)
{
  const int n_sectors = 64;
  const auto rim = report::projected_outline(test::ball(10, 32, n_sectors), {.from_mm = -10, .to_mm = 10});
  ASSERT_EQ(rim.size(), 240u);
  const double sagitta_mm = 10.0 * (1.0 - std::cos(3.15 / n_sectors));
  for (const Eigen::Vector2d& p : rim) EXPECT_NEAR(p.norm(), 10.0, sagitta_mm + rounding);
}

TEST(Outline, CountsTrianglesWithinTheHeightsOnly)
{
  Mesh mesh = test::box({0, 0, 0}, {2, 2, 2});
  append(mesh, test::box({0, 50, 0}, {20, 2, 20}));
  for (const Eigen::Vector2d& p : report::projected_outline(mesh, {.from_mm = -1, .to_mm = 1}))
    EXPECT_LE(p.norm(), std::sqrt(2.0) + rounding);
  EXPECT_TRUE(report::projected_outline(mesh, {.from_mm = 5, .to_mm = 6}).empty());
  EXPECT_TRUE(report::projected_outline(Mesh{}, {.from_mm = -1, .to_mm = 1}).empty());
}

}  // namespace vrda::page_test
