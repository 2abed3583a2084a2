// Measured and repaired motion of a repaired model, for the page.
#include "model/clinical.hpp"
#include "core/units.hpp"
#include "report/model_json.hpp"

namespace vrda::report {
namespace {

struct FrameLengths {
  const std::vector<double>&gap_mm, &penetration_mm;
};

Json motion_json(const store::MotionModel& model, const std::vector<double>& poses,
                 const FrameLengths& lengths)
{
  const Side side = model.side == "left" ? Side::left : Side::right;
  ContinuousCoordinates along(side, model.rotation_centre_mm);
  std::vector<double> flexion, varus, internal, anterior, proximal, lateral;
  for (std::size_t k = 0; k < model.flexion_deg.size(); ++k) {
    const ClinicalCoordinates c = along.next(store::pose_in(poses, k));
    flexion.push_back(deg_from_rad(c.flexion_rad));
    varus.push_back(deg_from_rad(c.varus_rad));
    internal.push_back(deg_from_rad(c.internal_rotation_rad));
    anterior.push_back(c.anterior_mm);
    proximal.push_back(c.proximal_mm);
    lateral.push_back(c.lateral_mm);
  }
  return {{"gap", short_numbers(lengths.gap_mm)}, {"penetration", short_numbers(lengths.penetration_mm)},
          {"flexion", short_numbers(flexion)},    {"varus", short_numbers(varus)},
          {"internal", short_numbers(internal)},  {"anterior", short_numbers(anterior)},
          {"proximal", short_numbers(proximal)},  {"lateral", short_numbers(lateral)}};
}

}  // namespace

Json repair_json(const store::MotionModel& model)
{
  if (!model.repair || !model.frames) return nullptr;
  const store::RepairedFrames& r = *model.repair;
  Json statuses = Json::array();
  for (const std::int8_t status : r.status) statuses.push_back(status);
  return {{"key_name", model.frames->key_name},
          {"key", short_numbers(model.frames->key)},
          {"before", motion_json(model, r.X_measured, {r.gap_before_mm, r.penetration_before_mm})},
          {"after", motion_json(model, model.X_reference_moving, {r.gap_after_mm, r.penetration_after_mm})},
          {"distance", short_numbers(r.distance)},
          {"status", statuses},
          {"converged", r.is_converged},
          {"noise_deg", short_numbers(r.noise_deg)},
          {"noise_mm", short_numbers(r.noise_mm)},
          {"gap_limit", short_numbers(r.gap_limit_mm)}};
}

}  // namespace vrda::report
