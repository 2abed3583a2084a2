#include "scene/labels.hpp"

#include <algorithm>
#include <array>

#include "core/side.hpp"

namespace vrda::scene {
namespace {

/// Distances of the labels from the rotation centre, and from the plateau's sides, on a knee.
constexpr double femur_height_mm = 38.0, tibia_depth_mm = 62.0, side_distance_mm = 7.0;

/// The ligament of a bundle: "ACLam" gives "ACL".
std::string ligament_of(const std::string& bundle)
{
  for (const char* known : {"ACL", "PCL", "MCL", "LCL"}) {
    if (bundle.starts_with(known)) return known;
  }
  return bundle;
}

void add_ligaments(const store::MotionModel& model, std::vector<JointLabel>& labels)
{
  if (!model.ligaments) return;
  const store::LigamentRows& rows = *model.ligaments;
  std::vector<std::string> names;
  for (const std::string& bundle : rows.bundle) {
    const std::string name = ligament_of(bundle);
    if (!name.empty() && std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  for (const std::string& name : names) {
    JointLabel label{name, Owner::reference, Owner::moving};
    double n = 0.0;
    for (std::size_t i = 0; i < rows.bundle.size(); ++i) {
      if (ligament_of(rows.bundle[i]) != name) continue;
      label.first_mm += rows.reference_mm.row(static_cast<Eigen::Index>(i)).transpose();
      label.second_mm += rows.moving_mm.row(static_cast<Eigen::Index>(i)).transpose();
      n += 1.0;
    }
    label.first_mm /= n;
    label.second_mm /= n;
    labels.push_back(label);
  }
}

void add_point(std::vector<JointLabel>& labels, const std::string& text, Owner owner,
               const Eigen::Vector3d& p_mm)
{
  labels.push_back({text, owner, owner, p_mm, p_mm});
}

}  // namespace

std::string displayed_name(const store::MotionModel& model, Owner owner)
{
  if (model.joint == "knee") return owner == Owner::reference ? "femur" : "tibia";
  return owner == Owner::reference ? model.reference.name : model.moving.name;
}

std::vector<JointLabel> joint_labels(const store::MotionModel& model)
{
  std::vector<JointLabel> labels;
  const double scale = marker_scale(model);
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  add_point(labels, displayed_name(model, Owner::reference), Owner::reference,
            centre_mm + scale * femur_height_mm * Eigen::Vector3d::UnitY());
  add_point(labels, displayed_name(model, Owner::moving), Owner::moving,
            centre_mm - scale * tibia_depth_mm * Eigen::Vector3d::UnitY());
  add_ligaments(model, labels);
  if (!model.has_compartments) return labels;
  // The subject's right is +Z, so medial is -Z in a right joint.
  const Box box = bounding_box(model.moving.contact.mesh);
  const double lateral = side_named(model.side) == Side::right ? 1.0 : -1.0;
  const Eigen::Vector3d middle_mm = 0.5 * (box.min_mm + box.max_mm);
  const double half_mm = 0.5 * (box.max_mm.z() - box.min_mm.z()) + scale * side_distance_mm;
  for (const double side : {-lateral, lateral}) {
    const Eigen::Vector3d p_mm(middle_mm.x(), box.max_mm.y(), middle_mm.z() + side * half_mm);
    add_point(labels, side == lateral ? "lateral" : "medial", Owner::moving, p_mm);
  }
  return labels;
}

Eigen::Vector3d place_of(const JointLabel& label, const JointFrames& frames)
{
  const auto placed = [&](Owner owner, const Eigen::Vector3d& p_mm) -> Eigen::Vector3d {
    return owner == Owner::reference ? frames.X_world_reference * p_mm
                                     : frames.X_world_delta * (frames.X_delta_moving * p_mm);
  };
  return 0.5 * (placed(label.first, label.first_mm) + placed(label.second, label.second_mm));
}

}  // namespace vrda::scene
