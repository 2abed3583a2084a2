#include "run/summary.hpp"

namespace vrda {

std::map<std::string, int> cells_by_status(const MotionModel& model)
{
  std::map<std::string, int> counts;
  for (Eigen::Index c = 0; c < model.status.size(); ++c) {
    ++counts[name_of(static_cast<StepStatus>(model.status.data()[c]))];
  }
  return counts;
}

double unsolved_fraction(const MotionModel& model)
{
  const auto stable = (model.status == status_stable).count();
  return 1.0 - static_cast<double>(stable) / static_cast<double>(model.status.size());
}

std::string status_line(const MotionModel& model)
{
  std::string line = std::to_string(model.status.size()) + " attitudes:";
  const char* separator = " ";
  for (const auto& [name, n] : cells_by_status(model)) {
    line += separator + std::to_string(n) + ' ' + name;
    separator = ", ";
  }
  return line;
}

}  // namespace vrda
