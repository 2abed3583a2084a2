/// Short summaries of cases and motion models, and how commands load them.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {

/// One line about the scaling: that the steps are shared, or why it is a new run. Empty without [scaling].
std::string scaling_line(const job::Case& job_case);

/// Null without scaling; landmarks are an empty list if the job gives the factor.
nlohmann::ordered_json scaling_json(const std::optional<Scaling>& scaling);

/// Prints scaling_json(): the factor, its standard error, and one line per pair of landmarks. Nothing for
/// null.
void print_scaling(const nlohmann::ordered_json& scaling);

/// Number of cells of each status that occurs, by name.
std::map<std::string, int> cells_by_status(const store::MotionModel& model);

/// A contact at a border so far in flexion past the first one of its column has left the surface that the
/// mesh has: the pose is not usable. A mesh's edge is first touched by a few mm of its rim, and 10 degrees of
/// flexion move the contact of a knee by 3 to 5 mm.
inline constexpr double border_margin_deg = 10.0;

/// Stable cells with Plausibility::border_contact more than border_margin_deg further in flexion than the
/// first one of their column, from the flexion nearest to zero on, in either direction.
store::GridB is_past_border(const store::MotionModel& model);

/// Share of cells that are not stable, or past a border.
double unsolved_fraction(const store::MotionModel& model);

/// "1911 attitudes: 1900 stable, 11 no_contact".
std::string status_line(const store::MotionModel& model);

/// "20 samples: 58 of 60 poses stable, 2 left out of the bands"; empty without samples.
std::string samples_line(const store::MotionModel& model);

/// Stable cells of doubtful plausibility, in attitude order.
struct DoubtfulCell {
  double flexion_deg = 0.0, varus_deg = 0.0;
  Plausibility plausibility = Plausibility::nothing_found;
};
std::vector<DoubtfulCell> doubtful_cells(const store::MotionModel& model);

/// "2 nothing_ahead, 1 unstable_balance"; empty without any.
std::string plausibility_line(const store::MotionModel& model);

/// load_checked_case(); prints its warnings and scaling.
job::Case load_and_report_case(const std::string& job_file, const job::LoadOptions& options);

/// Reads a motion model. Throws InputError if the file is invalid, too new, or has no stable attitude.
store::MotionModel read_solved_model(const std::string& file);

/// `requested`, or one per processor if that is 0.
int thread_count_or_all(int requested);

}  // namespace vrda::run
