// The options of `vrda trace`.
#include <CLI/CLI.hpp>

#include "app/model_commands.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void TraceOptions::add_to(CLI::App& command)
{
  command.add_option("file", file, "Trace (HDF5), written by vrda run --trace")->required();
  command.add_option("--flexion", filter.flexion_deg, "Only searches at this flexion of the grid, degrees")
      ->check(any_number());
  command.add_option("--varus", filter.varus_deg, "Only searches at this varus of the grid, degrees")
      ->check(any_number());
  command.add_flag("--contact-only", contact_only, "Only moves in contact");
  CLI::Option* csv = command.add_flag("--csv", as_csv, "Print the moves as CSV");
  command.add_flag("--json", as_json, "Print JSON")->excludes(csv);
}

}  // namespace vrda::app
