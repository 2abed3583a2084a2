// Sets derived from the raw surfaces: recontacted, with their own varus, zero-varus.
// Derived data in a motion model: order, replacement and removal.
#include <gmock/gmock.h>

#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "store/solved_cells.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"

namespace vrda::derived_motion_test {

using test::model_of;
using test::ModelPlan;

// Rounding of rotation products applied to coordinates of hundreds of mm.
constexpr double rounding = 1e-11;

Attitude attitude_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

Eigen::Vector3d turning_delta(double flexion_deg)
{
  return Eigen::Vector3d(0.1 + 0.004 * flexion_deg, 1.0, -0.3).normalized();
}

ModelPlan plan_of(const std::string& side)
{
  ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {430.0, 510.0, side == "left" ? -75.0 : 75.0};
  return plan;
}

// Degree two in each angle, which the patches reproduce.
double travel_mm(double flexion_deg, double varus_deg)
{
  return 0.3 - 0.0001 * flexion_deg * flexion_deg + 0.02 * varus_deg * flexion_deg - 0.05 * varus_deg;
}

/// A set "degree_1_recontacted" with travel_mm at every attitude.
store::MotionModel recontacted_model(const ModelPlan& plan)
{
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 1, [](int i, int j) {
    return store::PoseCoordinates{1.0 * i, -20.0, 3.0 + j, 8.0};
  });
  store::GridD travel(model.status.rows(), model.status.cols());
  for (Eigen::Index i = 0; i < travel.rows(); ++i) {
    for (Eigen::Index j = 0; j < travel.cols(); ++j) {
      travel(i, j) = travel_mm(plan.flexion_deg[static_cast<std::size_t>(i)],
                               plan.varus_deg[static_cast<std::size_t>(j)]);
    }
  }
  model.smoothed.front().recontact_mm = travel;
  return model;
}

TEST(RecontactedSet, IsShiftedByTheTravelAlongDeltaAtAndBetweenTheNodes)
{
  for (const std::string side : {"right", "left"}) {
    ModelPlan plan = plan_of(side);
    plan.turning_delta = turning_delta;
    const store::MotionModel model = recontacted_model(plan);
    const store::Motion plain(model, "degree_1"), recontacted(model, "degree_1_recontacted");
    for (const Attitude& at : {attitude_deg(0, -4), attitude_deg(90, 4), attitude_deg(45, 0),
                               attitude_deg(37, 1.3), attitude_deg(81, -3.9)}) {
      const store::JointPose a = plain.at(at), b = recontacted.at(at);
      const double expected_mm = travel_mm(deg_from_rad(at.flexion_rad), deg_from_rad(at.varus_rad));
      EXPECT_EQ(b.status, store::PoseStatus::solved);
      EXPECT_EQ(a.theta_rad, b.theta_rad);
      const Eigen::Vector3d shift = b.X_world_moving.translation() - a.X_world_moving.translation();
      EXPECT_LT((shift - expected_mm * recontacted.delta(at.flexion_rad)).norm(), rounding);
    }
  }
}

/// Free varus, 0.5 - 2 P_1 + 3 P_2 degrees in the smoothed set.
store::MotionModel own_varus_model()
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 0.1 * flexion_deg; };
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 2, [](int i, int) { return store::PoseCoordinates{1.0 * i, -20.0, 3.0, 8.0}; });
  store::SmoothedSet& set = model.smoothed.front();
  store::SmoothedSurface varus = set.surfaces.front();
  varus.name = "varus";
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    const double by_degree[3] = {0.5, -2.0, 3.0};
    varus.coefficients[static_cast<std::size_t>(k)] =
        set.exponents(k, 1) == 0 ? by_degree[set.exponents(k, 0)] : 0.0;
  }
  set.surfaces.push_back(varus);
  return model;
}

