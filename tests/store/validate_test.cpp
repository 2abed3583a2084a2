// Motion models whose values break a rule: what the finding names.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "store/changed_file.hpp"
#include "store/motion_model_file.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::validate_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

void expect_finding(const test::Damage& damage)
{
  test::expect_finding(test::sample_model(), damage);
}

TEST(Validate, RootAttributes)
{
  expect_finding({"/@joint", "\"elbow\"", "\"knee\", \"other\"", [](MotionModel& m) { m.joint = "elbow"; }});
  expect_finding({"/@side", "\"\"", "\"right\", \"left\"", [](MotionModel& m) { m.side = ""; }});
  expect_finding(
      {"/@method", "\"magic\"", "\"stability-search\"", [](MotionModel& m) { m.method = "magic"; }});
  expect_finding({"/@rotation_centre_mm", "nan at entry 1", "finite numbers",
                  [](MotionModel& m) { m.rotation_centre_mm.y() = nan; }});
  // Finite, but what is made of it would not be.
  expect_finding({"/@rotation_centre_mm", "2e+300 at entry 0", "none beyond 1e9",
                  [](MotionModel& m) { m.rotation_centre_mm.x() = 2e300; }});
  expect_finding({"/@delta", "length 2", "length 1", [](MotionModel& m) { m.delta *= 2.0; }});
  expect_finding({"/@delta", "another direction", "first row of /push/delta",
                  [](MotionModel& m) { m.push.delta.row(0) << 1.0, 0.0, 0.0; }});
  expect_finding(
      {"/@contact_resolution_mm", "0", "positive", [](MotionModel& m) { m.contact_resolution_mm = 0.0; }});
}

TEST(Validate, Axes)
{
  expect_finding({"/flexion", "at entry 1", "at least 1e-6 apart", [](MotionModel& m) {
                    m.flexion_deg[1] = m.flexion_deg[0] + 1e-9;
                    m.smoothed.clear();
                  }});
  expect_finding({"/flexion", "at entry 2", "strictly increasing", [](MotionModel& m) {
                    m.flexion_deg[2] = m.flexion_deg[1];
                    m.smoothed.clear();
                  }});
  expect_finding({"/varus", "nan at entry 0 (the first of 2)", "strictly increasing", [](MotionModel& m) {
                    m.varus_deg[0] = nan;
                    m.smoothed.clear();
                  }});
}

TEST(Validate, Cells)
{
  expect_finding({"/status", "77 at entry 5", "flag_values", [](MotionModel& m) { m.status(1, 2) = 77; }});
  expect_finding({"/tx", "nan at entry 0", "NaN elsewhere", [](MotionModel& m) { m.tx_mm(0, 0) = nan; }});
  expect_finding(
      {"/theta", "3 at entry 5", "NaN elsewhere", [](MotionModel& m) { m.theta_deg(1, 2) = 3.0; }});
  expect_finding({"/clinical/anterior", "inf at entry 1", "NaN elsewhere",
                  [](MotionModel& m) { m.clinical.anterior_mm(0, 1) = infinity; }});
  expect_finding({"/iterations", "-4 at entry 2", "from 0", [](MotionModel& m) { m.iterations(0, 2) = -4; }});
  expect_finding({"/queries", "-1 at entry 3", "from 0", [](MotionModel& m) { m.queries(1, 0) = -1; }});
  expect_finding({"/residual", "inf", "NaN", [](MotionModel& m) { m.residual_mm(0, 0) = infinity; }});
  expect_finding({"/gap_medial_mm", "0.5 at entry 5", "NaN elsewhere",
                  [](MotionModel& m) { m.gap_medial_mm(1, 2) = 0.5; }});
  expect_finding(
      {"/gap_lateral_mm", "inf", "number or NaN", [](MotionModel& m) { m.gap_lateral_mm(0, 0) = infinity; }});
  expect_finding(
      {"/contact_medial", "-1 at entry 0", "0 or 1", [](MotionModel& m) { m.contact_medial(0, 0) = -1; }});
  expect_finding({"/contact_lateral", "1 at entry 5", "-1 elsewhere",
                  [](MotionModel& m) { m.contact_lateral(1, 2) = 1; }});
  expect_finding({"/theta_determined", "2 at entry 0 (the first of 3)", "0 or 1",
                  [](MotionModel& m) { m.theta_determined.row(0) = 2; }});
  expect_finding(
      {"/plausibility", "7", "a code of flag_values", [](MotionModel& m) { m.plausibility(0, 0) = 7; }});
  expect_finding({"/plausibility", "1", "-1 where status is not stable", [](MotionModel& m) {
                    m.plausibility = (m.status == 0).select(m.plausibility, std::int8_t{1});
                  }});
  expect_finding({"/is_spine", "several", "at most one", [](MotionModel& m) { m.is_spine(3, 2) = 1; }});
  expect_finding({"/is_spine", "9", "0 to 1", [](MotionModel& m) { m.is_spine(3, 2) = 9; }});
}

TEST(Validate, Poses)
{
  const char* wanted = "a rotation and a translation";
  expect_finding({"/X_reference_moving", "no rigid pose at entry 4", wanted,
                  [](MotionModel& m) { m.X_reference_moving[64] += 1e-6; }});
  expect_finding(
      {"/X_reference_moving", "no rigid pose at entry 0 (the first of 2)", wanted, [](MotionModel& m) {
         for (const std::size_t entry : {0u, 1u, 2u, 4u, 5u, 6u, 8u, 9u, 10u})
           m.X_reference_moving[entry] *= -1.0;
         m.X_reference_moving[31] = 2.0;
       }});
  expect_finding({"/X_reference_moving", "numbers in an unsolved cell at entry 5", wanted,
                  [](MotionModel& m) { m.X_reference_moving[83] = 1.0; }});
}

