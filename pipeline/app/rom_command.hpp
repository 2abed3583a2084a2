/// `vrda rom`: range of motion.
#pragma once

#include <string>
#include <vector>

#include "core/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct RomOptions {
  std::string job_file, data_directory, folder;
  std::vector<std::string> overrides;
  std::string flexion, varus, internal;  ///< FROM:TO:STEP, degrees; empty: 0, not driven
  std::string translation_mm = "2";      ///< or "free"
  double opening_mm = 0.5;
  double strain = 0.1;
  std::string delta_of;              ///< "moving" or "reference"; empty: as the job's push
  std::vector<std::string> compare;  ///< two rom.json, instead of a job
  std::string shard;                 ///< "I/N", or empty
  bool is_fresh = false;
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  std::string progress = "auto";
  bool as_json = false;
};

/// Resumes from its journal and those of shards in the folder, which it removes at the end. With `shard`
/// writes only a journal. Writes rom.json, rom.csv, boundary.csv, index.html and rom.png into the folder and
/// prints volume and ends; or compares two rom.json, into the folder if one is given. Throws InputError
/// before solving if less than two rotations are driven, or if the folder has the result of another job or of
/// other limits.
core::ExitCode rom_command(const RomOptions& options);

/// Adds the options to a command.
void add_rom_options(CLI::App& command, RomOptions& options);

}  // namespace vrda::app
