#include "store/layout.hpp"

#include <algorithm>
#include <limits>

#include "core/error.hpp"
#include "core/plausibility.hpp"
#include "core/step_record.hpp"
#include "store/dataset_specs.hpp"
#include "store/derived_layout.hpp"
#include "store/mechanics_layout.hpp"

namespace vrda {
namespace {

FlagSet statuses_of(std::int32_t minor_version)
{
  if (minor_version == 0) return FlagSet::search_status;
  return minor_version < 4 ? FlagSet::solver_status : FlagSet::status;
}

void add_root(FileLayout& layout, const FileShape& shape)
{
  layout.dimensions.insert(layout.dimensions.end(),
                           {{"/row", 4}, {"/column", 4}, {"/xyz", 3}, {"/corner", 3}});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/flexion", ValueKind::float64, {"/flexion"}, "degree", "flexion of the attitude"),
       numbers("/varus", ValueKind::float64, {"/varus"}, "degree",
               "varus of the attitude, adduction positive"),
       surface("/tx", "mm", "translation along X of the world frame W"),
       surface("/ty", "mm", "translation along Y of the world frame W"),
       surface("/tz", "mm", "translation along Z of the world frame W"),
       surface("/theta", "degree", "rotation about Delta, right-knee sign"),
       {"/X_reference_moving",
        ValueKind::float64,
        {"/flexion", "/varus", "/row", "/column"},
        "mm",
        "pose taking stored moving vertices to stored reference vertices; the rotation in columns 0 to 2 has "
        "no unit",
        true,
        FlagSet::none},
       flag_surface("/status", statuses_of(shape.minor_version), "how the motion step ended")});
  if (shape.minor_version >= 4) {
    layout.datasets.push_back(flag_surface("/plausibility", FlagSet::plausibility,
                                           "what measuring the stable pose again finds against it"));
  }
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/iterations", ValueKind::int32, grid_dimensions(), "1", "iterations of the motion step"),
       numbers("/queries", ValueKind::int32, grid_dimensions(), "1",
               "collision and gap queries of the motion step"),
       surface("/residual", "mm", "last translation that the solver predicted"),
       flag_surface("/theta_determined", FlagSet::answer,
                    "whether the contacts hold the rotation about Delta"),
       flag_surface("/is_spine", FlagSet::yes_no, "whether the cell is its flexion's cell of the spine")});
  if (shape.minor_version >= 1) {
    layout.datasets.push_back(surface("/varus_solved", "degree", "varus of the pose, adduction positive"));
  }
  if (!shape.has_compartments) return;
  layout.datasets.insert(
      layout.datasets.end(),
      {surface("/gap_medial_mm", "mm", "gap along Delta left in the medial compartment"),
       surface("/gap_lateral_mm", "mm", "gap along Delta left in the lateral compartment"),
       flag_surface("/contact_medial", FlagSet::answer, "whether the medial compartment touches"),
       flag_surface("/contact_lateral", FlagSet::answer, "whether the lateral compartment touches")});
}

void add_clinical(FileLayout& layout)
{
  layout.groups.emplace_back("/clinical");
  layout.datasets.insert(
      layout.datasets.end(),
      {surface("/clinical/flexion_angle", "degree", "Grood-Suntay flexion"),
       surface("/clinical/varus_angle", "degree", "Grood-Suntay varus, adduction positive"),
       surface("/clinical/internal_rotation", "degree", "Grood-Suntay internal rotation"),
       surface("/clinical/anterior", "mm", "anterior translation along the floating axis"),
       surface("/clinical/proximal", "mm", "proximal translation along the moving body's long axis"),
       surface("/clinical/lateral", "mm", "lateral translation along the flexion axis")});
}

void add_contacts(FileLayout& layout, const FileShape& shape)
{
  layout.groups.emplace_back("/contacts");
  layout.dimensions.push_back({"/contacts/contact", shape.n_contacts});
  layout.dimensions.push_back({"/contacts/cell_bound", shape.n_flexion * shape.n_varus + 1});
  const Dimensions contact{"/contacts/contact"};
  const Dimensions vectors{"/contacts/contact", "/xyz"};
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/contacts/row_start", ValueKind::int64, {"/contacts/cell_bound"}, "1",
               "first contact of each cell, cells in the order of the grid, then the number of contacts"),
       numbers("/contacts/point", ValueKind::float64, vectors, "mm",
               "point on the reference's surface, world W"),
       numbers("/contacts/normal", ValueKind::float64, vectors, "1",
               "unit direction of the reaction on the moving object, world W"),
       numbers("/contacts/distance", ValueKind::float64, contact, "mm", "distance of the two surfaces"),
       numbers("/contacts/triangle_reference", ValueKind::int32, contact, "1",
               "row of /bodies/reference/triangles"),
       numbers("/contacts/triangle_moving", ValueKind::int32, contact, "1",
               "row of /bodies/moving/triangles"),
       codes("/contacts/compartment", contact, FlagSet::compartment,
             "compartment that the contact lies in")});
}

