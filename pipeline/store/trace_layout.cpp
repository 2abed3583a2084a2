#include "store/trace_layout.hpp"

#include "store/dataset_specs.hpp"

namespace vrda {
namespace {

void add_searches(FileLayout& layout, const TraceShape& shape)
{
  layout.groups.emplace_back("/searches");
  const std::string search = "/searches/search", bound = "/searches/search_bound";
  layout.dimensions.push_back({search, shape.n_searches});
  layout.dimensions.push_back({bound, shape.n_searches + 1});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/searches/flexion", ValueKind::float64, {search}, "degree", "flexion of the attitude"),
       numbers("/searches/varus", ValueKind::float64, {search}, "degree",
               "varus of the attitude, adduction positive"),
       codes("/searches/node", {search}, FlagSet::node, "kind of node of the seeding graph"),
       codes("/searches/status", {search}, FlagSet::search_status, "how the search ended"),
       numbers("/searches/seed_translation", ValueKind::float32, {search, "/xyz"}, "mm",
               "translation of the seed, world W"),
       numbers("/searches/seed_theta", ValueKind::float32, {search}, "degree",
               "rotation of the seed about Delta, right-knee sign"),
       numbers("/searches/move_start", ValueKind::int64, {bound}, "1",
               "first move of each search, then the number of moves")});
}

void add_moves(FileLayout& layout, const TraceShape& shape)
{
  layout.groups.emplace_back("/moves");
  const std::string move = "/moves/move", bound = "/moves/move_bound";
  layout.dimensions.push_back({move, shape.n_moves});
  layout.dimensions.push_back({bound, shape.n_moves + 1});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/moves/iteration", ValueKind::int32, {move}, "1", "iteration of the search"),
       codes("/moves/kind", {move}, FlagSet::move_kind, "kind of the move"),
       numbers("/moves/translation", ValueKind::float32, {move, "/xyz"}, "mm",
               "translation after the move, world W"),
       numbers("/moves/theta", ValueKind::float32, {move}, "degree",
               "rotation about Delta after the move, right-knee sign"),
       numbers("/moves/translation_step", ValueKind::float32, {move}, "mm", "translation step in force"),
       numbers("/moves/rotation_step", ValueKind::float32, {move}, "degree", "rotation step in force"),
       codes("/moves/collides", {move}, FlagSet::yes_no, "whether a trial of a bisection was blocked"),
       codes("/moves/is_cycle", {move}, FlagSet::yes_no, "whether the pose was there before"),
       codes("/moves/in_contact", {move}, FlagSet::yes_no, "whether the approach has ended in the touch"),
       numbers("/moves/contact_start", ValueKind::int64, {bound}, "1",
               "first contact of each move, then the number of contacts")});
}

void add_contacts(FileLayout& layout, const TraceShape& shape)
{
  layout.groups.emplace_back("/contacts");
  const std::string contact = "/contacts/contact";
  layout.dimensions.push_back({contact, shape.n_contacts});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/contacts/point", ValueKind::float32, {contact, "/xyz"}, "mm",
               "point on the reference's surface, world W"),
       numbers("/contacts/normal", ValueKind::float32, {contact, "/xyz"}, "1",
               "unit direction of the reaction on the moving object, world W"),
       numbers("/contacts/distance", ValueKind::float32, {contact}, "mm", "distance of the two surfaces"),
       numbers("/contacts/triangle_reference", ValueKind::int32, {contact}, "1",
               "row of /bodies/reference/triangles of the motion model"),
       numbers("/contacts/triangle_moving", ValueKind::int32, {contact}, "1",
               "row of /bodies/moving/triangles of the motion model"),
       codes("/contacts/compartment", {contact}, FlagSet::compartment,
             "compartment that the contact lies in")});
}

void add_job(FileLayout& layout, const TraceShape& shape)
{
  layout.groups.emplace_back("/job");
  layout.dimensions.push_back({"/job/input", shape.n_inputs});
  layout.datasets.insert(
      layout.datasets.end(),
      {numbers("/job/resolved", ValueKind::text, {}, "", "every key of the job with its value"),
       numbers("/job/input_name", ValueKind::text, {"/job/input"}, "", "input files as the job names them"),
       numbers("/job/input_sha256", ValueKind::text, {"/job/input"}, "", "SHA-256 of the input files")});
}

}  // namespace

FileLayout trace_layout_of(const TraceShape& shape)
{
  FileLayout layout;
  for (const char* name : {"format", "format_version", "Conventions", "title", "side", "job_key"}) {
    layout.attributes.push_back({"/", name, ValueKind::text, 1});
  }
  for (const char* name : {"approach_step_mm", "translation_resolution_mm", "rotation_resolution_deg"}) {
    layout.attributes.push_back({"/", name, ValueKind::float64, 1});
  }
  layout.dimensions.push_back({"/xyz", 3});
  add_searches(layout, shape);
  add_moves(layout, shape);
  add_contacts(layout, shape);
  add_job(layout, shape);
  return layout;
}

}  // namespace vrda
