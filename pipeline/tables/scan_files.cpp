#include "tables/scan_files.hpp"

#include "core/document.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/slicer_files.hpp"
#include "tables/formats.hpp"

namespace vrda::tables {

ScanFrame scan_frame(const store::MotionModel& model, const std::string& file)
{
  if (model.job.resolved.empty())
    throw InputError({file, "/job/resolved", "nothing", "a model that vrda run made"});
  const core::DocumentValue root = core::parse_toml(model.job.resolved, file);
  if (root.contains("scaling"))
    throw InputError({file, "/job/resolved, scaling", "bones scaled to a subject",
                      "a job without [scaling]: its bones are those of the scan"});
  ScanFrame scan;
  const core::DocumentValue* own = core::find_key(root, "scan");
  if (own != nullptr) scan.space = core::text_or_empty(*own, "space");
  if (own != nullptr && own->contains("X_scan_reference")) {
    const core::DocumentValue& rows = core::value_at(*own, "X_scan_reference");
    for (Eigen::Index i = 0; i < 3; ++i) {
      const std::vector<double> row = core::numbers_of(rows[static_cast<std::size_t>(i)]);
      for (Eigen::Index k = 0; k < 4; ++k)
        scan.X_scan_reference.matrix()(i, k) = row[static_cast<std::size_t>(k)];
    }
    scan.unit_mm = job::mm_per_unit(core::text_at(*own, "unit"));
    return scan;
  }
  const job::Job job = job::parse_job(file, model.job.resolved);
  const job::AxisMap map = job::body_map(job, job.reference);
  scan.X_scan_reference = map.X_canonical_native.inverse();
  scan.unit_mm = map.unit_mm;
  return scan;
}

std::vector<std::pair<std::string, Mesh>> meshes_in_scan(const store::MotionModel& model,
                                                         const FlexionFrame& frame, const ScanFrame& scan)
{
  std::vector<std::pair<std::string, Mesh>> meshes;
  const auto add = [&](const Body& body, const Pose& X_reference_body) {
    Mesh mesh;
    for (const Part* part : {&body.contact, &body.visual})
      append(mesh, transformed(part->mesh, scan.X_scan_reference * X_reference_body));
    mesh.vertices_mm /= scan.unit_mm;
    meshes.emplace_back(body.name, std::move(mesh));
  };
  add(model.reference, Pose::Identity());
  add(model.moving, frame.pose.X_reference_moving);
  for (const store::FollowerRows* follower : store::in_order(model.followers)) {
    const auto body = static_cast<BodyIndex>(follower->body_index);
    if (frame.pose.has_follower.at(model::follower_row(body)))
      add(follower->body, frame.pose.X_reference(body));
  }
  return meshes;
}

std::string markups_in_scan(const store::MotionModel& model, const FlexionMotion& motion,
                            const ScanFrame& scan)
{
  const FlexionFrame& frame = motion.frames.front();
  std::vector<job::Markup> markups;
  const auto point = [&](const std::string& label, const Eigen::Vector3d& p_reference_mm) {
    return job::LabelledPoint{label, scan.X_scan_reference * p_reference_mm};
  };
  const auto add_axis = [&](const std::string& name, const Pose& X_reference_body,
                            const Eigen::Vector3d& axis) {
    constexpr double half_length_mm = 50.0;  // beyond both sides of a knee
    job::Markup& line = markups.emplace_back(job::Markup{name, true, {}});
    for (const double sign : {-1.0, 1.0})
      line.points.push_back(
          point(name, X_reference_body * (model.rotation_centre_mm + sign * half_length_mm * axis)));
  };
  add_axis("flexion axis", Pose::Identity(), Eigen::Vector3d::UnitZ());
  add_axis("rotation axis", frame.pose.X_reference_moving, Eigen::Vector3d::UnitY());
  job::Markup attachments{"attachments", false, {}};
  const auto add_fibres = [&](const std::optional<store::LigamentRows>& rows) {
    for (std::size_t k = 0; rows && k < rows->name.size(); ++k) {
      const auto end = [&](const std::vector<std::int8_t>& bodies, BodyIndex otherwise, const Points& at_mm) {
        const BodyIndex body = bodies.empty() ? otherwise : static_cast<BodyIndex>(bodies[k]);
        attachments.points.push_back(
            point(rows->name[k],
                  frame.pose.X_reference(body) * Eigen::Vector3d(at_mm.row(static_cast<Eigen::Index>(k)))));
      };
      end(rows->from_body, BodyIndex::reference, rows->reference_mm);
      end(rows->to_body, BodyIndex::moving, rows->moving_mm);
    }
  };
  add_fibres(model.ligaments);
  for (const store::FollowerRows* follower : store::in_order(model.followers))
    add_fibres(follower->ligaments);
  if (!attachments.points.empty()) markups.push_back(attachments);
  if (const Eigen::Index cell = motion.set == "raw" ? raw_cell(model, frame) : -1; cell >= 0) {
    job::Markup contacts{"contacts", false, {}};
    const auto c = static_cast<std::size_t>(cell);
    for (std::int64_t k = model.contacts.row_start[c]; k < model.contacts.row_start[c + 1]; ++k)
      contacts.points.push_back(point("contact", frame.pose.X_world_reference.inverse() *
                                                     Eigen::Vector3d(model.contacts.point_world_mm.row(k))));
    if (!contacts.points.empty()) markups.push_back(contacts);
  }
  return job::markups_text(markups, scan.space.empty() ? "LPS" : scan.space);
}

}  // namespace vrda::tables
