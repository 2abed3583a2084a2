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

std::vector<DoubtfulCell> doubtful_cells(const MotionModel& model)
{
  std::vector<DoubtfulCell> cells;
  for (Eigen::Index i = 0; i < model.plausibility.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.plausibility.cols(); ++j) {
      const auto plausibility = static_cast<Plausibility>(model.plausibility(i, j));
      if (!is_doubtful(plausibility)) continue;
      cells.push_back({model.flexion_deg[static_cast<std::size_t>(i)],
                       model.varus_deg[static_cast<std::size_t>(j)], plausibility});
    }
  }
  return cells;
}

std::string plausibility_line(const MotionModel& model)
{
  std::string line;
  for (const Plausibility plausibility : doubtful_plausibilities) {
    const auto n = (model.plausibility == static_cast<std::int8_t>(plausibility)).count();
    if (n > 0) line += (line.empty() ? "" : ", ") + std::to_string(n) + ' ' + name_of(plausibility);
  }
  return line;
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
