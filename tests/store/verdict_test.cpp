#include "store/verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/fields_json.hpp"
#include "core/units.hpp"
#include "support/models.hpp"

namespace vrda::verdict_test {

using store::Standing;
using store::Verdict;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Rounding of rotation products applied to coordinates of hundreds of mm.
constexpr double rounding = 1e-11;

using Rotation = std::function<double(double flexion_deg)>;

std::vector<double> flexions(double from_deg, double to_deg, double step_deg = 5.0)
{
  std::vector<double> all;
  for (double flexion_deg = from_deg; flexion_deg <= to_deg; flexion_deg += step_deg)
    all.push_back(flexion_deg);
  return all;
}

/// The tibia turns by `rotation` and moves forwards by `forward_mm` up to 90 degrees, in contact on both
/// sides.
store::MotionModel knee(const Rotation& rotation, double forward_mm = 6.0,
                        const std::vector<double>& flexion_deg = flexions(0, 90),
                        const std::string& side = "right")
{
  test::ModelPlan plan;
  plan.side = side;
  plan.flexion_deg = flexion_deg;
  plan.varus_deg = {-2, 0, 2};
  plan.rotation_centre_mm = {31.0, 47.0, side == "left" ? -83.0 : 83.0};
  plan.motion = [&](double flexion, double /*varus*/) {
    return store::PoseCoordinates{forward_mm * flexion / 90.0, 0.0, 0.0, rotation(flexion)};
  };
  store::MotionModel model = test::model_of(plan);
  model.gap_mm[0].setZero();
  model.gap_mm[1].setZero();
  return model;
}

/// 10 degrees at 60 degrees of flexion, then 7.5 at 90.
double parabola(double flexion_deg)
{
  const double s = flexion_deg / 60.0;
  return 10.0 * s * (2.0 - s);
}

/// 12 degrees at 90 degrees of flexion, 55.6 % of it at 30.
double rising(double flexion_deg)
{
  const double s = flexion_deg / 90.0;
  return 12.0 * s * (2.0 - s);
}

const store::VerdictMeasure& measure(const Verdict& verdict, const std::string& name)
{
  const auto found = std::ranges::find(verdict.measures, name, &store::VerdictMeasure::name);
  EXPECT_NE(found, verdict.measures.end()) << name;
  return *found;
}

std::vector<std::string> outside(const Verdict& verdict)
{
  std::vector<std::string> names;
  for (const store::VerdictMeasure& m : verdict.measures)
    if (m.standing == Standing::below || m.standing == Standing::above) names.push_back(m.name);
  return names;
}

/// Sets the centre of contact on the tibia, x only, at the spine's cells.
void set_contacts(store::MotionModel& model, double medial_mm, double lateral_mm)
{
  const std::size_t n_varus = model.varus_deg.size();
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    const std::size_t x = 3 * (i * n_varus + 1);
    model.contact_paths->at(0).moving_mm[x] = 5.0 + medial_mm * model.flexion_deg[i] / 90.0;
    model.contact_paths->at(1).moving_mm[x] = 2.0 + lateral_mm * model.flexion_deg[i] / 90.0;
  }
}

TEST(Verdict, MeasuresOfAParabola)
{
  store::MotionModel model = knee(parabola, 8.0);
  set_contacts(model, -9.0, -13.5);
  const Verdict verdict = *store::verdict_of(model, "raw");
  // The femur's centre moves back by the tibia's travel seen along the turned tibia, the facets also turn.
  const double turn_rad = rad_from_deg(7.5);
  const double middle_mm = -8.0 * std::cos(turn_rad), arc_mm = 22.0 * std::sin(turn_rad);
  struct Row {
    const char* name;
    double value, flexion_deg;
  };
  for (const Row& row :
       {Row{"net_internal_rotation", 7.5, 90}, Row{"peak_internal_rotation", 10.0, 60},
        Row{"drop_after_peak", 2.5, 90}, Row{"largest_change_per_5", 10.0 * 23.0 / 144.0, 0},
        Row{"middle_travel", middle_mm, 90}, Row{"medial_facet_travel", middle_mm + arc_mm, 90},
        Row{"lateral_facet_travel", middle_mm - arc_mm, 90}, Row{"medial_contact_travel", -9.0, 90},
        Row{"lateral_contact_travel", -13.5, 90}}) {
    SCOPED_TRACE(row.name);
    EXPECT_NEAR(measure(verdict, row.name).value, row.value, rounding);
    EXPECT_EQ(measure(verdict, row.name).flexion_deg, row.flexion_deg);
  }
  EXPECT_NEAR(measure(verdict, "share_by_30").value, 75.0, rounding);
  EXPECT_THAT(outside(verdict), IsEmpty());
  EXPECT_EQ(verdict.sentence,
            "From 0 to 90 degrees of flexion the motion is within the published range (spread assumed).");
}

