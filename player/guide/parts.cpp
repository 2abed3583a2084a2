#include "guide/parts.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda {
namespace {

bool is_part_of(CalibrationPart part, const BenchFile& bench)
{
  const bool is_on_stage = bench.head == HeadKind::stage;
  const bool is_touched = !bench.calibration.is_model_adjusted;
  switch (part) {
    case CalibrationPart::rails:
    case CalibrationPart::bullseye:
      return is_on_stage;
    case CalibrationPart::stop:
      return has_stage(bench);
    case CalibrationPart::probe:
      return is_touched;
    case CalibrationPart::head:
      return !is_on_stage;
    case CalibrationPart::subject:
      return !bench.calibration.landmarks.empty();
    case CalibrationPart::leg:
      return bench.leg == LegKind::rigid;
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      return bench.leg == LegKind::two_bodies;
    default:
      return true;
  }
}

/// Whatever the bench has of it.
std::vector<CalibrationPart> may_rest_on(CalibrationPart part, const BenchFile& bench)
{
  switch (part) {
    case CalibrationPart::distortion:
      return {CalibrationPart::viewport};
    case CalibrationPart::eyepoints:
      return {CalibrationPart::distortion};
    case CalibrationPart::ipd:
      return {CalibrationPart::eyepoints};
    case CalibrationPart::bullseye:
      return {CalibrationPart::rails, CalibrationPart::stop, CalibrationPart::eyepoints,
              CalibrationPart::ipd};
    case CalibrationPart::head:
      return {CalibrationPart::eyepoints, CalibrationPart::ipd};
    case CalibrationPart::leg:
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      // A model that is placed by eye is seen through everything else.
      if (bench.calibration.is_model_adjusted)
        return {CalibrationPart::subject, CalibrationPart::bullseye, CalibrationPart::head};
      return {CalibrationPart::probe, CalibrationPart::subject};
    default:
      return {};
  }
}

/// All that may be asked for of the bench, for a message.
std::string step_names(const BenchFile& bench)
{
  return "all, bench, person, tracking, status, solve, " + names_of(parts_of(bench));
}

}  // namespace

std::string names_of(std::span<const CalibrationPart> parts)
{
  std::string text;
  for (const CalibrationPart part : parts) text += (text.empty() ? "" : ", ") + std::string(name_of(part));
  return text;
}

bool is_model_part(CalibrationPart part)
{
  return part == CalibrationPart::leg || part == CalibrationPart::femur || part == CalibrationPart::tibia;
}

bool has_stage(const BenchFile& bench)
{
  return bench.head == HeadKind::stage && bench.board && bench.board->has_stage;
}

std::vector<CalibrationPart> parts_of(const BenchFile& bench)
{
  std::vector<CalibrationPart> parts;
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    if (is_part_of(static_cast<CalibrationPart>(k), bench)) parts.push_back(static_cast<CalibrationPart>(k));
  }
  return parts;
}

std::vector<CalibrationPart> rests_on(CalibrationPart part, const BenchFile& bench)
{
  std::vector<CalibrationPart> parts = may_rest_on(part, bench);
  std::erase_if(parts, [&](CalibrationPart p) { return !is_part_of(p, bench); });
  return parts;
}

bool is_done(const Calibration& calibration, CalibrationPart part)
{
  const auto found = calibration.records.find(part);
  return found != calibration.records.end() && found->second.estimate && !found->second.is_outdated;
}

void outdate_after(Calibration& calibration, CalibrationPart part, const BenchFile& bench)
{
  for (const CalibrationPart later : parts_of(bench)) {
    const std::vector<CalibrationPart> below = rests_on(later, bench);
    if (std::find(below.begin(), below.end(), part) == below.end()) continue;
    const auto record = calibration.records.find(later);
    if (record != calibration.records.end()) record->second.is_outdated = true;
    outdate_after(calibration, later, bench);
  }
}

std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench)
{
  const std::vector<CalibrationPart> all = parts_of(bench);
  if (step == "all") return all;
  std::vector<CalibrationPart> wanted;
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    const bool is_tracking = part == CalibrationPart::rails || part == CalibrationPart::stop ||
                             part == CalibrationPart::probe || part == CalibrationPart::bullseye ||
                             is_model_part(part);
    const bool is_group = (step == "tracking" && is_tracking) || (step == "bench" && is_once_a_bench(part)) ||
                          (step == "person" && !is_once_a_bench(part));
    if (step == name_of(part) || is_group) wanted.push_back(part);
  }
  if (wanted.empty())
    throw InputError({"calibrate", "STEP", "'" + step + "'", "one of " + step_names(bench)});
  if (wanted.size() == 1 && !is_part_of(wanted.front(), bench)) {
    require_wanted(wanted.front(), bench);
    throw InputError({"calibrate", "STEP", "'" + step + "', which " + bench.path + " has no use for",
                      "one of " + step_names(bench)});
  }
  std::erase_if(wanted, [&](CalibrationPart part) { return !is_part_of(part, bench); });
  return wanted;
}

void require_wanted(CalibrationPart part, const BenchFile& bench)
{
  const CalibrationSettings& settings = bench.calibration;
  const auto refuse = [&](const std::string& key, const std::string& found, const std::string& wanted) {
    throw InputError({bench.path, key, found, wanted + ", for " + name_of(part)});
  };
  if (!settings.is_present) refuse("calibration", "nothing", "a table [calibration]");
  constexpr std::size_t least_distances = 3, least_fiducials = 4;
  if (part == CalibrationPart::subject && settings.landmarks.size() < least_distances) {
    refuse("calibration.landmarks", std::to_string(settings.landmarks.size()) + " distances",
           "three or more distances between landmarks");
  }
  if (!is_model_part(part) || settings.is_model_adjusted) return;
  const std::vector<CalibrationPoint>& points = points_of(part, settings);
  const auto n = std::count_if(points.begin(), points.end(),
                               [](const CalibrationPoint& point) { return !point.is_target; });
  if (n < static_cast<std::ptrdiff_t>(least_fiducials)) {
    refuse(part == CalibrationPart::tibia ? "calibration.tibia_point" : "calibration.point",
           std::to_string(n) + " points that are no targets", "four or more, not in one plane");
  }
}

BodyRole role_of(CalibrationPart part)
{
  check(is_model_part(part), "only models are placed on bodies");
  return part == CalibrationPart::leg ? BodyRole::leg
                                      : (part == CalibrationPart::femur ? BodyRole::femur : BodyRole::tibia);
}

const std::vector<CalibrationPoint>& points_of(CalibrationPart part, const CalibrationSettings& settings)
{
  return part == CalibrationPart::tibia ? settings.tibia_points : settings.points;
}

}  // namespace vrda
