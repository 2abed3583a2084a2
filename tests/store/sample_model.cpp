#include "store/sample_model.hpp"

#include "core/clinical.hpp"
#include "core/frames.hpp"
#include "core/units.hpp"
#include "store/evaluate_smoothed.hpp"
#include "support/meshes.hpp"

namespace vrda::test {
namespace {

Part part_of(const Mesh& mesh, std::int32_t component)
{
  return {mesh, std::vector<std::int32_t>(static_cast<std::size_t>(mesh.triangles.rows()), component)};
}

Body sample_body(const std::string& name, bool has_visual)
{
  Body body;
  body.name = name;
  body.components = {{name, "bone"}, {name + " shaft", "bone"}};
  body.contact = part_of(ball(20.0, 8, 12), 0);
  if (has_visual) body.visual = part_of(box({0, 60, 0}, {10, 80, 10}), 1);
  body.visual.mesh.normals.resize(0, 3);  // one part with normals, one without
  return body;
}

void solve_cell(MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  const double flexion_deg = model.flexion_deg[static_cast<std::size_t>(i)];
  const double varus_deg = model.varus_deg[static_cast<std::size_t>(j)];
  const Attitude attitude{rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
  const MovingPose pose{{0.1 * flexion_deg, -40.0 + 0.01 * varus_deg, 0.3}, rad_from_deg(0.2 * flexion_deg)};
  const SolverFrame frame{Side::right, model.rotation_centre_mm, model.delta};
  const Eigen::Vector3d t_mm = world_translation_mm(frame, pose);
  model.tx_mm(i, j) = t_mm.x();
  model.ty_mm(i, j) = t_mm.y();
  model.tz_mm(i, j) = t_mm.z();
  model.theta_deg(i, j) = deg_from_rad(pose.theta_rad);
  const Pose X = X_reference_moving(frame, attitude, pose);
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(
      &model.X_reference_moving[static_cast<std::size_t>(16 * (i * model.tx_mm.cols() + j))]) = X.matrix();
  const Clinical clinical = clinical_of(X, Side::right, model.rotation_centre_mm);
  model.clinical.flexion_deg(i, j) = deg_from_rad(clinical.flexion_rad);
  model.clinical.varus_deg(i, j) = deg_from_rad(clinical.varus_rad);
  model.clinical.internal_rotation_deg(i, j) = deg_from_rad(clinical.internal_rotation_rad);
  model.clinical.anterior_mm(i, j) = clinical.anterior_mm;
  model.clinical.proximal_mm(i, j) = clinical.proximal_mm;
  model.clinical.lateral_mm(i, j) = clinical.lateral_mm;
  model.status(i, j) = static_cast<std::int8_t>(StepStatus::stable);
  model.iterations(i, j) = static_cast<std::int32_t>(10 + i);
  model.queries(i, j) = static_cast<std::int32_t>(30 + j);
  model.residual_mm(i, j) = 0.01;
  model.theta_determined(i, j) = 1;
  model.is_spine(i, j) = j == 1 ? 1 : 0;
  if (!model.has_compartments) return;
  model.gap_medial_mm(i, j) = 0.02;  // the lateral one faces nothing and stays NaN
  model.contact_medial(i, j) = 1;
  model.contact_lateral(i, j) = 0;
}

ContactRows sample_contacts(const MotionModel& model)
{
  ContactRows contacts;
  contacts.row_start = {0};
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    const bool is_stable = model.status.data()[cell] == 0;
    contacts.row_start.push_back(contacts.row_start.back() + (is_stable ? 2 : 0));
  }
  const std::size_t n = static_cast<std::size_t>(contacts.row_start.back());
  contacts.point_world_mm = Points::Constant(static_cast<Eigen::Index>(n), 3, 1.5);
  contacts.normal_world = Eigen::RowVector3d(0, -1, 0).replicate(static_cast<Eigen::Index>(n), 1);
  contacts.distance_mm.assign(n, 0.05);
  contacts.triangle_reference.assign(n, 7);
  contacts.triangle_moving.assign(n, 3);
  contacts.compartment.assign(n, model.has_compartments ? 1 : 0);
  return contacts;
}

SmoothedSet sample_smoothed(const MotionModel& model)
{
  SmoothedSet set;
  set.degree = 1;
  const bool has_varus = model.varus_deg.size() > 1;
  set.exponents.resize(has_varus ? 3 : 2, 2);
  set.exponents.topRows(2) << 0, 0, 1, 0;
  if (has_varus) set.exponents.row(2) << 0, 1;
  const AxisRanges ranges = axis_ranges(model.flexion_deg, model.varus_deg);
  double level = 1.0;
  for (const char* name : {"tx", "ty", "tz", "theta"}) {
    SmoothedSurface surface;
    surface.name = name;
    surface.coefficients = {level, 0.5, -0.25};
    surface.coefficients.resize(static_cast<std::size_t>(set.exponents.rows()));
    surface.n_cells = 11;
    surface.rms = 0.03;
    surface.largest_residual = 0.1;
    surface.leave_one_out_rms = 0.04;
    surface.condition_number = 1.5;
    surface.values.resize(model.tx_mm.rows(), model.tx_mm.cols());
    for (Eigen::Index i = 0; i < surface.values.rows(); ++i) {
      for (Eigen::Index j = 0; j < surface.values.cols(); ++j) {
        surface.values(i, j) = evaluate(set, surface, ranges, model.flexion_deg[static_cast<std::size_t>(i)],
                                        model.varus_deg[static_cast<std::size_t>(j)])
                                   .value;
      }
    }
    set.surfaces.push_back(surface);
    level += 1.0;
  }
  return set;
}

}  // namespace

MotionModel sample_model(const SampleOptions& options)
{
  MotionModel model;
  model.title = "Sample joint, knee-like (genou \xC3\xA9tal\xC3\xB3n)";
  model.joint = options.has_compartments ? "knee" : "other";
  model.side = "right";
  model.method = "stability-search";
  model.rotation_centre_mm = {1.0, -2.0, 3.0};
  model.contact_resolution_mm = 0.1;
  model.has_compartments = options.has_compartments;
  for (std::int32_t i = 0; i < options.n_flexion; ++i) model.flexion_deg.push_back(1.0 * i);
  for (std::int32_t j = 0; j < options.n_varus; ++j) model.varus_deg.push_back(-1.0 + j);
  model.reference = sample_body("femur", options.has_visual);
  model.moving = sample_body("tibmen", options.has_visual);
  model.job = {"title = \"Sample joint\"\n",
               "title = \"Sample joint\"\njoint = \"knee\"\n",
               {{"femur.stl", std::string(64, 'a')}, {"tibia.stl", std::string(64, '0')}}};
  model = with_pending_cells(model);
  for (Eigen::Index i = 0; i < model.tx_mm.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.tx_mm.cols(); ++j) {
      const bool fails = options.has_failed_cell && i == 1 && j == 2;
      if (fails) {
        model.status(i, j) = static_cast<std::int8_t>(StepStatus::no_clearance);
      } else {
        solve_cell(model, i, j);
      }
    }
  }
  model.contacts = sample_contacts(model);
  model.smoothed = {sample_smoothed(model)};
  return model;
}

}  // namespace vrda::test