// The same motion between flexions of the grid, and on a grid that begins before 0 and ends beyond 90.
TEST(Verdict, FromZeroToNinetyOfALongerMotion)
{
  const Verdict whole = *store::verdict_of(knee(rising), "raw");
  const Verdict longer = *store::verdict_of(knee(rising, 6.0, flexions(-10, 120)), "raw");
  for (const store::VerdictMeasure& m : whole.measures) {
    if (std::isfinite(m.value)) {
      EXPECT_NEAR(measure(longer, m.name).value, m.value, rounding) << m.name;
    }
  }
  const Verdict between = *store::verdict_of(knee(rising, 6.0, flexions(-2, 98, 4)), "raw");
  // A chord of 4 degrees is below the parabola by at most 12 (2 / 90)^2.
  EXPECT_NEAR(measure(between, "net_internal_rotation").value, 12.0, 0.006);
  EXPECT_EQ(between.from_flexion_deg, 0.0);
  EXPECT_EQ(between.to_flexion_deg, 90.0);
}

TEST(Verdict, OfAMirroredKneeHasTheSameBits)
{
  store::MotionModel right = knee(parabola), left = knee(parabola, 6.0, flexions(0, 90), "left");
  set_contacts(right, -9.0, -13.5);
  set_contacts(left, -9.0, -13.5);
  const nlohmann::ordered_json expected = *store::verdict_of(right, "raw");
  const nlohmann::ordered_json found = *store::verdict_of(left, "raw");
  EXPECT_EQ(found.dump(), expected.dump());
}

// Delta that is not proximal changes the axis of the grid, not the joint's own flexion.
TEST(Verdict, IsOverTheJointsOwnFlexion)
{
  const store::MotionModel model = knee(parabola);
  store::MotionModel turned = model;
  turned.push.delta.rowwise() = Eigen::Vector3d(0.1, 1.0, 0.0).normalized().transpose();
  for (double& flexion_deg : turned.flexion_deg) flexion_deg += 1.5;
  const Verdict expected = *store::verdict_of(model, "raw"), found = *store::verdict_of(turned, "raw");
  EXPECT_NEAR(found.to_flexion_deg, 90.0, rounding);
  for (const char* name : {"net_internal_rotation", "peak_internal_rotation", "lateral_facet_travel"})
    EXPECT_NEAR(measure(found, name).value, measure(expected, name).value, rounding) << name;
}

TEST(Verdict, NamesWhatIsOutside)
{
  struct Row {
    Rotation rotation;
    double forward_mm;
    std::vector<std::string> outside;
  };
  const auto none = [](double) { return 0.0; };
  const auto jump = [](double flexion_deg) {
    return rising(flexion_deg) + (flexion_deg >= 10.0 ? 3.0 : 0.0);
  };
  const auto late = [](double flexion_deg) { return 12.0 * flexion_deg / 90.0; };
  const auto dip = [](double flexion_deg) {
    return 0.9 * parabola(flexion_deg) - std::max(0.0, 4.0 - 0.4 * std::abs(flexion_deg - 70.0));
  };
  const auto falling = [](double flexion_deg) { return 1.3 * parabola(flexion_deg); };
  for (const Row& row :
       {Row{rising, 6, {}}, Row{none, 6, {"net_internal_rotation"}}, Row{jump, 6, {"largest_change_per_5"}},
        Row{late, 6, {"share_by_30"}}, Row{falling, 6, {"drop_after_peak"}}, Row{dip, 6, {"drop_after_peak"}},
        Row{rising, -1, {"middle_travel", "medial_facet_travel", "lateral_facet_travel"}}}) {
    const Verdict verdict = *store::verdict_of(knee(row.rotation, row.forward_mm), "raw");
    SCOPED_TRACE(verdict.sentence);
    EXPECT_EQ(outside(verdict), row.outside);
    for (const std::string& name : row.outside)
      EXPECT_THAT(verdict.sentence, HasSubstr(measure(verdict, name).label));
    EXPECT_THAT(verdict.sentence, HasSubstr(row.outside.empty() ? "within the" : "outside the"));
  }
}

