#include "run/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/console.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "run/job_checks.hpp"
#include "job/job.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::run {
namespace {

using Json = nlohmann::ordered_json;

std::string factor_text(const Eigen::Vector3d& factor)
{
  const auto digits = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return std::string(text);
  };
  if (is_uniform(factor)) return digits(factor.x());
  return "[" + digits(factor.x()) + ", " + digits(factor.y()) + ", " + digits(factor.z()) + "]";
}

}  // namespace

std::string scaling_line(const job::Case& job_case)
{
  if (!job_case.scaling) return "";
  const Scaling& scaling = *job_case.scaling;
  if (scaling.factor == Eigen::Vector3d::Ones()) return "scaled by 1: the joint has the size of the meshes";
  const std::string by = "scaled by " + factor_text(scaling.factor);
  if (scaling.keeps_steps)
    return by + " from the unscaled joint: uniform scaling keeps contact, the steps are shared";
  return by + ": a new run, since " + job_case.rerun_reason;
}

Json scaling_json(const std::optional<Scaling>& scaling)
{
  if (!scaling) return {};
  Json landmarks = Json::array();
  for (std::size_t i = 0; i < scaling->landmark.size(); ++i) {
    landmarks.push_back({{"name", scaling->landmark[i]},
                         {"model_mm", scaling->model_mm[i]},
                         {"scaled_mm", scaling->factor.x() * scaling->model_mm[i]},
                         {"subject_mm", scaling->subject_mm[i]},
                         {"residual_mm", scaling->residual_mm[i]}});
  }
  return {{"factor", {scaling->factor.x(), scaling->factor.y(), scaling->factor.z()}},
          {"keeps_steps", scaling->keeps_steps},
          {"standard_error", scaling->standard_error},
          {"residual_rms_mm", scaling->residual_rms_mm},
          {"landmarks", landmarks}};
}

void print_scaling(const Json& scaling)
{
  if (scaling.is_null()) return;
  const Json& f = scaling["factor"];
  std::printf("scaling: factor %s",
              factor_text({f[0].get<double>(), f[1].get<double>(), f[2].get<double>()}).c_str());
  const Json& pairs = scaling["landmarks"];
  if (!pairs.empty()) {
    const Json& error = scaling["standard_error"];
    std::printf(
        " (standard error %s), from %zu pair(s) of landmarks, residual %.2f mm root mean square",
        error.is_null() ? "unknown" : shortest_decimal(std::round(error.get<double>() * 1e6) / 1e6).c_str(),
        pairs.size(), scaling["residual_rms_mm"].get<double>());
  }
  std::printf("\n");
  if (pairs.empty()) return;
  std::printf("  %-24s %10s %10s %10s %10s mm\n", "pair", "model", "scaled", "subject", "residual");
  for (const Json& pair : pairs) {
    std::printf("  %-24s %10.2f %10.2f %10.2f %+10.2f\n", pair["name"].get<std::string>().c_str(),
                pair["model_mm"].get<double>(), pair["scaled_mm"].get<double>(),
                pair["subject_mm"].get<double>(), pair["residual_mm"].get<double>());
  }
}

std::map<std::string, int> cells_by_status(const store::MotionModel& model)
{
  std::map<std::string, int> counts;
  for (Eigen::Index c = 0; c < model.status.size(); ++c) {
    ++counts[name_of(static_cast<StepStatus>(model.status.data()[c]))];
  }
  return counts;
}

store::GridB is_past_border(const store::MotionModel& model)
{
  store::GridB past = store::GridB::Zero(model.status.rows(), model.status.cols());
  const std::vector<double>& flexion_deg = model.flexion_deg;
  const double start_deg = *std::min_element(flexion_deg.begin(), flexion_deg.end(),
                                             [](double a, double b) { return std::abs(a) < std::abs(b); });
  for (Eigen::Index j = 0; j < past.cols(); ++j) {
    for (const double sign : {1.0, -1.0}) {
      const auto is_at_border = [&](Eigen::Index i) {
        return model.plausibility(i, j) == static_cast<std::int8_t>(Plausibility::border_contact);
      };
      const auto beyond_start_deg = [&](Eigen::Index i) {
        return sign * (flexion_deg[static_cast<std::size_t>(i)] - start_deg);
      };
      double first_deg = std::numeric_limits<double>::infinity();
      for (Eigen::Index i = 0; i < past.rows(); ++i) {
        if (is_at_border(i) && beyond_start_deg(i) >= 0.0)
          first_deg = std::min(first_deg, beyond_start_deg(i));
      }
      for (Eigen::Index i = 0; i < past.rows(); ++i)
        if (is_at_border(i) && beyond_start_deg(i) > first_deg + border_margin_deg) past(i, j) = 1;
    }
  }
  return past;
}

double unsolved_fraction(const store::MotionModel& model)
{
  const auto stable = (model.status == status_stable && is_past_border(model) == 0).count();
  return 1.0 - static_cast<double>(stable) / static_cast<double>(model.status.size());
}

std::string samples_line(const store::MotionModel& model)
{
  if (!model.uncertainty) return "";
  const std::vector<std::int8_t>& status = model.uncertainty->status;
  const auto n_stable = std::count(status.begin(), status.end(), status_stable);
  const auto n_failed = static_cast<std::ptrdiff_t>(status.size()) - n_stable;
  std::string line = std::to_string(model.uncertainty->n_samples()) +
                     " samples: " + std::to_string(n_stable) + " of " + std::to_string(status.size()) +
                     " poses stable";
  if (n_failed > 0) line += ", " + std::to_string(n_failed) + " left out of the bands";
  return line;
}

std::vector<DoubtfulCell> doubtful_cells(const store::MotionModel& model)
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

std::string plausibility_line(const store::MotionModel& model)
{
  std::string line;
  for (const Plausibility plausibility : doubtful_plausibilities) {
    const auto n = (model.plausibility == static_cast<std::int8_t>(plausibility)).count();
    if (n > 0) line += (line.empty() ? "" : ", ") + std::to_string(n) + ' ' + name_of(plausibility);
  }
  return line;
}

std::string status_line(const store::MotionModel& model)
{
  std::string line = std::to_string(model.status.size()) + " attitudes:";
  const char* separator = " ";
  for (const auto& [name, n] : cells_by_status(model)) {
    line += separator + std::to_string(n) + ' ' + name;
    separator = ", ";
  }
  return line;
}

job::Case load_and_report_case(const std::string& job_file, const job::LoadOptions& options)
{
  job::Case job_case =
      load_checked_case(job::read_job(job_file, options.overrides), options.data_directory).job_case;
  for (const std::string& line : job_case.warnings) core::log_warning(line);
  if (const std::string line = scaling_line(job_case); !line.empty()) core::log_info(line);
  return job_case;
}

store::MotionModel read_solved_model(const std::string& file)
{
  store::MotionModel model = store::read_motion_model(file);
  const auto n_stable = (model.status == status_stable).count();
  if (n_stable == 0) throw InputError({file, "/status", status_line(model), "at least one stable attitude"});
  return model;
}

int thread_count_or_all(int requested)
{
  if (requested > 0) return requested;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace vrda::run
