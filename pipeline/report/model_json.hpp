/// One motion model as the data of the report's page: JSON in mm and degrees, NaN or null where a cell has no
/// value.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <vector>

#include "model/mesh.hpp"
#include "report/report.hpp"
#include "store/motion_model.hpp"

namespace vrda::report {

using Json = nlohmann::ordered_json;

/// Options of projected_outline().
struct OutlineOptions {
  double from_mm = 0.0;  ///< range of height (canonical Y) of the corners of included triangles
  double to_mm = 0.0;
  int n_directions = 240;  ///< points of the outline
};

/// Closed star-shaped outline (X, Z, mm; canonical) of the mesh near the joint, projected along Y, as
/// background of contact paths: in each direction from the centre of its bounding box the farthest crossing
/// with an edge. Empty if no triangle is included; directions without a crossing are omitted.
std::vector<Eigen::Vector2d> projected_outline(const Mesh& mesh, const OutlineOptions& options);

/// The page's data of one model, with exact numbers. With `is_whole` false only those for a comparison of
/// models: header, numbers, warnings, curves, provenance, spine.
struct ModelJsonOptions {
  bool is_whole = true;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< whose translations the curves have, canonical
};
Json model_json(const ReportModel& entry, const ModelJsonOptions& options);

/// The data as text with all numbers rounded to 1e-6 of the unit, more than the page shows, which reduces it
/// to a third; null where they are not finite.
std::string data_text(Json data);

/// A page with that title and data_text() of one of the kinds of page/main.js.
std::string page_of(const std::string& title, Json data);

/// Contact of both compartments in a motion; null without compartments.
Json two_sided_json(const store::TwoSidedFigures& figures);

/// A curve over flexion with the page's keys.
Json curve_json(const ClinicalCurve& curve);

}  // namespace vrda::report
