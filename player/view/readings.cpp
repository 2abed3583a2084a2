#include "view/readings.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/axis.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"

namespace vrda::view {
namespace {

AxisPosition position_on_deg(const std::vector<double>& axis_deg, double angle_rad)
{
  return position_on(axis_deg, deg_from_rad(angle_rad));
}

/// Bilinear interpolation. Corners of weight 0 are skipped, so that a NaN next to a cell does not affect it.
double interpolated(const store::GridD& grid, const AxisPosition& flexion, const AxisPosition& varus)
{
  double sum = 0.0;
  for (const int i : {0, 1}) {
    for (const int j : {0, 1}) {
      const double weight =
          (i == 1 ? flexion.share : 1.0 - flexion.share) * (j == 1 ? varus.share : 1.0 - varus.share);
      if (weight > 0.0)
        sum += weight *
               grid(static_cast<Eigen::Index>(flexion.row) + i, static_cast<Eigen::Index>(varus.row) + j);
    }
  }
  return sum;
}

Eigen::Index nearest_row(const AxisPosition& position)
{
  return static_cast<Eigen::Index>(position.row) + (position.share >= 0.5 ? 1 : 0);
}

GapReading of_audit(const store::AuditSet& audit, Eigen::Index i, Eigen::Index j)
{
  GapReading reading{GapSource::audit};
  const auto state = static_cast<store::AuditState>(audit.state(i, j));
  if (state == store::AuditState::no_pose || state == store::AuditState::nothing_ahead) return reading;
  reading.gap_mm = state == store::AuditState::free ? audit.gap_mm(i, j) : 0.0;
  reading.penetration_mm = audit.penetration_mm(i, j);
  return reading;
}

}  // namespace

GapReader::GapReader(const store::MotionModel& model, const std::string& set)
    : has_cells_(set == "raw" && model.has_compartments), model_(model)
{
  for (const store::AuditSet& audit : model.audits) {
    if (audit.name == set) audit_ = &audit;
  }
  if (set == "two_sided" && model.two_sided) two_sided_ = &*model.two_sided;
  for (const store::SmoothedSet& smoothed : model.smoothed) {
    const std::string name = "degree_" + std::to_string(smoothed.degree);
    if (!smoothed.recontact_mm) continue;
    if (set == name) travel_mm_ = &*smoothed.recontact_mm;
    if (set == name + "_recontacted") is_recontacted_ = true;
  }
}

GapReading GapReader::at(const store::JointPose& pose) const
{
  return model_.frames ? at_frame(pose.key) : at(pose.attitude);
}

GapReading GapReader::at_frame(double key) const
{
  if (has_cells_) {
    const AxisPosition frame = position_on(model_.frames->key, key);
    return {GapSource::cells,
            {interpolated(model_.gap_mm[0], frame, {}), interpolated(model_.gap_mm[1], frame, {})}};
  }
  if (audit_ != nullptr) return of_audit(*audit_, nearest_row(position_on(audit_->frame_key, key)), 0);
  return {GapSource::none};
}

GapReading GapReader::at(const Attitude& attitude) const
{
  if (two_sided_ != nullptr) {
    const AxisPosition flexion = position_on_deg(two_sided_->flexion_deg, attitude.flexion_rad);
    return {GapSource::two_sided,
            {linear_at(two_sided_->gap_mm[0], flexion), linear_at(two_sided_->gap_mm[1], flexion)}};
  }
  if (!has_cells_ && audit_ != nullptr)
    return of_audit(*audit_, nearest_row(position_on_deg(audit_->flexion_deg, attitude.flexion_rad)),
                    nearest_row(position_on_deg(audit_->varus_deg, attitude.varus_rad)));
  const AxisPosition flexion = position_on_deg(model_.flexion_deg, attitude.flexion_rad);
  const AxisPosition varus =
      model_.varus_deg.size() > 1 ? position_on_deg(model_.varus_deg, attitude.varus_rad) : AxisPosition{};
  if (has_cells_) {
    return {GapSource::cells,
            {interpolated(model_.gap_mm[0], flexion, varus), interpolated(model_.gap_mm[1], flexion, varus)}};
  }
  if (travel_mm_ != nullptr) {
    const double travel_mm = interpolated(*travel_mm_, flexion, varus);
    if (std::isnan(travel_mm)) return {GapSource::travel};
    return {GapSource::travel, {nan, nan}, std::max(travel_mm, 0.0), std::max(-travel_mm, 0.0)};
  }
  if (is_recontacted_) return {GapSource::recontacted, {nan, nan}, 0.0, 0.0};
  return {GapSource::none};
}

std::string set_label(const std::string& set)
{
  if (set == "raw") return "raw cells";
  std::string label = set;
  const std::string suffix = "_recontacted";
  const std::size_t at = label.find(suffix);
  if (at != std::string::npos) label = label.substr(0, at) + ", recontacted";
  std::replace(label.begin(), label.end(), '_', ' ');
  return label;
}

RotationPlots rotation_plots(const store::MotionModel& model, const std::vector<std::string>& sets)
{
  if (!model.prior) return {};
  constexpr std::size_t n_values = 61;
  const store::Motion alone(model, store::bones_alone_name);
  const auto line = [&](const std::string& set, float width_px) {
    const store::Motion motion(model, set);
    CurveLine curve{set_label(set), {}, {}, {}, width_px};
    for (std::size_t i = 0; i < n_values; ++i) {
      const double flexion_rad = std::lerp(alone.first_flexion_rad(), alone.last_flexion_rad(),
                                           static_cast<double>(i) / (n_values - 1));
      const store::JointPose pose = motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad)});
      const auto rotation_deg = [&] {
        return static_cast<float>(deg_from_rad(
            clinical_coordinates(pose.X_reference_moving, side_named(model.side), model.rotation_centre_mm)
                .internal_rotation_rad));
      };
      curve.values.push_back(pose.status == store::PoseStatus::solved ? rotation_deg() : NAN);
    }
    return curve;
  };
  RotationPlots plots{{}, alone.first_flexion_rad(), alone.last_flexion_rad()};
  const CurveLine thin = line(store::bones_alone_name, 1.0F);
  for (const std::string& set : sets) {
    plots.of_sets.push_back({line(set, 2.0F)});
    if (set != store::bones_alone_name) plots.of_sets.back().push_back(thin);
  }
  return plots;
}

}  // namespace vrda::view