void add_part(FileLayout& layout, const std::string& group, const std::string& body, const PartShape& shape)
{
  layout.dimensions.push_back({group + "/vertex", shape.n_vertices});
  layout.dimensions.push_back({group + "/triangle", shape.n_triangles});
  layout.datasets.push_back(numbers(group + "/vertices", ValueKind::float64, {group + "/vertex", "/xyz"},
                                    "mm", "vertices, canonical axes"));
  if (shape.has_normals) {
    layout.datasets.push_back(numbers(group + "/normals", ValueKind::float64, {group + "/vertex", "/xyz"},
                                      "1", "outward unit normals of the vertices, canonical axes"));
  }
  layout.datasets.push_back(numbers(group + "/triangles", ValueKind::int32, {group + "/triangle", "/corner"},
                                    "1", "rows of vertices, counter-clockwise seen from outside"));
  const std::string meaning = "row of " + body + "/component_name of each triangle";
  layout.datasets.push_back(
      numbers(group + "/component", ValueKind::int32, {group + "/triangle"}, "1", meaning.c_str()));
}

void add_body(FileLayout& layout, const std::string& group, const BodyShape& shape)
{
  layout.groups.push_back(group);
  layout.attributes.push_back({group, "name", ValueKind::text, 1});
  layout.dimensions.push_back({group + "/member", shape.n_components});
  const Dimensions member{group + "/member"};
  layout.datasets.push_back(
      numbers(group + "/component_name", ValueKind::text, member, "", "names of the body's components"));
  layout.datasets.push_back(numbers(group + "/component_material", ValueKind::text, member, "",
                                    "materials of the body's components"));
  add_part(layout, group, group, shape.contact);
  if (!shape.has_visual) return;
  layout.groups.push_back(group + "/visual");
  add_part(layout, group + "/visual", group, shape.visual);
}

void add_scaling(FileLayout& layout, std::int64_t n_landmarks)
{
  const std::string group = "/job/scaling";
  const Dimensions pair{group + "/pair"};
  layout.groups.push_back(group);
  layout.attributes.insert(layout.attributes.end(), {{group, "factor", ValueKind::float64, 3},
                                                     {group, "keeps_steps", ValueKind::int8, 1},
                                                     {group, "standard_error", ValueKind::float64, 1},
                                                     {group, "residual_rms_mm", ValueKind::float64, 1}});
  layout.dimensions.push_back({group + "/pair", n_landmarks});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers(group + "/landmark", ValueKind::text, pair, "", "names of the pairs of landmarks"),
       numbers(group + "/model", ValueKind::float64, pair, "mm",
               "distance of each pair in the unscaled model"),
       numbers(group + "/subject", ValueKind::float64, pair, "mm", "distance of each pair in the subject"),
       numbers(group + "/residual", ValueKind::float64, pair, "mm",
               "the subject's distance less the factor times the model's")});
}

void add_job(FileLayout& layout, const FileShape& shape)
{
  layout.groups.emplace_back("/job");
  layout.dimensions.push_back({"/job/input", shape.n_inputs});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/job/text", ValueKind::text, {}, "", "the job file as given"),
       numbers("/job/resolved", ValueKind::text, {}, "", "every key of the job with its value"),
       numbers("/job/input_name", ValueKind::text, {"/job/input"}, "", "input files as the job names them"),
       numbers("/job/input_sha256", ValueKind::text, {"/job/input"}, "", "SHA-256 of the input files")});
  if (shape.n_landmarks) add_scaling(layout, *shape.n_landmarks);
}

std::uint64_t bytes_of(ValueKind kind)
{
  switch (kind) {
    case ValueKind::float64:
    case ValueKind::int64:
      return 8;
    case ValueKind::float32:
    case ValueKind::int32:
    case ValueKind::text:
      return 4;
    case ValueKind::int8:
      return 1;
  }
  throw InternalError("a kind of values has a size");
}

}  // namespace

const char* name_of(ValueKind kind)
{
  switch (kind) {
    case ValueKind::float64:
      return "float64";
    case ValueKind::float32:
      return "float32";
    case ValueKind::int64:
      return "int64";
    case ValueKind::int32:
      return "int32";
    case ValueKind::int8:
      return "int8";
    case ValueKind::text:
      return "variable-length UTF-8 text";
  }
  throw InternalError("a kind of values without a name");
}

