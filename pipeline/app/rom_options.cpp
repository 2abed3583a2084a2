// The options of `vrda rom`.
#include <CLI/CLI.hpp>

#include "app/rom_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void add_rom_options(CLI::App& c, RomOptions& o)
{
  constexpr double largest = 1e6;
  c.add_option("job", o.job_file, "Job file (TOML); its grid is not used");
  c.add_option("-o,--output", o.folder,
               "Output folder: rom.json, rom.csv, boundary.csv, index.html, rom.png");
  c.add_option("--data", o.data_directory, "Base folder of relative mesh file names");
  add_overrides(c, o.overrides);
  c.add_option("--flexion", o.flexion, "FROM:TO:STEP, degrees; default: 0, not driven");
  c.add_option("--varus", o.varus, "FROM:TO:STEP, degrees (adduction +); default: 0, not driven");
  c.add_option("--internal", o.internal, "FROM:TO:STEP, degrees; default: 0, not driven");
  c.add_option("--translation-mm", o.translation_mm,
               "Largest translation of the rotation centre from the neutral seat along each axis across "
               "Delta, or free")
      ->check(number(0.0, largest, {"free"}))
      ->capture_default_str();
  c.add_option("--opening-mm", o.opening_mm,
               "Largest translation of the rotation centre from the neutral seat against Delta")
      ->check(number(0.0, largest))
      ->capture_default_str();
  c.add_option("--strain", o.strain, "Largest strain of a fibre")
      ->check(number(0.0, largest))
      ->capture_default_str();
  c.add_option("--delta-of", o.delta_of,
               "The object to which Delta is fixed: moving or reference; default: as push.frame of the job")
      ->check(one_of({"moving", "reference"}));
  c.add_option("--compare", o.compare,
               "Two rom.json: volume of each, common, only in one; with --output also maps as "
               "comparison.html and comparison.png, and comparison.csv")
      ->expected(2);
  c.add_option("--shard", o.shard,
               "I/N: solve every Nth flexion from the Ith on, into a journal in the folder; the same command "
               "without --shard joins them");
  c.add_flag("--fresh", o.is_fresh, "Discard the journals in the folder");
  c.add_flag("--replace", o.may_replace, "Replace the result of another job or of other limits");
  add_threads(c, o.n_threads);
  add_progress(c, o.progress);
  c.add_flag("--json", o.as_json, "Print JSON");
}

}  // namespace vrda::app