TEST(SmoothedSet, WithAVarusSurfaceHasItsVarus)
{
  const store::MotionModel model = own_varus_model();
  const store::Motion smoothed(model, "degree_2"), raw(model, "raw");
  for (const double flexion_deg : {0.0, 10.0, 45.0, 77.0, 90.0}) {
    const double u = flexion_deg / 45.0 - 1.0;
    const double expected_rad = rad_from_deg(0.5 - 2.0 * u + 1.5 * (3.0 * u * u - 1.0));
    const store::JointPose pose = smoothed.at(attitude_deg(flexion_deg, 0));
    EXPECT_NEAR(pose.attitude.varus_rad, expected_rad, rounding);
    EXPECT_TRUE(pose.is_varus_clamped);
    EXPECT_EQ(smoothed.balanced_varus_rad(rad_from_deg(flexion_deg)), pose.attitude.varus_rad);
    EXPECT_NEAR(raw.at(attitude_deg(flexion_deg, 0)).attitude.varus_rad, rad_from_deg(0.1 * flexion_deg),
                rounding);
    // The reference is rotated to that varus.
    EXPECT_LT((pose.X_world_reference.linear() - reference_rotation(pose.attitude)).norm(), rounding);
  }
  EXPECT_TRUE(smoothed.is_varus_free());
  EXPECT_NEAR(smoothed.last_varus_rad(), rad_from_deg(5.5), rounding);  // at 0 degrees
}

