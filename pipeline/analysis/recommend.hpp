/// Recommends the lowest degree that predicts left-out attitudes as well as the best one, stays in contact
/// and is smooth; or none, with the reason.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/raw_motion.hpp"
#include "analysis/leave_out.hpp"
#include "store/derived.hpp"

namespace vrda::analysis {

/// Why a degree, or every degree, does not meet the criteria. Lengths are visible above perceptible_mm.
enum class Fault {
  none,
  not_measurable,  ///< a block of attitudes cannot be left out
  unpredicted,     ///< predicts less than half of the raw motion's variance, with a visible error
  jump,            ///< the raw motion jumps (raw_motion.hpp), so no polynomial follows it
  no_contact,      ///< no pose in contact at some flexion or attitude that another degree has
  overlap,         ///< visible after it was moved into contact, of any side
  gap,             ///< the same
  rough,           ///< a second difference over one degree of flexion is visible
};
const char* name_of(Fault fault);

/// A degree's motion after it was moved into contact: two-sided, or along Delta without compartments.
struct ContactFigures {
  int n_poses = 0;
  int n_lifted_off = 0;  ///< flexions at which a side is lifted off as in the raw motion; its gap is omitted
  double largest_gap_mm = 0.0, largest_overlap_mm = 0.0;  ///< of any side
  std::optional<store::TwoSidedFigures> sides;            ///< only with compartments
};

/// What is known of one degree; errors in units of the perceptible error.
struct DegreeEvidence {
  int degree = 0;
  /// [n_cells] squared errors of fits without the cell's block, the same cells in the same order for every
  /// degree; empty if a block cannot be omitted.
  std::vector<double> left_out_sq;
  double second_difference = 0.0;                        ///< RMS over one degree of flexion
  std::optional<ContactFigures> contact = std::nullopt;  ///< if measured
};

/// What is known of the raw motion.
struct RawEvidence {
  std::vector<std::int32_t> block;  ///< [n_cells] number of each cell's block
  analysis::BlockSize block_size;
  double variance = 0.0;  ///< raw_variance()
  RawJump jump;
};

/// One degree compared with the best.
struct RankedDegree {
  int degree = 0;
  double error = 0.0;           ///< root mean square; NaN if not measurable, like the next two
  double excess_sq = 0.0;       ///< mean over the cells of squared error minus that of the best
  double standard_error = 0.0;  ///< of excess_sq, paired: from the spread of the differences per block
  bool is_within = false;       ///< excess_sq <= 2 standard_error
  Fault fault = Fault::none;
  std::string fault_reason;  ///< the fault with its figures, a part of a sentence; empty without a fault
};

struct Recommendation {
  int degree = -1;               ///< -1: none meets the criteria
  Fault fault = Fault::none;     ///< why none meets the criteria: that of the best degree, or `jump`
  int best_degree = -1;          ///< smallest error, of the degrees without a fault if there is one
  std::string reason;            ///< one sentence
  analysis::BlockSize block_size;  ///< attitudes left out together
  std::vector<RankedDegree> ranked;
};

/// Recommends the lowest degree without a fault within two paired standard errors of the best of them. Errors
/// of a cell below 1e-6 count as 1e-6: they are rounding, and their order is chance. Expects ascending
/// degrees.
Recommendation recommend(const std::vector<DegreeEvidence>& degrees, const RawEvidence& raw);

/// [n_fits] The error of each cell's pose, for DegreeEvidence; compare/compare.hpp has the rules. `left_out`
/// are the errors of each fit's surfaces (leave_one_out, or leave_blocks_out). Cells are those fitted in
/// translation, in grid order. Robust if the fits are. `fits` are of one model by ascending degree.
std::vector<std::vector<double>> left_out_errors(const std::vector<analysis::SmoothFit>& fits,
                                                 const std::vector<std::vector<store::GridD>>& left_out);

}  // namespace vrda::analysis
