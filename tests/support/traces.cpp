#include "support/traces.hpp"

#include <array>

#include "model/step_record.hpp"

namespace vrda::test {
namespace {

using Place = std::array<double, 4>;  // mm, degrees

struct MoveTemplate {
  int iteration;
  MoveKind kind;
  Place from_end;
  bool collides = false;
  bool is_cycle = false;
  int n_contacts = 0;  // above 0: in contact
};

const MoveTemplate moves_of_a_cell[n_moves_of_a_cell] = {
    {1, MoveKind::approach, {0.5, -1, 0, 0.5}},
    {1, MoveKind::approach, {0.5, -0.25, 0, 0.5}, false, false, 2},
    {1, MoveKind::bisect, {0.25, -0.25, 0, 0.5}, true},
    {1, MoveKind::bisect, {0.375, -0.25, 0, 0.5}},
    {1, MoveKind::translate, {0.375, -0.25, 0, 0.5}},
    {2, MoveKind::approach, {0.375, 0, 0, 0.5}, false, false, 1},
    {2, MoveKind::rotate, {0, 0, 0, 0}},
    {3, MoveKind::approach, {0, 0, 0, 0}, false, true, 1},
};

Eigen::RowVector3f single(const Place& a, const Place& b)
{
  return {static_cast<float>(a[0] + b[0]), static_cast<float>(a[1] + b[1]), static_cast<float>(a[2] + b[2])};
}

void add_contact(store::TraceContacts& contacts, int n)
{
  const Eigen::Index row = contacts.point_mm.rows();
  contacts.point_mm.conservativeResize(row + 1, 3);
  contacts.normal.conservativeResize(row + 1, 3);
  contacts.point_mm.row(row) << 0.5F * static_cast<float>(n), 20.0F, -0.25F;
  contacts.normal.row(row) << 0.0F, -1.0F, 0.0F;
  contacts.distance_mm.push_back(0.01F);
  contacts.triangle_reference.push_back(n);
  contacts.triangle_moving.push_back(n + 1);
  contacts.compartment.push_back(static_cast<std::int8_t>(n % 3));
}

void add_move(store::Trace& trace, const MoveTemplate& step, const Place& end)
{
  store::TraceMoves& moves = trace.moves;
  const Eigen::Index row = moves.translation_mm.rows();
  moves.translation_mm.conservativeResize(row + 1, 3);
  moves.translation_mm.row(row) = single(end, step.from_end);
  moves.theta_deg.push_back(static_cast<float>(end[3] + step.from_end[3]));
  moves.iteration.push_back(step.iteration);
  moves.kind.push_back(static_cast<std::int8_t>(step.kind));
  moves.translation_step_mm.push_back(1.0F);
  moves.rotation_step_deg.push_back(step.is_cycle ? 0.5F : 1.0F);
  moves.collides.push_back(step.collides ? 1 : 0);
  moves.is_cycle.push_back(step.is_cycle ? 1 : 0);
  moves.in_contact.push_back(step.n_contacts > 0 ? 1 : 0);
  for (int n = 0; n < step.n_contacts; ++n) add_contact(trace.contacts, n);
  moves.contact_start.push_back(static_cast<std::int64_t>(trace.contacts.compartment.size()));
}

struct Cell {
  double flexion_deg, varus_deg;
  StepKind node;
  StepStatus status;
};

void add_search(store::Trace& trace, const Cell& cell, const Place& end)
{
  store::TraceSearches& searches = trace.searches;
  const Eigen::Index row = searches.seed_translation_mm.rows();
  searches.seed_translation_mm.conservativeResize(row + 1, 3);
  searches.seed_translation_mm.row(row) = single(end, {0.5, -3, 0, 0.5});
  searches.seed_theta_deg.push_back(static_cast<float>(end[3] + 0.5));
  searches.flexion_deg.push_back(cell.flexion_deg);
  searches.varus_deg.push_back(cell.varus_deg);
  searches.node.push_back(static_cast<std::int8_t>(cell.node));
  searches.status.push_back(static_cast<std::int8_t>(cell.status));
  if (cell.status == StepStatus::stable) {
    for (const MoveTemplate& step : moves_of_a_cell) add_move(trace, step, end);
  }
  searches.move_start.push_back(static_cast<std::int64_t>(trace.moves.kind.size()));
}

}  // namespace

store::Trace trace_beside(const store::MotionModel& model)
{
  store::Trace trace;
  trace.title = model.title;
  trace.side = model.side;
  trace.job_key = std::string(64, 'c');
  trace.approach_step_mm = 5.0;
  trace.translation_resolution_mm = 0.1;
  trace.rotation_resolution_deg = 0.1;
  trace.job.resolved = model.job.resolved;
  trace.job.inputs = model.job.inputs;
  const Eigen::Index last_varus = model.status.cols() - 1;
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    for (Eigen::Index j = 0; j <= last_varus; ++j) {
      const double flexion_deg = model.flexion_deg[static_cast<std::size_t>(i)],
                   varus_deg = model.varus_deg[static_cast<std::size_t>(j)];
      const auto status = static_cast<StepStatus>(model.status(i, j));
      const bool is_stable = status == StepStatus::stable;
      const Place end =
          is_stable ? Place{model.tx_mm(i, j), model.ty_mm(i, j), model.tz_mm(i, j), model.theta_deg(i, j)}
                    : Place{};
      if (i == 0 && j == last_varus) {
        add_search(trace, {flexion_deg, varus_deg, StepKind::spine_probe, StepStatus::no_contact}, end);
      }
      const StepKind node = model.is_spine(i, j) == 1 ? StepKind::spine : StepKind::row;
      add_search(trace, {flexion_deg, varus_deg, node, status}, end);
    }
  }
  return trace;
}

}  // namespace vrda::test