store::ZeroVarus table_of(const store::MotionModel& model)
{
  store::ZeroVarus table;
  for (const double f : model.flexion_deg) {
    table.source.push_back(static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
    table.varus_deg.push_back(-1.0 + 0.0005 * f * f);
    table.tx_mm.push_back(-0.001 * f * f);
    table.ty_mm.push_back(-20.0 + 0.01 * f);
    table.tz_mm.push_back(1.0);
    table.theta_deg.push_back(12.0 - 0.1 * f);
  }
  return table;
}

TEST(ZeroVarusSet, KnowsFlexionAloneAndReproducesSurfacesOfDegreeTwo)
{
  store::MotionModel model = model_of(plan_of("left"));
  model.zero_varus = table_of(model);
  const store::Motion motion(model, "zero_varus");
  EXPECT_TRUE(motion.is_varus_free());
  for (const double f : {0.0, 15.0, 22.0, 61.0, 90.0}) {
    const store::JointPose pose = motion.at(attitude_deg(f, 2.0));
    EXPECT_EQ(pose.status, store::PoseStatus::solved);
    EXPECT_TRUE(pose.is_varus_clamped);
    EXPECT_NEAR(pose.attitude.varus_rad, rad_from_deg(-1.0 + 0.0005 * f * f), rounding);
    EXPECT_NEAR(pose.theta_rad, rad_from_deg(12.0 - 0.1 * f), rounding);
    const Eigen::Vector3d expected_mm(-0.001 * f * f, -20.0 + 0.01 * f, 1.0);
    EXPECT_LT((pose.X_world_moving * model.rotation_centre_mm - expected_mm).norm(), rounding);
    EXPECT_EQ(motion.balanced_varus_rad(rad_from_deg(f)), pose.attitude.varus_rad);
  }
  EXPECT_TRUE(motion.at(attitude_deg(95, 0)).is_flexion_clamped);
  EXPECT_NEAR(motion.first_varus_rad(), rad_from_deg(-1.0), rounding);
}

TEST(ZeroVarusSet, BridgesNoHole)
{
  store::MotionModel model = model_of({});
  model.zero_varus = table_of(model);
  model.zero_varus->source[3] = static_cast<std::int8_t>(store::ZeroVarusSource::none);  // 45 degrees
  model.zero_varus->tx_mm[3] = model.zero_varus->varus_deg[3] = nan;
  const store::Motion motion(model, "zero_varus");
  EXPECT_EQ(motion.at(attitude_deg(45, 0)).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(motion.at(attitude_deg(40, 0)).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(motion.at(attitude_deg(60, 0)).status, store::PoseStatus::solved);
  EXPECT_FALSE(std::isnan(motion.balanced_varus_rad(rad_from_deg(45))));
}

TEST(SetNames, ShowFirstWhatNeitherOverlapsNorGapes)
{
  store::MotionModel model = recontacted_model({});
  test::add_smoothed(model, 4, [](int, int) { return store::PoseCoordinates{}; });
  model.zero_varus = table_of(model);
  EXPECT_EQ(store::set_names(model),
            (std::vector<std::string>{"degree_4", "degree_1_recontacted", "degree_1", "raw", "zero_varus"}));
  for (const std::string& name : store::set_names(model)) {
    EXPECT_EQ(store::Motion(model, name).at({}).status, store::PoseStatus::solved);
  }
  EXPECT_THROW(store::Motion(model, "degree_4_recontacted"), InternalError);
  // A table without poses is not a motion.
  model.zero_varus->source.assign(model.flexion_deg.size(),
                                  static_cast<std::int8_t>(store::ZeroVarusSource::none));
  EXPECT_EQ(store::set_names(model).back(), "raw");
  EXPECT_THROW(store::Motion(model, "zero_varus"), InternalError);
}

// Everything that names no set follows it; without it, files before 1.10 keep what they showed.
TEST(DefaultMotion, IsTheModelsIfItStillHasTheSet)
{
  store::MotionModel model = recontacted_model({});
  EXPECT_EQ(store::default_motion(model).set, "degree_1_recontacted");
  model.default_motion = store::DefaultMotion{"raw", "why"};
  EXPECT_EQ(store::default_motion(model).set, "raw");
  EXPECT_EQ(store::default_motion(model).reason, "why");
  EXPECT_EQ(store::chosen_set(model, "knee.h5", ""), "raw");
  EXPECT_EQ(store::chosen_set(model, "knee.h5", "degree_1"), "degree_1");
  model.default_motion->set = "degree_9";
  EXPECT_EQ(store::default_motion(model).set, "degree_1_recontacted");
  EXPECT_EQ(store::default_motion(model).reason, "");
}

// Products of rotations acting on coordinates of hundreds of mm.
constexpr double rounding_mm = 1e-11;

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

Eigen::Vector3d at(const std::vector<double>& path_mm, std::size_t cell)
{
  return Eigen::Map<const Eigen::Vector3d>(&path_mm[3 * cell]);
}

/// One cell at one attitude, with a generic pose of the moving object.
store::MotionModel one_cell(const std::string& side, const Eigen::Vector3d& delta)
{
  store::MotionModel model;
  model.side = side;
  model.method = "stability-search";
  model.delta = delta;
  model.rotation_centre_mm = {430.0, 510.0, -75.0};
  model.flexion_deg = {30.0};
  model.varus_deg = {0.0};
  model = store::with_pending_cells(model);
  const SolverFrame frame{side == "left" ? Side::left : Side::right, model.rotation_centre_mm, delta};
  const Attitude attitude{rad_from_deg(30.0), rad_from_deg(-2.0)};
  model.varus_solved_deg(0, 0) = -2.0;  // varus was free: differs from the axis
  const Matrix4 X = X_reference_moving(frame, attitude, {{1.0, -40.0, 2.0}, 0.2}).matrix();
  model.X_reference_moving.assign(X.data(), X.data() + 16);
  model.status(0, 0) = 0;
  return model;
}

void add_contact(store::MotionModel& model, std::int8_t compartment, const Eigen::RowVector3d& point_world_mm)
{
  store::ContactRows& contacts = model.contacts;
  contacts.point_world_mm.conservativeResize(contacts.point_world_mm.rows() + 1, 3);
  contacts.point_world_mm.bottomRows(1) = point_world_mm;
  contacts.compartment.push_back(compartment);
  contacts.row_start = {0, static_cast<std::int64_t>(contacts.compartment.size())};
}

/// Position of a stored point of the reference after solver_mesh() and the attitude.
Eigen::Vector3d world_of_reference(const store::MotionModel& model, const Eigen::Vector3d& p_reference_mm)
{
  const SolverFrame frame{model.side == "left" ? Side::left : Side::right, model.rotation_centre_mm,
                          model.delta};
  Mesh point;
  point.vertices_mm = p_reference_mm.transpose();
  const Eigen::Vector3d p_solver = solver_mesh(point, frame).vertices_mm.row(0).transpose();
  return world_from_solver(frame, reference_rotation({rad_from_deg(30.0), rad_from_deg(-2.0)}) * p_solver);
}

TEST(ContactPaths, AreTheMeansOfTheContactsInBothBodiesAxes)
{
  for (const std::string side : {"right", "left"}) {
    for (const Eigen::Vector3d& delta :
         {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(Eigen::Vector3d(0.1, 1.0, -0.3).normalized())}) {
      store::MotionModel model = one_cell(side, delta);
      const Eigen::Vector3d first_mm(425.0, 490.0, -97.0), second_mm(427.0, 488.0, -99.0);
      add_contact(model, 1, world_of_reference(model, first_mm).transpose());
      add_contact(model, 0, {100.0, 100.0, 100.0});
      add_contact(model, 1, world_of_reference(model, second_mm).transpose());
      const store::ContactPaths paths = store::contact_paths_of(model);
      const Eigen::Vector3d mean_mm = 0.5 * (first_mm + second_mm);
      EXPECT_LT((at(paths[0].reference_mm, 0) - mean_mm).norm(), rounding_mm);
      const Matrix4 X = Eigen::Map<const Matrix4>(model.X_reference_moving.data());
      const Eigen::Vector4d back = X * at(paths[0].moving_mm, 0).homogeneous();
      EXPECT_LT((back.head<3>() - mean_mm).norm(), rounding_mm);
      EXPECT_TRUE(at(paths[1].reference_mm, 0).array().isNaN().all());
      EXPECT_TRUE(at(paths[1].moving_mm, 0).array().isNaN().all());
    }
  }
}

TEST(ContactPaths, OfAnEquilibriumTheForcesWeigh)
{
  store::MotionModel model = one_cell("right", {0, 1, 0});
  model.method = "equilibrium";
  model.equilibrium.emplace();
  store::ForceRows& forces = model.equilibrium->forces;
  forces.row_start = {0, 2};
  const Eigen::Vector3d first_mm(425.0, 490.0, -52.0), second_mm(429.0, 490.0, -48.0);
  forces.point_world_mm.resize(2, 3);
  forces.point_world_mm.row(0) = world_of_reference(model, first_mm).transpose();
  forces.point_world_mm.row(1) = world_of_reference(model, second_mm).transpose();
  forces.normal_world.resize(2, 3);
  forces.normal_world << 0.0, -1.0, 0.0, 0.6, -0.8, 0.0;
  forces.along_delta_n = {5.0, 12.0};  // forces of 5 and 15 N
  forces.compartment = {2, 2};
  add_contact(model, 2, {0.0, 0.0, 0.0});  // belongs to no compartment
  const store::ContactPaths paths = store::contact_paths_of(model);
  const Eigen::Vector3d mean_mm = 0.25 * first_mm + 0.75 * second_mm;
  EXPECT_LT((at(paths[1].reference_mm, 0) - mean_mm).norm(), rounding_mm);
  EXPECT_TRUE(at(paths[0].reference_mm, 0).array().isNaN().all());
}

TEST(ContactPaths, UnsolvedCellsHaveNone)
{
  const store::MotionModel model = test::sample_model();  // cell (1, 2) failed
  const store::ContactPaths paths = store::contact_paths_of(model);
  EXPECT_TRUE(at(paths[0].reference_mm, 5).array().isNaN().all());
  EXPECT_TRUE(at(paths[0].reference_mm, 4).array().isFinite().all());
}

using testing::NanSensitiveDoubleEq;

// Maximum minus minimum would hide the sign, the place and the speed of the change.
TEST(CurveFigures, MatchTheClosedForms)
{
  struct Row {
    const char* what;
    std::vector<double> flexion_deg, value_deg;
    store::CurveFigures expected;
  };
  const Row rows[] = {
      {"line", {0, 30, 90}, {2, -1, -7}, {0, 90, -9, -9, 90, -0.5, 0, 5}},
      {"external, then back", {0, 10, 20, 40}, {1, -9, -3, 3}, {0, 40, 2, -10, 10, -5, 0, 5}},
      {"jump within the window", {0, 1, 2, 3}, {0, 0, 8, 8}, {0, 3, 8, 8, 2, 8, 1, 2}},
      {"jump beside a corner", {0, 20, 22, 40}, {0, 0, 4, 13}, {0, 40, 13, 13, 40, 5.5, 20, 25}},
      {"a hole is bridged", {0, 5, 10}, {0, nan, 4}, {0, 10, 4, 4, 10, 2, 0, 5}},
      {"frames: no change over flexion", {0, 20, 10}, {0, 6, 5}, {0, 10, 5, 6, 20, nan, nan, nan}},
      {"one value", {0, 5}, {nan, 3}, {}},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.what);
    const store::CurveFigures f = store::curve_figures({row.flexion_deg, row.value_deg});
    EXPECT_THAT(f.first_deg, NanSensitiveDoubleEq(row.expected.first_deg));
    EXPECT_THAT(f.last_deg, NanSensitiveDoubleEq(row.expected.last_deg));
    EXPECT_THAT(f.net_deg, NanSensitiveDoubleEq(row.expected.net_deg));
    EXPECT_THAT(f.peak_deg, NanSensitiveDoubleEq(row.expected.peak_deg));
    EXPECT_THAT(f.peak_at_deg, NanSensitiveDoubleEq(row.expected.peak_at_deg));
    EXPECT_THAT(f.change_deg, NanSensitiveDoubleEq(row.expected.change_deg));
    EXPECT_THAT(f.change_from_deg, NanSensitiveDoubleEq(row.expected.change_from_deg));
    EXPECT_THAT(f.change_to_deg, NanSensitiveDoubleEq(row.expected.change_to_deg));
  }
}

// A hole is no jump; the step of 4 degrees is.
TEST(SpineJump, IsBetweenSolvedNeighbours)
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30, 40};
  plan.varus_deg = {0};
  plan.motion = [](double flexion_deg, double) {
    return store::PoseCoordinates{0, 0, 0, flexion_deg < 15 ? 20.0 : flexion_deg < 35 ? 0.0 : 4.0};
  };
  store::MotionModel model = test::model_of(plan);
  EXPECT_NEAR(store::spine_jump(model).change_deg, 20.0, 1e-12);
  test::unsolve(model, 1, 0);
  const store::SpineJump jump = store::spine_jump(model);
  EXPECT_NEAR(jump.change_deg, 4.0, 1e-12);
  EXPECT_EQ(jump.from_deg, 30.0);
  EXPECT_EQ(jump.to_deg, 40.0);
  EXPECT_EQ(store::text_of(jump), "theta jumps by 4 degrees between flexion 30 and 40 of the spine");
  model.theta_deg(4, 0) = 3.0;
  EXPECT_EQ(store::text_of(store::spine_jump(model)), "");
}

