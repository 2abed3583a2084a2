// `vrda run` and `vrda merge`, which the room `run` does.
#include "run/run_command.hpp"

#include "app/commands.hpp"

namespace vrda::app {

void declare_run(Command& c)
{
  auto& o = c.options<run::RunOptions>();
  c.job(o.job_file);
  c.option("-o,--output", o.output, "Motion model; default: results/NAME/NAME.h5, named by job and folder");
  c.loading(o);
  c.threads(o.n_threads);
  c.flag("--fresh", o.is_fresh, "Discard the journal and solve again, also when the job is finished");
  c.flag("--replace", o.may_replace, "Replace the result of another job");
  const Option spine = c.flag("--spine", o.only_spine,
                              "Solve only the spine (the path along flexion from which each row "
                              "starts), into NAME.h5.spine.journal");
  c.option_for(
       "--shard", [&o](const std::string& text) { o.shard = run::shard_of(text); },
       "I/N: solve every Nth flexion from the Ith on, into a separate journal for vrda merge")
      .named("I/N")
      .excludes(spine);
  c.flag("--trace", o.writes_trace,
         "Write every move of every search, or every iterate of every equilibrium, to NAME.trace.h5");
  c.flag("--profile", o.has_profile, "Print the seconds and processor time of each phase");
  c.option("--progress", o.progress, "auto, bar, plain or none").shows_default();
  c.runs([&o, c] {
    if (c.is_quiet()) o.progress = "none";
    return run::run_command(o);
  });
}

void declare_merge(Command& c)
{
  auto& o = c.options<run::MergeOptions>();
  c.option("journals", o.journals, "Journals; default: those of the spine and shards next to FILE");
  c.option("-o,--output", o.output, "Motion model to write").required();
  c.option("--job", o.job_file,
           "Job file (TOML); default: as recorded in the case file next to the journals");
  c.data(o.data_directory, "With --job: base folder of relative mesh file names");
  c.option("--set", o.overrides, "With --job: key=value, overrides the job file; may be repeated")
      .repeatable();
  c.threads(o.n_threads, "Threads for smoothing; default: one per processor");
  c.flag("--keep", o.keeps_journals, "Keep the journals");
  c.flag("--replace", o.may_replace, "Replace the result of another job");
  c.runs([&o] { return run::merge_command(o); });
}

}  // namespace vrda::app
