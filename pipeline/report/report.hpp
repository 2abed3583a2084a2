/// What a report is made of.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/compare.hpp"
#include "report/curve_file.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// The largest gap and penetration of the raw motion at the attitudes of the grid.
struct RawExtremes {
  std::int64_t n_overlapping = 0;
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;  ///< infinite when nothing is in the way of some cell
};

/// A picture of the joint.
struct Still {
  std::string view;   ///< "front", ...
  std::string label;  ///< "flexion 030"
  std::string png;    ///< the file's bytes
};

struct Stills {
  std::vector<Still> stills;
  std::string note;  ///< why there are none, or what is missing; else empty
};

struct ReportModel {
  std::string name;  ///< the file's, without folder and ending; unique in a report
  MotionModel model;
  RawExtremes raw;
  std::optional<Comparison> comparison;  ///< of smoothing degrees
  Stills stills;
};

struct Report {
  std::string program;  ///< "vrda 0.1.0"
  std::vector<ReportModel> models;
  std::vector<CurveFile> against;
};

}  // namespace vrda
