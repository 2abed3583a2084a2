#include "store/mechanics_layout.hpp"

#include "store/dataset_specs.hpp"

namespace vrda {
namespace {

void add_push(FileLayout& layout)
{
  layout.groups.emplace_back("/push");
  layout.attributes.push_back({"/push", "point_mm", ValueKind::float64, 3});
  layout.datasets.insert(layout.datasets.end(),
                         {numbers("/push/delta", ValueKind::float64, {"/flexion", "/xyz"}, "1",
                                  "unit direction Delta in which the moving object is pushed, world W"),
                          numbers("/push/force", ValueKind::float64, {"/flexion", "/xyz"}, "N",
                                  "force on the moving object, along Delta and across it, world W"),
                          numbers("/push/moment", ValueKind::float64, {"/flexion"}, "N mm",
                                  "moment on the moving object about Delta, right-knee sign"),
                          numbers("/push/varus_moment", ValueKind::float64, {"/flexion"}, "N mm",
                                  "moment on the moving object in varus")});
}

void add_contact_paths(FileLayout& layout)
{
  const Dimensions points{"/flexion", "/varus", "/xyz"};
  layout.groups.emplace_back("/contact_paths");
  layout.datasets.insert(
      layout.datasets.end(),
      {answers("/contact_paths/medial_reference", points, "mm",
               "where the medial compartment bears, canonical axes of the reference body"),
       answers("/contact_paths/medial_moving", points, "mm",
               "where the medial compartment bears, canonical axes of the moving body"),
       answers("/contact_paths/lateral_reference", points, "mm",
               "where the lateral compartment bears, canonical axes of the reference body"),
       answers("/contact_paths/lateral_moving", points, "mm",
               "where the lateral compartment bears, canonical axes of the moving body")});
}

void add_forces(FileLayout& layout, const FileShape& shape)
{
  layout.groups.emplace_back("/equilibrium/forces");
  layout.dimensions.push_back({"/equilibrium/forces/force", *shape.n_forces});
  layout.dimensions.push_back({"/equilibrium/forces/cell_bound", shape.n_flexion * shape.n_varus + 1});
  const Dimensions force{"/equilibrium/forces/force"};
  const Dimensions vectors{"/equilibrium/forces/force", "/xyz"};
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/equilibrium/forces/row_start", ValueKind::int64, {"/equilibrium/forces/cell_bound"}, "1",
               "first force of each cell, cells in the order of the grid, then the number of forces"),
       numbers("/equilibrium/forces/point", ValueKind::float64, vectors, "mm",
               "where the force acts, world W"),
       numbers("/equilibrium/forces/normal", ValueKind::float64, vectors, "1",
               "unit direction of the force on the moving object, world W"),
       numbers("/equilibrium/forces/along_delta", ValueKind::float64, force, "N",
               "part of the force against Delta: what it takes of the push"),
       numbers("/equilibrium/forces/triangle_reference", ValueKind::int32, force, "1",
               "row of /bodies/reference/triangles"),
       numbers("/equilibrium/forces/triangle_moving", ValueKind::int32, force, "1",
               "row of /bodies/moving/triangles"),
       codes("/equilibrium/forces/compartment", force, FlagSet::compartment,
             "compartment that the force lies in")});
}

void add_free_spine(FileLayout& layout)
{
  const std::string group = "/equilibrium/spine";
  const Dimensions flexion{"/flexion"};
  layout.groups.push_back(group);
  layout.datasets.insert(
      layout.datasets.end(),
      {codes(group + "/status", flexion, FlagSet::solver_status, "how the motion step with free varus ended"),
       answers(group + "/varus", flexion, "degree", "varus at rest, adduction positive"),
       answers(group + "/tx", flexion, "mm", "translation along X of the world frame W"),
       answers(group + "/ty", flexion, "mm", "translation along Y of the world frame W"),
       answers(group + "/tz", flexion, "mm", "translation along Z of the world frame W"),
       answers(group + "/theta", flexion, "degree", "rotation about Delta, right-knee sign"),
       answers(group + "/energy", flexion, "N mm", "energy at rest"),
       answers(group + "/theta_low", flexion, "degree", "theta under a moment of -band_moment_nmm more"),
       answers(group + "/theta_high", flexion, "degree", "theta under a moment of +band_moment_nmm more"),
       numbers(group + "/n_optima", ValueKind::int32, flexion, "1",
               "different places of rest that the starts led to"),
       answers(group + "/optima_theta_spread", flexion, "degree",
               "largest less smallest theta of the places of rest"),
       answers(group + "/optima_energy_spread", flexion, "N mm",
               "largest less smallest energy of the places of rest")});
}

