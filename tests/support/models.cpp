#include "support/models.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "support/meshes.hpp"

namespace vrda::test {
namespace {

void add_component(Body& body, const Component& component, const Mesh& mesh)
{
  const auto index = static_cast<std::int32_t>(body.components.size());
  body.components.push_back(component);
  append(body.contact.mesh, mesh);
  body.contact.component.resize(static_cast<std::size_t>(body.contact.mesh.triangles.rows()), index);
}

}  // namespace

void solve_cell(store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus,
                const store::PoseCoordinates& numbers)
{
  const auto i = static_cast<std::size_t>(flexion), j = static_cast<std::size_t>(varus);
  const Side side = model.side == "left" ? Side::left : Side::right;
  const SolverFrame frame{side, model.rotation_centre_mm, model.push.delta.row(flexion).transpose()};
  const Attitude attitude{rad_from_deg(model.flexion_deg[i]),
                          rad_from_deg(model.varus_solved_deg(flexion, varus))};
  const MovingPose pose{solver_translation_mm(frame, {numbers[0], numbers[1], numbers[2]}),
                        rad_from_deg(numbers[3])};
  const Pose X = X_reference_moving(frame, attitude, pose);
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(
      &model.X_reference_moving[16 * (i * model.varus_deg.size() + j)]) = X.matrix();
  model.tx_mm(flexion, varus) = numbers[0];
  model.ty_mm(flexion, varus) = numbers[1];
  model.tz_mm(flexion, varus) = numbers[2];
  model.theta_deg(flexion, varus) = numbers[3];
  const auto clinical = in_files(clinical_coordinates(X, side, model.rotation_centre_mm));
  for (std::size_t k = 0; k < clinical.size(); ++k) model.clinical[k](flexion, varus) = clinical[k];
  for (store::GridB& grid : model.is_in_contact) grid(flexion, varus) = 1;
  model.theta_determined(flexion, varus) = 1;
  model.status(flexion, varus) = status_stable;
}

store::GridD grid_values(const store::MotionModel& model, const store::SmoothedSet& set,
                         const store::SmoothedSurface& surface)
{
  const store::AxisRanges ranges = store::axis_ranges(model.flexion_deg, model.varus_deg);
  store::GridD values(model.status.rows(), model.status.cols());
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      values(i, j) = store::evaluate(set, surface, ranges, model.flexion_deg[static_cast<std::size_t>(i)],
                                     model.varus_deg[static_cast<std::size_t>(j)]);
    }
  }
  return values;
}

store::MotionModel model_of(const ModelPlan& plan)
{
  store::MotionModel model;
  model.title = "made by code";
  model.joint = "knee";
  model.side = plan.side;
  model.method = "stability-search";
  model.rotation_centre_mm = plan.rotation_centre_mm;
  model.delta = plan.delta;
  model.flexion_deg = plan.flexion_deg;
  model.varus_deg = plan.varus_deg;
  model = store::with_pending_cells(model);
  for (Eigen::Index i = 0; plan.turning_delta && i < model.status.rows(); ++i) {
    model.push.delta.row(i) = plan.turning_delta(plan.flexion_deg[static_cast<std::size_t>(i)]).transpose();
  }
  if (plan.turning_delta) model.delta = model.push.delta.row(0).transpose();
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      const double flexion_deg = plan.flexion_deg[static_cast<std::size_t>(i)];
      const double varus_deg = plan.varus_deg[static_cast<std::size_t>(j)];
      model.varus_solved_deg(i, j) = plan.free_varus_deg ? plan.free_varus_deg(flexion_deg) : varus_deg;
      solve_cell(model, i, j, plan.motion ? plan.motion(flexion_deg, varus_deg) : store::PoseCoordinates{});
    }
  }
  model.is_spine.col(model.status.cols() / 2) = 1;
  return model;
}

void add_follower(store::MotionModel& model, BodyIndex of, const Eigen::Vector3d& centre_mm,
                  const std::function<JointCoordinates(double, double)>& coordinates)
{
  store::FollowerRows rows;
  rows.body_index = static_cast<std::int32_t>(2 + model.followers.size());
  rows.name = "follower_" + std::to_string(rows.body_index);
  rows.of = static_cast<std::int32_t>(of);
  rows.touches = {0};
  rows.centre_mm = centre_mm;
  rows.body.name = rows.name;
  rows.body.components = {{"bead", "bone"}};
  rows.body.contact.mesh = box(centre_mm, {4, 6, 8});
  rows.body.contact.component.assign(static_cast<std::size_t>(rows.body.contact.mesh.triangles.rows()), 0);
  rows.status = model.status;
  for (store::GridD& grid : rows.coordinates) grid.resize(model.status.rows(), model.status.cols());
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      const JointCoordinates q = coordinates(model.flexion_deg[static_cast<std::size_t>(i)],
                                             model.varus_deg[static_cast<std::size_t>(j)]);
      const Pose X = follower_pose(q, side_named(model.side), centre_mm);
      for (Eigen::Index k = 0; k < 16; ++k) rows.X_of_follower.push_back(X.matrix()(k / 4, k % 4));
      for (std::size_t k = 0; k < n_joint_coordinates; ++k) rows.coordinates[k](i, j) = in_files(q)[k];
    }
  }
  model.followers.push_back(std::move(rows));
}