std::vector<std::string> names_of(const std::vector<store::AuditSet>& audits)
{
  std::vector<std::string> names;
  names.reserve(audits.size());
  for (const store::AuditSet& audit : audits) names.push_back(audit.name);
  return names;
}

std::vector<std::string> names_after(const store::MotionModel& model, const store::SmoothedSet& set)
{
  return names_of(store::with_smoothed(model, set).audits);
}

TEST(TwoSidedFigures, CountsPosesWithBothGapsWithinThePerceptible)
{
  store::AuditSet audit;
  audit.state = store::GridB::Zero(1, 7);
  audit.state(0, 6) = store::code_of(store::AuditState::no_pose);
  audit.compartment_gap_mm[0].resize(1, 7);
  audit.compartment_gap_mm[1].resize(1, 7);
  // Both sides at the limits; either side beyond, in either direction; a side that faces nothing; no pose.
  audit.compartment_gap_mm[0] << 0.145, 0.15, 0.0, -0.15, 0.0, nan, 9.0;
  audit.compartment_gap_mm[1] << -0.145, 0.0, 0.3, 0.0, -0.4, 0.0, 0.0;
  const store::TwoSidedFigures f = store::two_sided_figures(audit);
  EXPECT_EQ(f.n_poses, 6);
  EXPECT_EQ(f.n_both_in_contact, 1);
  EXPECT_EQ(f.largest_gap_mm[0], 0.15);
  EXPECT_EQ(f.largest_overlap_mm[0], 0.15);
  EXPECT_EQ(f.largest_gap_mm[1], 0.3);
  EXPECT_EQ(f.largest_overlap_mm[1], 0.4);
  audit.compartment_gap_mm[0].resize(0, 0);
  EXPECT_EQ(store::two_sided_figures(audit).n_poses, 0) << "without compartments";
}

