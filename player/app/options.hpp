/// The modes on the command line.
#pragma once

#include "bench/bench_run.hpp"
#include "bench/measure_body.hpp"
#include "bench/simulate.hpp"
#include "calibrate/calibrate.hpp"
#include "follow/follow.hpp"
#include "show/show.hpp"
#include "web/server.hpp"

namespace CLI {
class App;
}

namespace vrda {

CLI::App* add_bench(CLI::App& app, BenchOptions& options);
CLI::App* add_calibrate(CLI::App& app, CalibrateOptions& options);
CLI::App* add_devices(CLI::App& app, DevicesOptions& options);
CLI::App* add_follow(CLI::App& app, FollowOptions& options);
CLI::App* add_measure_body(CLI::App& app, MeasureBodyOptions& options);
CLI::App* add_show(CLI::App& app, ShowOptions& options);
CLI::App* add_simulate(CLI::App& app, SimulateOptions& options);
CLI::App* add_web(CLI::App& app, WebOptions& options);

/// Of every mode that draws.
void add_look(CLI::App& mode, LookOptions& look);

}  // namespace vrda
