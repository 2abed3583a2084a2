#include "store/derived_layout.hpp"

#include "store/dataset_specs.hpp"
#include "store/evaluate_smoothed.hpp"

namespace vrda {
namespace {

std::string dataset_of(const std::string& name)
{
  return name == "varus" ? "varus_solved" : name;
}

void add_set(FileLayout& layout, const FileShape& shape, const SmoothedShape& set)
{
  const std::string group = smoothed_group(set.degree);
  const Dimensions term{group + "/term"};
  layout.groups.push_back(group);
  layout.attributes.push_back({group, "degree", ValueKind::int32, 1});
  if (shape.minor_version >= 2) layout.attributes.push_back({group, "is_robust", ValueKind::int8, 1});
  layout.dimensions.push_back({group + "/term", set.n_terms});
  layout.dimensions.push_back({group + "/axis", 2});
  layout.datasets.push_back(numbers(group + "/exponents", ValueKind::int32,
                                    {group + "/term", group + "/axis"}, "1",
                                    "degree of each term's Legendre polynomial of flexion and of varus"));
  for (const std::string& name : smoothed_names(set)) {
    const char* units = name == "theta" || name == "varus" ? "degree" : "mm";
    const std::string path = smoothed_path(set.degree, name);
    layout.datasets.push_back(
        numbers(path, ValueKind::float64, grid_dimensions(), units, "smoothed surface on the grid"));
    layout.datasets.push_back(numbers(coefficients_path(set.degree, name), ValueKind::float64, term, units,
                                      "coefficients of the terms"));
    layout.attributes.push_back({path, "n_cells", ValueKind::int32, 1});
    for (const char* measure : {"rms", "largest_residual", "leave_one_out_rms", "condition_number"}) {
      layout.attributes.push_back({path, measure, ValueKind::float64, 1});
    }
  }
  if (!set.has_recontact) return;
  layout.datasets.push_back(
      surface(group + "/recontact", "mm", "travel along Delta from the smoothed pose into contact"));
}

void add_zero_varus_poses(FileLayout& layout, const std::string& group)
{
  const Dimensions flexion{"/flexion"};
  layout.datasets.insert(
      layout.datasets.end(),
      {codes(group + "/source", flexion, FlagSet::zero_varus_source, "where the varus comes from"),
       answers(group + "/varus", flexion, "degree", "varus of the attitude, adduction positive"),
       answers(group + "/varus_first", flexion, "degree", "first varus at which both compartments touch"),
       answers(group + "/varus_last", flexion, "degree", "last varus at which both compartments touch"),
       answers(group + "/tx", flexion, "mm", "translation along X of the world frame W"),
       answers(group + "/ty", flexion, "mm", "translation along Y of the world frame W"),
       answers(group + "/tz", flexion, "mm", "translation along Z of the world frame W"),
       answers(group + "/theta", flexion, "degree", "rotation about Delta, right-knee sign"),
       answers(
           group + "/X_reference_moving", {"/flexion", "/row", "/column"}, "mm",
           "pose taking stored moving vertices to stored reference vertices; the rotation in columns 0 to "
           "2 has no unit"),
       answers(group + "/flexion_angle", flexion, "degree", "Grood-Suntay flexion"),
       answers(group + "/varus_angle", flexion, "degree", "Grood-Suntay varus, adduction positive"),
       answers(group + "/internal_rotation", flexion, "degree", "Grood-Suntay internal rotation"),
       answers(group + "/anterior", flexion, "mm", "anterior translation along the floating axis"),
       answers(group + "/proximal", flexion, "mm", "proximal translation along the moving body's long axis"),
       answers(group + "/lateral", flexion, "mm", "lateral translation along the flexion axis")});
}

void add_zero_varus_contacts(FileLayout& layout, const std::string& group)
{
  const Dimensions points{"/flexion", "/xyz"};
  layout.datasets.insert(
      layout.datasets.end(),
      {answers(group + "/medial_reference", points, "mm",
               "where the medial compartment bears, canonical axes of the reference body"),
       answers(group + "/medial_moving", points, "mm",
               "where the medial compartment bears, canonical axes of the moving body"),
       answers(group + "/lateral_reference", points, "mm",
               "where the lateral compartment bears, canonical axes of the reference body"),
       answers(group + "/lateral_moving", points, "mm",
               "where the lateral compartment bears, canonical axes of the moving body")});
}

void add_zero_varus_intervals(FileLayout& layout, const std::string& group, const FileShape& shape)
{
  layout.dimensions.push_back({group + "/interval", shape.n_flexion - 1});
  layout.dimensions.push_back({group + "/sagittal", 2});
  const Dimensions interval{group + "/interval"};
  const Dimensions vectors{group + "/interval", "/xyz"};
  layout.datasets.insert(
      layout.datasets.end(),
      {answers(group + "/helical_rotation", interval, "degree", "rotation about the finite helical axis"),
       answers(group + "/helical_translation", interval, "mm", "translation along the finite helical axis"),
       answers(group + "/helical_direction", vectors, "1",
               "unit direction of the finite helical axis, canonical axes of the reference body"),
       answers(group + "/helical_point", vectors, "mm",
               "point of the finite helical axis, canonical axes of the reference body"),
       answers(group + "/instant_centre", {group + "/interval", group + "/sagittal"}, "mm",
               "instant centre in the sagittal plane: anterior, proximal")});
  if (!shape.has_compartments) return;
  layout.datasets.insert(
      layout.datasets.end(),
      {answers(group + "/medial_rolling", interval, "mm", "rolling in the medial compartment"),
       answers(group + "/medial_sliding", interval, "mm", "sliding in the medial compartment"),
       answers(group + "/lateral_rolling", interval, "mm", "rolling in the lateral compartment"),
       answers(group + "/lateral_sliding", interval, "mm", "sliding in the lateral compartment")});
}

void add_audit(FileLayout& layout, const AuditShape& shape)
{
  const std::string group = audit_group(shape.name);
  const std::string flexion = group + "/flexion", varus = group + "/varus";
  layout.groups.push_back(group);
  layout.attributes.push_back({group, "refine", ValueKind::int32, 1});
  layout.attributes.push_back({group, "largest_penetration", ValueKind::float64, 1});
  layout.attributes.push_back({group, "largest_gap", ValueKind::float64, 1});
  layout.dimensions.push_back({flexion, shape.n_flexion});
  layout.dimensions.push_back({varus, shape.n_varus});
  const Dimensions grid{flexion, varus};
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers(flexion, ValueKind::float64, {flexion}, "degree", "flexion of the attitude"),
       numbers(varus, ValueKind::float64, {varus}, "degree", "varus of the attitude, adduction positive"),
       codes(group + "/state", grid, FlagSet::audit_state, "what the audit found"),
       answers(group + "/gap", grid, "mm", "travel along Delta to the next touch"),
       answers(group + "/penetration", grid, "mm", "travel back along Delta to the first touch from afar")});
}

}  // namespace

