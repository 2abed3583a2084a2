/// Error of a part with the tasks that must be repeated.
#pragma once

#include <string>
#include <vector>

#include "calibration_tasks/task.hpp"
#include "tracking/rigid_body.hpp"

namespace vrda::calibration_tasks {

class PartRefusal : public InputError {
 public:
  explicit PartRefusal(Facts facts, std::vector<std::string> tasks = {})
      : InputError(std::move(facts)), tasks_(std::move(tasks))
  {
  }
  /// Names of the tasks whose marks are rejected; empty: all checked tasks.
  const std::vector<std::string>& tasks() const { return tasks_; }

 private:
  std::vector<std::string> tasks_;
};

/// Runs a fit to the marks of `tasks` (same order) and converts FitError to PartRefusal with task names.
template <typename Fit>
auto run_fit(const std::vector<std::string>& tasks, const Fit& fit)
{
  try {
    return fit();
  } catch (const tracking::FitError& refusal) {
    std::vector<std::string> rejected;
    for (const std::size_t mark : refusal.marks()) rejected.push_back(tasks.at(mark));
    throw PartRefusal(refusal.facts(), std::move(rejected));
  }
}

/// Throws PartRefusal if the mark of task `done` crosses a scan of the opposite edge.
void require_edge_order(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                        const std::string& path);

/// Message for the screen: field, found and wanted, without the file.
std::string screen_message(const InputError& error);

}  // namespace vrda::calibration_tasks
