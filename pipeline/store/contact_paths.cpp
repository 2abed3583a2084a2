// Centre of contact of each compartment, from the contacts or the contact forces of a motion model.
#include "store/motion_model.hpp"

#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "model/side.hpp"
#include "core/units.hpp"

namespace vrda::store {
namespace {

struct CellPoints {
  Eigen::Vector3d medial_world_mm = Eigen::Vector3d::Constant(nan);
  Eigen::Vector3d lateral_world_mm = Eigen::Vector3d::Constant(nan);
};

/// Weighted means of the rows [first, last); `weight(row)` is above 0.
template <typename Rows, typename Weight>
CellPoints weighted_means(const Rows& rows, std::int64_t first, std::int64_t last, Weight weight)
{
  double sums[3] = {};
  Eigen::Vector3d moments[3] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (std::int64_t row = first; row < last; ++row) {
    const std::int8_t compartment = rows.compartment[static_cast<std::size_t>(row)];
    const double w = weight(row);
    sums[compartment] += w;
    moments[compartment] += w * rows.point_world_mm.row(row).transpose();
  }
  constexpr int medial = static_cast<int>(Compartment::medial),
                lateral = static_cast<int>(Compartment::lateral);
  CellPoints points;
  if (sums[medial] > 0.0) points.medial_world_mm = moments[medial] / sums[medial];
  if (sums[lateral] > 0.0) points.lateral_world_mm = moments[lateral] / sums[lateral];
  return points;
}

CellPoints points_of(const MotionModel& model, std::size_t cell, const Eigen::Vector3d& delta)
{
  if (!model.equilibrium) {
    const ContactRows& contacts = model.contacts;
    return weighted_means(contacts, contacts.row_start[cell], contacts.row_start[cell + 1],
                          [](std::int64_t) { return 1.0; });
  }
  const ForceRows& forces = model.equilibrium->forces;
  return weighted_means(forces, forces.row_start[cell], forces.row_start[cell + 1], [&](std::int64_t row) {
    return forces.along_delta_n[static_cast<std::size_t>(row)] / -forces.normal_world.row(row).dot(delta);
  });
}

void set_point(std::vector<double>& path_mm, std::size_t cell, const Eigen::Vector3d& point_mm)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    path_mm[3 * cell + axis] = point_mm[static_cast<Eigen::Index>(axis)];
}

}  // namespace

ContactPaths contact_paths_of(const MotionModel& model)
{
  using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const std::size_t n_varus = model.varus_deg.size(), n_cells = model.flexion_deg.size() * n_varus;
  const std::vector<double> no_points(3 * n_cells, nan);
  ContactPaths paths{no_points, no_points, no_points, no_points};
  SolverFrame frame{side_named(model.side), model.rotation_centre_mm, {}};
  for (std::size_t cell = 0; cell < n_cells; ++cell) {
    if (model.status.data()[cell] != status_stable) continue;
    const std::size_t flexion = cell / n_varus;
    frame.delta = model.push.delta.row(static_cast<Eigen::Index>(flexion)).transpose();
    const Eigen::Matrix3d R_reference_world_solver =
        reference_rotation(
            {rad_from_deg(model.flexion_deg[flexion]), rad_from_deg(model.varus_solved_deg.data()[cell])})
            .transpose();
    const Matrix4 X = Eigen::Map<const Matrix4>(&model.X_reference_moving[16 * cell]);
    const auto in_reference = [&](const Eigen::Vector3d& p_world_mm) -> Eigen::Vector3d {
      return world_from_solver(frame, R_reference_world_solver * solver_translation_mm(frame, p_world_mm)) +
             model.rotation_centre_mm;
    };
    const auto in_moving = [&](const Eigen::Vector3d& p_reference_mm) -> Eigen::Vector3d {
      return X.topLeftCorner<3, 3>().transpose() * (p_reference_mm - X.topRightCorner<3, 1>());
    };
    const CellPoints points = points_of(model, cell, frame.delta);
    const Eigen::Vector3d medial_mm = in_reference(points.medial_world_mm);
    const Eigen::Vector3d lateral_mm = in_reference(points.lateral_world_mm);
    set_point(paths.medial_reference_mm, cell, medial_mm);
    set_point(paths.medial_moving_mm, cell, in_moving(medial_mm));
    set_point(paths.lateral_reference_mm, cell, lateral_mm);
    set_point(paths.lateral_moving_mm, cell, in_moving(lateral_mm));
  }
  return paths;
}

}  // namespace vrda::store
