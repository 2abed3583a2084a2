#include "store/trace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/step_record.hpp"
#include "store/dataset.hpp"
#include "store/h5_file.hpp"
#include "store/model_checks.hpp"
#include "store/read_separately.hpp"
#include "store/registry.hpp"

namespace vrda::store {
namespace {

/// Tolerance of angles typed by a user; grid values have fewer digits.
constexpr double same_angle_deg = 1e-6;

/// The value of an axis nearest to `wanted_deg`; "any" without one.
std::string nearest(const std::vector<double>& axis_deg, const std::optional<double>& wanted_deg)
{
  if (!wanted_deg) return "any";
  double best_deg = axis_deg.front();
  for (const double value_deg : axis_deg) {
    if (std::abs(value_deg - *wanted_deg) < std::abs(best_deg - *wanted_deg)) best_deg = value_deg;
  }
  return rounded_text(best_deg);
}

}  // namespace

MoveRange moves_of(const Trace& trace, std::size_t search)
{
  return {static_cast<std::size_t>(trace.searches.move_start[search]),
          static_cast<std::size_t>(trace.searches.move_start[search + 1])};
}

std::vector<std::size_t> moves_in_contact(const Trace& trace, std::size_t search)
{
  std::vector<std::size_t> moves;
  const MoveRange range = moves_of(trace, search);
  for (std::size_t m = range.first; m < range.end; ++m) {
    if (trace.moves.in_contact[m] == 1) moves.push_back(m);
  }
  return moves;
}

std::vector<std::size_t> searches_at(const Trace& trace, const std::string& file,
                                     const AttitudeFilter& filter)
{
  const TraceSearches& searches = trace.searches;
  const auto matches = [](const std::optional<double>& wanted_deg, double value_deg) {
    return !wanted_deg || std::abs(*wanted_deg - value_deg) < same_angle_deg;
  };
  std::vector<std::size_t> found;
  for (std::size_t s = 0; s < searches.node.size(); ++s) {
    if (matches(filter.flexion_deg, searches.flexion_deg[s]) &&
        matches(filter.varus_deg, searches.varus_deg[s])) {
      found.push_back(s);
    }
  }
  if (!found.empty()) return found;
  if (searches.node.empty()) throw InputError({file, "/searches", "no searches", "at least one"});
  const auto text = [](const std::optional<double>& angle_deg) {
    return angle_deg ? rounded_text(*angle_deg) : std::string("any");
  };
  throw InputError({file, "attitude",
                    "no search at flexion " + text(filter.flexion_deg) + ", varus " + text(filter.varus_deg),
                    "one of the grid; the nearest is flexion " +
                        nearest(searches.flexion_deg, filter.flexion_deg) + ", varus " +
                        nearest(searches.varus_deg, filter.varus_deg)});
}

std::string trace_name(const std::string& motion_model_file)
{
  const std::string_view ending = ".h5";
  const bool has_ending = motion_model_file.size() > ending.size() && motion_model_file.ends_with(ending);
  return motion_model_file.substr(0, motion_model_file.size() - (has_ending ? ending.size() : 0)) +
         ".trace.h5";
}

void write_trace(const std::string& path, const Trace& trace)
{
  const std::string content = hdf5_bytes(path, {trace_format_name, trace_format_version}, trace);
  write_atomically(path, {content, seal_of(content)});
}

void require_trace_matches_model(const Trace& trace, const std::string& trace_file, const MotionModel& model,
                                 const std::string& model_file)
{
  const std::vector<Finding> findings = compare_trace(trace, model);
  if (findings.empty()) return;
  throw InputError({trace_file, findings[0].where, findings[0].found,
                    findings[0].wanted + ", the trace of " + model_file});
}

// Rules for the values of a trace, and between a trace and its motion model.

namespace {

/// Twice the relative rounding error of float32 (6e-8); also the absolute tolerance near 0, in mm or degrees.
constexpr double single_precision = 1.2e-7;

class TraceCheck {
 public:
  explicit TraceCheck(const Trace& trace) : trace_(trace) {}

  std::vector<Finding> run()
  {
    check_attributes();
    check_rows(trace_, findings_);
    check_flags();
    // Row starts are valid from here on.
    if (findings_.empty()) check_order();
    return findings_.take();
  }

 private:
  void check_attributes()
  {
    if (trace_.side != "right" && trace_.side != "left")
      findings_.add("/@side", "\"" + trace_.side + "\"", "one of \"right\", \"left\"");
    positive("/@approach_step_mm", trace_.approach_step_mm);
    positive("/@translation_resolution_mm", trace_.translation_resolution_mm);
    positive("/@rotation_resolution_deg", trace_.rotation_resolution_deg);
  }

