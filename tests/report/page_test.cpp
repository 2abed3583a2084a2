// The page's data, its warnings, and the pages of other results.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "report/model_json.hpp"
#include "report/report.hpp"
#include "report/result_pages.hpp"
#include "store/sample_model.hpp"
#include "support/meshes.hpp"

namespace vrda::page_test {

using Json = nlohmann::ordered_json;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

report::Report sample_report(const test::SampleOptions& options = {})
{
  report::Report report;
  report.program = "vrda 1.2.3";
  report.models = {{"sample", test::sample_model(options), {}, {}, {}, {}}};
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
  report.models.push_back({"other", test::sample_model(), {}, {}, {}, {}});
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

/// Removes the sample's doubtful poses.
store::MotionModel undoubted(store::MotionModel model)
{
  model.plausibility.setConstant(static_cast<std::int8_t>(Plausibility::nothing_found));
  return model;
}

report::ReportModel whole_entry()
{
  test::SampleOptions options;
  options.has_failed_cell = false;
  return {"sample", undoubted(test::sample_model(options)), {}, {}, {}, {}};
}

report::ReportModel equilibrium_entry()
{
  test::SampleOptions options;
  options.has_failed_cell = false;
  options.is_equilibrium = true;
  options.n_fibres = 4;
  report::ReportModel entry{"sample", undoubted(test::sample_model(options)), {}, {}, {}, {}};
  entry.model.equilibrium->spine.n_optima.assign(4, 1);
  return entry;
}

TEST(Findings, NothingToWarnOfIsNoWarning)
{
  EXPECT_THAT(report::warnings_of(whole_entry()), IsEmpty());
  EXPECT_THAT(report::warnings_of(equilibrium_entry()), IsEmpty());
}

TEST(Findings, DoubtfulPosesAreCountedByKind)
{
  report::ReportModel entry = whole_entry();
  entry.model.plausibility(1, 1) = static_cast<std::int8_t>(Plausibility::unstable_balance);
  EXPECT_THAT(report::warnings_of(entry),
              ElementsAre(HasSubstr("1 stable attitudes are doubtful, unstable_balance")));
}

TEST(Findings, NoDegreeIsAWarningWithItsReason)
{
  report::ReportModel entry = whole_entry();
  entry.comparison.emplace();
  entry.comparison->recommendation.reason = "the raw motion jumps";
  EXPECT_THAT(report::warnings_of(entry),
              ElementsAre("No smoothing degree meets the criteria: the raw motion jumps."));
  entry.comparison->recommendation.degree = 4;
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
}

TEST(Findings, NameEveryStatusThatIsNotStable)
{
  const store::MotionModel model = test::sample_model();
  EXPECT_THAT(report::warnings_of({"sample", model, {}, {}, {}, {}}),
              Contains(HasSubstr("1 of 12 attitudes ended as no_clearance")));
  for (const StepStatus status : all_step_statuses) {
    SCOPED_TRACE(name_of(status));
    report::ReportModel entry = whole_entry();
    entry.model.status(3, 1) = static_cast<std::int8_t>(status);
    const bool is_stable = status == StepStatus::stable;
    EXPECT_EQ(report::warnings_of(entry).size(),
              is_stable ? 0u : 2u);  // the status, and the hole in the spine
    const std::vector<std::string> lines = report::warnings_of(entry);
    const auto n_named = std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.find(std::string("ended as ") + name_of(status)) != std::string::npos;
    });
    EXPECT_EQ(n_named, is_stable ? 0 : 1);
  }
}

TEST(Findings, RawGapsAndPenetrationsCountFromWhatCanBeSeen)
{
  report::ReportModel entry = whole_entry();
  entry.raw = {7, 0.14, 0.14};
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
  entry.raw = {7, 0.25, 0.5};
  EXPECT_THAT(report::warnings_of(entry), AllOf(Contains(HasSubstr("overlaps by up to 0.25 mm (7 attitudes")),
                                                Contains(HasSubstr("gap of up to 0.5 mm"))));
  entry.raw = {0, 0.0, std::numeric_limits<double>::infinity()};
  EXPECT_THAT(report::warnings_of(entry), Contains(HasSubstr("no contact is ahead along Delta")));
}

TEST(Findings, AnAuditThatCanBeSeenIsNamed)
{
  report::ReportModel entry = whole_entry();
  store::AuditSet audit;
  audit.name = "degree_1";
  audit.state = store::GridB::Constant(4, 3, static_cast<std::int8_t>(store::AuditState::free));
  audit.penetration_mm = store::GridD::Zero(4, 3);
  audit.state(1, 2) = static_cast<std::int8_t>(store::AuditState::overlapping);
  audit.penetration_mm(1, 2) = 0.3;
  entry.model.audits = {audit, audit};
  entry.model.audits[1].name = "degree_2";
  entry.model.audits[1].penetration_mm(1, 2) = 0.2;
  EXPECT_THAT(
      report::warnings_of(entry),
      ElementsAre(HasSubstr("degree_1 by up to 0.3 mm (1 of 12 attitudes overlap), degree_2 by up to 0.2")));
  entry.model.audits[0].penetration_mm(1, 2) = 0.1;
  EXPECT_THAT(report::warnings_of(entry), ElementsAre(HasSubstr("degree_2")));
  entry.model.audits[1].penetration_mm(1, 2) = 0.1;
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
}

