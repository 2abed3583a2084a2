/// Curves from the literature: CSV files of clinical numbers over flexion.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/clinical_curve.hpp"

namespace vrda {

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
