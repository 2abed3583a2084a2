/// The keyword configuration of thesis appendix B as plain settings. schemas/legacy-formats.md lists the
/// keywords and which names are not from the thesis.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "job/text_lines.hpp"

namespace vrda::job {

/// Angles in degrees, ends included; a single angle if the ends are equal.
struct AngleRange {
  double from_deg = 0.0;
  double to_deg = 0.0;
  double step_deg = 1.0;
};

/// An additional view of the scene, in the axes of the files.
struct ConfiguredView {
  Eigen::Vector3d shift_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d orientation_deg{0.0, 0.0, 0.0};  ///< about fixed X, Y and Z, in that order
};

/// Vectors are in the axes of the files. Omitted settings have the defaults of the thesis. Angles are in
/// degrees, as in a job file.
struct KeywordConfiguration {
  std::vector<std::string> reference;          ///< models of body 0, at least one
  std::vector<std::string> moving;             ///< models of body 1, at least one
  Eigen::Vector3d position_mm{0.0, 0.0, 0.0};  ///< of the origin of the moving body
  Eigen::Vector3d motion_mm{0.0, 5.0, 0.0};    ///< one step of the approach
  double turn_deg = 0.0;                       ///< rotation of the moving body about the motion, right-handed
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

/// `unit_mm`: the length unit of the text in mm; the thesis uses metres.
/// Throws InputError with file and line for unknown and duplicate keywords, missing values, values out of
/// range, a missing model, and an orientation that a job cannot express.
KeywordConfiguration parse_configuration(const NamedText& source, double unit_mm = 1000.0);

/// Reads a configuration file. Throws InputError if it is missing or larger than 1 MiB.
NamedText read_configuration(const std::string& file);

}  // namespace vrda::job
