/// The parts of the procedure: which a bench has, and what each rests on.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "setup/calibration.hpp"

namespace vrda {

/// In the order of doing them.
std::vector<CalibrationPart> parts_of(const BenchFile& bench);

/// Those whose results it uses, of the ones that the bench has.
std::vector<CalibrationPart> rests_on(CalibrationPart part, const BenchFile& bench);

/// Solved, and nothing that it rests on was done again since.
bool is_done(const Calibration& calibration, CalibrationPart part);

/// All that rest on `part`, and on those, are to be done again.
void outdate_after(Calibration& calibration, CalibrationPart part, const BenchFile& bench);

/// Parts named by a step of the command line; see guide/session.hpp.
std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench);

/// Throws InputError naming the bench file's key when it lacks what the part wants.
void require_wanted(CalibrationPart part, const BenchFile& bench);

/// Their names, "rails, stop".
std::string names_of(std::span<const CalibrationPart> parts);

/// leg, femur or tibia
bool is_model_part(CalibrationPart part);
/// Whose body's model a part places.
BodyRole role_of(CalibrationPart part);
/// The points that it touches.
const std::vector<CalibrationPoint>& points_of(CalibrationPart part, const CalibrationSettings& settings);

/// The stage's encoder is read.
bool has_stage(const BenchFile& bench);

}  // namespace vrda
