// The options of `vrda fit`.
#include <CLI/CLI.hpp>

#include "app/fit_command.hpp"

namespace vrda::app {

void FitCommandOptions::add_to(CLI::App& command)
{
  command.add_option("job", job_file, "Job file (TOML) with offset_mm = \"fit\"")->required();
  command.add_option("--motion", motion, "Measured motion: a table of poses, or a motion model (HDF5)")
      ->required();
  command.add_option("--rows", rows,
                     "Training frames: A:B (from 1, both included), first-half or second-half; default: all");
  command.add_option("-o,--output", output, "Write the resolved job with the number found");
  command.add_option("--data", data_directory, "Base folder of relative mesh file names");
  command.add_option("--set", overrides, "key=value, overrides the job file; may be repeated")
      ->allow_extra_args(false)
      ->take_all();
  command.add_flag("--json", as_json, "Print JSON");
}

}  // namespace vrda::app
