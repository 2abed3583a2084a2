/// The options of `vrda run`.
#pragma once

#include "job_run/run_command.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

/// Adds the options to a command.
void add_run_options(CLI::App& command, job_run::RunOptions& options);

}  // namespace vrda::app
