#include "assemble/assemble_trace.hpp"

#include <algorithm>
#include <tuple>

#include "core/units.hpp"

namespace vrda {
namespace {

struct Entry {
  const SearchTrace* search = nullptr;
  StepKind node = StepKind::row;
};

// By flexion, varus and node, whatever order the steps were solved in.
std::vector<Entry> ordered(const std::map<StepKey, SearchTrace>& searches,
                           const std::vector<std::int32_t>& spine_column)
{
  std::vector<Entry> entries;
  for (const auto& [key, search] : searches) {
    const bool is_spine =
        key.kind == StepKind::spine_probe && spine_column[static_cast<std::size_t>(key.flexion)] == key.varus;
    entries.push_back({&search, is_spine ? StepKind::spine : key.kind});
  }
  const auto place = [](const Entry& e) {
    return std::make_tuple(e.search->key.flexion, e.search->key.varus, e.node);
  };
  std::sort(entries.begin(), entries.end(),
            [&](const Entry& a, const Entry& b) { return place(a) < place(b); });
  return entries;
}

Eigen::RowVector3f single(const Eigen::Vector3d& v)
{
  return v.cast<float>().transpose();
}

float single_deg(double angle_rad)
{
  return static_cast<float>(deg_from_rad(angle_rad));
}

class TraceAssembly {
 public:
  TraceAssembly(const Case& job_case, Trace& trace)
      : case_(job_case), scale_(job_case.steps_scale), frame_(job_case.frame), trace_(trace)
  {
  }

  void make_room(const std::vector<Entry>& entries)
  {
    Eigen::Index n_moves = 0, n_contacts = 0;
    for (const Entry& entry : entries) {
      n_moves += static_cast<Eigen::Index>(entry.search->moves.size());
      for (const SearchMove& move : entry.search->moves) {
        n_contacts += static_cast<Eigen::Index>(move.contacts.size());
      }
    }
    trace_.searches.seed_translation_mm.resize(static_cast<Eigen::Index>(entries.size()), 3);
    trace_.moves.translation_mm.resize(n_moves, 3);
    trace_.contacts.point_mm.resize(n_contacts, 3);
    trace_.contacts.normal.resize(n_contacts, 3);
  }

  void add(const Entry& entry)
  {
    const SearchTrace& search = *entry.search;
    TraceSearches& searches = trace_.searches;
    searches.seed_translation_mm.row(static_cast<Eigen::Index>(searches.node.size())) =
        single(scale_ * world_translation_mm(frame_, search.seed));
    searches.seed_theta_deg.push_back(single_deg(search.seed.theta_rad));
    searches.flexion_deg.push_back(case_.grid.flexion_deg[static_cast<std::size_t>(search.key.flexion)]);
    searches.varus_deg.push_back(case_.grid.varus_deg[static_cast<std::size_t>(search.key.varus)]);
    searches.node.push_back(static_cast<std::int8_t>(entry.node));
    searches.status.push_back(static_cast<std::int8_t>(search.status));
    for (const SearchMove& move : search.moves) add(move);
    searches.move_start.push_back(static_cast<std::int64_t>(trace_.moves.kind.size()));
  }

 private:
  void add(const SearchMove& move)
  {
    TraceMoves& moves = trace_.moves;
    moves.translation_mm.row(static_cast<Eigen::Index>(moves.kind.size())) =
        single(scale_ * world_translation_mm(frame_, move.pose));
    moves.theta_deg.push_back(single_deg(move.pose.theta_rad));
    moves.iteration.push_back(move.iteration);
    moves.kind.push_back(static_cast<std::int8_t>(move.kind));
    moves.translation_step_mm.push_back(static_cast<float>(scale_ * move.translation_step_mm));
    moves.rotation_step_deg.push_back(single_deg(move.rotation_step_rad));
    moves.collides.push_back(move.collides ? 1 : 0);
    moves.is_cycle.push_back(move.is_cycle ? 1 : 0);
    moves.in_contact.push_back(move.in_contact ? 1 : 0);
    for (const ContactRecord& contact : move.contacts) add(contact);
    moves.contact_start.push_back(static_cast<std::int64_t>(trace_.contacts.compartment.size()));
  }

  void add(const ContactRecord& contact)
  {
    TraceContacts& contacts = trace_.contacts;
    const auto row = static_cast<Eigen::Index>(contacts.compartment.size());
    contacts.point_mm.row(row) = single(scale_ * world_from_solver(frame_, contact.point_solver_mm));
    contacts.normal.row(row) = single(world_from_solver(frame_, contact.normal_solver));
    contacts.distance_mm.push_back(static_cast<float>(scale_ * contact.distance_mm));
    contacts.triangle_reference.push_back(contact.triangle_reference);
    contacts.triangle_moving.push_back(contact.triangle_moving);
    contacts.compartment.push_back(contact.compartment);
  }

  const Case& case_;
  double scale_;  // of the subject over what was solved
  const SolverFrame& frame_;
  Trace& trace_;
};

}  // namespace

Trace trace_of(const Case& job_case, const std::string& job_key,
               const std::map<StepKey, SearchTrace>& searches, const std::vector<std::int32_t>& spine_column)
{
  Trace trace;
  trace.title = job_case.title;
  trace.side = job_case.frame.side == Side::left ? "left" : "right";
  trace.job_key = job_key;
  trace.approach_step_mm = job_case.steps_scale * job_case.search.approach_step_mm;
  trace.translation_resolution_mm = job_case.steps_scale * job_case.search.translation_resolution_mm;
  trace.rotation_resolution_deg = deg_from_rad(job_case.search.rotation_resolution_rad);
  trace.job.resolved = job_case.resolved_job;
  for (const LoadedInput& input : job_case.inputs) trace.job.inputs.push_back({input.name, input.sha256});
  const std::vector<Entry> entries = ordered(searches, spine_column);
  TraceAssembly assembly(job_case, trace);
  assembly.make_room(entries);
  for (const Entry& entry : entries) assembly.add(entry);
  return trace;
}

}  // namespace vrda