void add_equilibrium(FileLayout& layout, const FileShape& shape)
{
  layout.groups.emplace_back("/equilibrium");
  layout.attributes.push_back({"/equilibrium", "band_moment_nmm", ValueKind::float64, 1});
  layout.datasets.insert(
      layout.datasets.end(),
      {surface("/equilibrium/energy", "N mm", "energy of the ligaments less the work of the loads"),
       surface("/equilibrium/balance_residual", "N",
               "what is left unbalanced along the free coordinates, moments divided by a lever"),
       surface("/equilibrium/complementarity", "mm",
               "gaps of the load-bearing features, weighted by their share of the load"),
       surface("/equilibrium/worst_gap", "mm", "smallest signed gap of any feature, negative is overlap"),
       surface("/equilibrium/flexion_moment", "N mm",
               "moment that holds the moving object in flexion over the reference"),
       surface("/equilibrium/varus_moment", "N mm",
               "moment that holds the moving object in varus over the reference")});
  if (shape.has_compartments) {
    const Dimensions vectors{"/flexion", "/varus", "/xyz"};
    layout.datasets.push_back(answers("/equilibrium/force_medial", vectors, "N",
                                      "sum of the medial contact forces on the moving object, world W"));
    layout.datasets.push_back(answers("/equilibrium/force_lateral", vectors, "N",
                                      "sum of the lateral contact forces on the moving object, world W"));
  }
  add_forces(layout, shape);
  add_free_spine(layout);
}

void add_wraps(FileLayout& layout, const LigamentShape& shape)
{
  layout.dimensions.push_back({"/ligaments/wrapping", shape.n_wraps});
  const Dimensions wrap{"/ligaments/wrapping"};
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/ligaments/wrap_name", ValueKind::text, wrap, "", "names of the wrapping surfaces"),
       codes("/ligaments/wrap_shape", wrap, FlagSet::wrap_shape, "shape of the wrapping surface"),
       codes("/ligaments/wrap_body", wrap, FlagSet::body, "body that the wrapping surface is fixed to"),
       numbers("/ligaments/X_body_wrap", ValueKind::float64, {"/ligaments/wrapping", "/row", "/column"}, "mm",
               "pose taking points of the wrapping surface to canonical axes of its body; the rotation in "
               "columns 0 to 2 has no unit"),
       numbers("/ligaments/wrap_radii", ValueKind::float64, {"/ligaments/wrapping", "/xyz"}, "mm",
               "half-axes of an ellipsoid; radius, radius and half length of a cylinder along its Z")});
}

void add_ligaments(FileLayout& layout, const LigamentShape& shape)
{
  layout.groups.emplace_back("/ligaments");
  layout.attributes.push_back({"/ligaments", "transition_strain", ValueKind::float64, 1});
  layout.dimensions.push_back({"/ligaments/fibre", shape.n_fibres});
  const Dimensions fibre{"/ligaments/fibre"};
  const Dimensions vectors{"/ligaments/fibre", "/xyz"};
  const Dimensions cells{"/flexion", "/varus", "/ligaments/fibre"};
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/ligaments/name", ValueKind::text, fibre, "", "names of the fibres"),
       numbers("/ligaments/bundle", ValueKind::text, fibre, "", "ligament that the fibre belongs to"),
       numbers("/ligaments/reference", ValueKind::float64, vectors, "mm",
               "attachment to the reference body, its canonical axes"),
       numbers("/ligaments/moving", ValueKind::float64, vectors, "mm",
               "attachment to the moving body, its canonical axes"),
       numbers("/ligaments/stiffness", ValueKind::float64, fibre, "N", "force per unit strain"),
       numbers("/ligaments/slack_length", ValueKind::float64, fibre, "mm", "length of zero strain"),
       numbers("/ligaments/wrap", ValueKind::int32, fibre, "1", "row of wrap_name, -1 for none")});
  add_wraps(layout, shape);
  layout.datasets.insert(
      layout.datasets.end(),
      {answers("/ligaments/length", cells, "mm", "length of the fibre"),
       answers("/ligaments/strain", cells, "1", "strain of the fibre, negative is slack"),
       answers("/ligaments/tension", cells, "N", "tension of the fibre"),
       answers("/ligaments/energy", cells, "N mm", "energy of the fibre"),
       codes("/ligaments/is_wrapped", cells, FlagSet::answer, "whether the fibre touches its wrap")});
}

}  // namespace

void add_mechanics(FileLayout& layout, const FileShape& shape)
{
  if (shape.minor_version == 0) return;
  add_push(layout);
  if (shape.has_compartments) add_contact_paths(layout);
  if (shape.n_forces) add_equilibrium(layout, shape);
  if (shape.ligaments) add_ligaments(layout, *shape.ligaments);
}

}  // namespace vrda
