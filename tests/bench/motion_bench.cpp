// One pose of each set, as queried by the player in every frame.
#include <benchmark/benchmark.h>

#include "core/units.hpp"
#include "store/motion.hpp"
#include "support/models.hpp"

namespace vrda::benchmarks {
namespace {

/// 91 x 21 attitudes, as in the thesis.
store::MotionModel thesis_sized()
{
  test::ModelPlan plan;
  plan.flexion_deg.clear();
  plan.varus_deg.clear();
  for (int i = 0; i <= 90; ++i) plan.flexion_deg.push_back(i);
  for (int j = -10; j <= 10; ++j) plan.varus_deg.push_back(j);
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.001 * flexion_deg, -0.002 * varus_deg, 0.05, 0.1 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_smoothed(model, 6, [](int i, int j) {
    const double term = 1.0 / (1.0 + i + 7 * j);
    return store::PoseCoordinates{term, term, term, term};
  });
  model.smoothed.front().recontact_mm = store::GridD::Constant(model.status.rows(), model.status.cols(), 0.1);
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
