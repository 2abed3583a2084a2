#include "run/job_checks.hpp"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/console.hpp"
#include "model/side.hpp"
#include "core/text.hpp"
#include "job/case_warnings.hpp"
#include "job/input_file.hpp"
#include "job/job.hpp"
#include "job/shells.hpp"
#include "solve/case_solver.hpp"
#include "prepare/frame_check.hpp"
#include "geometry/directional_gap.hpp"
#include "geometry/fit_checks.hpp"

namespace vrda::run {
namespace {

using Warnings = std::vector<std::string>;

std::string list_text(const Eigen::Vector3d& v)
{
  std::string text;
  for (const double value : v)
    text += (text.empty() ? "[" : ", ") + shortest_decimal(std::round(100.0 * value) / 100.0 + 0.0);
  return text + "]";
}

// Signed coordinate axis nearest to the direction from the moving object to the reference.
Eigen::Vector3d towards_reference(const job::Case& job_case)
{
  const Box reference = bounding_box(job_case.reference.contact.mesh);
  const Box moving = bounding_box(job_case.moving.contact.mesh);
  const Eigen::Vector3d offset_mm = reference.min_mm + reference.max_mm - moving.min_mm - moving.max_mm;
  Eigen::Index k = 0;
  offset_mm.cwiseAbs().maxCoeff(&k);
  return Eigen::Vector3d::Unit(k) * (offset_mm[k] < 0.0 ? -1.0 : 1.0);
}

// At the first flexion.
InitialContact initial_contact(const job::Case& job_case)
{
  const solve::InitialBodies bodies = solve::initial_bodies_of(job_case);
  const solve::SweepPlan plan = solve::plan_of(job_case);
  contact::NarrowPhase narrow_phase;
  const geometry::TreeMesh reference =
      geometry::rotated_reference(bodies.reference, {plan.flexion_rad.front(), 0.0});
  const bool is_overlapping =
      contact::find_collision(reference, bodies.moving, plan.initial, narrow_phase).has_value();
  const geometry::Gap gap = geometry::directional_gap(
      reference, bodies.moving.mesh, bodies.moving.tree, plan.initial,
      {is_overlapping ? geometry::GapKind::signed_facing : geometry::GapKind::non_negative, {}});
  return {is_overlapping, gap.travel_mm, bodies.substep_mm};
}

// An initial pose from which the first step cannot approach the reference.
void warn_of_start(const job::Case& job_case, const InitialContact& start, Warnings& warnings)
{
  const Eigen::Vector3d& delta = job_case.frame.delta;
  if (start.is_overlapping) {
    constexpr double clearance_mm = 5.0;
    std::string remedy = "a larger shift against push.delta";
    if (std::isfinite(start.travel_mm)) {
      const Eigen::Vector3d clear_mm =
          job_case.initial.translation_mm + (start.travel_mm - clearance_mm) * delta;
      remedy = "moving.initial.translation_mm = " + list_text(clear_mm);
    }
    warnings.push_back(
        "moving.initial.translation_mm: the objects overlap in the initial pose; to clear it, use " + remedy);
  } else if (!std::isfinite(start.travel_mm)) {
    warnings.push_back(
        "push.delta: the reference is not along Delta from the initial pose, so no attitude can be solved; "
        "the direction to it is push.delta = " +
        list_text(towards_reference(job_case)) +
        "; also check moving.initial.translation_mm, and winding, which sets the outside of open sheets");
  }
}

// Enough to identify a faulty component; the exact number is not needed.
constexpr std::size_t most_overlaps = 100;

// Components whose triangles intersect each other: their thickness is undefined.
void warn_of_self_overlaps(const Body& body, Warnings& warnings)
{
  contact::NarrowPhase narrow_phase;
  for (std::size_t c = 0; c < body.components.size(); ++c) {
    std::vector<Eigen::Index> rows;
    for (std::size_t t = 0; t < body.contact.component.size(); ++t) {
      if (body.contact.component[t] == static_cast<std::int32_t>(c))
        rows.push_back(static_cast<Eigen::Index>(t));
    }
    if (rows.empty()) continue;
    const std::size_t n =
        contact::find_self_overlaps(geometry::make_tree_mesh(select_triangles(body.contact.mesh, rows)),
                                    narrow_phase, most_overlaps)
            .size();
    if (n == 0) continue;
    warnings.push_back(body.name + " component \"" + body.components[c].name +
                       "\": its triangles intersect each other in " +
                       (n == most_overlaps ? "at least " : "") + std::to_string(n) + " place(s)");
  }
}

// The contact triangles of bones, without those of `left_out`.
Mesh bones_of(const Body& body, std::size_t left_out)
{
  const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, body.contact);
  std::vector<Eigen::Index> kept;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    if (c != left_out && body.components[c].material == "bone")
      kept.insert(kept.end(), rows[c].begin(), rows[c].end());
  }
  return job::compacted(body.contact.mesh, kept);
}

