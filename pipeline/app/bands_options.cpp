// The options of `vrda bands`.
#include <CLI/CLI.hpp>

#include "app/bands_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void BandsOptions::add_to(CLI::App& command)
{
  command.add_option("file", file, "Motion model (HDF5) of a job with [uncertainty]")->required();
  CLI::Option* chosen = command
                            .add_option("--table", table,
                                        "bands: quantiles over flexion; fibres: of their tension; shares: "
                                        "contributions of the draws to the spread; samples: draws and poses")
                            ->check(one_of({"bands", "fibres", "shares", "samples"}))
                            ->capture_default_str();
  command.add_flag("--json", as_json, "Print bands and shares as JSON")->excludes(chosen);
}

}  // namespace vrda::app
