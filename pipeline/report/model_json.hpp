/// One motion model as the data of the report's page: JSON with rounded numbers, mm and degrees, null where a
/// cell has no value.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <vector>

#include "model/mesh.hpp"
#include "report/report.hpp"
#include "store/motion_model.hpp"

namespace vrda::report {

using Json = nlohmann::ordered_json;

/// Rounded to 1e-6 of the unit, more than the page shows; reduces the file to a third. Null if not finite.
Json short_number(double value);
Json short_numbers(const std::vector<double>& values);
/// One row per flexion with the values over varus.
Json short_grid(const store::GridD& grid);
/// Rows of `width` numbers.
Json short_rows(const std::vector<double>& values, std::size_t width);

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

/// Contact points of each compartment on both bodies over flexion, with the bodies' outlines; null without
/// compartments. From the zero-varus motion if present, else from the spine cells.
Json contact_paths_json(const store::MotionModel& model);

/// Finite helical axes and instant centres from the rotation centre, rolling and sliding between flexions;
/// null before `vrda reduce`.
Json axes_json(const store::MotionModel& model);

/// Force along Delta by compartment over flexion, N; null for the stability search.
Json forces_json(const store::MotionModel& model);

/// By bundle over flexion: largest fibre strain and total tension; null without fibres.
Json fibres_json(const store::MotionModel& model);

/// Role of each joint coordinate, the load that holds it (N mm or N) and the number of solved flexions at
/// which it is determined, along the spine; null unless the job gives roles.
Json coordinates_json(const store::MotionModel& model);

/// The measured and the repaired motion over the frames: gap, overlap, six coordinates; null unless repaired.
Json repair_json(const store::MotionModel& model);

/// By quantity over flexion: quantiles of the samples of an uncertain job, and the largest shares of the
/// spread; null without samples.
Json uncertainty_json(const store::MotionModel& model);

/// Spine data of the equilibrium: internal rotation under an extra moment, distinct equilibria; else null.
Json spine_json(const store::MotionModel& model);

/// The page's data of one model. With `is_whole` false only those for a comparison of models: header,
/// numbers, warnings, curves, provenance, spine.
struct ModelJsonOptions {
  bool is_whole = true;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< whose translations the curves have, canonical
};
Json model_json(const ReportModel& entry, const ModelJsonOptions& options);

/// A curve over flexion with the page's keys.
Json curve_json(const ClinicalCurve& curve);

}  // namespace vrda::report
