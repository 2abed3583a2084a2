#include "bench_files/calibration_record.hpp"

#include <array>

namespace vrda::bench_files {
namespace {

constexpr std::array<const char*, n_calibration_parts> part_names{
    "viewport", "distortion", "rails", "stop", "probe", "eyepoints", "ipd",
    "subject",  "bullseye",   "head",  "leg",  "femur", "tibia"};

}  // namespace

const char* name_of(CalibrationPart part)
{
  return part_names[static_cast<std::size_t>(part)];
}

std::vector<std::string> shared_estimate_names(CalibrationPart part)
{
  const auto of_each_eye = [](const std::vector<std::string>& numbers) {
    std::vector<std::string> named;
    for (const char* side : {"left.", "right."}) {
      for (const std::string& number : numbers) named.push_back(side + number);
    }
    return named;
  };
  switch (part) {
    case CalibrationPart::viewport:
      return of_each_eye({"edge_left", "edge_right", "edge_top", "edge_bottom", "pixel_aspect"});
    case CalibrationPart::distortion:
      return of_each_eye({"k1", "k2", "centre_x", "centre_y", "pixel_aspect"});
    case CalibrationPart::eyepoints:
      return of_each_eye({"distance", "depth"});
    case CalibrationPart::ipd:
      return {"ipd"};
    case CalibrationPart::rails:
      return calibration::pose_number_names("table");
    case CalibrationPart::probe:
      return {"probe.tip_x", "probe.tip_y", "probe.tip_z"};
    case CalibrationPart::subject:
      return {"subject.scale"};
    default:
      return {};
  }
}

bool is_per_bench(CalibrationPart part)
{
  return part < CalibrationPart::eyepoints;
}

}  // namespace vrda::bench_files
