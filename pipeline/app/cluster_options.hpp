/// Command-line options of `vrda run`, and of the commands for many cases: plan, submit, status, resume,
/// index, task.
#pragma once

#include <functional>
#include <string>

#include "app/cluster_commands.hpp"
#include "core/console.hpp"
#include "run/run_command.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

class ClusterOptions {
 public:
  /// Creates a subcommand with a name, a description and an example.
  using AddCommand =
      std::function<CLI::App&(const std::string& name, const std::string& what, const std::string& example)>;

  /// Adds the commands; parsing one of them stores its action in `chosen`. `chosen` and this object must
  /// outlive parsing and the call of the action.
  void add_to(const AddCommand& add, std::function<core::ExitCode()>& chosen);

 private:
  void add_plan(const AddCommand& add, std::function<core::ExitCode()>& chosen);
  void add_index(const AddCommand& add, std::function<core::ExitCode()>& chosen);
  void add_submit(const AddCommand& add, std::function<core::ExitCode()>& chosen);
  void add_resume(const AddCommand& add, std::function<core::ExitCode()>& chosen);
  void add_status(const AddCommand& add, std::function<core::ExitCode()>& chosen);
  void add_task(const AddCommand& add, std::function<core::ExitCode()>& chosen);

  PlanOptions plan_;
  IndexOptions index_;
  SubmitOptions submit_;
  ResumeOptions resume_;
  StatusOptions status_;
  TaskOptions task_;
};

/// Adds the options of `vrda run`.
void add_run_options(CLI::App& command, run::RunOptions& options);

}  // namespace vrda::app
