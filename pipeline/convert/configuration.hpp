/// The keyword configuration of thesis appendix B as plain settings. schemas/legacy-formats.md lists the
/// keywords, and which names are ours because the page lost them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "convert/text_lines.hpp"

namespace vrda {

/// Degrees, both ends included; one angle when they are equal.
struct AngleRange {
  double from_deg = 0.0;
  double to_deg = 0.0;
  double step_deg = 1.0;
};

/// One more view of the scene, in the files' axes.
struct ConfiguredView {
  Eigen::Vector3d shift_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d orientation_deg{0.0, 0.0, 0.0};  ///< about fixed X, Y and Z, in that order
};

/// Vectors are in the files' axes; what the text leaves out has the thesis's default. Angles stay degrees,
/// since all of this goes into a job file.
struct Configuration {
  std::vector<std::string> reference;          ///< models of body 0, at least one
  std::vector<std::string> moving;             ///< models of body 1, at least one
  Eigen::Vector3d position_mm{0.0, 0.0, 0.0};  ///< of the moving body's origin
  Eigen::Vector3d motion_mm{0.0, 5.0, 0.0};    ///< one step of the approach
  double turn_deg = 0.0;                       ///< of the moving body about the motion, right-handed
  double contact_resolution_mm = 0.1;
  double modelling_step_mm = 1.0;
  double orientation_resolution_deg = 0.1;
  double orientation_step_deg = 1.0;
  AngleRange flexion;
  AngleRange varus;
  std::map<int, ConfiguredView> views;  ///< by number
  std::optional<std::array<int, 2>> display_px;
  std::optional<double> zoom;
  std::string render;  ///< "fill", "wire" or empty
};

/// `unit_mm`: the unit of every length in the text, in mm; metres in the thesis.
/// Throws InputError naming file and line: an unknown keyword, one without its values, one given twice,
/// values out of range, a model missing, an orientation that a job cannot carry.
Configuration parse_configuration(const NamedText& source, double unit_mm = 1000.0);

/// Throws InputError for a file that is missing or too large to be a configuration.
NamedText read_configuration(const std::string& file);

}  // namespace vrda
