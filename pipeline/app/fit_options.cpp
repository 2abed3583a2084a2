// The options of `vrda fit`.
#include <CLI/CLI.hpp>

#include "app/fit_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void FitCommandOptions::add_to(CLI::App& command)
{
  command.add_option("job", job_file, "Job file (TOML) with [[fit.parameter]] or offset_mm = \"fit\"")
      ->required();
  CLI::Option* to =
      command.add_option("--to", to_files,
                         "Fit [[fit.parameter]] so that the solved motion, or the laxity of [laxity], fits "
                         "this table; may be repeated, each motion is a trial");
  to->allow_extra_args(false)->take_all();
  command
      .add_option("--motion", motion,
                  "Fit offset_mm = \"fit\" to these poses in contact: a table, or a motion model (HDF5)")
      ->excludes(to);
  command.add_option("--rows", rows,
                     "Training frames: A:B (from 1, both included), first-half or second-half; default: all");
  command
      .add_option("--translations", translations,
                  "With --to: rotation-centre, along the Grood-Suntay axes, or mesh-origin, along the "
                  "reference's axes")
      ->check(one_of({"rotation-centre", "mesh-origin"}))
      ->capture_default_str();
  command
      .add_option("--angles", angles,
                  "Unit of the angles of the tables: deg or rad; default: as they state, else deg")
      ->check(one_of({"deg", "rad"}));
  command.add_option(
      "-o,--output", output,
      "Write the resolved job with the numbers found; with --to also JOB.ligaments.csv and JOB.fit.json");
  command.add_flag("--replace", may_replace,
                   "Replace existing files that are not results of this job and these measurements");
  command.add_option("--data", data_directory, "Base folder of relative mesh file names");
  add_overrides(command, overrides);
  command.add_flag("--fresh", is_fresh, "With --to: discard the journal of an interrupted fit");
  command.add_option("--threads", n_threads, "With --to: worker threads; default: one per processor")
      ->check(whole_number(1, 1024));
  add_progress(command, progress);
  command.add_flag("--json", as_json, "Print JSON");
}

}  // namespace vrda::app
