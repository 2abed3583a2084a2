/// Ties the datasets of trace_layout.hpp to the members of Trace.
#pragma once

#include "store/binding.hpp"
#include "store/trace.hpp"
#include "store/trace_layout.hpp"

namespace vrda {

inline TraceShape shape_of(const Trace& trace)
{
  return {static_cast<std::int64_t>(trace.searches.node.size()),
          static_cast<std::int64_t>(trace.moves.kind.size()),
          static_cast<std::int64_t>(trace.contacts.compartment.size()),
          static_cast<std::int64_t>(trace.job.inputs.size())};
}

/// Calls visit(path, member) for every dataset of trace_layout_of, in its order.
template <typename ATrace, typename Visitor>
void visit_trace(ATrace& trace, Visitor&& visit)
{
  visit("/searches/flexion", trace.searches.flexion_deg);
  visit("/searches/varus", trace.searches.varus_deg);
  visit("/searches/node", trace.searches.node);
  visit("/searches/status", trace.searches.status);
  visit("/searches/seed_translation", trace.searches.seed_translation_mm);
  visit("/searches/seed_theta", trace.searches.seed_theta_deg);
  visit("/searches/move_start", trace.searches.move_start);
  visit("/moves/iteration", trace.moves.iteration);
  visit("/moves/kind", trace.moves.kind);
  visit("/moves/translation", trace.moves.translation_mm);
  visit("/moves/theta", trace.moves.theta_deg);
  visit("/moves/translation_step", trace.moves.translation_step_mm);
  visit("/moves/rotation_step", trace.moves.rotation_step_deg);
  visit("/moves/collides", trace.moves.collides);
  visit("/moves/is_cycle", trace.moves.is_cycle);
  visit("/moves/in_contact", trace.moves.in_contact);
  visit("/moves/contact_start", trace.moves.contact_start);
  visit("/contacts/point", trace.contacts.point_mm);
  visit("/contacts/normal", trace.contacts.normal);
  visit("/contacts/distance", trace.contacts.distance_mm);
  visit("/contacts/triangle_reference", trace.contacts.triangle_reference);
  visit("/contacts/triangle_moving", trace.contacts.triangle_moving);
  visit("/contacts/compartment", trace.contacts.compartment);
  visit("/job/resolved", trace.job.resolved);
  visit_inputs(trace.job.inputs, visit);
}

}  // namespace vrda
