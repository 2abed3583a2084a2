#include "store/motion_model.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "model/frames.hpp"
#include "store/sample_model.hpp"

namespace vrda::contact_paths_test {

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
      EXPECT_LT((at(paths.medial_reference_mm, 0) - mean_mm).norm(), rounding_mm);
      const Matrix4 X = Eigen::Map<const Matrix4>(model.X_reference_moving.data());
      const Eigen::Vector4d back = X * at(paths.medial_moving_mm, 0).homogeneous();
      EXPECT_LT((back.head<3>() - mean_mm).norm(), rounding_mm);
      EXPECT_TRUE(at(paths.lateral_reference_mm, 0).array().isNaN().all());
      EXPECT_TRUE(at(paths.lateral_moving_mm, 0).array().isNaN().all());
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
  EXPECT_LT((at(paths.lateral_reference_mm, 0) - mean_mm).norm(), rounding_mm);
  EXPECT_TRUE(at(paths.medial_reference_mm, 0).array().isNaN().all());
}

TEST(ContactPaths, UnsolvedCellsHaveNone)
{
  const store::MotionModel model = test::sample_model();  // cell (1, 2) failed
  const store::ContactPaths paths = store::contact_paths_of(model);
  EXPECT_TRUE(at(paths.medial_reference_mm, 5).array().isNaN().all());
  EXPECT_TRUE(at(paths.medial_reference_mm, 4).array().isFinite().all());
}

}  // namespace vrda::contact_paths_test