TEST(WithSmoothed, KeepsTheOrderOfDegrees)
{
  store::MotionModel model;
  for (const std::int32_t degree : {6, 2, 10, 4}) {
    store::SmoothedSet set;
    set.degree = degree;
    model = store::with_smoothed(model, set);
  }
  ASSERT_EQ(model.smoothed.size(), 4u);
  EXPECT_EQ(model.smoothed[0].degree, 2);
  EXPECT_EQ(model.smoothed[1].degree, 4);
  EXPECT_EQ(model.smoothed[2].degree, 6);
  EXPECT_EQ(model.smoothed[3].degree, 10);
}

TEST(WithSmoothed, AnAuditOfAnotherMotionGoes)
{
  store::MotionModel model = test::with_derived(test::sample_model());
  model.zero_varus->set = "raw";
  ASSERT_EQ(names_of(model.audits),
            (std::vector<std::string>{"degree_1", "degree_1_recontacted", "raw", "zero_varus"}));
  const std::vector<std::string> none_of_it{"raw", "zero_varus"};
  const std::vector<std::string> as_smoothed{"degree_1", "raw", "zero_varus"};
  store::SmoothedSet set = model.smoothed[0];
  set.surfaces[3].coefficients[0] += 1e-12;
  EXPECT_EQ(names_after(model, set), none_of_it);
  set = model.smoothed[0];
  (*set.recontact_mm)(1, 1) += 1e-12;
  EXPECT_EQ(names_after(model, set), as_smoothed);
  (*set.recontact_mm)(1, 1) = nan;
  EXPECT_EQ(names_after(model, set), as_smoothed);
  set.recontact_mm.reset();
  EXPECT_EQ(names_after(model, set), as_smoothed);
  set.degree = 2;
  EXPECT_EQ(names_after(model, set), names_of(model.audits));
}

