#include "store/motion_model.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "store/h5_file.hpp"
#include "store/motion.hpp"
#include "store/read_separately.hpp"
#include "store/registry.hpp"
#include "store/solved_cells.hpp"

namespace vrda::store {
namespace {

std::string dataset_of(const std::string& name)
{
  return name == "varus" ? "varus_solved" : name;
}

}  // namespace

std::string smoothed_group(std::int32_t degree)
{
  return "/smoothed/degree_" + std::to_string(degree);
}

std::string smoothed_path(std::int32_t degree, const std::string& name)
{
  return smoothed_group(degree) + "/" + dataset_of(name);
}

bool is_audit_name(const std::string& name)
{
  if (name == "raw" || name == "two_sided" || name == "zero_varus") return true;
  for (int degree = 0; degree <= max_smoothed_degree; ++degree) {
    const std::string set = "degree_" + std::to_string(degree);
    if (name == set || name == set + "_recontacted") return true;
  }
  return false;
}

std::string audit_group(const std::string& name)
{
  return "/audit/" + name;
}

std::string group_name(const SmoothedSet& set)
{
  return "degree_" + std::to_string(set.degree);
}

bool set_group_name(SmoothedSet& set, const std::string& name)
{
  const std::size_t start = std::string("degree_").size();
  if (name.size() <= start) return false;
  std::from_chars(name.data() + start, name.data() + name.size(), set.degree);
  return group_name(set) == name;
}

std::string group_name(const PriorTermRows& term)
{
  return name_of(static_cast<PriorCoordinate>(term.coordinate));
}
bool set_group_name(PriorTermRows& term, const std::string& name)
{
  const auto coordinate = value_named<PriorCoordinate>(name);
  if (coordinate) term.coordinate = static_cast<std::int8_t>(*coordinate);
  return coordinate.has_value();
}

std::string group_name(const OfFollower& follower)
{
  return follower.name;
}
bool set_group_name(OfFollower& follower, const std::string& name)
{
  follower.name = name;
  return is_follower_name(name);
}

double rotation_share_of(const PriorRows& prior)
{
  double sum = 0.0;
  int n = 0;
  for (const double share : prior.rotation_share) {
    if (!std::isfinite(share)) continue;
    sum += share;
    ++n;
  }
  return n > 0 ? sum / n : nan;
}

std::string group_name(const AuditSet& audit)
{
  return audit.name;
}

bool set_group_name(AuditSet& audit, const std::string& name)
{
  audit.name = name;
  return is_audit_name(name);
}

AuditSummary summary_of(const AuditSet& audit)
{
  return {largest_of(audit.penetration_mm), largest_of(audit.gap_mm)};
}

void PoseRows::set(std::size_t row, const Eigen::Vector3d& t_mm, double of_theta_deg, double of_varus_deg)
{
  tx_mm[row] = t_mm.x();
  ty_mm[row] = t_mm.y();
  tz_mm[row] = t_mm.z();
  theta_deg[row] = of_theta_deg;
  varus_deg[row] = of_varus_deg;
}

void TwoSidedFigures::include(const OfCompartments<double>& gap_mm)
{
  ++n_poses;
  if (std::ranges::all_of(gap_mm, [](double mm) { return std::abs(mm) <= perceptible_mm; }))
    ++n_both_in_contact;
  for (std::size_t side = 0; side < gap_mm.size(); ++side) {
    largest_gap_mm[side] = std::fmax(largest_gap_mm[side], gap_mm[side]);
    largest_overlap_mm[side] = std::fmax(largest_overlap_mm[side], -gap_mm[side]);
  }
}

TwoSidedFigures two_sided_figures(const AuditSet& audit)
{
  TwoSidedFigures figures;
  if (audit.compartment_gap_mm[0].size() == 0) return figures;
  for (Eigen::Index k = 0; k < audit.state.size(); ++k) {
    if (audit.state.data()[k] != code_of(AuditState::no_pose))
      figures.include({audit.compartment_gap_mm[0].data()[k], audit.compartment_gap_mm[1].data()[k]});
  }
  return figures;
}

std::vector<AuditSet> with_audit(std::vector<AuditSet> audits, AuditSet audit)
{
  std::erase_if(audits, [&](const AuditSet& other) { return other.name == audit.name; });
  const auto next = std::find_if(audits.begin(), audits.end(),
                                 [&](const AuditSet& other) { return audit.name < other.name; });
  audits.insert(next, std::move(audit));
  return audits;
}

namespace {

/// Resizes every dataset of the cells and of the free spine and fills it with empty values.
class EmptyCells : public RegistryVisitor {
  bool may_change() const override { return true; }
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    const std::vector<std::string>& dimensions = dataset.dimensions;
    const bool is_of_cells =
        dimensions.size() >= 2 && dimensions[0] == "/flexion" && dimensions[1] == "/varus";
    const bool is_of_spine = dataset.path.starts_with("/equilibrium/spine/");
    const bool is_of_rows = dimensions == std::vector<std::string>{"/contacts/cell_bound"} ||
                            dimensions == std::vector<std::string>{"/equilibrium/forces/cell_bound"} ||
                            (dimensions.size() == 1 && dataset.path.starts_with("/followers/") &&
                             dimensions.front().ends_with("/cell_bound"));
    if (!is_of_cells && !is_of_spine && !is_of_rows) return;
    const bool has_unknown = std::ranges::count(flag_table(dataset.flags()).values, -1) > 0;
    const std::vector<std::int64_t> shape = shape_of(dataset);
    std::visit([&](auto* all) { resize(*all, shape); }, member);
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_arithmetic_v<Scalar>)
        std::ranges::fill(values, static_cast<Scalar>(has_unknown                      ? -1.0
                                                      : std::is_same_v<Scalar, double> ? nan
                                                                                       : 0.0));
    });
  }
};