  void positive(const std::string& where, double value)
  {
    if (!(value > 0.0) || !is_number(value)) findings_.add(where, text_of(value), "a positive number");
  }

  void check_flags()
  {
    const TraceMoves& moves = trace_.moves;
    only_where("/moves/collides", moves.collides, "1 only at a bisection",
               [&](std::size_t m) { return moves.kind[m] == code_of(MoveKind::bisect); });
    only_where("/moves/in_contact", moves.in_contact, "1 only at an approach or iterate", [&](std::size_t m) {
      return moves.kind[m] == code_of(MoveKind::approach) || moves.kind[m] == code_of(MoveKind::iterate);
    });
    only_where("/moves/is_cycle", moves.is_cycle, "1 only in contact",
               [&](std::size_t m) { return moves.in_contact[m] == 1; });
  }

  template <typename IsAllowed>
  void only_where(const std::string& where, const std::vector<std::int8_t>& flags, const std::string& wanted,
                  IsAllowed is_allowed)
  {
    findings_.report_each(
        where, flags.size(), wanted, [&](std::size_t m) { return flags[m] == 1 && !is_allowed(m); },
        [&](std::size_t) { return "1"; });
  }

  void check_order()
  {
    const TraceMoves& moves = trace_.moves;
    findings_.report_each(
        "/moves/contact_start", moves.kind.size(), "contacts only of moves in contact",
        [&](std::size_t m) {
          return moves.in_contact[m] == 0 && moves.contact_start[m + 1] > moves.contact_start[m];
        },
        [&](std::size_t) { return "contacts of a move that is not in contact"; });
    for (std::size_t s = 0; s < trace_.searches.node.size(); ++s) {
      const MoveRange range = moves_of(trace_, s);
      for (std::size_t m = range.first + 1; m < range.end; ++m) {
        if (moves.iteration[m] >= moves.iteration[m - 1]) continue;
        findings_.add("/moves/iteration",
                      std::to_string(moves.iteration[m]) + " at entry " + std::to_string(m),
                      "non-decreasing iterations within a search");
        return;
      }
    }
  }

  const Trace& trace_;
  ValueFindings findings_;
};

std::map<double, Eigen::Index> indices_on(const std::vector<double>& axis)
{
  std::map<double, Eigen::Index> indices;
  for (std::size_t i = 0; i < axis.size(); ++i) indices[axis[i]] = static_cast<Eigen::Index>(i);
  return indices;
}

class MatchCheck {
 public:
  MatchCheck(const Trace& trace, const MotionModel& model) : trace_(trace), model_(model) {}

  std::vector<Finding> run()
  {
    if (!is_same_job()) {
      findings_.add("/job", "the trace of another job (\"" + trace_.title + "\", key " + trace_.job_key + ")",
                    "the job \"" + model_.title + "\"");
      return findings_.take();
    }
    check_cells();
    const std::size_t n = trace_.contacts.compartment.size();
    findings_.report_out_of_range("/contacts/triangle_reference", trace_.contacts.triangle_reference.data(),
                                  n, 0, model_.reference.contact.mesh.triangles.rows() - 1);
    findings_.report_out_of_range("/contacts/triangle_moving", trace_.contacts.triangle_moving.data(), n, 0,
                                  model_.moving.contact.mesh.triangles.rows() - 1);
    return findings_.take();
  }

 private:
  bool is_same_job() const
  {
    const auto same = [](const InputFile& a, const InputFile& b) {
      return a.name == b.name && a.sha256 == b.sha256;
    };
    const std::vector<InputFile>& a = trace_.job.inputs;
    const std::vector<InputFile>& b = model_.job.inputs;
    return trace_.job.resolved == model_.job.resolved && trace_.side == model_.side &&
           std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
  }

  // Every cell of the model must be the end of exactly one search.
  void check_cells()
  {
    const std::map<double, Eigen::Index> flexions = indices_on(model_.flexion_deg),
                                         varuses = indices_on(model_.varus_deg);
    GridB n_ends = GridB::Zero(model_.status.rows(), model_.status.cols());
    for (std::size_t s = 0; s < trace_.searches.node.size(); ++s) {
      const auto i = flexions.find(trace_.searches.flexion_deg[s]);
      const auto j = varuses.find(trace_.searches.varus_deg[s]);
      if (i == flexions.end() || j == varuses.end()) {
        findings_.add("/searches/flexion", "an attitude outside the grid at entry " + std::to_string(s),
                      "attitudes of the grid");
        return;
      }
      if (trace_.searches.node[s] == static_cast<std::int8_t>(StepKind::spine_probe)) continue;
      if (n_ends(i->second, j->second) < 2) ++n_ends(i->second, j->second);
      if (!ends_at(s, i->second, j->second)) return;
    }
    if ((n_ends != 1).any())
      findings_.add("/searches/node", "a cell without a search or with several",
                    "one search per cell, not counting spine probes");
  }