TEST(Validate, Contacts)
{
  expect_finding({"/contacts/row_start", "at entry 3", "never falling",
                  [](MotionModel& m) { m.contacts.row_start[2] = 8; }});
  expect_finding({"/contacts/row_start", "22 at entry 12", "number of contacts", [](MotionModel& m) {
                    m.contacts.row_start.back() = 22;
                    const std::size_t n = 24;
                    m.contacts.point_world_mm.setZero(static_cast<Eigen::Index>(n), 3);
                    m.contacts.normal_world =
                        Eigen::RowVector3d(0, 1, 0).replicate(static_cast<Eigen::Index>(n), 1);
                    m.contacts.distance_mm.resize(n);
                    m.contacts.triangle_reference.resize(n);
                    m.contacts.triangle_moving.resize(n);
                    m.contacts.compartment.resize(n);
                  }});
  expect_finding({"/contacts/point", "nan at entry 4", "finite",
                  [](MotionModel& m) { m.contacts.point_world_mm(1, 1) = nan; }});
  expect_finding({"/contacts/normal", "length 0 at entry 6", "unit vectors",
                  [](MotionModel& m) { m.contacts.normal_world.row(6).setZero(); }});
  expect_finding(
      {"/contacts/distance", "inf", "finite", [](MotionModel& m) { m.contacts.distance_mm[0] = infinity; }});
  expect_finding({"/contacts/triangle_reference", "168 at entry 3", "0 to 167",
                  [](MotionModel& m) { m.contacts.triangle_reference[3] = 168; }});
  expect_finding({"/contacts/triangle_moving", "-1 at entry 21", "0 to 167",
                  [](MotionModel& m) { m.contacts.triangle_moving.back() = -1; }});
  expect_finding(
      {"/contacts/compartment", "3", "0 to 2", [](MotionModel& m) { m.contacts.compartment[0] = 3; }});
}

TEST(Validate, Bodies)
{
  expect_finding({"/bodies/reference/vertices", "nan at entry 3", "finite",
                  [](MotionModel& m) { m.reference.contact.mesh.vertices_mm(1, 0) = nan; }});
  expect_finding({"/bodies/reference/visual/vertices", "nan", "finite",
                  [](MotionModel& m) { m.reference.visual.mesh.vertices_mm(0, 0) = nan; }});
  expect_finding({"/bodies/moving/triangles", "86 at entry 2", "0 to 85",
                  [](MotionModel& m) { m.moving.contact.mesh.triangles(0, 2) = 86; }});
  expect_finding({"/bodies/moving/component", "2 at entry 7", "0 to 1",
                  [](MotionModel& m) { m.moving.contact.component[7] = 2; }});
  expect_finding({"/bodies/moving/normals", "length 3", "unit vectors",
                  [](MotionModel& m) { m.moving.contact.mesh.normals.row(5) *= 3.0; }});
  expect_finding({"/bodies/moving/component_name", "\"tibmen\" at entry 0", "differ",
                  [](MotionModel& m) { m.moving.components[1].name = m.moving.components[0].name; }});
  expect_finding({"/bodies/moving/triangles", "no triangles", "at least one", [](MotionModel& m) {
                    m.moving.contact.mesh.triangles.resize(0, 3);
                    m.moving.contact.component.clear();
                    m = with_pending_cells(m);
                  }});
}

TEST(Validate, Smoothed)
{
  expect_finding({"/smoothed/degree_1/exponents", "0, 2", "once",
                  [](MotionModel& m) { m.smoothed[0].exponents(2, 1) = 2; }});
  expect_finding({"/smoothed/degree_1/exponents", "1, 0", "once",
                  [](MotionModel& m) { m.smoothed[0].exponents.row(2) << 1, 0; }});
  expect_finding({"/smoothed/degree_1/exponents", "-1, 0", "once",
                  [](MotionModel& m) { m.smoothed[0].exponents(0, 0) = -1; }});
  expect_finding({"/smoothed/degree_2/exponents", "3 terms", "6 terms for degree 2",
                  [](MotionModel& m) { m.smoothed[0].degree = 2; }});
  expect_finding({"/smoothed/degree_21", "degree 21", "from 0 to 20",
                  [](MotionModel& m) { m.smoothed[0].degree = 21; }});
  expect_finding({"/smoothed/degree_1/tz", "at entry 1", "the value of the polynomial",
                  [](MotionModel& m) { m.smoothed[0].surfaces[2].values(0, 1) += 1e-6; }});
}

TEST(Validate, Job)
{
  expect_finding({"/job/input_sha256", "\"abc\" at entry 1", "64 hexadecimal digits",
                  [](MotionModel& m) { m.job.inputs[1].sha256 = "abc"; }});
}

TEST(Validate, EveryBrokenRuleIsListed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  MotionModel model = test::sample_model();
  model.side = "both";
  model.tx_mm(0, 0) = nan;
  model.contacts.compartment[0] = -7;
  write_motion_model(path, model);
  std::vector<std::string> places;
  for (const Finding& finding : validate_hdf5(path)) places.push_back(finding.where);
  EXPECT_EQ(places, (std::vector<std::string>{"/@side", "/tx", "/contacts/compartment"}));
}

}  // namespace vrda::validate_test
