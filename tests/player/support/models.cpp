#include "player/support/models.hpp"

#include <limits>

#include "core/units.hpp"
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

MotionModel model_of(const ModelPlan& plan)
{
  MotionModel model;
  model.title = "made by code";
  model.joint = "knee";
  model.side = plan.side;
  model.method = "stability-search";
  model.rotation_centre_mm = plan.rotation_centre_mm;
  model.delta = plan.delta;
  model.flexion_deg = plan.flexion_deg;
  model.varus_deg = plan.varus_deg;
  const auto rows = static_cast<Eigen::Index>(plan.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(plan.varus_deg.size());
  for (GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg})
    *grid = GridD::Zero(rows, columns);
  model.status = GridB::Zero(rows, columns);
  model.is_spine = GridB::Zero(rows, columns);
  model.is_spine.col(columns / 2) = 1;
  const SolverFrame frame{plan.side == "left" ? Side::left : Side::right, plan.rotation_centre_mm,
                          plan.delta};
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < columns; ++j) {
      const double flexion_deg = plan.flexion_deg[static_cast<std::size_t>(i)];
      const double varus_deg = plan.varus_deg[static_cast<std::size_t>(j)];
      const PoseNumbers numbers = plan.motion ? plan.motion(flexion_deg, varus_deg) : PoseNumbers{};
      model.tx_mm(i, j) = numbers[0];
      model.ty_mm(i, j) = numbers[1];
      model.tz_mm(i, j) = numbers[2];
      model.theta_deg(i, j) = numbers[3];
      const MovingPose pose{solver_translation_mm(frame, {numbers[0], numbers[1], numbers[2]}),
                            rad_from_deg(numbers[3])};
      const Pose X = X_reference_moving(frame, {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)}, pose);
      for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column)
          model.X_reference_moving.push_back(X.matrix()(row, column));
      }
    }
  }
  return model;
}

void unsolve(MotionModel& model, Eigen::Index flexion, Eigen::Index varus)
{
  model.status(flexion, varus) = static_cast<std::int8_t>(StepStatus::no_contact);
  for (GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    (*grid)(flexion, varus) = std::numeric_limits<double>::quiet_NaN();
  }
}

void add_smoothed(MotionModel& model, int degree, const std::function<PoseNumbers(int, int)>& coefficient)
{
  SmoothedSet set;
  set.degree = degree;
  for (const char* name : {"tx", "ty", "tz", "theta"}) {
    set.surfaces.emplace_back();
    set.surfaces.back().name = name;
  }
  set.exponents.resize((degree + 1) * (degree + 2) / 2, 2);
  Eigen::Index k = 0;
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) {
      set.exponents.row(k++) << i, j;
      const PoseNumbers numbers = coefficient(i, j);
      for (std::size_t surface = 0; surface < 4; ++surface) {
        set.surfaces[surface].coefficients.push_back(numbers[surface]);
      }
    }
  }
  model.smoothed.push_back(set);
}

void add_bodies(MotionModel& model)
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
}

}  // namespace vrda::test
