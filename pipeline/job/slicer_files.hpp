/// Files of 3D Slicer: the space of its meshes, and points (schemas/slicer.md).
#pragma once

#include <Eigen/Core>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "job/job.hpp"

namespace vrda::job {

/// "LPS" or "RAS", as the header of a mesh file (STL, PLY, OBJ) says by SPACE=; empty: it does not. Throws
/// InputError for another space.
std::string scan_space(const std::string& file, std::string_view bytes);

/// A mesh or a list of points with its space.
using FileSpace = std::pair<std::string, std::string>;
/// The space of the files that have one. Throws InputError for the first that differs from one before it.
std::string common_space(const std::vector<FileSpace>& files);
/// The same of the meshes that one frame of a job describes.
void require_one_space(const Job& job, const std::string& data_directory);

struct LabelledPoint {
  std::string label;
  Eigen::Vector3d p_mm;
};

struct SlicerPoints {
  std::string space;  ///< LPS or RAS
  std::vector<LabelledPoint> points;
};

/// By the name: .mrk.json or .fcsv.
bool is_slicer_points(const std::string& file);

/// The points of all markups of a file that are set. Throws InputError for damaged text, another space or
/// unit, a label twice, and no points.
SlicerPoints read_slicer_points(const std::string& file, const std::string& text);

/// The points in another space: X and Y are negated. An empty space is any.
SlicerPoints in_space(SlicerPoints points, const std::string& space);

/// A markups file (.mrk.json): a list of points, or of lines with two points each.
struct Markup {
  std::string name;
  bool is_line = false;
  std::vector<LabelledPoint> points;
};
std::string markups_text(const std::vector<Markup>& markups, const std::string& space);

}  // namespace vrda::job
