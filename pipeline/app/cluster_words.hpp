/// Command-line options of the commands for many cases: plan, submit, status, resume, index, task.
#pragma once

#include <functional>
#include <string>

#include "app/cluster_commands.hpp"
#include "talk/talk.hpp"

namespace CLI {
class App;
}

namespace vrda {

class ClusterWords {
 public:
  /// Creates a subcommand with a name, a description and an example.
  using Add =
      std::function<CLI::App&(const std::string& name, const std::string& what, const std::string& example)>;

  /// Adds the commands; parsing one of them stores its action in `chosen`. `chosen` and this object must
  /// outlive parsing and the call of the action.
  void add_to(const Add& add, std::function<ExitCode()>& chosen);

 private:
  void add_plan(const Add& add, std::function<ExitCode()>& chosen);
  void add_index(const Add& add, std::function<ExitCode()>& chosen);
  void add_submit(const Add& add, std::function<ExitCode()>& chosen);
  void add_resume(const Add& add, std::function<ExitCode()>& chosen);
  void add_status(const Add& add, std::function<ExitCode()>& chosen);
  void add_task(const Add& add, std::function<ExitCode()>& chosen);

  PlanOptions plan_;
  IndexOptions index_;
  SubmitOptions submit_;
  ResumeOptions resume_;
  StatusOptions status_;
  TaskOptions task_;
};

}  // namespace vrda
