#include "store/values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.hpp"
#include "store/derived_values.hpp"
#include "store/layout.hpp"
#include "store/mechanics_values.hpp"
#include "store/scaling_values.hpp"
#include "store/value_findings.hpp"

namespace vrda {
namespace {

class ValueCheck {
 public:
  explicit ValueCheck(const MotionModel& model)
      : model_(model), n_cells_(model.flexion_deg.size() * model.varus_deg.size())
  {
  }

  std::vector<Finding> run()
  {
    check_root_attributes();
    findings_.axis("/flexion", model_.flexion_deg);
    findings_.axis("/varus", model_.varus_deg);
    check_cells();
    check_poses();
    check_spine();
    check_contacts();
    check_mechanics(model_, findings_);
    check_body("/bodies/reference", model_.reference);
    check_body("/bodies/moving", model_.moving);
    check_derived(model_, findings_);
    if (model_.job.scaling) check_scaling(*model_.job.scaling, findings_);
    findings_.each(
        "/job/input_sha256", model_.job.inputs.size(), "64 hexadecimal digits",
        [&](std::size_t i) { return !is_sha256(model_.job.inputs[i].sha256); },
        [&](std::size_t i) { return "\"" + model_.job.inputs[i].sha256 + "\""; });
    return findings_.take();
  }

 private:
  bool is_stable(std::size_t cell) const { return model_.status.data()[cell] == status_stable; }

  static bool is_sha256(const std::string& text)
  {
    return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
  }

  void one_of(const std::string& where, const std::string& value, const std::vector<std::string>& allowed)
  {
    if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return;
    std::string wanted;
    for (const std::string& word : allowed) wanted += (wanted.empty() ? "\"" : ", \"") + word + "\"";
    findings_.find(where, "\"" + value + "\"", "one of " + wanted);
  }

  void check_root_attributes()
  {
    one_of("/@joint", model_.joint, {"knee", "other"});
    one_of("/@side", model_.side, {"right", "left"});
    one_of("/@method", model_.method, {"stability-search", "equilibrium"});
    findings_.all_finite("/@rotation_centre_mm", model_.rotation_centre_mm.data(), 3);
    const double length = model_.delta.norm();
    if (!(std::abs(length - 1.0) <= exact_tolerance)) {
      findings_.find("/@delta", "a vector of length " + text_of(length), "length 1");
    } else if ((model_.push.delta.row(0).transpose() - model_.delta).norm() > exact_tolerance) {
      findings_.find("/@delta", "another direction", "that of the first row of /push/delta");
    }
    if (!(model_.contact_resolution_mm > 0.0) || !is_number(model_.contact_resolution_mm)) {
      findings_.find("/@contact_resolution_mm", text_of(model_.contact_resolution_mm), "a positive length");
    }
  }

  /// A number where the cell is stable, NaN elsewhere.
  void answers(const std::string& where, const GridD& grid)
  {
    const double* values = grid.data();
    findings_.each_number(where, values, n_cells_, "a number where status is stable, NaN elsewhere",
                          [&](std::size_t cell) {
                            return is_stable(cell) ? !is_number(values[cell]) : !std::isnan(values[cell]);
                          });
  }

  /// 0 or 1 where the cell is stable, -1 elsewhere.
  void answers(const std::string& where, const GridB& grid)
  {
    const std::int8_t* values = grid.data();
    findings_.each(
        where, n_cells_, "0 or 1 where status is stable, -1 elsewhere",
        [&](std::size_t cell) {
          return is_stable(cell) ? values[cell] != 0 && values[cell] != 1 : values[cell] != -1;
        },
        [&](std::size_t cell) { return std::to_string(values[cell]); });
  }

  /// A number or NaN where the cell is stable, NaN elsewhere.
  void gaps(const std::string& where, const GridD& grid)
  {
    const double* values = grid.data();
    findings_.each_number(where, values, n_cells_, "a number or NaN where status is stable, NaN elsewhere",
                          [&](std::size_t cell) {
                            return is_stable(cell) ? !is_number_or_nan(values[cell])
                                                   : !std::isnan(values[cell]);
                          });
  }

  void check_cells()
  {
    findings_.codes("/status", model_.status.data(), n_cells_, flag_table(FlagSet::status).values);
    check_plausibility();
    answers("/tx", model_.tx_mm);
    answers("/ty", model_.ty_mm);
    answers("/tz", model_.tz_mm);
    answers("/theta", model_.theta_deg);
    answers("/clinical/flexion_angle", model_.clinical.flexion_deg);
    answers("/clinical/varus_angle", model_.clinical.varus_deg);
    answers("/clinical/internal_rotation", model_.clinical.internal_rotation_deg);
    answers("/clinical/anterior", model_.clinical.anterior_mm);
    answers("/clinical/proximal", model_.clinical.proximal_mm);
    answers("/clinical/lateral", model_.clinical.lateral_mm);
    answers("/theta_determined", model_.theta_determined);
    constexpr std::int64_t any = std::numeric_limits<std::int32_t>::max();
    findings_.each_within("/iterations", model_.iterations.data(), n_cells_, 0, any);
    findings_.each_within("/queries", model_.queries.data(), n_cells_, 0, any);
    findings_.each_number(
        "/residual", model_.residual_mm.data(), n_cells_, "a number or NaN",
        [&](std::size_t cell) { return !is_number_or_nan(model_.residual_mm.data()[cell]); });
    if (!model_.has_compartments) return;
    gaps("/gap_medial_mm", model_.gap_medial_mm);
    gaps("/gap_lateral_mm", model_.gap_lateral_mm);
    answers("/contact_medial", model_.contact_medial);
    answers("/contact_lateral", model_.contact_lateral);
  }

