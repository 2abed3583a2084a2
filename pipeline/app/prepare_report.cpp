#include "app/prepare_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/component_loader.hpp"
#include "model/frames.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
using geometry::KneeFit;

Json matrix_json(const Eigen::Matrix4d& X)
{
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < 4; ++i) rows.push_back({X(i, 0), X(i, 1), X(i, 2), X(i, 3)});
  return rows;
}

// Takes vertices of the files to the bone's anatomical frame.
Eigen::Matrix4d anatomical_from_file(const KneeFit& fit, const Pose& X_scan_bone)
{
  Eigen::Matrix4d X = X_scan_bone.inverse().matrix();
  X.leftCols<3>() *= fit.unit_mm;
  X(3, 3) = 1.0;
  return X;
}

Json bone_json(const KneeFit& fit, const geometry::BoneFit& bone, const Pose& X_scan_bone)
{
  return {{"anatomical_from_file", matrix_json(anatomical_from_file(fit, X_scan_bone))},
          {"scale", {bone.scale.x(), bone.scale.y(), bone.scale.z()}},
          {"residual_mm", bone.residual_mm}};
}

Json number_or_null(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
}

Json bone_scale_json(const Scaling& scaling)
{
  Json distances = Json::array();
  for (std::size_t i = 0; i < scaling.landmark.size(); ++i) {
    distances.push_back({{"name", scaling.landmark[i]},
                         {"template_mm", scaling.model_mm[i]},
                         {"subject_mm", scaling.subject_mm[i]},
                         {"residual_mm", scaling.residual_mm[i]}});
  }
  return {{"scale", {scaling.factor.x(), scaling.factor.y(), scaling.factor.z()}},
          {"residual_rms_mm", number_or_null(scaling.residual_rms_mm)},
          {"distances", distances}};
}

}  // namespace

Json fit_json(const KneeFit& fit)
{
  const ClinicalCoordinates& scanned = fit.scanned;
  return {{"unit", job::unit_of_mm(fit.unit_mm)},
          {"side", side_name(fit.side)},
          {"side_margin", fit.side_margin},
          {"coarse_residual_mm", fit.coarse_residual_mm},
          {"femur", bone_json(fit, fit.femur, fit.X_scan_femur)},
          {"tibia", bone_json(fit, fit.tibia, fit.X_scan_tibia)},
          {"scanned",
           {{"flexion_deg", deg_from_rad(scanned.flexion_rad)},
            {"varus_deg", deg_from_rad(scanned.varus_rad)},
            {"internal_rotation_deg", deg_from_rad(scanned.internal_rotation_rad)},
            {"anterior_mm", scanned.anterior_mm},
            {"proximal_mm", scanned.proximal_mm},
            {"lateral_mm", scanned.lateral_mm},
            {"X_femur_tibia", matrix_json((fit.X_scan_femur.inverse() * fit.X_scan_tibia).matrix())}}}};
}

Json landmarks_json(const prepare::KneeLandmarks& landmarks, const std::vector<double>& residuals_mm,
                    std::vector<std::string>& warnings)
{
  constexpr double usual_mm = 10.0;
  Json rows = Json::array();
  for (std::size_t i = 0; i < landmarks.points.size(); ++i) {
    const std::string& name = landmarks.points[i].name;
    const double residual_mm = residuals_mm[i];
    rows.push_back({{"name", name}, {"residual_mm", number_or_null(residual_mm)}});
    if (!std::isfinite(residual_mm)) {
      warnings.push_back("landmarks." + name + ": not used; the template does not have this bone");
    } else if (residual_mm > usual_mm) {
      warnings.push_back("landmarks." + name + ": " + shortest_decimal(std::round(residual_mm)) +
                         " mm from where the bones have it");
    }
  }
  return rows;
}

Json scales_json(const prepare::LandmarkScales& scales, Side side)
{
  return {{"side", side_name(side)},
          {"femur", bone_scale_json(scales.femur)},
          {"tibia", bone_scale_json(scales.tibia)}};
}

Json bundles_json(const model::Ligaments& ligaments, const prepare::SlackResult& slack,
                  std::vector<std::string>& warnings)
{
  constexpr double largest_strain = 0.15, largest_tension_n = 1000.0;
  struct Sum {
    double strain = 0.0, tension_n = 0.0;
  };
  std::vector<std::pair<std::string, Sum>> bundles;
  for (std::size_t i = 0; i < ligaments.fibres.size(); ++i) {
    const std::string& name = ligaments.fibres[i].bundle;
    auto found = std::find_if(bundles.begin(), bundles.end(), [&](const auto& b) { return b.first == name; });
    if (found == bundles.end()) found = bundles.insert(bundles.end(), {name, {}});
    found->second.strain = std::max(found->second.strain, slack.loads.largest_strain[i]);
    found->second.tension_n += slack.loads.largest_tension_n[i];
  }
  Json rows = Json::array();
  for (const auto& [name, sum] : bundles) {
    rows.push_back({{"name", name}, {"largest_strain", sum.strain}, {"largest_tension_n", sum.tension_n}});
    if (sum.strain <= largest_strain && sum.tension_n <= largest_tension_n) continue;
    warnings.push_back("ligament " + name + ": strain " +
                       shortest_decimal(std::round(1e3 * sum.strain) / 1e3) + " and tension " +
                       shortest_decimal(std::round(sum.tension_n)) + " N, usual are at most 0.15 and 1000 N");
  }
  return rows;
}

Json fibres_json(const prepare::TransferredLigaments& transferred, const prepare::SlackResult& slack)
{
  Json rows = Json::array();
  for (std::size_t i = 0; i < transferred.moves.size(); ++i) {
    rows.push_back({{"name", transferred.ligaments.fibres[i].name},
                    {"moved_femur_mm", number_or_null(transferred.moves[i].reference_mm)},
                    {"moved_tibia_mm", number_or_null(transferred.moves[i].moving_mm)},
                    {"largest_strain", slack.loads.largest_strain[i]},
                    {"template_strain", slack.template_strain[i]}});
  }
  return rows;
}

}  // namespace vrda::app
