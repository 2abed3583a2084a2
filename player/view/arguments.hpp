/// Values of the command line.
#pragma once

#include <string>
#include <vector>

#include "store/motion_model.hpp"

namespace vrda {

struct AngleRange {
  double first_deg = 0.0;
  double last_deg = 0.0;
  double step_deg = 1.0;
};

/// The parts between separators, empty ones too; at least one.
std::vector<std::string> split(const std::string& text, char separator);

/// Throws InputError of an option.
[[noreturn]] void refuse_option(const char* option, const std::string& found, const std::string& wanted);

/// "A:B:STEP" or one angle "A", in degrees. Throws InputError on anything else, a reversed range, a step
/// below 0.001, or more than 10,000 angles.
AngleRange parsed_angles(const std::string& option, const std::string& text);

/// Throws InputError unless it is a number from -360 to 360.
void require_angle(const std::string& option, double angle_deg);

/// first, first + step, ... up to last (within a millionth of a step).
std::vector<double> angles_deg(const AngleRange& range);

struct PictureSize {
  int width = 1280;
  int height = 960;
};

/// "WxH" in pixels. Throws InputError unless both lie within 16 and 4096.
PictureSize parsed_size(const std::string& text);

/// Names separated by commas. Throws InputError on an unknown, repeated or missing one.
std::vector<std::string> parsed_views(const std::string& text);

/// `wanted`, which must be one of the model's sets; of an empty one what to show first. Throws InputError
/// naming `file` and --set.
std::string chosen_set(const MotionModel& model, const std::string& file, const std::string& wanted);

/// The angle with the fewest decimals (at most three) that `others` need too, padded to three whole digits:
/// "005", "-05", "007.5".
std::string angle_label(double angle_deg, const std::vector<double>& others_deg);

}  // namespace vrda
