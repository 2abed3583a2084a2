#include "view/gap_reading.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.hpp"

namespace vrda::view {
namespace {

/// Interpolation position on an ascending axis: `part` (0 to 1) between `row` and the next.
struct AxisPosition {
  Eigen::Index row = 0;
  double part = 0.0;
};

AxisPosition position_among(const std::vector<double>& axis, double value)
{
  const auto above = std::upper_bound(axis.begin(), axis.end(), value);
  if (above == axis.begin()) return {};
  const Eigen::Index row = above - axis.begin() - 1;
  if (above == axis.end()) return {row, 0.0};
  return {row, (value - *(above - 1)) / (*above - *(above - 1))};
}

AxisPosition position_on(const std::vector<double>& axis_deg, double angle_rad)
{
  return position_among(axis_deg, deg_from_rad(angle_rad));
}

/// Bilinear interpolation. Corners of weight 0 are skipped, so that a NaN next to a cell does not affect it.
double interpolated(const store::GridD& grid, const AxisPosition& flexion, const AxisPosition& varus)
{
  double sum = 0.0;
  for (const int i : {0, 1}) {
    for (const int j : {0, 1}) {
      const double weight =
          (i == 1 ? flexion.part : 1.0 - flexion.part) * (j == 1 ? varus.part : 1.0 - varus.part);
      if (weight > 0.0) sum += weight * grid(flexion.row + i, varus.row + j);
    }
  }
  return sum;
}

double interpolated(const std::vector<double>& values, const AxisPosition& flexion)
{
  const double first = values[static_cast<std::size_t>(flexion.row)];
  if (flexion.part == 0.0) return first;
  return (1.0 - flexion.part) * first + flexion.part * values[static_cast<std::size_t>(flexion.row + 1)];
}

Eigen::Index nearest_row(const AxisPosition& position)
{
  return position.row + (position.part >= 0.5 ? 1 : 0);
}

GapReading of_audit(const store::AuditSet& audit, Eigen::Index i, Eigen::Index j)
{
  GapReading reading{GapSource::audit, nan, nan, nan, nan};
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
    const AxisPosition frame = position_among(model_.frames->key, key);
    return {GapSource::cells, interpolated(model_.gap_medial_mm, frame, {}),
            interpolated(model_.gap_lateral_mm, frame, {}), nan, nan};
  }
  if (audit_ != nullptr) return of_audit(*audit_, nearest_row(position_among(audit_->frame_key, key)), 0);
  return {GapSource::none, nan, nan, nan, nan};
}

GapReading GapReader::at(const Attitude& attitude) const
{
  if (two_sided_ != nullptr) {
    const AxisPosition flexion = position_on(two_sided_->flexion_deg, attitude.flexion_rad);
    return {GapSource::two_sided, interpolated(two_sided_->gap_medial_mm, flexion),
            interpolated(two_sided_->gap_lateral_mm, flexion), nan, nan};
  }
  if (!has_cells_ && audit_ != nullptr)
    return of_audit(*audit_, nearest_row(position_on(audit_->flexion_deg, attitude.flexion_rad)),
                    nearest_row(position_on(audit_->varus_deg, attitude.varus_rad)));
  const AxisPosition flexion = position_on(model_.flexion_deg, attitude.flexion_rad);
  const AxisPosition varus =
      model_.varus_deg.size() > 1 ? position_on(model_.varus_deg, attitude.varus_rad) : AxisPosition{};
  if (has_cells_) {
    return {GapSource::cells, interpolated(model_.gap_medial_mm, flexion, varus),
            interpolated(model_.gap_lateral_mm, flexion, varus), nan, nan};
  }
  if (travel_mm_ != nullptr) {
    const double travel_mm = interpolated(*travel_mm_, flexion, varus);
    if (std::isnan(travel_mm)) return {GapSource::travel, nan, nan, nan, nan};
    return {GapSource::travel, nan, nan, std::max(travel_mm, 0.0), std::max(-travel_mm, 0.0)};
  }
  if (is_recontacted_) return {GapSource::recontacted, nan, nan, 0.0, 0.0};
  return {GapSource::none, nan, nan, nan, nan};
}

}  // namespace vrda::view
