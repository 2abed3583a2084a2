// Identification of a plate held by fibres in closed form, and the offset of two plates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <random>

#include "analysis/fit_files.hpp"
#include "analysis/identification.hpp"
#include "analysis/offset_fit.hpp"
#include "analysis/plates.hpp"
#include "core/files.hpp"
#include "core/units.hpp"
#include "job/job_parts.hpp"
#include "model/frames.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::analysis::identification_test {

// With two slack fibres in front and two behind.
job::Case plates()
{
  job::Case plates = test::two_plates();
  for (const double z_mm : {-10.0, 10.0}) {
    for (const bool is_front : {false, true})
      test::add_fibre(plates, is_front ? "front" : "back", is_front, z_mm, 1000.0);
  }
  return plates;
}

Unknown strain_of(const std::string& name, std::vector<std::size_t> rows)
{
  Unknown unknown;
  unknown.name = "reference_strain " + name;
  unknown.fibres = std::move(rows);
  unknown.sd = 0.03;
  unknown.from = -0.1;
  unknown.to = 0.1;
  return unknown;
}

/// The strains of both bundles and a varus moment, which no laxity along the plates depends on.
struct PlateQuestion {
  job::Case job_case = plates();
  FitData data;
  IdentifyPlan plan;

  explicit PlateQuestion(const Eigen::Vector3d& truth)
  {
    Unknown moment;
    moment.name = "varus_moment";
    moment.quantity = job::InputQuantity::load;
    moment.load = job::InputLoad::varus_moment;
    moment.sd = 1.0;
    moment.from = -2.0;
    moment.to = 2.0;
    plan.unknowns = {strain_of("back", {0, 2}), strain_of("front", {1, 3}), moment};
    plan.fit.noise.fill(0.05);
    data.laxity = &job_case;
    data.loads.flexion_deg = {0.0};
    data.loads.anterior_force_n = 120.0;
    LaxityPlan measured;
    measured.loads = data.loads;
    const LaxityResult result = laxity_of(changed_case(job_case, plan.unknowns, truth), measured);
    for (const LaxityCurve& curve : result.curves) {
      for (const double load_n : {24.0, 72.0, 120.0})
        data.laxities.push_back(
            {kind_of(curve.test).name, 0.0, load_n, laxity_at_load(curve, load_n), nan, ""});
    }
  }
  PlateQuestion(const PlateQuestion&) = delete;
  PlateQuestion& operator=(const PlateQuestion&) = delete;
};

TEST(Identification, RecoversStrainsThatTheDataDecideAndNamesTheRest)
{
  const Eigen::Vector3d truth(0.02, -0.015, 0.5);
  PlateQuestion question(truth);
  const Identification found = identify(question.data, question.plan);
  EXPECT_EQ(found.status, FitStatus::converged);
  EXPECT_LT(found.misfit_after, 0.01 * found.misfit_before);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(found.unknowns[k].identifiability, Identifiability::decided) << k;
    // The prior draws the estimate towards no change by the share that the data leave.
    const double drawn = (1.0 - found.unknowns[k].explained) * std::abs(truth(static_cast<Eigen::Index>(k)));
    EXPECT_NEAR(found.unknowns[k].change, truth(static_cast<Eigen::Index>(k)), drawn + 1e-3) << k;
  }
  const FittedUnknown& moment = found.unknowns[2];
  EXPECT_EQ(moment.identifiability, Identifiability::undecided);
  EXPECT_NEAR(moment.change, 0.0, 1e-6);
  EXPECT_NEAR(moment.sd, 1.0, 1e-6);  // the prior's
  EXPECT_EQ(found.n_directions, 2u);
  for (const LaxityMisfit& row : found.laxities) EXPECT_NEAR(row.after, row.measured.value, 0.05);
}

