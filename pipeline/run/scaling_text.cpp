#include "run/scaling_text.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/number_text.hpp"
#include "run/json_number.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

std::string factor_text(const Eigen::Vector3d& factor)
{
  const auto digits = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return std::string(text);
  };
  if (is_even(factor)) return digits(factor.x());
  return "[" + digits(factor.x()) + ", " + digits(factor.y()) + ", " + digits(factor.z()) + "]";
}

}  // namespace

std::string scaling_line(const Case& job_case)
{
  if (!job_case.scaling) return "";
  const Scaling& scaling = *job_case.scaling;
  if (scaling.factor == Eigen::Vector3d::Ones()) return "scaled by 1: the joint is that of the meshes";
  const std::string by = "scaled by " + factor_text(scaling.factor);
  if (scaling.keeps_steps)
    return by + " from the unscaled joint: uniform scaling keeps contact, the steps are shared";
  return by + ": a new run, since " + job_case.solved_anew_because;
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
          {"standard_error", number_or_null(scaling->standard_error)},
          {"residual_rms_mm", number_or_null(scaling->residual_rms_mm)},
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
    std::printf(" (standard error %s), from %zu pair(s) of landmarks, residual %.2f mm root mean square",
                error.is_null() ? "unknown" : shortest(std::round(error.get<double>() * 1e6) / 1e6).c_str(),
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

}  // namespace vrda