const std::vector<std::string>& smoothed_names(const SmoothedShape& shape)
{
  static const std::vector<std::string> four{"tx", "ty", "tz", "theta"};
  static const std::vector<std::string> five{"tx", "ty", "tz", "theta", "varus"};
  return shape.has_varus ? five : four;
}

std::string smoothed_group(std::int32_t degree)
{
  return "/smoothed/degree_" + std::to_string(degree);
}

std::string smoothed_path(std::int32_t degree, const std::string& name)
{
  return smoothed_group(degree) + "/" + dataset_of(name);
}

std::string coefficients_path(std::int32_t degree, const std::string& name)
{
  return smoothed_group(degree) + "/coefficients_" + dataset_of(name);
}

bool is_audit_name(const std::string& name)
{
  if (name == "raw" || name == "zero_varus") return true;
  for (int degree = 0; degree <= largest_smoothed_degree; ++degree) {
    const std::string set = "degree_" + std::to_string(degree);
    if (name == set || name == set + "_recontacted") return true;
  }
  return false;
}

std::string audit_group(const std::string& name)
{
  return "/audit/" + name;
}

void add_smoothed(FileLayout& layout, const FileShape& shape)
{
  layout.groups.emplace_back("/smoothed");
  for (const SmoothedShape& set : shape.smoothed) add_set(layout, shape, set);
}

void add_zero_varus(FileLayout& layout, const FileShape& shape)
{
  const std::string group = "/zero_varus";
  layout.groups.push_back(group);
  layout.attributes.push_back({group, "set", ValueKind::text, 1});
  add_zero_varus_poses(layout, group);
  if (shape.has_compartments) add_zero_varus_contacts(layout, group);
  add_zero_varus_intervals(layout, group, shape);
}

void add_audits(FileLayout& layout, const FileShape& shape)
{
  if (shape.audits.empty()) return;
  layout.groups.emplace_back("/audit");
  for (const AuditShape& audit : shape.audits) add_audit(layout, audit);
}

}  // namespace vrda