// Its unloaded poses are those of the motion, at another row: the same answer as by a spine of its own.
TEST(Identification, ALaxityBesideAMotionStartsFromItsPoses)
{
  const Eigen::Vector3d truth(0.02, -0.015, 0.0);
  PlateQuestion alone(truth), beside(truth);
  job::Case motion = beside.job_case;
  motion.grid.flexion_deg = {-4.0, -2.0, 0.0, 2.0};
  motion.push.resize(4, motion.push.front());
  motion.path_push = motion.push;
  motion.path_flexion_deg = motion.grid.flexion_deg;
  beside.data.motion = &motion;
  std::size_t n_spines = 0;
  constexpr int whole_spine = 0;
  beside.plan.keep = [&](const Evaluation& one) { n_spines += one.kind == whole_spine ? 1 : 0; };
  const Identification expected = identify(alone.data, alone.plan),
                       found = identify(beside.data, beside.plan);
  EXPECT_GT(n_spines, 0u);
  constexpr double slack = 1e-3;  // unloaded, the plates may slide while all fibres are slack
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(found.unknowns[k].change, expected.unknowns[k].change, slack) << k;
}

TEST(Identification, StopsAtABound)
{
  PlateQuestion question(Eigen::Vector3d(0.02, 0.0, 0.0));
  question.plan.unknowns[0].to = 0.01;
  const Identification found = identify(question.data, question.plan);
  EXPECT_EQ(found.unknowns[0].identifiability, Identifiability::at_bound);
  EXPECT_NEAR(found.unknowns[0].change, 0.01, 1e-9);
}

std::string json_of(const Identification& found, const IdentifyPlan& plan)
{
  FitDocument document;
  document.unknowns = plan.unknowns;
  document.found = found;
  return fit_json(document);
}

TEST(Identification, ContinuesWithTheSameBits)
{
  PlateQuestion question(Eigen::Vector3d(0.02, -0.015, 0.0));
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "fit.journal").string();
  const std::string key = identification_key(question.data, question.plan, {"data"});
  EXPECT_NE(identification_key(question.data, question.plan, {"other data"}), key);
  std::size_t n_all = 0;
  std::string whole;
  {
    core::FrameWriter journal = open_evaluations(path, key, true, question.plan.known);
    question.plan.keep = [&](const Evaluation& evaluation) {
      // Half of them survive the interruption.
      if (++n_all % 2 == 0) journal.append(core::bytes_of_value(evaluation));
    };
    whole = json_of(identify(question.data, question.plan), question.plan);
    journal.close();
  }
  std::size_t n_new = 0;
  question.plan.keep = [&](const Evaluation&) { ++n_new; };
  core::FrameWriter journal = open_evaluations(path, key, false, question.plan.known);
  EXPECT_EQ(question.plan.known.size(), n_all / 2);
  question.plan.n_threads = 3;
  EXPECT_EQ(json_of(identify(question.data, question.plan), question.plan), whole);
  EXPECT_EQ(n_new, n_all - n_all / 2);
  journal.close();
  EXPECT_THAT(test::input_error([&] { open_evaluations(path, "another key", false, question.plan.known); }),
              test::refuses({.file = path, .field = "key", .wanted = "--fresh"}));
}

TEST(Identification, AnInterruptedFitSaysSo)
{
  PlateQuestion question(Eigen::Vector3d(0.02, 0.0, 0.0));
  question.plan.is_stopped = [] { return true; };
  EXPECT_TRUE(identify(question.data, question.plan).is_stopped);
}

job::Job generic_knee(const std::string& fit)
{
  return job::parse_job("knee.toml", *read_text_file(VRDA_SOURCE_DIR "/jobs/knee-generic.toml") + fit);
}

constexpr const char* many_unknowns = R"(
[fit]
[[fit.parameter]]
quantity = "reference_strain"
sd = 0.03
from = -0.1
to = 0.1
[[fit.parameter]]
quantity = "attachment"
bundle = "LCL"
shared_by = "fibre"
body = "moving"
axis = "anterior"
sd = 2
from = -5
to = 5
[[fit.parameter]]
quantity = "load"
load = "anterior_force"
flexion_deg = [0, 30, 90]
sd = 10
from = -40
to = 40
)";

