// `vrda trace`: the searches of a trace file, one per line, or their moves.

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "model/step_record.hpp"
#include "store/trace.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

/// `vrda trace`: summarises the searches of a trace.
struct TraceOptions {
  std::string file;
  store::AttitudeFilter filter;
  bool contact_only = false;  ///< omit moves that are not in contact
  bool as_csv = false;
  bool as_json = false;
};

constexpr std::size_t n_kinds = std::size(all_move_kinds);

struct Tally {
  std::array<int, n_kinds> by_kind{};
  int n_moves = 0;
  int n_in_contact = 0;
  int n_cycles = 0;
  int n_blocked = 0;  ///< trials

  void add(const store::TraceMoves& moves, std::size_t m)
  {
    ++by_kind[static_cast<std::size_t>(moves.kind[m])];
    ++n_moves;
    n_in_contact += moves.in_contact[m];
    n_cycles += moves.is_cycle[m];
    n_blocked += moves.collides[m];
  }
};

std::vector<std::size_t> chosen_moves(const store::Trace& trace, std::size_t search, bool contact_only)
{
  if (contact_only) return store::moves_in_contact(trace, search);
  std::vector<std::size_t> moves;
  const store::MoveRange range = store::moves_of(trace, search);
  for (std::size_t m = range.first; m < range.end; ++m) moves.push_back(m);
  return moves;
}

const char* node_name(const store::Trace& trace, std::size_t search)
{
  return name_of(static_cast<StepKind>(trace.searches.node[search]));
}

const char* status_name(const store::Trace& trace, std::size_t search)
{
  return name_of(static_cast<StepStatus>(trace.searches.status[search]));
}

struct End {
  std::array<float, 3> translation_mm{};
  float theta_deg = 0.0F;
};

// The pose after the last move; without moves the seed.
End end_of(const store::Trace& trace, std::size_t search)
{
  const store::MoveRange range = store::moves_of(trace, search);
  const bool has_moves = range.first < range.end;
  const store::Points32& points = has_moves ? trace.moves.translation_mm : trace.searches.seed_translation_mm;
  const auto row = static_cast<Eigen::Index>(has_moves ? range.end - 1 : search);
  return {{points(row, 0), points(row, 1), points(row, 2)},
          has_moves ? trace.moves.theta_deg[range.end - 1] : trace.searches.seed_theta_deg[search]};
}

int iterations_of(const store::Trace& trace, std::size_t search)
{
  const store::MoveRange range = store::moves_of(trace, search);
  return range.first < range.end ? trace.moves.iteration[range.end - 1] : 0;
}

Json json_of(const Tally& tally)
{
  Json kinds = Json::object();
  for (const MoveKind kind : all_move_kinds)
    kinds[name_of(kind)] = tally.by_kind[static_cast<std::size_t>(kind)];
  return {{"moves", tally.n_moves},
          {"by_kind", kinds},
          {"in_contact", tally.n_in_contact},
          {"cycles", tally.n_cycles},
          {"blocked_trials", tally.n_blocked}};
}

Json json_of(const store::Trace& trace, std::size_t search, const Tally& tally)
{
  const End end = end_of(trace, search);
  Json json = {{"flexion_deg", trace.searches.flexion_deg[search]},
               {"varus_deg", trace.searches.varus_deg[search]},
               {"node", node_name(trace, search)},
               {"status", status_name(trace, search)},
               {"iterations", iterations_of(trace, search)}};
  json.update(json_of(tally));
  json["end"] = {{"translation_mm", end.translation_mm}, {"theta_deg", end.theta_deg}};
  return json;
}

void print_row(const store::Trace& trace, std::size_t search, const Tally& tally)
{
  const End end = end_of(trace, search);
  std::printf("%8g %7g  %-11s %-15s %5d %6d", trace.searches.flexion_deg[search],
              trace.searches.varus_deg[search], node_name(trace, search), status_name(trace, search),
              iterations_of(trace, search), tally.n_moves);
  for (const int n : tally.by_kind) std::printf(" %9d", n);
  std::printf(" %6d  %.4f %.4f %.4f %.4f\n", tally.n_cycles, end.translation_mm[0], end.translation_mm[1],
              end.translation_mm[2], end.theta_deg);
}

