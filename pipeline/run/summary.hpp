/// What cases and motion models say in short, and what commands begin with.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "load/case.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// "scaled by 1.07 from the unscaled joint: uniform scaling keeps contact, the steps are shared", or that it
/// is a new run, and why. Empty without [scaling].
std::string scaling_line(const Case& job_case);

/// Null without scaling; landmarks are an empty list where the job gives the factor.
nlohmann::ordered_json scaling_json(const std::optional<Scaling>& scaling);

/// Prints scaling_json(): the factor, how well it is known, and a line a pair of landmarks. Nothing of null.
void print_scaling(const nlohmann::ordered_json& scaling);

/// Cells by the name of their status; every status that occurs.
std::map<std::string, int> cells_by_status(const MotionModel& model);

/// Share of cells that are not stable.
double unsolved_fraction(const MotionModel& model);

/// "1911 attitudes: 1900 stable, 11 no_contact".
std::string status_line(const MotionModel& model);

/// Stable cells of which something is found against the pose, in attitude order.
struct DoubtfulCell {
  double flexion_deg = 0.0, varus_deg = 0.0;
  Plausibility plausibility = Plausibility::nothing_found;
};
std::vector<DoubtfulCell> doubtful_cells(const MotionModel& model);

/// "2 nothing_ahead, 1 unstable_balance"; empty without any.
std::string plausibility_line(const MotionModel& model);

/// load_case(), with its warnings said, and how it is scaled.
Case announced_case(const std::string& job_file, const LoadOptions& options);

/// Reads a motion model with at least one stable attitude. Throws InputError of a file that is none, is
/// damaged or newer than this version, and of one whose every attitude failed or is pending.
MotionModel read_solved_model(const std::string& file);

/// `asked`, or one a processor where that is 0.
int threads_or_all(int asked);

}  // namespace vrda
