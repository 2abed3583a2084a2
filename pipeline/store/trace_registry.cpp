#include "store/trace_registry.hpp"

#include "store/registry_rows.hpp"

namespace vrda::store {
namespace registry {

// One line per dataset.
// clang-format off

namespace {

void visit_searches(Trace& trace, RowVisitor& visit)
{
  auto& searches = trace.searches;
  const std::vector<std::string> search{"/searches/search"}, vectors{"/searches/search", "/xyz"};
  visit.group("/searches");
  visit.dimension("/searches/search", DimensionSize::counted(searches.node.size()));
  visit.dimension("/searches/search_bound", DimensionSize::fixed(visit.size("/searches/search") + 1));
  visit({"/searches/flexion", search, unit::degree, number(), "flexion of the attitude"}, searches.flexion_deg);
  visit({"/searches/varus", search, unit::degree, number(), "varus of the attitude, adduction positive"}, searches.varus_deg);
  visit({"/searches/node", search, unit::none, codes(FlagSet::node), "kind of node of the seeding graph"}, searches.node);
  visit({"/searches/status", search, unit::none, codes(FlagSet::search_status), "how the search ended"}, searches.status);
  visit({"/searches/seed_translation", vectors, unit::mm, number(), "translation of the seed, world W"}, searches.seed_translation_mm);
  visit({"/searches/seed_theta", search, unit::degree, number(), "rotation of the seed about Delta, right-knee sign"}, searches.seed_theta_deg);
  visit({"/searches/move_start", {"/searches/search_bound"}, unit::one, row_starts(trace.moves.kind.size()), "first move of each search, then the number of moves"}, searches.move_start);
}

void visit_moves(Trace& trace, RowVisitor& visit)
{
  auto& moves = trace.moves;
  const std::vector<std::string> move{"/moves/move"}, vectors{"/moves/move", "/xyz"};
  visit.group("/moves");
  visit.dimension("/moves/move", DimensionSize::counted(moves.kind.size()));
  visit.dimension("/moves/move_bound", DimensionSize::fixed(visit.size("/moves/move") + 1));
  visit({"/moves/iteration", move, unit::one, count(), "iteration of the search"}, moves.iteration);
  visit({"/moves/kind", move, unit::none, codes(FlagSet::move_kind), "kind of the move"}, moves.kind);
  visit({"/moves/translation", vectors, unit::mm, number(), "translation after the move, world W"}, moves.translation_mm);
  visit({"/moves/theta", move, unit::degree, number(), "rotation about Delta after the move, right-knee sign"}, moves.theta_deg);
  visit({"/moves/translation_step", move, unit::mm, number(), "current translation step"}, moves.translation_step_mm);
  visit({"/moves/rotation_step", move, unit::degree, number(), "current rotation step"}, moves.rotation_step_deg);
  visit({"/moves/collides", move, unit::none, codes(FlagSet::yes_no), "whether a trial of a bisection was blocked"}, moves.collides);
  visit({"/moves/is_cycle", move, unit::none, codes(FlagSet::yes_no), "whether the search visited this pose before"}, moves.is_cycle);
  visit({"/moves/in_contact", move, unit::none, codes(FlagSet::yes_no), "whether the approach ended in contact"}, moves.in_contact);
  visit({"/moves/contact_start", {"/moves/move_bound"}, unit::one, row_starts(trace.contacts.compartment.size()), "first contact of each move, then the number of contacts"}, moves.contact_start);
}

void visit_trace_contacts(TraceContacts& contacts, RowVisitor& visit)
{
  const std::vector<std::string> contact{"/contacts/contact"}, vectors{"/contacts/contact", "/xyz"};
  visit.group("/contacts");
  visit.dimension("/contacts/contact", DimensionSize::counted(contacts.compartment.size()));
  visit({"/contacts/point", vectors, unit::mm, number(), "point on the reference's surface, world W"}, contacts.point_mm);
  visit({"/contacts/normal", vectors, unit::one, rule(Rule::unit_rows), "unit direction of the reaction on the moving object, world W"}, contacts.normal);
  visit({"/contacts/distance", contact, unit::mm, number(), "distance of the two surfaces"}, contacts.distance_mm);
  visit({"/contacts/triangle_reference", contact, unit::one, count(), "row of /bodies/reference/triangles of the motion model"}, contacts.triangle_reference);
  visit({"/contacts/triangle_moving", contact, unit::one, count(), "row of /bodies/moving/triangles of the motion model"}, contacts.triangle_moving);
  visit({"/contacts/compartment", contact, unit::none, codes(FlagSet::compartment), "compartment of the contact"}, contacts.compartment);
}

}  // namespace

// clang-format on
}  // namespace registry

void visit_rows(Trace& trace, RowVisitor& visit)
{
  using namespace registry;
  visit.attribute("/", "title", trace.title);
  visit.attribute("/", "side", trace.side);
  visit.attribute("/", "job_key", trace.job_key);
  visit.attribute("/", "approach_step_mm", trace.approach_step_mm);
  visit.attribute("/", "translation_resolution_mm", trace.translation_resolution_mm);
  visit.attribute("/", "rotation_resolution_deg", trace.rotation_resolution_deg);
  visit.dimension("/xyz", DimensionSize::fixed(3));
  visit_searches(trace, visit);
  visit_moves(trace, visit);
  visit_trace_contacts(trace.contacts, visit);
  visit.group("/job");
  visit.dimension("/job/input", DimensionSize::counted(trace.job.inputs.size()));
  visit({"/job/resolved", {}, unit::none, rule(Rule::any), "every key of the job with its value"},
        trace.job.resolved);
  visit_inputs(trace.job.inputs, visit);
}

}  // namespace vrda::store
