/// Declares each mode of `vrda-player` with its options on the command line. The options structs are filled
/// while CLI11 parses; a wrong value is a usage error "found X, wanted Y" with exit code 2.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/bench_run.hpp"
#include "bench/body_tracker.hpp"
#include "calibration/calibrate.hpp"
#include "show/follow.hpp"
#include "show/show.hpp"
#include "view/keys.hpp"
#include "web/server.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace vrda::app {

/// Adds an option whose value is called `type` in the help.
template <typename App, typename Value>
auto add(App* mode, const char* name, const char* type, Value& value, const std::string& text)
{
  return mode->add_option(name, value, text)->type_name(type);
}

/// For CLI::Option::check: returns an error text for an empty value, otherwise an empty string.
std::string empty_value_error(const std::string& text);

/// Returns "Keys:" and one line per key; the descriptions start at `column`.
std::string key_help_text(std::span<const view::HelpLine> lines, std::size_t column);

CLI::App* add_bench(CLI::App& app, bench::BenchOptions& options);
CLI::App* add_calibrate(CLI::App& app, calibration::CalibrateOptions& options);
CLI::App* add_devices(CLI::App& app, bench::DevicesOptions& options);
CLI::App* add_follow(CLI::App& app, show::FollowOptions& options);
CLI::App* add_measure_body(CLI::App& app, bench::MeasureBodyOptions& options);
CLI::App* add_serve(CLI::App& app, bench::ServeOptions& options);
CLI::App* add_show(CLI::App& app, show::ShowOptions& options);
CLI::App* add_simulate(CLI::App& app, bench::SimulateOptions& options);
/// `web`, with the bench that it streams.
struct WebMode {
  web::WebOptions web;
  std::vector<std::string> tls;  ///< certificate and key
  bench::BenchOptions bench;
};
CLI::App* add_web(CLI::App& app, WebMode& mode);

/// Adds the appearance options shared by all modes that render.
void add_appearance_options(CLI::App& mode, view::AppearanceOptions& look);

}  // namespace vrda::app
