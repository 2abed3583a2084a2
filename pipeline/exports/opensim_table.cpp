#include "exports/opensim_table.hpp"

#include "core/number_text.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

/// The first line of the header: one line that is not taken for a key or for the header's end.
std::string name_line(const FlexionMotion& motion)
{
  std::string line = "vrda: ";
  for (const char c : motion.title) {
    const bool is_plain = static_cast<unsigned char>(c) >= 0x20 && c != '=' && c != 0x7f;
    line += is_plain ? c : ' ';
  }
  for (std::size_t at = line.find("endheader"); at != std::string::npos; at = line.find("endheader")) {
    line.insert(at + 3, 1, ' ');
  }
  return line + ", " + motion.set + "\n";
}

std::string header(const FlexionMotion& motion, const OpenSimOptions& options)
{
  std::string text = name_line(motion);
  text += "version=1\n";
  text += "nRows=" + std::to_string(motion.frames.size()) + "\n";
  text += "nColumns=" + std::to_string(1 + options.columns.size()) + "\n";
  text += std::string("inDegrees=") + (options.in_degrees ? "yes" : "no") + "\n\n";
  text += "Units are S.I. units (second, meters, Newtons, ...)\n";
  text += "Flexion grows by " + shortest(options.degrees_per_second) + " degrees a second.\n\n";
  text += "endheader\ntime";
  for (const std::string& column : options.columns) text += "\t" + column;
  return text + "\n";
}

std::array<double, 6> numbers_of(const FlexionFrame& frame, bool in_degrees)
{
  const Clinical& c = frame.clinical;
  const Eigen::Vector3d t_m = frame.pose.X_reference_moving.translation() * metres_per_mm;
  std::array<double, 6> numbers{c.flexion_rad, c.varus_rad, c.internal_rotation_rad,
                                t_m.x(),       t_m.y(),     t_m.z()};
  for (std::size_t k = 0; in_degrees && k < 3; ++k) numbers[k] = deg_from_rad(numbers[k]);
  return numbers;
}

}  // namespace

std::array<std::string, 6> opensim_columns(Side side)
{
  std::array<std::string, 6> columns{"knee_flex", "knee_add", "knee_rot", "knee_tx", "knee_ty", "knee_tz"};
  for (std::string& column : columns) column += side == Side::left ? "_l" : "_r";
  return columns;
}

std::string opensim_table(const FlexionMotion& motion, const OpenSimOptions& options)
{
  std::string text = header(motion, options);
  for (const FlexionFrame& frame : motion.frames) {
    text += shortest(time_s(motion, frame, options.degrees_per_second));
    for (const double number : numbers_of(frame, options.in_degrees)) text += "\t" + shortest(number);
    text += "\n";
  }
  return text;
}

}  // namespace vrda
