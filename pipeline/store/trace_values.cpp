// Rules for the values of a trace, and between a trace and its motion model.
#include "store/values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "model/step_record.hpp"
#include "store/row_check.hpp"
#include "store/trace_registry.hpp"
#include "store/value_findings.hpp"

namespace vrda::store {
namespace {

/// Twice the relative rounding error of float32 (6e-8); also the absolute tolerance near 0, in mm or degrees.
constexpr double single_precision = 1.2e-7;

std::string quoted(const std::string& text)
{
  return "\"" + text + "\"";
}

class TraceCheck {
 public:
  explicit TraceCheck(const Trace& trace) : trace_(trace) {}

  std::vector<Finding> run()
  {
    check_attributes();
    visit_trace(trace_, RowCheck(findings_));
    check_flags();
    // Row starts are valid from here on.
    if (findings_.empty()) check_order();
    return findings_.take();
  }

 private:
  void check_attributes()
  {
    if (trace_.side != "right" && trace_.side != "left")
      findings_.add("/@side", quoted(trace_.side), "one of \"right\", \"left\"");
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
      findings_.add("/job",
                    "the trace of another job (" + quoted(trace_.title) + ", key " + trace_.job_key + ")",
                    "the job " + quoted(model_.title));
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

}  // namespace vrda::store