bool have_equal_polynomials(const SmoothedSet& a, const SmoothedSet& b)
{
  const auto are_equal = [](const SmoothedSurface& left, const SmoothedSurface& right) {
    return left.name == right.name && left.coefficients == right.coefficients;
  };
  return a.exponents.rows() == b.exponents.rows() && (a.exponents == b.exponents).all() &&
         std::equal(a.surfaces.begin(), a.surfaces.end(), b.surfaces.begin(), b.surfaces.end(), are_equal) &&
         std::equal(a.followers.begin(), a.followers.end(), b.followers.begin(), b.followers.end(),
                    [&](const SmoothedFollower& left, const SmoothedFollower& right) {
                      return left.name == right.name &&
                             std::equal(left.surfaces.begin(), left.surfaces.end(), right.surfaces.begin(),
                                        right.surfaces.end(), are_equal);
                    });
}

bool are_equal_travels(const std::optional<GridD>& a, const std::optional<GridD>& b)
{
  if (!a || !b) return a.has_value() == b.has_value();
  const auto are_equal = [](double left, double right) {
    return left == right || (std::isnan(left) && std::isnan(right));
  };
  return a->rows() == b->rows() && a->cols() == b->cols() &&
         std::equal(a->data(), a->data() + a->size(), b->data(), are_equal);
}

// Of sets with equal polynomials.
bool have_equal_recontact(const SmoothedSet& a, const SmoothedSet& b)
{
  return are_equal_travels(a.recontact_mm, b.recontact_mm) &&
         std::equal(a.followers.begin(), a.followers.end(), b.followers.begin(), b.followers.end(),
                    [](const SmoothedFollower& left, const SmoothedFollower& right) {
                      return are_equal_travels(left.recontact_mm, right.recontact_mm);
                    });
}

}  // namespace

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
  model.gap_mm.fill(GridD::Constant(n_flexion, n_varus, nan));
  model.is_in_contact.fill(GridB::Constant(n_flexion, n_varus, -1));
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
  for (FollowerRows& follower : model.followers) follower.forces = {};
  model.smoothed.clear();
  model.two_sided.reset();
  model.default_motion.reset();
  model.uncertainty.reset();
  model.prior.reset();
  model.repair.reset();
  model.zero_varus.reset();
  model.audits.clear();
  EmptyCells empty;
  visit_registry(model, empty);
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

// A motion model to HDF5: attributes, then the datasets of the layout, sealed and written atomically.

