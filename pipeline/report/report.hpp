/// The input data of a report (one or more motion models with their comparison of degrees and images), its
/// warnings, and the page: one HTML file without references to others. Lengths are in mm, angles on the page
/// in degrees.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/compare.hpp"
#include "analysis/flexion_curves.hpp"
#include "report/clinical_curve.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"

namespace vrda::report {

/// The largest gap and penetration of the raw motion at the attitudes of the grid.
struct RawExtremes {
  std::int64_t n_overlapping = 0;
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;  ///< infinite if a cell has no contact ahead
};

/// An image of the joint.
struct RenderedImage {
  std::string view;   ///< "front", ...
  std::string label;  ///< "flexion 030"
  std::string png;    ///< the file's bytes
};

struct RenderedImages {
  std::vector<RenderedImage> images;
  std::string note;  ///< reason for missing images; else empty
};

struct ReportModel {
  std::string name;  ///< file name without folder and extension; unique in a report
  store::MotionModel model;
  RawExtremes raw;
  std::optional<analysis::Comparison> comparison;    ///< of smoothing degrees
  std::vector<analysis::CurveGroup> flexion_curves;  ///< along the spine, a value for each flexion
  RenderedImages images;
};

struct Report {
  std::string program;  ///< "vrda 0.1.0"
  std::vector<ReportModel> models;
  std::vector<CurveFile> against;
};

/// Summary of a motion model. NaN: unknown or not applicable.
struct MotionSummary {
  std::int64_t n_cells = 0, n_stable = 0;
  double theta_undetermined_share = 0.0;  ///< of the stable cells
  store::CurveFigures rotation;           ///< internal rotation along the spine
  store::SpineJump spine_jump;
  std::int64_t n_several_optima = 0;       ///< number of flexions; equilibrium only
  double largest_optima_spread_deg = 0.0;  ///< of theta between them
  double balance_residual_n = 0.0;         ///< largest
  double worst_gap_mm = 0.0;               ///< smallest
  double push_n = 0.0;                     ///< largest force of the push
  double largest_strain = 0.0;
  double largest_tension_n = 0.0;
};
MotionSummary motion_summary(const store::MotionModel& model);

/// One line per warning, most severe first.
std::vector<std::string> warnings_of(const ReportModel& entry);

/// The page's data as JSON: a single model completely, of several models what a comparison needs.
std::string report_json(const Report& report);

/// The complete page with style, plotting library, code and data. A Content-Security-Policy denies all
/// network access. Text of the models is never interpreted as HTML.
std::string report_page(const Report& report);

/// Files embedded in the program: page/ of this room and uPlot.
std::string_view
page_template();  ///< HTML with placeholders {{title}}, {{plot_style}}, {{style}}, {{plot_licence}},
                  ///< {{code}}, {{data}}
std::string_view page_style();    ///< CSS
std::string_view page_code();     ///< JavaScript, with uPlot
std::string_view plot_style();    ///< CSS of uPlot
std::string_view plot_licence();  ///< text of uPlot's licence

}  // namespace vrda::report
