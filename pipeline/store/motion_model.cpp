#include "store/motion_model.hpp"

#include <limits>
#include <utility>

namespace vrda {

MotionModel with_pending_cells(MotionModel model)
{
  const Eigen::Index n_flexion = static_cast<Eigen::Index>(model.flexion_deg.size());
  const Eigen::Index n_varus = static_cast<Eigen::Index>(model.varus_deg.size());
  const std::size_t n_cells = model.flexion_deg.size() * model.varus_deg.size();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg, &model.residual_mm,
                      &model.gap_medial_mm, &model.gap_lateral_mm, &model.clinical.flexion_deg,
                      &model.clinical.varus_deg, &model.clinical.internal_rotation_deg,
                      &model.clinical.anterior_mm, &model.clinical.proximal_mm, &model.clinical.lateral_mm}) {
    *grid = GridD::Constant(n_flexion, n_varus, nan);
  }
  for (GridB* grid : {&model.contact_medial, &model.contact_lateral, &model.theta_determined}) {
    *grid = GridB::Constant(n_flexion, n_varus, -1);
  }
  model.status = GridB::Constant(n_flexion, n_varus, static_cast<std::int8_t>(StepStatus::pending));
  model.is_spine = GridB::Zero(n_flexion, n_varus);
  model.iterations = GridI::Zero(n_flexion, n_varus);
  model.queries = GridI::Zero(n_flexion, n_varus);
  model.X_reference_moving.assign(16 * n_cells, nan);
  model.contacts = {};
  model.contacts.row_start.assign(n_cells + 1, 0);
  model.smoothed.clear();
  return model;
}

}  // namespace vrda