namespace {

constexpr StepStatus solver_statuses[] = {StepStatus::pending,         StepStatus::stable,
                                          StepStatus::no_contact,      StepStatus::no_clearance,
                                          StepStatus::iteration_limit, StepStatus::unbounded};
constexpr StepStatus search_statuses[] = {StepStatus::pending, StepStatus::stable, StepStatus::no_contact,
                                          StepStatus::no_clearance, StepStatus::iteration_limit};

template <typename Codes>
FlagTable table_of(const Codes& codes)
{
  FlagTable table;
  for (const auto code : codes) {
    table.values.push_back(static_cast<std::int8_t>(code));
    table.meanings += (table.meanings.empty() ? "" : " ") + std::string(name_of(code));
  }
  return table;
}

}  // namespace

FlagTable flag_table(FlagSet set)
{
  switch (set) {
    case FlagSet::none:
      break;
    case FlagSet::status:
      return table_of(all_step_statuses);
    case FlagSet::solver_status:
      return table_of(solver_statuses);
    case FlagSet::plausibility:
      return table_of(all_plausibilities);
    case FlagSet::search_status:
      return table_of(search_statuses);
    case FlagSet::move_kind:
      return table_of(all_move_kinds);
    case FlagSet::node:
      return table_of(searched_step_kinds);
    case FlagSet::answer:
      return {{-1, 0, 1}, "no_answer no yes"};
    case FlagSet::yes_no:
      return {{0, 1}, "no yes"};
    case FlagSet::compartment:
      return {{0, 1, 2}, "none medial lateral"};
    case FlagSet::wrap_shape:
      return {{0, 1}, "cylinder ellipsoid"};
    case FlagSet::body:
      return {{0, 1}, "reference moving"};
    case FlagSet::audit_state:
      return {{-1, 0, 1, 2}, "no_pose free overlapping nothing_ahead"};
    case FlagSet::zero_varus_source:
      return {{-1, 0, 1, 2}, "none both_touch interpolated free"};
    case FlagSet::case_status:
      return {{0, 1, 2, 3}, "done partial failed missing"};
  }
  return {};
}

FileLayout layout_of(const FileShape& shape)
{
  FileLayout layout;
  for (const char* name : {"format", "format_version", "Conventions", "title", "joint", "side", "method"}) {
    layout.attributes.push_back({"/", name, ValueKind::text, 1});
  }
  layout.attributes.push_back({"/", "rotation_centre_mm", ValueKind::float64, 3});
  layout.attributes.push_back({"/", "delta", ValueKind::float64, 3});
  layout.attributes.push_back({"/", "contact_resolution_mm", ValueKind::float64, 1});
  layout.attributes.push_back({"/", "has_compartments", ValueKind::int8, 1});
  add_root(layout, shape);
  add_clinical(layout);
  add_smoothed(layout, shape);
  add_contacts(layout, shape);
  add_mechanics(layout, shape);
  if (shape.has_zero_varus) add_zero_varus(layout, shape);
  add_audits(layout, shape);
  layout.groups.emplace_back("/bodies");
  add_body(layout, "/bodies/reference", shape.reference);
  add_body(layout, "/bodies/moving", shape.moving);
  add_job(layout, shape);
  return layout;
}

std::int64_t dimension_size(const FileLayout& layout, const FileShape& shape, const std::string& path)
{
  if (path == "/flexion") return shape.n_flexion;
  if (path == "/varus") return shape.n_varus;
  const auto found = std::find_if(layout.dimensions.begin(), layout.dimensions.end(),
                                  [&](const DimensionSpec& dimension) { return dimension.path == path; });
  check(found != layout.dimensions.end(), "a dataset of the layout uses a dimension that is not in it");
  return found->size;
}

std::uint64_t value_bytes(const FileLayout& layout, const FileShape& shape)
{
  constexpr std::uint64_t too_large = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t total = 0;
  for (const DatasetSpec& spec : layout.datasets) {
    std::uint64_t bytes = bytes_of(spec.kind);
    for (const std::string& dimension : spec.dimensions) {
      const auto size = static_cast<std::uint64_t>(dimension_size(layout, shape, dimension));
      if (__builtin_mul_overflow(bytes, size, &bytes)) return too_large;
    }
    if (__builtin_add_overflow(total, bytes, &total)) return too_large;
  }
  return total;
}

}  // namespace vrda
