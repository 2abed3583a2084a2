#include "run/cost.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace vrda::run {
namespace {

// Measured on one core of an Intel Xeon with two or three other busy cores, release build, on the generic
// knee with 1,200 to 75,000 contact triangles, with and without ligaments, and on four real knees with
// 75,000 to 97,000 (results/benchmarks.md), flexion steps of 1 to 10 degrees: log least squares.
constexpr double reference_triangles = 5000.0;

struct StepSeconds {
  double
      spine_s;  ///< per step at `reference_triangles`; spine steps are further from their seed than row steps
  double row_s;
};
// Equilibrium: 0.6 to 5.3 ms and 0.4 to 5.5 ms measured; one real knee 19 ms on its spine.
constexpr StepSeconds of_equilibrium{1.5e-3, 0.95e-3};
// Search: 14 to 150 ms and 12 to 80 ms measured.
constexpr StepSeconds of_search{30e-3, 19e-3};

// Generated meshes need more, 12 microseconds.
constexpr double load_s_of_triangle = 8e-6;
constexpr double load_s_at_least = 0.03;
// Recontacting one cell at `reference_triangles`, with its share of fitting and compression.
constexpr double finish_s_of_cell = 0.4e-3;
constexpr double finish_s_at_least = 0.03;

constexpr double memory_at_least = 20e6;
constexpr double memory_of_triangle = 1250.0;  // of contact meshes: vertices, trees, both objects' copies
constexpr double memory_of_cell = 8e3;

// A record grows with the number of contacts: 460 to 3,500 bytes measured, most on a fine regular mesh.
constexpr double journal_of_spine = 470.0;
constexpr double journal_of_row = 1000.0;

// A sample starts from the job's equilibria and both neighbouring flexions, and is measured: a typical count.
constexpr double starts_of_sample = 4.5;
constexpr double model_of_sample = 60.0;  // of each flexion, compressed

constexpr double model_at_least = 250e3;
constexpr double model_of_triangle = 22.0;  // compressed; all meshes, including display-only
constexpr double model_of_cell = 900.0;
constexpr double model_of_cell_and_fibre = 22.0;

// The exponent 1/2 needs only sqrt, which is equal on all processors; fitted exponents (0.53 to 0.57) improve
// the estimate by less than a tenth over the measured range.
double growth(std::int64_t n_triangles)
{
  return std::sqrt(static_cast<double>(n_triangles) / reference_triangles);
}

std::int64_t nearest_zero(const std::vector<double>& varus_rad)
{
  const auto nearer = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return std::min_element(varus_rad.begin(), varus_rad.end(), nearer) - varus_rad.begin();
}

// The balanced cell, and the probes on either side of it.
std::int64_t probes_of_flexion(const solve::SweepPlan& plan)
{
  if (plan.spine == solve::SpineRule::nearest_zero) return 1;
  const std::int64_t column = nearest_zero(plan.varus_rad);
  const auto last = static_cast<std::int64_t>(plan.varus_rad.size()) - 1;
  return 1 + (column > 0 ? 1 : 0) + (column < last ? 1 : 0);
}

}  // namespace

const double cost_spread = 2.0;

StepCounts step_counts(const solve::SweepPlan& plan)
{
  check(!plan.flexion_rad.empty() && !plan.varus_rad.empty(), "step_counts: an empty grid");
  const auto n_flexion = static_cast<std::int64_t>(plan.flexion_rad.size());
  const auto n_varus = static_cast<std::int64_t>(plan.varus_rad.size());
  const auto n_rows = plan.rows ? static_cast<std::int64_t>(plan.rows->size()) : n_flexion;
  StepCounts counts;
  if (plan.spine == solve::SpineRule::free_varus) {
    const auto n_path = static_cast<std::int64_t>(path_of(plan).size());
    // Each neighbour's equilibrium is tried once at least, each set of small offsets too.
    const auto n_offsets =
        plan.n_restarts > 0 ? static_cast<std::int64_t>(solve::polish_offsets().size()) : 0;
    counts.chain = 2 * n_path + 2 * (n_path - 1);
    counts.restarts = n_path * (plan.n_restarts + n_offsets);
    counts.bands = plan.has_band ? 2 * n_rows : 0;
    counts.cells = plan.is_varus_free ? 0 : n_rows * n_varus;
    counts.records = counts.all() + (plan.is_varus_free ? n_rows : 0);
  } else {
    counts.chain = n_flexion * probes_of_flexion(plan);
    counts.cells = n_rows * (n_varus - 1);
    counts.records = counts.all() + n_flexion;
  }
  return counts;
}

CaseCost cost_of(const CaseSize& size, const StepCounts& steps)
{
  const StepSeconds step = size.is_search ? of_search : of_equilibrium;
  const double factor = growth(size.n_contact_triangles);
  const auto n_triangles = static_cast<double>(size.n_triangles);
  const auto n_cells = static_cast<double>(size.n_flexion * size.n_varus);
  CaseCost cost;
  cost.steps = steps;
  cost.load_s = load_s_at_least + load_s_of_triangle * n_triangles;
  cost.chain_s = step.spine_s * factor * static_cast<double>(steps.chain);
  cost.spine_s = step.spine_s * factor * static_cast<double>(steps.spine());
  const auto n_sampled = static_cast<double>(size.n_samples * size.n_flexion);
  cost.rows_s =
      step.row_s * factor * (static_cast<double>(steps.rows()) + starts_of_sample * n_sampled);
  cost.finish_s =
      finish_s_at_least + finish_s_of_cell * factor * n_cells * static_cast<double>(size.n_smoothed);
  cost.memory_bytes = memory_at_least + memory_of_triangle * static_cast<double>(size.n_contact_triangles) +
                      memory_of_cell * n_cells;
  cost.journal_bytes = journal_of_spine * static_cast<double>(steps.records - steps.rows()) +
                       journal_of_row * (static_cast<double>(steps.rows()) + n_sampled);
  cost.model_bytes = model_at_least + model_of_triangle * n_triangles +
                     (model_of_cell + model_of_cell_and_fibre * static_cast<double>(size.n_fibres)) * n_cells +
                     model_of_sample * n_sampled;
  return cost;
}

}  // namespace vrda::run
