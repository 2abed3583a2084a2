/// One motion model as the page's data.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/mesh.hpp"
#include "report/report.hpp"
#include "store/grid.hpp"
#include "store/motion_model.hpp"

namespace vrda {

using Json = nlohmann::ordered_json;

/// Rounded to 1e-6 of the unit: a page shows fewer digits, and the file is a third as long.
Json short_number(double value);
Json short_numbers(const std::vector<double>& values);
/// Rows of flexion, each with the values over varus.
Json short_grid(const GridD& grid);
/// Rows of `width` numbers.
Json short_rows(const std::vector<double>& values, std::size_t width);

/// The rim of a body near the joint, seen along its long axis, to draw contact paths in.
struct OutlineOptions {
  double from_mm = 0.0;  ///< heights (canonical Y) of the triangles that count, by their corners
  double to_mm = 0.0;
  int n_directions = 240;  ///< points of the outline
};

/// Closed star-shaped outline (X, Z, mm; canonical) of the mesh's projection on the plane across Y: in each
/// direction from the middle of its bounding box the farthest crossing with an edge. Empty when no triangle
/// counts; directions without a crossing are left out.
std::vector<Eigen::Vector2d> outline(const Mesh& mesh, const OutlineOptions& options);

/// Points of each compartment on both bodies over flexion and the bodies' outlines; null without
/// compartments. Of the zero-varus motion where it is there, else of the spine's cells.
Json contact_paths_json(const MotionModel& model);

/// Finite helical axes, instant centres, rolling and sliding between flexions; null before `vrda reduce`.
Json axes_json(const MotionModel& model);

/// Force along Delta by compartment over flexion, N; null by the stability search.
Json forces_json(const MotionModel& model);

/// By bundle over flexion: strain of the fibre strained most, tension of all together; null without fibres.
Json fibres_json(const MotionModel& model);

/// What only the equilibrium's spine knows: internal rotation under an extra moment, places of rest; else
/// null.
Json spine_json(const MotionModel& model);

/// Everything the page shows of one model. With `is_whole` false only what a comparison of several needs:
/// head, numbers, warnings, curves, provenance.
struct ModelJsonOptions {
  bool is_whole = true;
};
Json model_json(const ReportModel& entry, const ModelJsonOptions& options = {});

/// The curves over flexion alone, as the page knows them.
Json curve_json(const ClinicalCurve& curve);

}  // namespace vrda
