#include "store/joint_parts.hpp"

#include <algorithm>

#include "model/mesh.hpp"
#include "model/side.hpp"

namespace vrda::store {
namespace {

/// Distances of the labels from the rotation centre, and from the plateau's sides, on a knee.
constexpr double femur_height_mm = 38.0, tibia_depth_mm = 62.0, side_distance_mm = 7.0;

void add_ligaments(const store::MotionModel& model, std::vector<JointLabel>& labels)
{
  if (!model.ligaments) return;
  const store::LigamentRows& rows = *model.ligaments;
  std::vector<std::string> found;
  for (const std::string& bundle : rows.bundle) {
    const std::string name = model::ligament_of(bundle);
    if (!name.empty() && std::ranges::find(found, name) == found.end()) found.push_back(name);
  }
  for (const std::string& name : found) {
    JointLabel label{name, JointBody::reference, JointBody::moving};
    double n = 0.0;
    for (std::size_t i = 0; i < rows.bundle.size(); ++i) {
      if (model::ligament_of(rows.bundle[i]) != name) continue;
      label.first_mm += rows.reference_mm.row(static_cast<Eigen::Index>(i)).transpose();
      label.second_mm += rows.moving_mm.row(static_cast<Eigen::Index>(i)).transpose();
      n += 1.0;
    }
    label.first_mm /= n;
    label.second_mm /= n;
    labels.push_back(label);
  }
}

/// Where a body's name is: of a knee at a distance from the rotation centre, else in the middle of its
/// contact parts.
Eigen::Vector3d name_mm(const store::MotionModel& model, JointBody body)
{
  const bool is_reference = body == JointBody::reference;
  if (model.joint == "knee") {
    const double height_mm = is_reference ? femur_height_mm : -tibia_depth_mm;
    return model.rotation_centre_mm + width_ratio(model.moving) * height_mm * Eigen::Vector3d::UnitY();
  }
  const Box box = bounding_box((is_reference ? model.reference : model.moving).contact.mesh);
  return 0.5 * (box.min_mm + box.max_mm);
}

void add_point(std::vector<JointLabel>& labels, const std::string& text, JointBody body,
               const Eigen::Vector3d& p_mm)
{
  labels.push_back({text, body, body, p_mm, p_mm});
}

}  // namespace

double width_ratio(const Body& moving)
{
  constexpr double width_of_knee_mm = 80.0;
  const Box box = bounding_box(moving.contact.mesh);
  const Eigen::Vector3d size_mm = box.max_mm - box.min_mm;
  const double width_mm = std::max(size_mm.x(), size_mm.z());
  return width_mm > 0.0 ? width_mm / width_of_knee_mm : 1.0;
}

std::string displayed_name(const store::MotionModel& model, JointBody body)
{
  if (model.joint == "knee") return body == JointBody::reference ? "femur" : "tibia";
  return body == JointBody::reference ? model.reference.name : model.moving.name;
}

std::vector<JointLabel> joint_labels(const store::MotionModel& model)
{
  std::vector<JointLabel> labels;
  for (const JointBody body : {JointBody::reference, JointBody::moving})
    add_point(labels, displayed_name(model, body), body, name_mm(model, body));
  add_ligaments(model, labels);
  if (!model.has_compartments) return labels;
  // The subject's right is +Z, so medial is -Z in a right joint.
  const Box box = bounding_box(model.moving.contact.mesh);
  const double lateral = side_named(model.side) == Side::right ? 1.0 : -1.0;
  const Eigen::Vector3d middle_mm = 0.5 * (box.min_mm + box.max_mm);
  const double half_mm =
      0.5 * (box.max_mm.z() - box.min_mm.z()) + width_ratio(model.moving) * side_distance_mm;
  for (const double side : {-lateral, lateral}) {
    const Eigen::Vector3d p_mm(middle_mm.x(), box.max_mm.y(), middle_mm.z() + side * half_mm);
    add_point(labels, side == lateral ? "lateral" : "medial", JointBody::moving, p_mm);
  }
  return labels;
}

model::Ligaments ligaments_of(const store::MotionModel& model)
{
  model::Ligaments ligaments;
  if (!model.ligaments) return ligaments;
  const store::LigamentRows& rows = *model.ligaments;
  ligaments.transition_strain = rows.transition_strain;
  for (std::size_t i = 0; i < rows.wrap_name.size(); ++i) {
    model::Wrap wrap;
    wrap.name = rows.wrap_name[i];
    wrap.shape = rows.wrap_shape[i] == 0 ? model::WrapShape::cylinder : model::WrapShape::ellipsoid;
    wrap.body = rows.wrap_body[i] == 0 ? model::WrapBody::reference : model::WrapBody::moving;
    wrap.X_body_wrap = store::pose_in(rows.X_body_wrap, i);
    wrap.radii_mm = rows.wrap_radii_mm.row(static_cast<Eigen::Index>(i)).transpose();
    ligaments.wraps.push_back(wrap);
  }
  for (std::size_t i = 0; i < rows.name.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    ligaments.fibres.push_back({rows.name[i], rows.bundle[i], rows.reference_mm.row(row).transpose(),
                                rows.moving_mm.row(row).transpose(), rows.stiffness_n[i],
                                rows.slack_length_mm[i], rows.wrap[i]});
  }
  return ligaments;
}

}  // namespace vrda::store
