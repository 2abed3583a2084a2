/// Clinical numbers over flexion, of a motion model, of a file or from the literature, ready to be laid over
/// one another.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "store/motion_model.hpp"

namespace vrda {

/// What a curve may tell at each flexion. Angles in degrees, translations in mm; internal rotation, varus
/// (adduction), anterior, proximal and lateral are positive, on both sides.
enum class Quantity {
  internal,
  varus,
  anterior,  ///< Grood-Suntay axes, of the point at the rotation centre (core/clinical.hpp); like the next
             ///< two
  proximal,
  lateral,
  origin_anterior,  ///< femoral axes, of the origin of the moving meshes; like the next two
  origin_proximal,
  origin_lateral,
};
inline constexpr std::size_t n_quantities = 8;

struct QuantityName {
  Quantity quantity;
  const char* key;   ///< in the page's data
  const char* name;  ///< for people
  const char* unit;
};
inline constexpr QuantityName quantity_names[n_quantities] = {
    {Quantity::internal, "internal", "internal rotation", "degrees"},
    {Quantity::varus, "varus", "varus", "degrees"},
    {Quantity::anterior, "anterior", "anterior", "mm"},
    {Quantity::proximal, "proximal", "proximal", "mm"},
    {Quantity::lateral, "lateral", "lateral", "mm"},
    {Quantity::origin_anterior, "origin_anterior", "anterior, mesh origin", "mm"},
    {Quantity::origin_proximal, "origin_proximal", "proximal, mesh origin", "mm"},
    {Quantity::origin_lateral, "origin_lateral", "lateral, mesh origin", "mm"},
};

struct ClinicalCurve {
  std::string name;                 ///< "raw", "zero_varus", "degree_6", ... or of a file
  std::vector<double> flexion_deg;  ///< [n] in the order of its source
  std::array<std::vector<double>, n_quantities> values;  ///< [n] or empty: not known. NaN: no answer there

  const std::vector<double>& of(Quantity quantity) const
  {
    return values[static_cast<std::size_t>(quantity)];
  }
  std::vector<double>& of(Quantity quantity) { return values[static_cast<std::size_t>(quantity)]; }
};

/// The cell of each flexion that the sweep's spine runs through, -1 where it has none or it is not stable.
std::vector<Eigen::Index> solved_spine(const MotionModel& model);

/// The curves of a model, one value a flexion of its grid: "zero_varus" where it was reduced, each smoothed
/// set at the varus of that (else where the compartments balance), and "raw", the spine's cells.
std::vector<ClinicalCurve> clinical_curves(const MotionModel& model);

/// Difference of `curve` and `other` at the flexions of `other` that lie within those of `curve`, which is
/// linear between its points.
struct CurveDifference {
  std::size_t n = 0;  ///< points compared; 0: nothing to compare, the rest is NaN
  double rms = 0.0;
  double largest = 0.0;         ///< absolute
  double mean = 0.0;            ///< of curve - other
  double rms_about_mean = 0.0;  ///< what is left of rms when the offset is taken out
};
CurveDifference difference(const ClinicalCurve& curve, const ClinicalCurve& other, Quantity quantity);

/// Curves from the literature: CSV files of clinical numbers over flexion.
struct CurveFile {
  ClinicalCurve curve;             ///< named like the file, without folder and ending
  std::vector<std::string> notes;  ///< its comments, without the '#'
};

/// A header of column names, then rows; lines that begin with '#' are comments. flexion_deg and at least one
/// of internal_deg, varus_deg, ant_mm, prox_mm, lat_mm (degrees and mm; the tibia in the femur's frame,
/// translations of the tibial origin along the femoral axes; internal, adduction, anterior, proximal, lateral
/// positive). An empty field is no answer. Columns known to mean something else (frame, time_s, T11 to T34,
/// femur_rel_tibia_..._mm, and what else vrda export writes) are passed over. Throws InputError for any other
/// column, a row that is too short or long, and what is no number.
CurveFile read_curve_file(const std::string& file);

/// The same of text; `file` is for the name and for errors.
CurveFile curve_from_text(const std::string& file, std::string_view text);

}  // namespace vrda
