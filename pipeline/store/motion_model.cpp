#include "store/motion_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "store/registry.hpp"

namespace vrda::store {
namespace {

/// Resizes every dataset of the cells and of the free spine and fills it with empty values.
class EmptyCells : public RegistryVisitor {
 public:
  template <typename Member>
  void operator()(const Dataset& dataset, Member& member)
  {
    if constexpr (member_kind<Member>() != ValueKind::text) empty(dataset, member);
  }

 private:
  template <typename Member>
  void empty(const Dataset& dataset, Member& member)
  {
    const std::vector<std::string>& dimensions = dataset.dimensions;
    const bool is_of_cells =
        dimensions.size() >= 2 && dimensions[0] == "/flexion" && dimensions[1] == "/varus";
    const bool is_of_spine = dataset.path.rfind("/equilibrium/spine/", 0) == 0;
    const bool is_of_rows = dimensions == std::vector<std::string>{"/contacts/cell_bound"} ||
                            dimensions == std::vector<std::string>{"/equilibrium/forces/cell_bound"};
    if (!is_of_cells && !is_of_spine && !is_of_rows) return;
    const std::vector<std::int8_t> codes = flag_table(dataset.flags()).values;
    const bool has_unknown = std::find(codes.begin(), codes.end(), -1) != codes.end();
    resize(member, shape_of(dataset));
    std::ranges::fill(values_of(member), empty_value(values_of(member), has_unknown));
  }

  template <typename Scalar>
  static Scalar empty_value(std::span<Scalar>, bool has_unknown)
  {
    if (has_unknown) return static_cast<Scalar>(-1);
    if constexpr (std::is_same_v<Scalar, double>) return nan;
    return Scalar(0);
  }
};

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

bool is_key_name(const std::string& name)
{
  return core::is_key_name(name);
}

void require_grid(const MotionModel& model, const std::string& file, const std::string& what)
{
  if (!model.frames) return;
  throw InputError({file, "/frame", "a sequence of frames", "a grid of attitudes, which " + what + " needs"});
}

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
  const auto n_flexion = static_cast<Eigen::Index>(model.flexion_deg.size());
  if (model.push.delta.rows() != n_flexion) {
    model.push = constant_push(model.delta, model.flexion_deg.size());
  }
  if (model.has_compartments)
    model.compartment_of_triangle.resize(
        static_cast<std::size_t>(model.moving.contact.mesh.triangles.rows()));
  model.contacts = {};
  model.contact_paths.reset();
  const double band_moment_nmm = model.equilibrium ? model.equilibrium->band_moment_nmm : 0.0;
  model.equilibrium.reset();
  model.smoothed.clear();
  model.two_sided.reset();
  model.default_motion.reset();
  model.uncertainty.reset();
  model.repair.reset();
  model.zero_varus.reset();
  model.audits.clear();
  EmptyCells empty;
  visit_motion_model(model, empty);
  if (model.equilibrium) model.equilibrium->band_moment_nmm = band_moment_nmm;
  if (!model.has_compartments) set_no_compartments(model);
  return model;
}

bool has_turned_axes(const MotionModel& model)
{
  const Points& delta = model.push.delta;
  return delta.rows() > 0 && delta != Eigen::RowVector3d::UnitY().replicate(delta.rows(), 1);
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
  if (model.default_motion && is_stale(model.default_motion->set)) model.default_motion.reset();
  std::erase_if(model.audits, [&](const AuditSet& audit) {
    return is_stale(audit.name) || (is_reduction_stale && audit.name == "zero_varus");
  });
  *place = std::move(set);
  return model;
}

}  // namespace vrda::store