// "the mesh of moving.component.0" with the same file as a cartilage, if that is of the other body or no
// cartilage; empty: none.
std::string same_file_as(const job::ComponentJob& cartilage, bool is_reference, const job::Job& job,
                         const job::Case& job_case)
{
  std::map<std::string, std::string> sha256;
  for (const job::LoadedInput& input : job_case.inputs) sha256[input.name] = input.sha256;
  for (const bool is_other_reference : {true, false}) {
    for (const job::ComponentJob& part : (is_other_reference ? job.reference : job.moving).components) {
      const bool may_be_same = is_reference == is_other_reference && part.material == cartilage.material;
      if (!may_be_same && !part.generate && sha256[part.file] == sha256[cartilage.file])
        return "the mesh of " + part.key + " (\"" + part.name + "\")";
    }
  }
  return "";
}

// The cartilage of a knee is neither its bone nor a meniscus. Both bones are compared where their meshes have
// common axes.
void require_own_cartilage(const job::Job& job, const job::Case& job_case)
{
  const bool is_one_scan = !job.reference.frame && !job.moving.frame;
  for (const bool is_femur : {true, false}) {
    const Body& body = is_femur ? job_case.reference : job_case.moving;
    const Body& other = is_femur ? job_case.moving : job_case.reference;
    const std::vector<job::ComponentJob>& parts = (is_femur ? job.reference : job.moving).components;
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, body.contact);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      // A bone with an offset may be its own cartilage.
      if (rows[c].empty() || body.components[c].material != "cartilage" || parts[c].generate ||
          parts[c].is_offset_fitted || parts[c].offset_mm != 0.0 || parts[c].inset_mm != 0.0)
        continue;
      const Mesh part = job::compacted(body.contact.mesh, rows[c]), own = bones_of(body, c);
      std::string found = same_file_as(parts[c], is_femur, job, job_case);
      if (found.empty() && own.triangles.rows() > 0 && geometry::is_part_of(part, own))
        found = "the surface of its bone";
      if (found.empty() && is_one_scan) {
        found = geometry::cartilage_check(
                    part, is_femur ? geometry::CartilageOf::femur : geometry::CartilageOf::tibia, own,
                    bones_of(other, other.components.size()))
                    .rejection;
      }
      if (!found.empty())
        job.document.refuse(parts[c].key + ".file", found,
                            "the mesh of the cartilage \"" + parts[c].name +
                                "\", in the scan of the bones; or another material");
    }
  }
}

// Collaterals on the wrong side are those of the other knee, unless the bones also say that the side is
// wrong: then a warning says so.
void require_table_of_side(const job::Job& job, const job::Case& job_case)
{
  const std::string misplaced = job::misplaced_collateral(job_case, job.side);
  if (!misplaced.empty()) {
    const std::string place = misplaced == "MCL" ? "lateral" : "medial";
    job.document.refuse("ligaments",
                        misplaced + " on the " + place + " side of a " + side_name(job.side) +
                            " knee, as its other collateral",
                        misplaced + " on the " + (misplaced == "MCL" ? "medial" : "lateral") +
                            " side: check the sign of its coordinate along frame.right");
  }
  const std::optional<Side> found = job::collateral_side(job_case);
  if (!found || *found == job.side) return;
  for (const std::string& warning : job_case.warnings)
    if (warning.starts_with("side: ")) return;
  const std::string side = side_name(job.side), other = side_name(*found);
  job.document.refuse(
      "ligaments", "MCL and LCL where a " + other + " knee has them, and side = \"" + side + "\"",
      "the fibres of a " + side + " knee: in a table of a " + other +
          " knee the coordinate along frame.right of both attachments changes its sign; or side "
          "= \"" +
          other + "\" if the bones are of a " + other + " knee");
}

}  // namespace

CheckedCase load_checked_case(const job::Job& job, const std::string& data_directory,
                              std::uintmax_t large_bytes)
{
  constexpr std::uintmax_t bytes_per_mb = 1'000'000;
  if (const std::uintmax_t n_bytes = job::mesh_bytes(job, data_directory); n_bytes >= large_bytes)
    core::log_info("reading and checking meshes of " + std::to_string(n_bytes / bytes_per_mb) + " MB");
  job::Case loaded = job::load_case(job, data_directory);
  const job::Case at_size = job::scaled_to_subject(loaded);
  const InitialContact initial = initial_contact(at_size);
  Warnings& warnings = loaded.warnings;
  warn_of_start(at_size, initial, warnings);
  warn_of_self_overlaps(at_size.reference, warnings);
  warn_of_self_overlaps(at_size.moving, warnings);
  if (job::has_mesh_file(job)) {
    const prepare::FrameKeys keys{frame_of(job, job.reference).key, frame_of(job, job.moving).key};
    for (const std::string& warning : prepare::frame_warnings(at_size, keys)) warnings.push_back(warning);
  }
  require_table_of_side(job, loaded);
  if (job.joint == "knee") require_own_cartilage(job, loaded);
  return {std::move(loaded), initial};
}

}  // namespace vrda::run
