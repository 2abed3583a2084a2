/// The words of the commands that make many cases by many tasks: plan, submit, status, resume, index, task.
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
  /// Makes a subcommand of that name, description and example.
  using Add =
      std::function<CLI::App&(const std::string& name, const std::string& what, const std::string& example)>;

  /// Adds the commands; the one that is parsed puts itself into `chosen`. Both, and this object, must outlive
  /// the parsing and what is chosen.
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