  bool ends_at(std::size_t s, Eigen::Index i, Eigen::Index j)
  {
    const std::string entry = " at entry " + std::to_string(s);
    if (trace_.searches.status[s] != model_.status(i, j)) {
      findings_.add("/searches/status", std::to_string(trace_.searches.status[s]) + entry,
                    std::to_string(model_.status(i, j)));
      return false;
    }
    if (trace_.searches.status[s] != status_stable) return true;
    const MoveRange range = moves_of(trace_, s);
    if (range.first < range.end && is_at(range.end - 1, i, j)) return true;
    findings_.add("/moves/translation", "another final pose" + entry, "the pose of its cell");
    return false;
  }

  bool is_at(std::size_t m, Eigen::Index i, Eigen::Index j) const
  {
    const auto near = [](double a, double b) {
      return std::abs(a - b) <= single_precision * (1.0 + std::abs(b));
    };
    const auto row = static_cast<Eigen::Index>(m);
    return near(trace_.moves.translation_mm(row, 0), model_.tx_mm(i, j)) &&
           near(trace_.moves.translation_mm(row, 1), model_.ty_mm(i, j)) &&
           near(trace_.moves.translation_mm(row, 2), model_.tz_mm(i, j)) &&
           near(trace_.moves.theta_deg[m], model_.theta_deg(i, j));
  }

  const Trace& trace_;
  const MotionModel& model_;
  ValueFindings findings_;
};

}  // namespace

std::vector<Finding> check_values(const Trace& trace)
{
  return TraceCheck(trace).run();
}

std::vector<Finding> compare_trace(const Trace& trace, const MotionModel& model)
{
  return MatchCheck(trace, model).run();
}

namespace {

bool is_node(const store::Trace& trace, std::size_t search, StepKind kind)
{
  return trace.searches.node[search] == static_cast<std::int8_t>(kind);
}

// Without a varus the spine cell of the flexion; otherwise the search of the attitude's cell.
std::size_t chosen_search(const store::Trace& trace, const std::string& file, store::AttitudeFilter cell)
{
  const bool wants_spine = !cell.varus_deg.has_value();
  if (!cell.flexion_deg) {
    const std::vector<std::size_t> any = store::searches_at(trace, file, cell);
    cell.flexion_deg = trace.searches.flexion_deg[any.front()];
  }
  const std::vector<std::size_t> found = store::searches_at(trace, file, cell);
  const auto chosen = std::find_if(found.begin(), found.end(), [&](std::size_t s) {
    return wants_spine ? is_node(trace, s, StepKind::spine) : !is_node(trace, s, StepKind::spine_probe);
  });
  if (chosen != found.end()) return *chosen;
  throw InputError({file, "/searches/node", "only probes at that attitude",
                    wants_spine ? "a spine cell, or a varus" : "the search of its cell"});
}

PoseCoordinates numbers_of(const store::Points32& translation_mm, std::size_t row, float theta_deg)
{
  const auto i = static_cast<Eigen::Index>(row);
  return {translation_mm(i, 0), translation_mm(i, 1), translation_mm(i, 2),
          rad_from_deg(static_cast<double>(theta_deg))};
}

}  // namespace

Film film_of(const store::Trace& trace, const std::string& file, const FilmOptions& options)
{
  check(options.every > 0, "a film keeps every Nth frame, N above 0");
  const std::size_t search = chosen_search(trace, file, options.cell);
  std::vector<PoseCoordinates> all;
  if (!options.contact_only) {
    all.push_back(
        numbers_of(trace.searches.seed_translation_mm, search, trace.searches.seed_theta_deg[search]));
  }
  const store::MoveRange range = store::moves_of(trace, search);
  for (std::size_t m = range.first; m < range.end; ++m) {
    if (options.contact_only && trace.moves.in_contact[m] == 0) continue;
    all.push_back(numbers_of(trace.moves.translation_mm, m, trace.moves.theta_deg[m]));
  }
  if (all.empty()) throw InputError({file, "/moves/in_contact", "no move in contact", "at least one"});
  Film film;
  film.attitude = {rad_from_deg(trace.searches.flexion_deg[search]),
                   rad_from_deg(trace.searches.varus_deg[search])};
  const auto every = static_cast<std::size_t>(options.every);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k % every == 0 || k + 1 == all.size()) film.frames.push_back(all[k]);
  }
  return film;
}

}  // namespace vrda::store