store::MotionModel frames_of(const store::MotionModel& column, const std::vector<std::size_t>& order,
                             const std::vector<double>& keys)
{
  store::MotionModel model = column;
  model.frames = store::FrameSequence{"time_s", keys};
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto to = static_cast<Eigen::Index>(i), from = static_cast<Eigen::Index>(order[i]);
    model.flexion_deg[i] = column.flexion_deg[order[i]];
    for (auto member : {&store::MotionModel::tx_mm, &store::MotionModel::ty_mm, &store::MotionModel::tz_mm,
                        &store::MotionModel::theta_deg, &store::MotionModel::varus_solved_deg})
      (model.*member)(to, 0) = (column.*member)(from, 0);
    model.push.delta.row(to) = column.push.delta.row(from);
    std::copy_n(&column.X_reference_moving[16 * order[i]], 16, &model.X_reference_moving[16 * i]);
  }
  model.delta = model.push.delta.row(0).transpose();
  return model;
}

void unsolve(store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus)
{
  const auto column = static_cast<std::size_t>(varus), row = static_cast<std::size_t>(flexion);
  store::MotionModel pending = store::with_pending_cells(model);
  for (const auto grid : {&store::MotionModel::tx_mm, &store::MotionModel::ty_mm, &store::MotionModel::tz_mm,
                          &store::MotionModel::theta_deg, &store::MotionModel::varus_solved_deg}) {
    (model.*grid)(flexion, varus) = (pending.*grid)(flexion, varus);
  }
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    model.clinical[k](flexion, varus) = pending.clinical[k](flexion, varus);
  for (store::GridB& grid : model.is_in_contact) grid(flexion, varus) = -1;
  model.theta_determined(flexion, varus) = -1;
  std::fill_n(model.X_reference_moving.begin() +
                  static_cast<std::ptrdiff_t>(16 * (row * model.varus_deg.size() + column)),
              16, std::numeric_limits<double>::quiet_NaN());
  model.status(flexion, varus) = static_cast<std::int8_t>(StepStatus::no_contact);
}

void add_smoothed(store::MotionModel& model, int degree,
                  const std::function<store::PoseCoordinates(int, int)>& coefficient)
{
  store::SmoothedSet set;
  set.degree = degree;
  set.surfaces.resize(4);
  set.exponents.resize((degree + 1) * (degree + 2) / 2, 2);
  Eigen::Index k = 0;
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) {
      set.exponents.row(k++) << i, j;
      const store::PoseCoordinates numbers = coefficient(i, j);
      for (std::size_t surface = 0; surface < 4; ++surface) {
        set.surfaces[surface].coefficients.push_back(numbers[surface]);
      }
    }
  }
  const std::array<const char*, 4> names{"tx", "ty", "tz", "theta"};
  for (std::size_t number = 0; number < 4; ++number) {
    store::SmoothedSurface& surface = set.surfaces[number];
    surface.name = names[number];
    surface.values = grid_values(model, set, surface);
    surface.n_cells = static_cast<std::int32_t>(model.status.size());
    surface.condition_number = 1.0;
  }
  model.smoothed.push_back(set);
}

void add_bodies(store::MotionModel& model)
{
  const auto placed = [&](Mesh mesh) {
    mesh.vertices_mm.rowwise() += model.rotation_centre_mm.transpose();
    return mesh;
  };
  model.reference.name = "femur";
  model.moving.name = "tibmen";
  add_component(model.reference, {"ball", "bone"}, placed(ball(20)));
  add_component(model.moving, {"block", "bone"}, placed(box({0, -30, 0}, {40, 10, 60})));
  add_component(model.moving, {"plate", "meniscus"}, placed(box({0, -22.5, 0}, {30, 5, 40})));
  model.compartment_of_triangle.assign(model.moving.contact.component.size(), 0);
}

store::MotionModel small_model()
{
  ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30};
  plan.varus_deg = {-1, 0, 1};
  store::MotionModel model = model_of(plan);
  add_bodies(model);
  unsolve(model, 1, 2);
  add_smoothed(model, 1, [](int i, int) { return store::PoseCoordinates{0.0, 0.0, 0.0, 2.0 * i}; });
  return model;
}

store::MotionModel small_sequence()
{
  ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30};
  plan.varus_deg = {0};
  store::MotionModel model = frames_of(model_of(plan), {2, 0, 3, 1}, {0.0, 0.5, 1.0, 2.0});
  add_bodies(model);
  return model;
}

}  // namespace vrda::test
