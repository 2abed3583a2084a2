#include "store/model_shape.hpp"

#include "core/error.hpp"
#include "store/derived_layout.hpp"

namespace vrda {
namespace {

PartShape shape_of(const Part& part)
{
  check(part.mesh.normals.rows() == 0 || part.mesh.normals.rows() == part.mesh.vertices_mm.rows(),
        "a mesh has as many normals as vertices, or none");
  return {part.mesh.vertices_mm.rows(), part.mesh.triangles.rows(), part.mesh.normals.rows() > 0};
}

BodyShape shape_of(const Body& body)
{
  const PartShape visual = shape_of(body.visual);
  return {static_cast<std::int64_t>(body.components.size()), shape_of(body.contact),
          visual.n_vertices > 0 || visual.n_triangles > 0, visual};
}

LigamentShape shape_of(const LigamentRows& ligaments)
{
  return {static_cast<std::int64_t>(ligaments.name.size()),
          static_cast<std::int64_t>(ligaments.wrap_name.size())};
}

SmoothedShape shape_of(const SmoothedSet& set)
{
  SmoothedShape shape{set.degree, set.exponents.rows(), set.surfaces.size() == 5,
                      set.recontact_mm.has_value()};
  const std::vector<std::string>& names = smoothed_names(shape);
  check(set.surfaces.size() == names.size(), "a smoothed set holds tx, ty, tz, theta and perhaps varus");
  for (std::size_t i = 0; i < names.size(); ++i) {
    check(set.surfaces[i].name == names[i],
          "a smoothed set holds tx, ty, tz, theta and perhaps varus, in this order");
  }
  return shape;
}

AuditShape shape_of(const AuditSet& audit)
{
  check(is_audit_name(audit.name), "an audit has the name of a motion");
  return {audit.name, static_cast<std::int64_t>(audit.flexion_deg.size()),
          static_cast<std::int64_t>(audit.varus_deg.size())};
}

void add_derived_shape(FileShape& shape, const MotionModel& model)
{
  for (const SmoothedSet& set : model.smoothed) {
    check(shape.smoothed.empty() || shape.smoothed.back().degree < set.degree,
          "smoothed sets stand by increasing degree, each degree once");
    shape.smoothed.push_back(shape_of(set));
  }
  shape.has_zero_varus = model.zero_varus.has_value();
  for (const AuditSet& audit : model.audits) {
    check(shape.audits.empty() || shape.audits.back().name < audit.name,
          "audits stand by name, each name once");
    shape.audits.push_back(shape_of(audit));
  }
}

}  // namespace

FileShape shape_of(const MotionModel& model)
{
  check(model.equilibrium.has_value() == (model.method == "equilibrium"),
        "a motion model has the surfaces of its method");
  check(model.contact_paths.has_value() == model.has_compartments,
        "a motion model has contact paths where it has compartments");
  FileShape shape;
  shape.n_flexion = static_cast<std::int64_t>(model.flexion_deg.size());
  shape.n_varus = static_cast<std::int64_t>(model.varus_deg.size());
  shape.has_compartments = model.has_compartments;
  shape.n_contacts = static_cast<std::int64_t>(model.contacts.distance_mm.size());
  if (model.equilibrium)
    shape.n_forces = static_cast<std::int64_t>(model.equilibrium->forces.along_delta_n.size());
  if (model.ligaments) shape.ligaments = shape_of(*model.ligaments);
  shape.reference = shape_of(model.reference);
  shape.moving = shape_of(model.moving);
  add_derived_shape(shape, model);
  shape.n_inputs = static_cast<std::int64_t>(model.job.inputs.size());
  if (model.job.scaling) shape.n_landmarks = static_cast<std::int64_t>(model.job.scaling->landmark.size());
  return shape;
}

}  // namespace vrda