TEST(WithSmoothed, AZeroVarusMotionMadeOfAnotherGoesWithItsAudit)
{
  store::MotionModel model = test::with_derived(test::sample_model());
  ASSERT_EQ(model.zero_varus.value_or(store::ZeroVarus()).set, "degree_1");
  store::SmoothedSet set = model.smoothed[0];
  EXPECT_TRUE(store::with_smoothed(model, set).zero_varus.has_value());
  set.recontact_mm.reset();
  EXPECT_TRUE(store::with_smoothed(model, set).zero_varus.has_value())
      << "derived from the set without recontact";
  set.surfaces[0].coefficients[0] += 1e-12;
  const store::MotionModel changed = store::with_smoothed(model, set);
  EXPECT_FALSE(changed.zero_varus.has_value());
  EXPECT_EQ(names_of(changed.audits), std::vector<std::string>{"raw"});
  model.zero_varus->set = "degree_1_recontacted";
  set = model.smoothed[0];
  set.recontact_mm.reset();
  EXPECT_FALSE(store::with_smoothed(model, set).zero_varus.has_value());
}

TEST(MotionAllocation, AnEvaluationAllocatesNothing)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  test::ModelPlan plan;
  plan.turning_delta = [](double flexion_deg) {
    return Eigen::Vector3d(0.001 * flexion_deg, 1.0, 0.0).normalized();
  };
  store::MotionModel model = test::model_of(plan);
  test::unsolve(model, 1, 1);
  test::add_smoothed(model, 6, [](int i, int j) {
    return store::PoseCoordinates{i + 1.0, j + 1.0, 1.0, 2.0};
  });
  model.smoothed.front().recontact_mm = store::GridD::Constant(model.status.rows(), model.status.cols(), 0.1);
  const std::vector<double> column(model.flexion_deg.size(), 1.0);
  store::ZeroVarus table;
  table.source.assign(column.size(), static_cast<std::int8_t>(store::ZeroVarusSource::free));
  table.varus_deg = table.tx_mm = table.ty_mm = table.tz_mm = table.theta_deg = column;
  model.zero_varus = table;
  for (const std::string& set : store::set_names(model)) {
    const store::Motion motion(model, set);
    const long before = test::allocations_of_program();
    double sum = 0.0;
    int n_solved = 0;
    for (int k = 0; k < 1000; ++k) {
      const double flexion_rad = rad_from_deg(0.11 * k - 5.0);
      const store::JointPose pose =
          motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad) + rad_from_deg(0.01 * k - 6.0)});
      sum += pose.X_reference_moving.linear().trace();
      n_solved += pose.status == store::PoseStatus::solved ? 1 : 0;
    }
    EXPECT_EQ(test::allocations_of_program() - before, 0) << set;
    EXPECT_GT(n_solved, 700);
    EXPECT_GT(sum, 0.0);
  }
  // The counter works.
  const long before = test::allocations_of_program();
  ::operator delete(::operator new(1));
  EXPECT_GE(test::allocations_of_program() - before, 1);
}

}  // namespace vrda::derived_motion_test