// Only a range that is published itself is not marked; it is the nearest one to a peak at 40 degrees.
TEST(Verdict, MarksAssumedSpreads)
{
  const auto peak_at_40 = [](double flexion_deg) {
    return flexion_deg <= 40.0 ? 0.3 * flexion_deg : 12.0 - 0.02 * (flexion_deg - 40.0);
  };
  const Verdict verdict = *store::verdict_of(knee(peak_at_40), "raw");
  for (const store::VerdictMeasure& m : verdict.measures)
    EXPECT_EQ(m.is_spread_assumed, m.name != "peak_internal_rotation") << m.name;
  for (const std::string& line : store::lines_of(verdict)) {
    if (line.find("published ") == std::string::npos || line.find("From") != std::string::npos) continue;
    EXPECT_EQ(line.find("spread assumed") == std::string::npos,
              line.find("peak internal") != std::string::npos)
        << line;
  }
}

TEST(Verdict, MissingFlexions)
{
  struct Row {
    double from_deg, to_deg;
    const char* sentence;
  };
  for (const Row& row : {Row{10, 90, "No verdict"}, Row{0, 30, "No verdict"}, Row{45, 90, "No verdict"},
                         Row{5, 90, "From 5 to 90 degrees of flexion the motion"},
                         Row{0, 60, "From 0 to 60 degrees of flexion (the last below 90)"}}) {
    SCOPED_TRACE(row.sentence);
    const Verdict verdict = *store::verdict_of(knee(rising, 6.0, flexions(row.from_deg, row.to_deg)), "raw");
    EXPECT_THAT(verdict.sentence, HasSubstr(row.sentence));
    EXPECT_EQ(verdict.measures.empty(), row.sentence[0] == 'N');
    EXPECT_THAT(store::lines_of(verdict), testing::Contains(HasSubstr(row.sentence)));
  }
  store::MotionModel frames = knee(rising);
  frames.frames = store::FrameSequence{"time_s", frames.flexion_deg};
  EXPECT_THAT(store::verdict_of(frames, "raw")->sentence, HasSubstr("a sequence of frames"));
  store::MotionModel hip = knee(rising);
  hip.joint = "hip";
  EXPECT_FALSE(store::verdict_of(hip, "raw").has_value());
}

// The last flexion without a pose ends the motion; the first one begins it later.
TEST(Verdict, UnsolvedEnds)
{
  store::MotionModel model = knee(rising);
  for (const Eigen::Index row : {0, 18}) test::unsolve(model, row, 1);
  const Verdict verdict = *store::verdict_of(model, "raw");
  EXPECT_EQ(verdict.from_flexion_deg, 5.0);
  EXPECT_EQ(verdict.to_flexion_deg, 85.0);
  EXPECT_NEAR(measure(verdict, "net_internal_rotation").value, rising(85) - rising(5), rounding);
}

TEST(Verdict, LiftOffOfTheRawAndTheTwoSidedMotion)
{
  store::MotionModel model = knee(rising);
  model.gap_mm[1](1, 1) = model.gap_mm[1](2, 1) = 0.146;
  model.gap_mm[1](3, 1) = 0.144;
  model.gap_mm[0](18, 1) = nan;
  model.gap_mm[0](5, 0) = 3.0;  // not a cell of the spine
  const std::vector<store::LiftOff> raw = *store::verdict_of(model, "raw")->lift_off;
  EXPECT_THAT(raw[0].flexion_deg, ElementsAre(90.0));
  EXPECT_THAT(raw[0].from_deg, ElementsAre(90.0));
  EXPECT_THAT(raw[0].to_deg, ElementsAre(90.0));
  EXPECT_THAT(raw[1].flexion_deg, ElementsAre(5.0, 10.0));
  EXPECT_THAT(raw[1].from_deg, ElementsAre(5.0));
  EXPECT_THAT(raw[1].to_deg, ElementsAre(10.0));
  store::TwoSided motion;
  motion.flexion_deg = flexions(0, 90, 2.5);
  for (const double flexion_deg : motion.flexion_deg) {
    motion.contact.push_back(store::code_of(store::TwoSidedContact::both));
    motion.tx_mm.push_back(6.0 * flexion_deg / 90.0);
    motion.theta_deg.push_back(rising(flexion_deg));
    for (auto* column : {&motion.ty_mm, &motion.tz_mm, &motion.varus_deg, &motion.gap_mm[0]})
      column->push_back(0.0);
    motion.gap_mm[1].push_back(flexion_deg == 87.5 ? 1.0 : -1.0);
  }
  model.two_sided = motion;
  const Verdict two_sided = *store::verdict_of(model, "two_sided");
  EXPECT_NEAR(measure(two_sided, "net_internal_rotation").value, 12.0, rounding);
  EXPECT_THAT((*two_sided.lift_off)[0].flexion_deg, IsEmpty());
  EXPECT_THAT((*two_sided.lift_off)[1].flexion_deg, ElementsAre(87.5));
  EXPECT_EQ(two_sided.contacts_of, "raw");
}

