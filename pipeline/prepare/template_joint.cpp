#include "prepare/template_joint.hpp"

#include "core/error.hpp"
#include "job/job.hpp"
#include "job/shells.hpp"
#include "geometry/knee_surfaces.hpp"

namespace vrda::prepare {
namespace {

constexpr const char* generic_job = R"(title = "Generic knee"
[reference]
name = "femur"
[[reference.component]]
name = "femur"
generate = { shape = "knee-template", part = "femur" }
[moving]
name = "tibia"
[[moving.component]]
name = "tibia"
generate = { shape = "knee-template", part = "tibia" }
[[moving.component]]
name = "fibula"
generate = { shape = "knee-template", part = "fibula" }
contact = false
[grid]
flexion = { from = 0, to = 90, step = 10 }
varus = "free"
[solver]
method = "equilibrium"
[ligaments]
generate = { shape = "knee-template" }
)";

bool is_fibula(const std::string& name)
{
  return name.find("fibula") != std::string::npos;
}

Mesh fibula_of(const Body& body)
{
  Mesh fibula;
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      if (is_fibula(body.components[c].name)) append(fibula, select_triangles(part->mesh, rows[c]));
    }
  }
  return fibula;
}

Eigen::Vector3d flipped(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), -v.z()};
}

model::Ligaments mirrored(model::Ligaments ligaments)
{
  const Eigen::DiagonalMatrix<double, 3> flip(1.0, 1.0, -1.0);
  for (model::Fibre& fibre : ligaments.fibres) {
    fibre.reference_mm = flipped(fibre.reference_mm);
    fibre.moving_mm = flipped(fibre.moving_mm);
  }
  for (model::Wrap& wrap : ligaments.wraps) {
    // An ellipsoid and a cylinder are symmetric in their own Z = 0.
    const Eigen::Matrix3d R = flip * wrap.X_body_wrap.linear() * flip;
    wrap.X_body_wrap.linear() = R;
    wrap.X_body_wrap.translation() = flipped(wrap.X_body_wrap.translation());
  }
  return ligaments;
}

}  // namespace

geometry::BoneSurfaces surfaces_of(const Body& body)
{
  geometry::BoneSurfaces surfaces;
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      const Component& component = body.components[c];
      if (rows[c].empty() || is_fibula(component.name)) continue;
      const Mesh mesh = job::outer_surface(select_triangles(part->mesh, rows[c]));
      if (component.material == "bone") append(surfaces.bone, mesh);
      if (component.material == "cartilage") append(surfaces.cartilage, mesh);
    }
  }
  return surfaces;
}

TemplateJoint mirrored(const TemplateJoint& joint)
{
  TemplateJoint other = joint;
  job::Case& c = other.joint;
  c.frame.side = c.frame.side == Side::left ? Side::right : Side::left;
  c.frame.rotation_centre_mm = flipped(c.frame.rotation_centre_mm);
  c.reference = mirrored_z(c.reference);
  c.moving = mirrored_z(c.moving);
  c.ligaments = mirrored(c.ligaments);
  other.knee = {mirrored_z(joint.knee.surfaces), flipped(joint.knee.origin_mm)};
  other.fibula = mirrored_z(joint.fibula);
  return other;
}

TemplateJoint template_of(const job::Case& joint)
{
  if (joint.joint != "knee" || joint.method != "equilibrium")
    throw InputError({"--template", "\"" + joint.title + "\"", joint.joint + ", " + joint.method,
                      "a knee with solver.method = \"equilibrium\""});
  TemplateJoint found{
      joint,
      {{surfaces_of(joint.reference), surfaces_of(joint.moving)}, joint.frame.rotation_centre_mm},
      fibula_of(joint.moving)};
  return joint.frame.side == Side::left ? mirrored(found) : found;
}

TemplateJoint generic_template()
{
  TemplateJoint knee = template_of(job::load_case(job::parse_job("generic knee", generic_job), ""));
  knee.knee = geometry::generic_template();
  return knee;
}

}  // namespace vrda::prepare
