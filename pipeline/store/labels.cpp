// Ligaments and names of a joint as they are drawn.
#include <algorithm>

#include "store/motion.hpp"

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
    JointLabel label{name, BodyIndex::reference, BodyIndex::moving};
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
Eigen::Vector3d name_mm(const store::MotionModel& model, BodyIndex body)
{
  const bool is_reference = body == BodyIndex::reference;
  if (model.joint == "knee") {
    const double height_mm = is_reference ? femur_height_mm : -tibia_depth_mm;
    return model.rotation_centre_mm + width_ratio(model.moving) * height_mm * Eigen::Vector3d::UnitY();
  }
  const Box box = bounding_box(part_of(model, body).contact.mesh);
  return 0.5 * (box.min_mm + box.max_mm);
}

void add_point(std::vector<JointLabel>& labels, const std::string& text, BodyIndex body,
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

std::string displayed_name(const store::MotionModel& model, BodyIndex body)
{
  if (model.joint == "knee") return body == BodyIndex::reference ? "femur" : "tibia";
  return part_of(model, body).name;
}

std::vector<JointLabel> joint_labels(const store::MotionModel& model)
{
  std::vector<JointLabel> labels;
  for (const BodyIndex body : all_bodies)
    add_point(labels, displayed_name(model, body), body, name_mm(model, body));
  for (const FollowerRows& follower : model.followers) {
    const Box box = bounding_box(follower.body.contact.mesh);
    add_point(labels, follower.name, static_cast<BodyIndex>(follower.body_index),
              0.5 * (box.min_mm + box.max_mm));
  }
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
    add_point(labels, side == lateral ? "lateral" : "medial", BodyIndex::moving, p_mm);
  }
  return labels;
}

namespace {

model::Ligaments ligaments_of(const store::LigamentRows& rows)
{
  model::Ligaments ligaments;
  ligaments.transition_strain = rows.transition_strain;
  for (std::size_t i = 0; i < rows.wrap_name.size(); ++i) {
    model::Wrap wrap;
    wrap.name = rows.wrap_name[i];
    wrap.shape = rows.wrap_shape[i] == 0 ? model::WrapShape::cylinder : model::WrapShape::ellipsoid;
    wrap.body = static_cast<BodyIndex>(rows.wrap_body[i]);
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

}  // namespace

model::Ligaments ligaments_of(const store::MotionModel& model)
{
  return model.ligaments ? ligaments_of(*model.ligaments) : model::Ligaments{};
}

model::Ligaments ligaments_of(const store::FollowerRows& follower)
{
  if (!follower.ligaments) return {};
  model::Ligaments ligaments = ligaments_of(*follower.ligaments);
  for (std::size_t k = 0; k < ligaments.fibres.size(); ++k) {
    model::Fibre& fibre = ligaments.fibres[k];
    fibre.from = static_cast<BodyIndex>(follower.ligaments->from_body[k]);
    fibre.to = static_cast<BodyIndex>(follower.ligaments->to_body[k]);
    fibre.tension_n = follower.ligaments->constant_tension_n[k];
  }
  for (model::Wrap& wrap : ligaments.wraps)
    wrap.body = model::row_of(wrap.body) == static_cast<std::size_t>(follower.body_index)
                    ? BodyIndex::moving
                    : BodyIndex::reference;
  return ligaments;
}

std::vector<const store::FollowerRows*> in_order(const std::vector<store::FollowerRows>& followers)
{
  std::vector<const store::FollowerRows*> order;
  for (const store::FollowerRows& follower : followers) order.push_back(&follower);
  std::sort(order.begin(), order.end(),
            [](const auto* a, const auto* b) { return a->body_index < b->body_index; });
  return order;
}

}  // namespace vrda::store
