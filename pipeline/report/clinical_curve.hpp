/// Clinical numbers over flexion of a motion model or of a file (measured or published), for comparison.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/frames.hpp"
#include "store/motion_model.hpp"

namespace vrda::report {

/// Quantities of a curve. Angles in degrees, translations in mm; internal rotation, varus (adduction),
/// anterior, proximal and lateral are positive, on both sides.
enum class Quantity {
  internal,
  varus,
  anterior,  ///< Grood-Suntay axes, a named point, usually the rotation centre; like the next two
  proximal,
  lateral,
  origin_anterior,  ///< femoral axes, origin of the moving meshes; like the next two
  origin_proximal,
  origin_lateral,
};
inline constexpr std::size_t n_quantities = 8;

struct QuantityName {
  Quantity quantity;
  const char* key;   ///< in the page's data
  const char* name;  ///< for display
  const char* unit;
  const char* column;  ///< of a curve file
};
inline constexpr QuantityName quantity_names[n_quantities] = {
    {Quantity::internal, "internal", "internal rotation", "degrees", "internal_deg"},
    {Quantity::varus, "varus", "varus", "degrees", "varus_deg"},
    {Quantity::anterior, "anterior", "anterior", "mm", "anterior_mm"},
    {Quantity::proximal, "proximal", "proximal", "mm", "proximal_mm"},
    {Quantity::lateral, "lateral", "lateral", "mm", "lateral_mm"},
    {Quantity::origin_anterior, "origin_anterior", "anterior, mesh origin", "mm", "ant_mm"},
    {Quantity::origin_proximal, "origin_proximal", "proximal, mesh origin", "mm", "prox_mm"},
    {Quantity::origin_lateral, "origin_lateral", "lateral, mesh origin", "mm", "lat_mm"},
};

struct ClinicalCurve {
  std::string name;  ///< "raw", "zero_varus", "degree_6", ... or the file's
  /// [n] in source order; of the joint, or of the grid where there is no pose; of a sequence the frames' keys
  std::vector<double> flexion_deg;
  std::array<std::vector<double>, n_quantities> values;  ///< [n]; empty: unknown; NaN: no value

  const std::vector<double>& values_of(Quantity quantity) const
  {
    return values[static_cast<std::size_t>(quantity)];
  }
  std::vector<double>& values_of(Quantity quantity) { return values[static_cast<std::size_t>(quantity)]; }
};

/// The curves of a model at the flexions of its grid: "zero_varus" if reduced, each smoothed set at that
/// varus (else at the balanced varus), and "raw", the spine cells. The translations are those of the moving
/// point at `point_mm` (canonical), usually the rotation centre.
std::vector<ClinicalCurve> clinical_curves(const store::MotionModel& model, const Eigen::Vector3d& point_mm);

/// The point of the translations where `model` is compared with `first`: the rotation centre of `first` if
/// both have the same meshes, so that one knee solved twice is compared by one point; else the model's own.
Eigen::Vector3d comparison_point_mm(const store::MotionModel& first, const store::MotionModel& model);

/// Difference of `curve` and `other` at the flexions of `other` within the range of `curve`, which is linear
/// between its points.
struct CurveDifference {
  std::size_t n = 0;  ///< number of compared points; if 0 the rest is NaN
  double rms = 0.0;
  double largest = 0.0;         ///< absolute
  double mean = 0.0;            ///< of curve - other
  double rms_about_mean = 0.0;  ///< rms after subtracting the mean
};
CurveDifference difference(const ClinicalCurve& curve, const ClinicalCurve& other, Quantity quantity);

/// A measured or published curve: a CSV file of clinical numbers over flexion.
struct CurveFile {
  ClinicalCurve curve;                      ///< named like the file, without folder and extension
  std::optional<Eigen::Vector3d> point_mm;  ///< of the translations, canonical; if the file names it
  bool is_incomplete = false;  ///< its translations cannot be those of another point: a number is missing
  std::vector<std::string> comments;  ///< its comments, without the '#'
};

/// Reads a header of column names, then rows; lines starting with '#' are comments. Needs flexion_deg and at
/// least one of internal_deg, varus_deg, anterior_mm, proximal_mm, lateral_mm (Grood-Suntay, of the moving
/// point at the rotation centre), ant_mm, prox_mm, lat_mm (of the tibial origin along the femoral axes);
/// degrees and mm; the tibia in the femur's frame; internal, adduction, anterior, proximal, lateral positive.
/// An empty field is a missing value. Ignores known other columns (frame, time_s, T11 to T34,
/// femur_rel_tibia_..._mm, and those of vrda export). Throws InputError for any other column, a row of wrong
/// length and an invalid number.
CurveFile read_curve_file(const std::string& file);

/// As read_curve_file, from text; `file` gives the name and appears in errors.
CurveFile curve_from_text(const std::string& file, std::string_view text);

/// The file with the Grood-Suntay translations of the moving point at `point_mm` (canonical), from those of
/// the mesh origin or of the point that the file names, by the three angles. `is_incomplete` is set, and
/// nothing changed, where a column that this needs is missing. Unnamed points are taken for `point_mm`.
CurveFile about_point(CurveFile file, Side side, const Eigen::Vector3d& point_mm);

}  // namespace vrda::report