TEST(Findings, RotationThatIsNotCertainIsSaid)
{
  report::ReportModel entry = equilibrium_entry();
  entry.model.theta_determined(0, 0) = entry.model.theta_determined(0, 1) =
      entry.model.theta_determined(0, 2) = 0;
  entry.model.equilibrium->spine.n_optima[1] = 3;
  entry.model.theta_deg(2, 1) += 5.0;
  const std::vector<std::string> lines = report::warnings_of(entry);
  EXPECT_THAT(lines, Contains(HasSubstr("in 25 % of the solved")));
  EXPECT_THAT(lines, Contains(HasSubstr("1 of 4 flexions have several equilibria, up to 6.5 degrees")));
  // Theta of an attitude whose axes turn with Delta follows the other rotations too.
  EXPECT_THAT(lines, testing::Not(Contains(HasSubstr("jumps by"))));
  Points& delta = entry.model.push.delta;
  delta = Eigen::RowVector3d::UnitY().replicate(delta.rows(), 1);
  EXPECT_THAT(report::warnings_of(entry),
              Contains(HasSubstr("jumps by 5.2 degrees")));  // 0.2 per degree of flexion without the jump
}

TEST(Findings, ForcesOutOfBalanceAreSaid)
{
  report::ReportModel entry = equilibrium_entry();
  const double allowed_n = 1e-2 * report::motion_summary(entry.model).push_n;
  entry.model.equilibrium->balance_residual_n(2, 2) = 0.99 * allowed_n;
  EXPECT_THAT(report::warnings_of(entry), IsEmpty());
  entry.model.equilibrium->balance_residual_n(2, 2) = 1.5 * allowed_n;
  EXPECT_THAT(report::warnings_of(entry), Contains(HasSubstr("The balance of forces has a residual")));
}

TEST(Findings, ASpineAtTheBorderAsksForMoreVarus)
{
  report::ReportModel entry = whole_entry();
  entry.model.is_spine(3, 1) = 0;
  entry.model.is_spine(3, 2) = 1;
  EXPECT_THAT(report::warnings_of(entry),
              Contains(HasSubstr("At 1 flexions the compartments balance at the border")));
}

TEST(Findings, ZeroVarusSaysWhereItIsNotMeasured)
{
  report::ReportModel entry = whole_entry();
  entry.model.zero_varus.emplace();
  entry.model.zero_varus->source = {0, 1, 1, -1};
  entry.model.zero_varus->is_cut_off = {1, 0, 0, 0};
  EXPECT_THAT(report::warnings_of(entry),
              AllOf(Contains(HasSubstr("Zero varus at 1 of 4 flexions: the band with both contacts reaches")),
                    Contains(HasSubstr("interpolated between two varus columns at 2 of 4")),
                    Contains(HasSubstr("1 of 4 flexions have no zero-varus pose"))));
}

TEST(Findings, NumbersAreThoseOfTheModel)
{
  const report::MotionSummary n = report::motion_summary(equilibrium_entry().model);
  EXPECT_EQ(n.n_cells, 12);
  EXPECT_EQ(n.n_stable, 12);
  EXPECT_EQ(n.theta_undetermined_share, 0.0);
  EXPECT_NEAR(n.balance_residual_n, 1e-4 * 12, 1e-15);
  EXPECT_NEAR(n.worst_gap_mm, -1e-6 * 11, 1e-15);
  EXPECT_NEAR(n.largest_strain, 0.001, 1e-15);
  EXPECT_EQ(n.n_several_optima, 0);
  const report::MotionSummary search = report::motion_summary(whole_entry().model);
  EXPECT_TRUE(std::isnan(search.balance_residual_n));
  EXPECT_TRUE(std::isnan(search.largest_strain));
  // theta is 0.2 degrees per degree of flexion
  EXPECT_NEAR(search.rotation.net_deg, 0.6, 1e-12);
  EXPECT_NEAR(search.rotation.change_deg, 0.6, 1e-12);
  EXPECT_NEAR(search.spine_jump.change_deg, 0.2, 1e-12);
}

// The data in a page; every other part is that of a report.
Json result_data_of(const std::string& page)
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
  const Json data = result_data_of(page).at("laxity");
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
  const Json data = result_data_of(page).at("range");
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
  const Json data = result_data_of(report::range_comparison_page(small_range(), small_range())).at("range");
  ASSERT_EQ(data.at("volumes").size(), 5U);
  EXPECT_EQ(data.at("volumes")[2].at("cells"), 1) << "both";
  EXPECT_EQ(data.at("volumes")[3].at("cells"), 0) << "the first only";
  EXPECT_FALSE(data.contains("ends"));
}

}  // namespace vrda::page_test
