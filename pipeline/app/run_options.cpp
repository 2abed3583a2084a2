// The options of `vrda run`.
#include "app/cluster_options.hpp"

#include <CLI/CLI.hpp>

#include "app/usage.hpp"
#include "run/submission.hpp"

namespace vrda::app {

void add_run_options(CLI::App& c, run::RunOptions& o)
{
  c.add_option("job", o.job_file, "Job file (TOML)")->required();
  c.add_option("-o,--output", o.output, "Motion model; default: results/<job name>/<job name>.h5");
  c.add_option("--data", o.data_directory, "Base folder of relative mesh file names");
  add_overrides(c, o.overrides);
  add_threads(c, o.n_threads);
  c.add_flag("--fresh", o.is_fresh, "Discard the journal and solve again, also when the job is finished");
  c.add_flag("--replace", o.may_replace, "Replace the result of another job");
  CLI::Option* spine = c.add_flag("--spine", o.only_spine,
                                  "Solve only the spine (the path along flexion from which each row "
                                  "starts), into NAME.h5.spine.journal");
  c.add_option_function<std::string>(
       "--shard", [&o](const std::string& text) { o.shard = run::shard_of(text); },
       "I/N: solve every Nth flexion from the Ith on, into a separate journal for vrda merge")
      ->type_name("I/N")
      ->excludes(spine);
  c.add_flag("--trace", o.writes_trace,
             "Write every move of every search, or every iterate of every equilibrium, to NAME.trace.h5");
  c.add_flag("--profile", o.has_profile, "Print the seconds and processor time of each phase");
  c.add_option("--progress", o.progress, "auto, bar, plain or none")->capture_default_str();
}

}  // namespace vrda::app
