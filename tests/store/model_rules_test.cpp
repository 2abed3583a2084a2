// Rules between the datasets of a motion model: the object that the finding names.
#include <gmock/gmock.h>

#include <limits>

#include "store/changed_file.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::model_rules_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void expect_finding(const test::Damage& damage)
{
  test::expect_finding(test::sample_model(), damage);
}

/// For a model with every dataset; its fifth cell is not solved.
void expect_finding_in_whole(const test::Damage& damage)
{
  test::expect_finding(test::whole_model(), damage);
}

TEST(ModelRules, RootAttributes)
{
  expect_finding(
      {"/@joint", "\"elbow\"", "\"knee\", \"hip\"", [](store::MotionModel& m) { m.joint = "elbow"; }});
  expect_finding({"/@side", "\"\"", "\"right\", \"left\"", [](store::MotionModel& m) { m.side = ""; }});
  expect_finding(
      {"/@method", "\"magic\"", "\"stability-search\"", [](store::MotionModel& m) { m.method = "magic"; }});
  expect_finding({"/@rotation_centre_mm", "nan at entry 1", "finite numbers",
                  [](store::MotionModel& m) { m.rotation_centre_mm.y() = nan; }});
  // Finite, but derived values would overflow.
  expect_finding({"/@rotation_centre_mm", "2e+300 at entry 0", "up to 1e9",
                  [](store::MotionModel& m) { m.rotation_centre_mm.x() = 2e300; }});
  expect_finding({"/@delta", "length 2", "length 1", [](store::MotionModel& m) { m.delta *= 2.0; }});
  expect_finding({"/@delta", "a different direction", "first row of /push/delta",
                  [](store::MotionModel& m) { m.push.delta.row(0) << 1.0, 0.0, 0.0; }});
  expect_finding({"/@contact_resolution_mm", "0", "positive",
                  [](store::MotionModel& m) { m.contact_resolution_mm = 0.0; }});
}

TEST(ModelRules, Cells)
{
  expect_finding({"/plausibility", "1", "-1 where status is not stable", [](store::MotionModel& m) {
                    m.plausibility = (m.status == 0).select(m.plausibility, std::int8_t{1});
                  }});
  expect_finding(
      {"/is_spine", "several", "at most one", [](store::MotionModel& m) { m.is_spine(3, 2) = 1; }});
  expect_finding({"/varus_solved", "-1.5 at entry 0", "axis has several",
                  [](store::MotionModel& m) { m.varus_solved_deg(0, 0) = -1.5; }});
  expect_finding({"/flexion", "at entry 1", "at least 1e-6 apart", [](store::MotionModel& m) {
                    m.flexion_deg[1] = m.flexion_deg[0] + 1e-9;
                    m.smoothed.clear();
                  }});
  expect_finding({"/bodies/moving/triangles", "no triangles", "at least one", [](store::MotionModel& m) {
                    m.moving.contact.mesh.triangles.resize(0, 3);
                    m.moving.contact.component.clear();
                    m.compartment_of_triangle.clear();
                    m = store::with_pending_cells(m);
                  }});
}

TEST(ModelRules, AFreeVarusMayDifferFromTheAxis)
{
  const test::SampleOptions one_column{4, 1, true, false, false};
  test::expect_finding(test::sample_model(one_column), {"/@side", "both", "right", [](store::MotionModel& m) {
                                                          m.varus_solved_deg(2, 0) = 3.25;
                                                          m.side = "both";
                                                        }});
}

TEST(ModelRules, Equilibrium)
{
  expect_finding_in_whole({"/equilibrium@band_moment_nmm", "-1", "0 or a moment",
                           [](store::MotionModel& m) { m.equilibrium->band_moment_nmm = -1.0; }});
  expect_finding_in_whole({"/ligaments@transition_strain", "0", "above 0",
                           [](store::MotionModel& m) { m.ligaments->transition_strain = 0.0; }});
  expect_finding_in_whole({"/equilibrium/forces/normal", "at entry 2", "oppose Delta",
                           [](store::MotionModel& m) { m.equilibrium->forces.normal_world.row(3) *= -1.0; }});
  expect_finding_in_whole({"/equilibrium/spine/branches/is_chosen", "2 at entry 1", "one chosen",
                           [](store::MotionModel& m) { m.equilibrium->spine.branches.is_chosen[2] = 1; }});
  expect_finding_in_whole({"/equilibrium/spine/branches/row_start", "2 equilibria at entry 1", "n_optima",
                           [](store::MotionModel& m) { m.equilibrium->spine.n_optima[1] = 3; }});
}

TEST(ModelRules, Smoothed)
{
  expect_finding({"/smoothed/degree_1/exponents", "0, 2", "once",
                  [](store::MotionModel& m) { m.smoothed[0].exponents(2, 1) = 2; }});
  expect_finding({"/smoothed/degree_1/exponents", "1, 0", "once",
                  [](store::MotionModel& m) { m.smoothed[0].exponents.row(2) << 1, 0; }});
  expect_finding({"/smoothed/degree_1/exponents", "-1, 0", "once",
                  [](store::MotionModel& m) { m.smoothed[0].exponents(0, 0) = -1; }});
  expect_finding({"/smoothed/degree_2/exponents", "3 terms", "6 terms for degree 2",
                  [](store::MotionModel& m) { m.smoothed[0].degree = 2; }});
  expect_finding({"/smoothed/degree_21", "degree 21", "from 0 to 20",
                  [](store::MotionModel& m) { m.smoothed[0].degree = 21; }});
  expect_finding({"/smoothed/degree_1/tz", "at entry 1", "the value of the polynomial",
                  [](store::MotionModel& m) { m.smoothed[0].surfaces[2].values(0, 1) += 1e-6; }});
}

