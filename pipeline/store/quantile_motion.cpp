// The motion over flexion of one sample of an uncertain job.
#include "store/poses.hpp"

#include <algorithm>
#include <array>

#include "core/error.hpp"

namespace vrda::store {
namespace {

// Of store::band_probabilities.
constexpr std::array<const char*, 5> quantile_names{"quantile_0", "quantile_5", "quantile_50", "quantile_95",
                                                    "quantile_100"};

// The row of [5, n_flexion] as a column over flexion.
template <typename Number>
std::vector<Number> quantile_row(const std::vector<Number>& table, std::size_t row)
{
  const auto n = static_cast<std::ptrdiff_t>(table.size() / quantile_names.size());
  const auto first = table.begin() + static_cast<std::ptrdiff_t>(row) * n;
  return {first, first + n};
}

bool has_quantile(const store::UncertainMotion& motion, std::size_t row)
{
  const std::vector<std::int8_t> status = quantile_row(motion.quantile_status, row);
  return std::find(status.begin(), status.end(), status_stable) != status.end();
}

}  // namespace

std::vector<std::string> quantile_set_names(const store::MotionModel& model)
{
  std::vector<std::string> listed;
  for (std::size_t row = 0; model.uncertainty && !model.frames && row < quantile_names.size(); ++row) {
    if (has_quantile(*model.uncertainty, row)) listed.emplace_back(quantile_names[row]);
  }
  return listed;
}

std::vector<std::string> all_set_names(const store::MotionModel& model)
{
  std::vector<std::string> sets = set_names(model);
  for (std::string& name : quantile_set_names(model)) sets.push_back(std::move(name));
  return sets;
}

std::optional<store::TwoSided> quantile_motion(const store::MotionModel& model, const std::string& set)
{
  const auto name = std::find(quantile_names.begin(), quantile_names.end(), set);
  if (name == quantile_names.end()) return std::nullopt;
  check(model.uncertainty.has_value(), "the set is one of all_set_names");
  const store::UncertainMotion& table = *model.uncertainty;
  const auto row = static_cast<std::size_t>(name - quantile_names.begin());
  store::TwoSided motion;
  for (const std::int8_t status : quantile_row(table.quantile_status, row))
    motion.contact.push_back(status == status_stable ? std::int8_t{0} : std::int8_t{-1});
  motion.tx_mm = quantile_row(table.tx_mm, row);
  motion.ty_mm = quantile_row(table.ty_mm, row);
  motion.tz_mm = quantile_row(table.tz_mm, row);
  motion.theta_deg = quantile_row(table.theta_deg, row);
  motion.varus_deg = quantile_row(table.varus_deg, row);
  return motion;
}

}  // namespace vrda::store