TEST(Unknowns, OfBundlesFibresAndAngles)
{
  const job::Job job = generic_knee(many_unknowns);
  const job::Case job_case = job::load_case(job::over_flexions(job, {0.0, 15.0, 60.0, 120.0}), "");
  const std::vector<Unknown> unknowns = unknowns_of(job, job_case);
  ASSERT_EQ(unknowns.size(), 8u + 4u + 3u);
  EXPECT_EQ(unknowns[0].name, "reference_strain ACLam");
  EXPECT_EQ(unknowns[0].fibres.size(), 3u);
  EXPECT_EQ(unknowns[8].name, "attachment moving LCL1 anterior");
  EXPECT_EQ(unknowns[13].name, "anterior_force at 30");
  Eigen::VectorXd change = Eigen::VectorXd::Zero(15);
  change(12) = 4.0;
  change(13) = 10.0;
  change(14) = -20.0;
  const job::Case changed = changed_case(job_case, unknowns, change);
  const double expected_n[] = {4.0, 7.0, -5.0, -20.0};  // linear between the angles, constant beyond
  for (std::size_t k = 0; k < 4; ++k) EXPECT_DOUBLE_EQ(changed.push[k].force_n.x(), expected_n[k]) << k;
  EXPECT_EQ(changed.ligaments.fibres[0].slack_length_mm, job_case.ligaments.fibres[0].slack_length_mm);
}

// Of the fibres at the pose of the meshes.
std::vector<double> strains_of(const model::Ligaments& ligaments)
{
  std::vector<double> strains;
  for (const model::FibreState& state : model::fibre_states(ligaments, {}, {}))
    strains.push_back(state.strain);
  return strains;
}

TEST(FitFiles, TheWrittenFibresHaveTheChangedStrains)
{
  const job::Job job = generic_knee(many_unknowns);
  const job::Case job_case = job::load_case(job::over_flexions(job, {0.0}), "");
  Identification found;
  const std::vector<Unknown> unknowns = unknowns_of(job, job_case);
  found.unknowns.resize(unknowns.size());
  found.unknowns[0].change = 0.02;  // ACLam
  found.unknowns[0].sd = 0.01;
  found.unknowns[8].change = 3.0;  // LCL1 forwards, with its strain kept
  found.unknowns[12].change = 5.0;
  const std::string csv = fitted_ligaments_csv(job, job_case, unknowns, found);
  const test::Scratch scratch;
  scratch.write("fitted.ligaments.csv", csv);
  const std::string text =
      fitted_job_text(job, job_case, {{std::nullopt, "fitted.ligaments.csv"}}, unknowns, found.change());
  EXPECT_THAT(text, testing::HasSubstr("fibres = \"fitted.ligaments.csv\""));
  const std::string fitted_file = scratch.write("fitted.toml", text).string();
  const job::Case fitted = job::load_case(job::over_flexions(job::read_job(fitted_file), {0.0}), "");
  EXPECT_DOUBLE_EQ(fitted.push[0].force_n.x(), 5.0);
  const std::vector<double> before = strains_of(job_case.ligaments), after = strains_of(fitted.ligaments);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    const model::Fibre& fibre = fitted.ligaments.fibres[k];
    // The decimals of the file read back exactly.
    EXPECT_NEAR(after[k] - before[k], fibre.bundle == "ACLam" ? 0.02 : 0.0, 1e-12) << fibre.name;
    const double forward_mm = fibre.moving_mm.x() - job_case.ligaments.fibres[k].moving_mm.x();
    EXPECT_NEAR(forward_mm, fibre.name == "LCL1" ? 3.0 : 0.0, 1e-9) << fibre.name;
  }
  // d l0 = l0 d e / (1 + e)
  const double l0_mm = fitted.ligaments.fibres[0].slack_length_mm;
  const std::string row =
      csv.substr(csv.find("ACLam1,"), csv.find('\n', csv.find("ACLam1,")) - csv.find("ACLam1,"));
  const std::size_t at = row.find(',', row.find(std::to_string(l0_mm).substr(0, 6))) + 1;
  EXPECT_NEAR(std::stod(row.substr(at)), 0.01 * l0_mm / (1.0 + after[0]), 1e-6);
}

