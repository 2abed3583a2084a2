// One pose of each set, as queried by the player in every frame: alone, and with its derivatives.
#include <benchmark/benchmark.h>

#include "core/units.hpp"
#include "store/motion.hpp"

namespace vrda::benchmarks {
namespace {

constexpr int degree = 6;

store::SmoothedSet smoothed_set(const store::MotionModel& model)
{
  store::SmoothedSet set;
  set.degree = degree;
  set.exponents.resize((degree + 1) * (degree + 2) / 2, 2);
  Eigen::Index k = 0;
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) set.exponents.row(k++) << i, j;
  }
  for (const char* name : {"tx", "ty", "tz", "theta"}) {
    store::SmoothedSurface& surface = set.surfaces.emplace_back();
    surface.name = name;
    for (int term = 0; term < k; ++term) surface.coefficients.push_back(1.0 / (1.0 + term));
  }
  set.recontact_mm = store::GridD::Constant(model.status.rows(), model.status.cols(), 0.1);
  return set;
}

/// 91 x 21 attitudes, as in the thesis.
store::MotionModel thesis_sized()
{
  store::MotionModel model;
  model.side = "right";
  model.method = "stability-search";
  for (int i = 0; i <= 90; ++i) model.flexion_deg.push_back(i);
  for (int j = -10; j <= 10; ++j) model.varus_deg.push_back(j);
  model = store::with_pending_cells(model);
  model.status.setConstant(status_stable);
  for (store::GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    for (Eigen::Index cell = 0; cell < grid->size(); ++cell)
      grid->data()[cell] = 0.001 * static_cast<double>(cell % 97);
  }
  model.smoothed = {smoothed_set(model)};
  const std::vector<double> column(model.flexion_deg.size(), 1.0);
  store::ZeroVarus table;
  table.source.assign(column.size(), static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
  table.varus_deg = table.tx_mm = table.ty_mm = table.tz_mm = table.theta_deg = column;
  model.zero_varus = table;
  return model;
}

/// Random points in the range, different each time.
Attitude next(int& k)
{
  k = (k + 37) % 9000;
  return {rad_from_deg(0.01 * k), rad_from_deg(0.001 * k - 4.5)};
}

void pose(benchmark::State& state, const store::Motion& motion)
{
  int k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(motion.at(next(k)));
}

[[maybe_unused]] const bool registered = [] {
  const store::MotionModel model = thesis_sized();
  for (const std::string& set : store::set_names(model)) {
    const store::Motion motion(model, set);
    benchmark::RegisterBenchmark(("motion/pose/" + set).c_str(),
                                 [motion](benchmark::State& state) { pose(state, motion); });
  }
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks
