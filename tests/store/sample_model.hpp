/// Valid samples computed by formulas, the exact comparison of models, and the tables of the pages in
/// schemas/.
#pragma once

#include <cstdint>
#include <string>

#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"
#include "store/trace.hpp"

namespace vrda::test {

struct SampleOptions {
  std::int32_t n_flexion = 4;
  std::int32_t n_varus = 3;
  bool has_compartments = true;
  bool has_visual = true;
  bool has_failed_cell = true;  ///< cell (1, 2) ended as no_clearance
  bool is_equilibrium = false;  ///< method equilibrium, with a Delta that rotates over flexion
  std::int32_t n_fibres = 0;    ///< 0: no ligaments
  std::int32_t n_wraps = 0;     ///< only with fibres
  bool has_frames = false;      ///< a sequence of frames: flexion rises and falls; n_varus is 1
};

/// Balls for bodies, two contacts per solved cell, one smoothed set of degree 1. As an equilibrium, a medial
/// and a lateral force in every solved cell with an even index, none in the others.
store::MotionModel sample_model(const SampleOptions& options = {});

/// Three cases: each kind of column, a missing value, a text that needs quotes.
store::IndexTable sample_index();

/// A failure for each member that differs; NaN equals NaN.
void expect_equal(const store::MotionModel& a, const store::MotionModel& b);
void expect_equal(const store::Trace& a, const store::Trace& b);

/// `model` with a robust set and its recontact, a zero-varus motion and audits of all of them. The
/// zero-varus motion has a pose wherever the first column is solved: at even flexions both compartments
/// are in contact, at odd ones the varus is interpolated (free everywhere, with a fifth smoothed surface, if
/// the model has one column); the first interval's rotation is too small for an axis. The audits have every
/// state.
store::MotionModel with_derived(store::MotionModel model);

/// A model with every dataset except the fifth smoothed surface: an equilibrium with five fibres and two
/// wraps, scaled by landmarks, with derived data.
store::MotionModel whole_model();

/// A sequence of frames with its audit.
store::MotionModel frames_model();

/// `page` with each table after a line `<!-- table GROUP -->` generated from the registry's rows below GROUP,
/// of the motion model or (`is_trace`) the trace.
std::string with_tables(const std::string& page, bool is_trace);

}  // namespace vrda::test
