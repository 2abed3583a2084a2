#include "store/motion_model.hpp"
#include "core/units.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vrda {
namespace {

constexpr std::int8_t pending_code = status_pending;

struct GridSize {
  Eigen::Index n_flexion = 0, n_varus = 0;
  std::size_t n_cells() const { return static_cast<std::size_t>(n_flexion * n_varus); }
};

FreeSpine pending_spine(std::size_t n_flexion)
{
  FreeSpine spine;
  spine.status.assign(n_flexion, pending_code);
  spine.n_optima.assign(n_flexion, 0);
  for (std::vector<double>* values :
       {&spine.varus_deg, &spine.tx_mm, &spine.ty_mm, &spine.tz_mm, &spine.theta_deg, &spine.energy_nmm,
        &spine.theta_low_deg, &spine.theta_high_deg, &spine.optima_theta_spread_deg,
        &spine.optima_energy_spread_nmm}) {
    values->assign(n_flexion, nan);
  }
  return spine;
}

EquilibriumSurfaces pending_equilibrium(const MotionModel& model, const GridSize& size)
{
  EquilibriumSurfaces surfaces;
  if (model.equilibrium) surfaces.band_moment_nmm = model.equilibrium->band_moment_nmm;
  for (GridD* grid : {&surfaces.energy_nmm, &surfaces.balance_residual_n, &surfaces.complementarity_mm,
                      &surfaces.worst_gap_mm, &surfaces.flexion_moment_nmm, &surfaces.varus_moment_nmm}) {
    *grid = GridD::Constant(size.n_flexion, size.n_varus, nan);
  }
  if (model.has_compartments) {
    surfaces.force_medial_n.assign(3 * size.n_cells(), nan);
    surfaces.force_lateral_n = surfaces.force_medial_n;
  }
  surfaces.forces.row_start.assign(size.n_cells() + 1, 0);
  surfaces.spine = pending_spine(static_cast<std::size_t>(size.n_flexion));
  return surfaces;
}

void empty_cells(LigamentRows& ligaments, std::size_t n_cells)
{
  const std::size_t n = n_cells * ligaments.name.size();
  for (std::vector<double>* values :
       {&ligaments.length_mm, &ligaments.strain, &ligaments.tension_n, &ligaments.energy_nmm}) {
    values->assign(n, nan);
  }
  ligaments.is_wrapped.assign(n, -1);
}

bool have_equal_polynomials(const SmoothedSet& a, const SmoothedSet& b)
{
  const auto are_equal = [](const SmoothedSurface& left, const SmoothedSurface& right) {
    return left.name == right.name && left.coefficients == right.coefficients;
  };
  return a.exponents.rows() == b.exponents.rows() && (a.exponents == b.exponents).all() &&
         std::equal(a.surfaces.begin(), a.surfaces.end(), b.surfaces.begin(), b.surfaces.end(), are_equal);
}

bool have_equal_recontact(const SmoothedSet& a, const SmoothedSet& b)
{
  if (!a.recontact_mm || !b.recontact_mm) return a.recontact_mm.has_value() == b.recontact_mm.has_value();
  const auto are_equal = [](double left, double right) {
    return left == right || (std::isnan(left) && std::isnan(right));
  };
  const GridD &left = *a.recontact_mm, &right = *b.recontact_mm;
  return left.rows() == right.rows() && left.cols() == right.cols() &&
         std::equal(left.data(), left.data() + left.size(), right.data(), are_equal);
}

}  // namespace

PushRows constant_push(const Eigen::Vector3d& delta, std::size_t n_flexion)
{
  PushRows push;
  push.delta = delta.transpose().replicate(static_cast<Eigen::Index>(n_flexion), 1);
  push.force_n = Points::Zero(static_cast<Eigen::Index>(n_flexion), 3);
  push.moment_nmm.assign(n_flexion, 0.0);
  push.varus_moment_nmm.assign(n_flexion, 0.0);
  return push;
}