TEST(ModelRules, ASurfaceOfVarusNeedsAFreeOne)
{
  expect_finding({"/smoothed/degree_1/varus_solved", "a surface", "where /varus has several values",
                  [](store::MotionModel& m) {
                    m.smoothed[0].surfaces.push_back(m.smoothed[0].surfaces[0]);
                    m.smoothed[0].surfaces[4].name = "varus";
                  }});
  const store::MotionModel free = test::with_derived(test::sample_model({4, 1, true, true, false}));
  test::expect_finding(free, {"/smoothed/degree_1/varus_solved", "at entry 2", "the value of the polynomial",
                              [](store::MotionModel& m) { m.smoothed[0].surfaces[4].values(2, 0) += 1e-6; }});
}

TEST(ModelRules, ZeroVarus)
{
  expect_finding_in_whole(
      {"/zero_varus@set", "raws", "degree_N", [](store::MotionModel& m) { m.zero_varus->set = "raws"; }});
  expect_finding_in_whole({"/default_motion@set", "\"smooth\"", "two_sided",
                           [](store::MotionModel& m) { m.default_motion->set = "smooth"; }});
  expect_finding_in_whole({"/zero_varus/source", "free at entry 1", "one value",
                           [](store::MotionModel& m) { m.zero_varus->source[1] = 2; }});
  expect_finding_in_whole({"/zero_varus/varus", "-0.9 at entry 2", "the mean of varus_first and varus_last",
                           [](store::MotionModel& m) { m.zero_varus->varus_deg[2] += 0.1; }});
  expect_finding_in_whole(
      {"/zero_varus/varus_last", "at entry 0", "at least varus_first", [](store::MotionModel& m) {
         std::swap(m.zero_varus->varus_first_deg[0], m.zero_varus->varus_last_deg[0]);
       }});
  expect_finding_in_whole(
      {"/zero_varus/helical_direction", "length 2 at entry 1", "unit vectors", [](store::MotionModel& m) {
         for (std::size_t k = 3; k < 6; ++k) m.zero_varus->helical_direction[k] *= 2.0;
       }});
}

TEST(ModelRules, Audits)
{
  expect_finding_in_whole(
      {"/audit/raw@refine", "0", "at least 1", [](store::MotionModel& m) { m.audits[2].refine = 0; }});
  expect_finding_in_whole({"/audit/raw/penetration", "0.25 at entry 1", "0 where state is free",
                           [](store::MotionModel& m) { m.audits[2].penetration_mm(0, 1) = 0.25; }});
}

TEST(ModelRules, Frames)
{
  const auto expect = [](const test::Damage& damage) { test::expect_finding(test::frames_model(), damage); };
  expect({"/frame", "0.25 at entry 2", "strictly increasing",
          [](store::MotionModel& m) { m.frames->key[2] = m.frames->key[1]; }});
  expect({"/frame", "nan at entry 3", "finite", [](store::MotionModel& m) { m.frames->key[3] = nan; }});
  expect({"/audit/raw/frame", "at entry 1", "strictly increasing",
          [](store::MotionModel& m) { m.audits[0].frame_key[1] = -1.0; }});
  expect({"/flexion", "nan at entry 1", "finite", [](store::MotionModel& m) { m.flexion_deg[1] = nan; }});
  expect({"/varus", "other values", "value 0", [](store::MotionModel& m) { m.varus_deg[0] = 1.0; }});
  for (const std::string& name :
       {std::string(), std::string("Time"), std::string("a,b"), std::string(41, 'a')})
    expect({"/frame@key_name", name.c_str(), "lower-case",
            [&](store::MotionModel& m) { m.frames->key_name = name; }});
  expect({"/zero_varus", "a zero-varus motion", "nothing in a sequence of frames", [](store::MotionModel& m) {
            m.zero_varus = test::with_derived(test::sample_model({6, 1, true, true, false})).zero_varus;
          }});
  expect({"/two_sided", "a two-sided motion", "nothing in a sequence of frames", [](store::MotionModel& m) {
            m.two_sided = test::with_derived(test::sample_model({6, 1, true, true, false})).two_sided;
          }});
  expect({"/smoothed", "a smoothed motion", "nothing in a sequence of frames", [](store::MotionModel& m) {
            m.smoothed = test::sample_model({6, 1, true, true, false}).smoothed;
          }});
  expect({"/audit/zero_varus", "an audit", "nothing in a sequence of frames", [](store::MotionModel& m) {
            m.audits.push_back(m.audits[0]);
            m.audits[1].name = "zero_varus";
          }});
}

TEST(ModelRules, WithoutFramesFlexionIsAnAxis)
{
  expect_finding({"/flexion", "1 at entry 3", "strictly increasing", [](store::MotionModel& m) {
                    m.flexion_deg[3] = 1.0;
                    m.smoothed.clear();
                  }});
}

TEST(ModelRules, EveryBrokenRuleIsListed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::MotionModel model = test::sample_model();
  model.side = "both";
  model.tx_mm(0, 0) = nan;
  model.contacts.compartment[0] = -7;
  store::write_motion_model(path, model);
  std::vector<std::string> places;
  for (const store::Finding& finding : store::validate_hdf5(path)) places.push_back(finding.where);
  EXPECT_EQ(places, (std::vector<std::string>{"/@side", "/tx", "/contacts/compartment"}));
}

}  // namespace vrda::model_rules_test
