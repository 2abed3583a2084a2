#include "setup/calibration_record.hpp"

#include <algorithm>
#include <array>

namespace vrda {
namespace {

constexpr std::array<const char*, n_calibration_parts> names{
    "viewport", "distortion", "rails", "stop", "probe", "eyepoints", "ipd",
    "subject",  "bullseye",   "head",  "leg",  "femur", "tibia"};

}  // namespace

const char* name_of(CalibrationPart part)
{
  return names[static_cast<std::size_t>(part)];
}

std::optional<CalibrationPart> calibration_part_named(const std::string& name)
{
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<CalibrationPart>(found - names.begin());
}

bool is_once_a_bench(CalibrationPart part)
{
  return part < CalibrationPart::eyepoints;
}

}  // namespace vrda