void set_no_compartments(MotionModel& model)
{
  const Eigen::Index n_flexion = model.tx_mm.rows(), n_varus = model.tx_mm.cols();
  model.gap_medial_mm = GridD::Constant(n_flexion, n_varus, std::numeric_limits<double>::quiet_NaN());
  model.gap_lateral_mm = model.gap_medial_mm;
  model.contact_medial = GridB::Constant(n_flexion, n_varus, -1);
  model.contact_lateral = model.contact_medial;
}

MotionModel with_pending_cells(MotionModel model)
{
  const GridSize size{static_cast<Eigen::Index>(model.flexion_deg.size()),
                      static_cast<Eigen::Index>(model.varus_deg.size())};
  for (GridD* grid :
       {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg, &model.residual_mm, &model.gap_medial_mm,
        &model.gap_lateral_mm, &model.varus_solved_deg, &model.clinical.flexion_deg,
        &model.clinical.varus_deg, &model.clinical.internal_rotation_deg, &model.clinical.anterior_mm,
        &model.clinical.proximal_mm, &model.clinical.lateral_mm}) {
    *grid = GridD::Constant(size.n_flexion, size.n_varus, nan);
  }
  for (GridB* grid : {&model.contact_medial, &model.contact_lateral, &model.theta_determined}) {
    *grid = GridB::Constant(size.n_flexion, size.n_varus, -1);
  }
  model.status = GridB::Constant(size.n_flexion, size.n_varus, pending_code);
  model.plausibility = GridB::Constant(size.n_flexion, size.n_varus, plausibility_not_judged);
  model.is_spine = GridB::Zero(size.n_flexion, size.n_varus);
  model.iterations = GridI::Zero(size.n_flexion, size.n_varus);
  model.queries = GridI::Zero(size.n_flexion, size.n_varus);
  model.X_reference_moving.assign(16 * size.n_cells(), nan);
  model.contacts = {};
  model.contacts.row_start.assign(size.n_cells() + 1, 0);
  if (model.push.delta.rows() != size.n_flexion) {
    model.push = constant_push(model.delta, model.flexion_deg.size());
  }
  const std::vector<double> nowhere(3 * size.n_cells(), nan);
  model.contact_paths.reset();
  if (model.has_compartments) model.contact_paths = {nowhere, nowhere, nowhere, nowhere};
  if (model.method == "equilibrium") {
    model.equilibrium = pending_equilibrium(model, size);
  } else {
    model.equilibrium.reset();
  }
  if (model.ligaments) empty_cells(*model.ligaments, size.n_cells());
  model.smoothed.clear();
  model.zero_varus.reset();
  model.audits.clear();
  return model;
}

Pose pose_in(const std::vector<double>& poses, std::size_t k)
{
  using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  Pose X;
  X.matrix() = Eigen::Map<const Matrix4>(&poses[16 * k]);
  return X;
}

MotionModel with_smoothed(MotionModel model, SmoothedSet set)
{
  const auto place = std::find_if(model.smoothed.begin(), model.smoothed.end(),
                                  [&](const SmoothedSet& other) { return other.degree >= set.degree; });
  if (place == model.smoothed.end() || place->degree > set.degree) {
    model.smoothed.insert(place, std::move(set));
    return model;
  }
  const bool is_moved = !have_equal_polynomials(*place, set);
  const bool is_recontact_moved = is_moved || !have_equal_recontact(*place, set);
  const std::string name = "degree_" + std::to_string(set.degree);
  const auto is_stale = [&](const std::string& motion) {
    return (is_moved && motion == name) || (is_recontact_moved && motion == name + "_recontacted");
  };
  const bool is_reduction_stale = model.zero_varus && is_stale(model.zero_varus->set);
  if (is_reduction_stale) model.zero_varus.reset();
  std::erase_if(model.audits, [&](const AuditSet& audit) {
    return is_stale(audit.name) || (is_reduction_stale && audit.name == "zero_varus");
  });
  *place = std::move(set);
  return model;
}

}  // namespace vrda
