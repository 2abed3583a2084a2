/// A part that is refused, and the tasks that are to be done again.
#pragma once

#include <string>
#include <vector>

#include "guide/task.hpp"
#include "tracking/rigid_body.hpp"

namespace vrda {

class PartRefusal : public InputError {
 public:
  explicit PartRefusal(Facts facts, std::vector<std::string> tasks = {})
      : InputError(std::move(facts)), tasks_(std::move(tasks))
  {
  }
  /// Names of those whose marks are doubted; empty: all that were looked at.
  const std::vector<std::string>& tasks() const { return tasks_; }

 private:
  std::vector<std::string> tasks_;
};

/// Runs a fit to marks of `tasks`, in order: of what it refuses, the tasks.
template <typename Fit>
auto fitted(const std::vector<std::string>& tasks, const Fit& fit)
{
  try {
    return fit();
  } catch (const FitRefusal& refusal) {
    std::vector<std::string> doubted;
    for (const std::size_t mark : refusal.marks()) doubted.push_back(tasks.at(mark));
    throw PartRefusal(refusal.facts(), std::move(doubted));
  }
}

/// After the mark of task `done`: throws PartRefusal where scans of opposite edges are crossed, so that one
/// of them is wrong.
void require_uncrossed(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                       const std::string& path);

/// For the screen: what was found and what is wanted, without the file's name.
std::string words_of(const InputError& error);

}  // namespace vrda