namespace {

/// Preconditions of the registry.
void require_consistent(const MotionModel& model)
{
  check(model.equilibrium.has_value() == (model.method == "equilibrium"),
        "equilibrium surfaces must exist exactly for method equilibrium");
  check(model.contact_paths.has_value() == model.has_compartments,
        "contact paths must exist exactly where there are compartments");
  for (const SmoothedSet& set : model.smoothed) {
    check(set.surfaces.size() == 4 || set.surfaces.size() == 5,
          "a smoothed set must have four or five surfaces");
    for (std::size_t i = 0; i < set.surfaces.size(); ++i)
      check(set.surfaces[i].name == smoothed_names[i],
            "the surfaces of a smoothed set must be tx, ty, tz, theta, varus");
  }
  const auto is_unsorted = [](const auto& list, auto is_before) {
    return std::adjacent_find(list.begin(), list.end(),
                              [&](const auto& a, const auto& b) { return !is_before(a, b); }) != list.end();
  };
  check(!is_unsorted(model.smoothed, [](const auto& a, const auto& b) { return a.degree < b.degree; }),
        "smoothed sets must be sorted by degree, each degree once");
  check(!is_unsorted(model.audits, [](const auto& a, const auto& b) { return a.name < b.name; }),
        "audits must be sorted by name, each name once");
  for (const AuditSet& audit : model.audits)
    check(is_audit_name(audit.name), "an audit must have the name of a motion");
}

/// Journals are removed after this file is written, so the content on disk is verified.
void require_written(const std::string& path, std::size_t n_bytes)
{
  std::error_code error;
  const std::uintmax_t n_found = std::filesystem::file_size(path, error);
  if (error || n_found != n_bytes) {
    throw InputError({path, "", error ? error.message() : std::to_string(n_found) + " bytes on the disk",
                      "the " + std::to_string(n_bytes) + " bytes just written"});
  }
  read_hdf5(path);
}

}  // namespace

void write_motion_model(const std::string& path, const MotionModel& model)
{
  const std::string& unlocked = missing_lock_warning();
  if (const std::vector<std::string>& known = model.job.warnings;
      !unlocked.empty() && std::find(known.begin(), known.end(), unlocked) == known.end()) {
    MotionModel warned = model;
    warned.job.warnings.push_back(unlocked);
    return write_motion_model(path, warned);
  }
  require_consistent(model);
  const std::string content = hdf5_bytes(path, {format_name, format_version}, model);
  const std::string seal = seal_of(content);
  write_atomically(path, {content, seal});
  require_written(path, content.size() + seal.size());
}

// Uniform scaling of a motion model to a subject's size, without a new run.

namespace {

/// Multiplies values by the factor to the length power of their unit.
class Scale : public RegistryVisitor {
 public:
  explicit Scale(double factor) : factor_(factor) {}
  bool may_change() const override { return true; }

 private:
  double factor_of(const Unit& units) const
  {
    return units.length_power == 0 ? 1.0 : units.length_power > 0 ? factor_ : 1.0 / factor_;
  }

  void visit_attribute(const std::string&, const std::string&, Attribute value, const Unit& units) override
  {
    if (double* const* number = std::get_if<double*>(&value)) **number *= factor_of(units);
    if (Eigen::Vector3d* const* vector = std::get_if<Eigen::Vector3d*>(&value)) **vector *= factor_of(units);
  }

  void visit_dataset(const Dataset& dataset, Member member) override
  {
    // In poses (4 x 4, row by row) only the translation is a length.
    const bool is_pose = dataset.valid.rule == Rule::rigid;
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, double>) {
        for (std::size_t k = 0; k < values.size(); ++k)
          if (!is_pose || (k % 4 == 3 && k % 16 != 15)) values[k] *= factor_of(dataset.units);
      }
    });
  }

  double factor_;
};

}  // namespace

MotionModel scaled_model(MotionModel model, double factor)
{
  check(std::isfinite(factor) && factor > 0.0, "the scale factor must be above 0");
  Scale scale(factor);
  if (factor != 1.0) visit_registry(model, scale);
  return model;
}

}  // namespace vrda::store