constexpr const char* unknowns_of_the_patella = R"(
[fit]
[[fit.parameter]]
quantity = "reference_strain"
follower = "patella"
bundle = "PT"
sd = 0.03
from = -0.1
to = 0.1
[[fit.parameter]]
quantity = "attachment"
follower = "patella"
body = "tibia"
axis = "proximal"
sd = 2
from = -5
to = 5
[[fit.parameter]]
quantity = "load"
follower = "patella"
load = "tension"
sd = 5
from = -30
to = 30
)";

// Of the generic knee, whose patella's fibres are generated: the fitted files, read again with its wraps.
TEST(FitFiles, TheWrittenFibresOfAFollowerHaveTheChangedStrainsEndsAndTension)
{
  const test::Scratch scratch;
  const job::Job job = generic_knee(unknowns_of_the_patella);
  const job::Case job_case = job::load_case(job::over_flexions(job, {0.0}), "");
  const std::vector<Unknown> unknowns = unknowns_of(job, job_case);
  ASSERT_EQ(unknowns.size(), 3u);
  EXPECT_EQ(unknowns[0].name, "patella reference_strain PT");
  EXPECT_EQ(unknowns[1].name, "patella attachment tibia PT proximal");
  EXPECT_EQ(unknowns[2].name, "patella tension");
  Identification found;
  found.unknowns.resize(3);
  for (std::size_t k = 0; k < 3; ++k) found.unknowns[k].change = std::array{0.02, 3.0, 6.0}[k];
  scratch.write("fitted.csv", fitted_ligaments_csv(job, job_case, unknowns, found, 0));
  const std::string text = fitted_job_text(job, job_case, {{0, "fitted.csv"}}, unknowns, found.change());
  const job::Job fitted_job = job::read_job(scratch.write("fitted.toml", text).string());
  const job::Case fitted = job::load_case(job::over_flexions(fitted_job, {0.0}), "");
  EXPECT_NEAR(job::tension_n(fitted.followers[0]), 36.0, 1e-9);
  const std::vector<double> before = job::scan_strains(job_case.followers, 0);
  const std::vector<double> after = job::scan_strains(fitted.followers, 0);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    const model::Fibre &fibre = fitted.followers[0].ligaments.fibres[k],
                       &given = job_case.followers[0].ligaments.fibres[k];
    const bool is_tendon = fibre.bundle == "PT";
    EXPECT_NEAR(after[k] - before[k], is_tendon ? 0.02 : 0.0, 1e-12) << fibre.name;
    EXPECT_NEAR(fibre.reference_mm.y() - given.reference_mm.y(), is_tendon ? 3.0 : 0.0, 1e-9) << fibre.name;
    EXPECT_NEAR((fibre.moving_mm - given.moving_mm).norm(), 0.0, 1e-9) << fibre.name;
    EXPECT_EQ(fibre.wrap, given.wrap) << fibre.name;
  }
}

TEST(FitFiles, ATableOfLoadsKeepsTheAnglesOfTheJob)
{
  const std::string file = VRDA_SOURCE_DIR "/jobs/knee-generic.toml";
  std::string knee = *read_text_file(file);
  const std::string push = "force_n = 20\n";
  ASSERT_NE(knee.find(push), std::string::npos);
  knee.insert(knee.find(push) + push.size(),
              "lateral_force_n = { flexion_deg = [3, 30, 59], value = [[1, 0], [2, 0], [3, 0]] }\n");
  const job::Job job = job::parse_job("knee.toml", knee + many_unknowns);
  const job::Case job_case = job::load_case(job::over_flexions(job, {0.0}), "");
  const std::vector<Unknown> unknowns = unknowns_of(job, job_case);
  const std::string text = fitted_job_text(job, job_case, {}, unknowns, Eigen::VectorXd::Zero(15));
  // Converted from radians, 3, 30 and 59 are off by their last bit, and 30 is in both tables.
  const job::Job fitted = job::parse_job("fitted.toml", text);
  const job::Push at = job::load_case(job::over_flexions(fitted, {30.0}), "").push.front();
  EXPECT_EQ(at.force_n.x(), 2.0);
  EXPECT_EQ(fitted.push.lateral_force_n.flexion_rad,
            (std::vector<double>{0.0, rad_from_deg(3.0), rad_from_deg(30.0), rad_from_deg(59.0),
                                 rad_from_deg(90.0)}));
}

