/// Parsers of option values.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "store/poses.hpp"

namespace vrda::view {

struct AngleRange {
  double first_deg = 0.0;
  double last_deg = 0.0;
  double step_deg = 1.0;
};

/// The parts between separators, including empty ones; at least one.
std::vector<std::string> split(const std::string& text, char separator);

/// Throws InputError for an option.
[[noreturn]] void refuse_option(const char* option, const std::string& found, const std::string& wanted);

/// Parses "A:B:STEP" or one angle "A", in degrees. Throws InputError for another form, a reversed range, a
/// step below 0.001, or more than 10,000 angles.
AngleRange parsed_angles(const std::string& option, const std::string& text);

/// Throws InputError unless it is a number from -360 to 360.
void require_angle(const std::string& option, double angle_deg);

/// first, first + step, ... up to last (with a tolerance of a millionth of a step).
std::vector<double> angles_deg(const AngleRange& range);

struct PictureSize {
  int width = 1280;
  int height = 960;
};

/// Parses "WxH" in pixels. Throws InputError unless both are from 16 to 4096.
PictureSize parsed_size(const std::string& text);

/// Parses view names separated by commas. Throws InputError for an unknown, repeated or missing one.
std::vector<std::string> parsed_views(const std::string& text);

/// The label of one angle without zero padding: "-5".
std::string plain_label(double angle_rad);

/// Reports, as options, the angles of `wanted` that the motion does not have at `pose`, the nearest one.
/// `used`: "drawn", "sent".
void report_clamped(const store::Motion& motion, const store::JointPose& pose, const Attitude& wanted,
                    const char* used, std::ostream& messages);

/// Formats the angle with the decimals (at most three) that it and `others_deg` need, zero-padded: "005",
/// "-05", "007.5".
std::string angle_label(double angle_deg, const std::vector<double>& others_deg);

}  // namespace vrda::view
