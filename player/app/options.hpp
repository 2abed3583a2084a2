/// Declares each mode of `vrda-player` with its options on the command line. The options structs are filled
/// while CLI11 parses; a wrong value is a usage error "found X, wanted Y" with exit code 2.
#pragma once

#include <map>
#include <span>
#include <string>

#include "bench/bench_run.hpp"
#include "bench/measure_body.hpp"
#include "calibrate/calibrate.hpp"
#include "follow/follow.hpp"
#include "navigation/keys.hpp"
#include "show/show.hpp"
#include "web/server.hpp"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace vrda::app {

/// Converts enum values to integers.
template <typename Value>
std::map<std::string, int> enum_numbers(const std::map<std::string, Value>& choices)
{
  std::map<std::string, int> numbers;
  for (const auto& [name, value] : choices) numbers[name] = static_cast<int>(value);
  return numbers;
}

/// Maps a name of `choices` to its number; reports any other as "found X, wanted A, B or C".
CLI::Validator named_choice(const std::map<std::string, int>& choices);

/// For CLI::Option::check: returns an error text for an empty value, otherwise an empty string.
std::string empty_value_error(const std::string& text);

/// Returns "Keys:" and one line per key; the descriptions start at `column`.
std::string key_help_text(std::span<const navigation::HelpLine> lines, std::size_t column);

CLI::App* add_bench(CLI::App& app, bench::BenchOptions& options);
CLI::App* add_calibrate(CLI::App& app, calibrate::CalibrateOptions& options);
CLI::App* add_devices(CLI::App& app, bench::DevicesOptions& options);
CLI::App* add_follow(CLI::App& app, follow::FollowOptions& options);
CLI::App* add_measure_body(CLI::App& app, bench::MeasureBodyOptions& options);
CLI::App* add_show(CLI::App& app, show::ShowOptions& options);
CLI::App* add_simulate(CLI::App& app, bench::SimulateOptions& options);
CLI::App* add_web(CLI::App& app, web::WebOptions& options);

/// Adds the appearance options shared by all modes that render.
void add_appearance_options(CLI::App& mode, navigation::AppearanceOptions& look);

}  // namespace vrda::app