job::Case two_plates()
{
  job::Case plates;
  plates.reference.contact = {test::plate(20.0, false), {0, 0}};
  plates.moving.contact = {test::plate(10.0, true), {0, 0}};
  return plates;
}

OffsetFitInput at_gaps(const std::vector<double>& gaps_mm)
{
  OffsetFitInput input;
  input.moving = {0};
  for (const double gap_mm : gaps_mm) {
    Pose X = Pose::Identity();
    X.translation().y() = -gap_mm;
    input.X_reference_moving.push_back(X);
  }
  return input;
}

TEST(OffsetFit, OfPlatesIsMeanAndStandardErrorOfTheGaps)
{
  const OffsetFit fit = fit_offset(two_plates(), at_gaps({1.2, 1.3, 1.5, 1.1, 1.4}));
  EXPECT_EQ(fit.status, FitStatus::converged);
  EXPECT_NEAR(fit.offset_mm, 1.3, 1e-6);  // settled_mm
  EXPECT_NEAR(fit.travel_per_mm, -1.0, 1e-9);
  // Deviations -0.1, 0, 0.2, -0.2, 0.1: variance 0.1 / 4, of the mean 0.025 / 5.
  EXPECT_NEAR(fit.standard_error_mm, std::sqrt(0.005), 1e-6);
  EXPECT_NEAR(fit.gap_rms_mm, std::sqrt(0.02), 1e-6);
}

// As where walls overlap sideways: the gap along Delta leads out of the joint.
TEST(OffsetFit, AFrameFarFromTheOthersCountsLikeOneAtThreeDeviations)
{
  const OffsetFit fit = fit_offset(two_plates(), at_gaps({1.2, 1.3, 1.5, 1.1, 1.4, -20.0}));
  EXPECT_EQ(fit.status, FitStatus::converged);
  // Median 1.3 and median deviation 0.2: the last one counts as 1.3 - 0.2 * 3 * 1.4826.
  EXPECT_NEAR(fit.offset_mm, (6.5 + 1.3 - 0.6 * 1.4826) / 6.0, 1e-5);
}

// A ball turned by 90 degrees below a plate: Delta belongs to the plate.
TEST(OffsetFit, ADeltaFixedInTheReferenceTurnsAgainstTheMovingObject)
{
  job::Case joint = two_plates();
  const Mesh ball = test::ball(5.0);
  joint.moving.contact = {ball,
                          std::vector<std::int32_t>(static_cast<std::size_t>(ball.triangles.rows()), 0)};
  joint.is_push_fixed_in_reference = true;
  OffsetFitInput input = at_gaps({6.2, 6.4, 6.3});
  for (Pose& X : input.X_reference_moving) X.linear() = rotation_z(rad_from_deg(90.0));
  const OffsetFit fit = fit_offset(joint, input);
  EXPECT_EQ(fit.status, FitStatus::converged);
  EXPECT_NEAR(fit.offset_mm, 1.3, 1e-5);
  joint.is_push_fixed_in_reference = false;
  EXPECT_EQ(fit_offset(joint, input).status, FitStatus::undetermined);
}

TEST(OffsetFit, ItsIntervalHoldsTheTruthAsOftenAsItSays)
{
  std::mt19937 random(26);
  std::normal_distribution<double> noise(0.0, 0.1);
  constexpr int n_trials = 200;
  int n_held = 0;
  for (int trial = 0; trial < n_trials; ++trial) {
    std::vector<double> gaps_mm(40);
    for (double& gap_mm : gaps_mm) gap_mm = 1.3 + noise(random);
    const OffsetFit fit = fit_offset(two_plates(), at_gaps(gaps_mm));
    n_held += std::abs(fit.offset_mm - 1.3) <= 1.96 * fit.standard_error_mm ? 1 : 0;
  }
  // 95 % of 200 with a binomial standard deviation of 3.1; three of them.
  EXPECT_GE(n_held, 180);
  EXPECT_LE(n_held, 199);
}

}  // namespace vrda::analysis::identification_test
