// The options of `vrda laxity`.
#include <CLI/CLI.hpp>

#include "app/laxity_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void LaxityOptions::add_to(CLI::App& command)
{
  command.add_option("job", job_file, "Job file (TOML) with [laxity]; its grid is not used")->required();
  command.add_option("-o,--output", folder, "Output folder: laxity.json, laxity.csv, share.csv, index.html")
      ->required();
  command.add_option("--against", against, "Published values (CSV, schemas/laxity.md) to compare with");
  command.add_option("--data", data_directory, "Base folder of relative file names");
  add_overrides(command, overrides);
  command.add_flag("--replace", may_replace, "Replace the result of another job");
  add_threads(command, n_threads);
  add_progress(command, progress);
  command.add_flag("--json", as_json, "Print JSON");
}

}  // namespace vrda::app