  void check_plausibility()
  {
    const std::int8_t* values = model_.plausibility.data();
    findings_.codes("/plausibility", values, n_cells_, flag_table(FlagSet::plausibility).values);
    findings_.each(
        "/plausibility", n_cells_, "-1 where status is not stable",
        [&](std::size_t cell) { return !is_stable(cell) && values[cell] != plausibility_not_judged; },
        [&](std::size_t cell) { return std::to_string(values[cell]); });
  }

  void check_poses()
  {
    const std::vector<double>& X = model_.X_reference_moving;
    findings_.each(
        "/X_reference_moving", n_cells_, "a rotation and a translation where status is stable, NaN elsewhere",
        [&](std::size_t cell) {
          const double* entries = &X[16 * cell];
          if (is_stable(cell)) return !is_rigid_pose(entries);
          return !std::all_of(entries, entries + 16, [](double entry) { return std::isnan(entry); });
        },
        [&](std::size_t cell) { return is_stable(cell) ? "no rigid pose" : "numbers in an unsolved cell"; });
  }

  void check_spine()
  {
    findings_.each_within("/is_spine", model_.is_spine.data(), n_cells_, 0, 1);
    findings_.each(
        "/is_spine", model_.flexion_deg.size(), "at most one spine cell a flexion",
        [&](std::size_t i) { return (model_.is_spine.row(static_cast<Eigen::Index>(i)) == 1).count() > 1; },
        [&](std::size_t) { return "several spine cells"; });
  }

  void check_contacts()
  {
    const ContactRows& contacts = model_.contacts;
    const std::size_t n = contacts.distance_mm.size();
    findings_.starts("/contacts/row_start", contacts.row_start, n, "contacts");
    findings_.all_finite("/contacts/point", contacts.point_world_mm.data(), 3 * n);
    findings_.unit_rows("/contacts/normal", contacts.normal_world, false);
    findings_.all_finite("/contacts/distance", contacts.distance_mm.data(), n);
    findings_.each_within("/contacts/triangle_reference", contacts.triangle_reference.data(), n, 0,
                          model_.reference.contact.mesh.triangles.rows() - 1);
    findings_.each_within("/contacts/triangle_moving", contacts.triangle_moving.data(), n, 0,
                          model_.moving.contact.mesh.triangles.rows() - 1);
    findings_.each_within("/contacts/compartment", contacts.compartment.data(), n, 0, 2);
  }

  void check_part(const std::string& group, const Part& part, std::size_t n_components)
  {
    const Points& vertices = part.mesh.vertices_mm;
    findings_.all_finite(group + "/vertices", vertices.data(), static_cast<std::size_t>(vertices.size()));
    findings_.each_within(group + "/triangles", part.mesh.triangles.data(),
                          static_cast<std::size_t>(part.mesh.triangles.size()), 0, vertices.rows() - 1);
    findings_.each_within(group + "/component", part.component.data(), part.component.size(), 0,
                          static_cast<std::int64_t>(n_components) - 1);
    findings_.unit_rows(group + "/normals", part.mesh.normals, true);
  }

  void check_body(const std::string& group, const Body& body)
  {
    if (body.contact.mesh.triangles.rows() == 0)
      findings_.find(group + "/triangles", "no triangles", "at least one");
    std::set<std::string> names;
    findings_.each(
        group + "/component_name", body.components.size(), "names that are not empty and differ",
        [&](std::size_t i) {
          return body.components[i].name.empty() || !names.insert(body.components[i].name).second;
        },
        [&](std::size_t i) { return "\"" + body.components[i].name + "\""; });
    check_part(group, body.contact, body.components.size());
    check_part(group + "/visual", body.visual, body.components.size());
  }

  const MotionModel& model_;
  std::size_t n_cells_;
  ValueFindings findings_;
};

}  // namespace

std::vector<Finding> check_values(const MotionModel& model)
{
  return ValueCheck(model).run();
}

void require_none(const std::vector<Finding>& findings, const std::string& file)
{
  if (findings.empty()) return;
  throw InputError({file, findings[0].where, findings[0].found, findings[0].wanted});
}

}  // namespace vrda