void print_summary(const store::Trace& trace, const std::vector<std::size_t>& searches,
                   const TraceOptions& options)
{
  Json list = Json::array();
  Tally all;
  if (!options.as_json) {
    std::printf("%8s %7s  %-11s %-15s %5s %6s", "flexion", "varus", "node", "status", "iter.", "moves");
    for (const MoveKind kind : all_move_kinds) std::printf(" %9s", name_of(kind));
    std::printf(" %6s  end: x y z mm, theta degrees\n", "cycles");
  }
  for (const std::size_t search : searches) {
    Tally tally;
    for (const std::size_t m : chosen_moves(trace, search, options.contact_only)) {
      tally.add(trace.moves, m);
      all.add(trace.moves, m);
    }
    if (options.as_json) {
      list.push_back(json_of(trace, search, tally));
    } else {
      print_row(trace, search, tally);
    }
  }
  if (!options.as_json) {
    std::printf("%zu searches, %d moves, %d in contact, %d cycles, %d trials blocked\n", searches.size(),
                all.n_moves, all.n_in_contact, all.n_cycles, all.n_blocked);
    return;
  }
  const Json summary = {
      {"title", trace.title}, {"job_key", trace.job_key}, {"all", json_of(all)}, {"searches", list}};
  print_json(summary);
}

void print_csv(const store::Trace& trace, const std::vector<std::size_t>& searches, bool contact_only)
{
  std::printf(
      "flexion_deg,varus_deg,node,iteration,kind,x_mm,y_mm,z_mm,theta_deg,translation_step_mm,"
      "rotation_step_deg,collides,is_cycle,in_contact,contacts\n");
  const store::TraceMoves& moves = trace.moves;
  for (const std::size_t s : searches) {
    for (const std::size_t m : chosen_moves(trace, s, contact_only)) {
      const auto row = static_cast<Eigen::Index>(m);
      std::printf("%g,%g,%s,%d,%s,%.6f,%.6f,%.6f,%.6f,%g,%g,%d,%d,%d,%d\n", trace.searches.flexion_deg[s],
                  trace.searches.varus_deg[s], node_name(trace, s), moves.iteration[m],
                  name_of(static_cast<MoveKind>(moves.kind[m])), moves.translation_mm(row, 0),
                  moves.translation_mm(row, 1), moves.translation_mm(row, 2), moves.theta_deg[m],
                  moves.translation_step_mm[m], moves.rotation_step_deg[m], moves.collides[m],
                  moves.is_cycle[m], moves.in_contact[m],
                  static_cast<int>(moves.contact_start[m + 1] - moves.contact_start[m]));
    }
  }
}

core::ExitCode trace_command(const TraceOptions& options)
{
  const store::Trace trace = store::read_trace(options.file);
  const std::vector<std::size_t> searches = store::searches_at(trace, options.file, options.filter);
  if (options.as_csv) {
    print_csv(trace, searches, options.contact_only);
  } else {
    print_summary(trace, searches, options);
  }
  return core::ExitCode::done;
}

}  // namespace

void declare_trace(Command& c)
{
  auto& o = c.options<TraceOptions>();
  c.model(o.file, "Trace (HDF5), written by vrda run --trace");
  c.option("--flexion", o.filter.flexion_deg, "Only searches at this flexion of the grid, degrees")
      .any_number();
  c.option("--varus", o.filter.varus_deg, "Only searches at this varus of the grid, degrees").any_number();
  c.flag("--contact-only", o.contact_only, "Only moves in contact");
  const Option csv = c.flag("--csv", o.as_csv, "Print the moves as CSV");
  c.json(o.as_json).excludes(csv);
  c.runs([&o] { return trace_command(o); });
}

}  // namespace vrda::app