TEST(Verdict, NamesWhatIsFoundOfFollowers)
{
  // A kneecap that lags by a third is within; one that hardly turns is not.
  store::MotionModel model = knee(rising);
  const auto add = [&](const char* name, double share) {
    test::add_follower(model, BodyIndex::reference, {40, 0, 0}, [&](double flexion_deg, double) {
      JointCoordinates q = JointCoordinates::Zero();
      q(0) = rad_from_deg(share * flexion_deg);
      q(5) = 0.1 * flexion_deg;
      return q;
    });
    store::FollowerRows& rows = model.followers.back();
    rows.name = name;
    rows.plausibility = store::GridB::Zero(rows.status.rows(), rows.status.cols());
  };
  add("patella", 2.0 / 3.0);
  add("fabella", 1.0);
  Verdict verdict = *store::verdict_of(model, "raw");
  EXPECT_NEAR(measure(verdict, "patellar_flexion_share").value, 200.0 / 3.0, rounding);
  EXPECT_EQ(measure(verdict, "patellar_flexion_share").standing, Standing::within);
  EXPECT_NEAR(measure(verdict, "patellar_shift").value, 6.0, rounding);
  EXPECT_EQ(measure(verdict, "patellar_shift").standing, Standing::within);
  EXPECT_THAT(verdict.followers, IsEmpty());
  EXPECT_EQ(verdict.sentence.find("patella"), std::string::npos);

  model.followers[0].coordinates[JointCoordinate::flexion] *= 0.6;
  model.followers[0].coordinates[JointCoordinate::lateral] *= 1.5;
  const auto set = [](store::GridB& grid, Eigen::Index row, auto code) {
    grid(row, 1) = static_cast<std::int8_t>(code);
  };
  for (const Eigen::Index row : {17, 18}) set(model.followers[0].plausibility, row, Plausibility::dislocated);
  set(model.followers[0].status, 3, StepStatus::unbounded);
  set(model.followers[0].plausibility, 3, Plausibility::not_judged);
  model.followers[0].plausibility(5, 0) = 4;  // not a cell of the spine
  verdict = *store::verdict_of(model, "raw");
  EXPECT_THAT(outside(verdict), testing::IsSupersetOf({"patellar_flexion_share", "patellar_shift"}));
  EXPECT_THAT(verdict.sentence,
              HasSubstr("; patella: dislocated at 2 flexions; patella: unbounded at 1 flexion."));
  ASSERT_EQ(verdict.followers.size(), 2u);
  EXPECT_THAT(verdict.followers[0].from_deg, ElementsAre(85.0));
  EXPECT_THAT(verdict.followers[0].to_deg, ElementsAre(90.0));
  EXPECT_THAT(store::lines_of(verdict), testing::Contains("  patella: unbounded at flexion 15"));
}

TEST(Verdict, SaysTheShareOfThePrior)
{
  Verdict verdict = *store::verdict_of(knee(rising), "raw");
  EXPECT_EQ(verdict.sentence.find("prior"), std::string::npos);
  verdict.prior_share = 0.8;
  EXPECT_THAT(store::sentence_of(verdict), HasSubstr("; decided by the prior to 80 %."));
}

}  // namespace vrda::verdict_test
