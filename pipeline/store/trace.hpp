/// The trace of every search of a run as plain data. schemas/trace.md specifies its file.
/// Units here are those of the file: mm and degrees.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

using Points32 = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// One entry per search, sorted by flexion, varus and node.
struct TraceSearches {
  std::vector<double> flexion_deg, varus_deg;  ///< values of the motion model's axes
  std::vector<std::int8_t> node;               ///< StepKind; `spine` is the accepted probe of the spine
  std::vector<std::int8_t> status;             ///< StepStatus
  Points32 seed_translation_mm;                ///< world W
  std::vector<float> seed_theta_deg;
  std::vector<std::int64_t> move_start{0};  ///< [n + 1]
};

/// One entry per move, in search order.
struct TraceMoves {
  std::vector<std::int32_t> iteration;
  std::vector<std::int8_t> kind;  ///< MoveKind
  Points32 translation_mm;        ///< world W
  std::vector<float> theta_deg;
  std::vector<float> translation_step_mm, rotation_step_deg;
  std::vector<std::int8_t> collides, is_cycle, in_contact;
  std::vector<std::int64_t> contact_start{0};  ///< [n + 1]
};

struct TraceContacts {
  Points32 point_mm;  ///< world W
  Points32 normal;
  std::vector<float> distance_mm;
  std::vector<std::int32_t> triangle_reference, triangle_moving;
  std::vector<std::int8_t> compartment;
};

struct Trace {
  std::string title;
  std::string side;     ///< "right" or "left"
  std::string job_key;  ///< SHA-256 of the solver's version, the resolved job and the inputs
  double approach_step_mm = 0.0;
  double translation_resolution_mm = 0.0;
  double rotation_resolution_deg = 0.0;
  TraceSearches searches;
  TraceMoves moves;
  TraceContacts contacts;
  JobRecord job;  ///< as in the motion model, without `text`
};

/// The moves of one search, [first, end) of Trace::moves.
struct MoveRange {
  std::size_t first = 0;
  std::size_t end = 0;
};
MoveRange moves_of(const Trace& trace, std::size_t search);

/// The moves in contact of one search; played alone they show a smooth motion (thesis 3.8).
std::vector<std::size_t> moves_in_contact(const Trace& trace, std::size_t search);

struct AttitudeFilter {
  std::optional<double> flexion_deg, varus_deg;  ///< values of the grid; empty: any
};

/// The searches at those attitudes, in file order. Throws InputError naming `file` without one.
std::vector<std::size_t> searches_at(const Trace& trace, const std::string& file,
                                     const AttitudeFilter& filter);

// HDF5 file of the trace (schemas/trace.md).

/// "knee.trace.h5" for "knee.h5".
std::string trace_name(const std::string& motion_model_file);

/// As write_motion_model. Equal traces give equal bytes.
void write_trace(const std::string& path, const Trace& trace);

/// As read_motion_model.
Trace read_trace(const std::string& path);

/// Throws InputError naming `trace_file` when it is not the trace of `model`, read from `model_file`.
void require_trace_matches_model(const Trace& trace, const std::string& trace_file, const MotionModel& model,
                                 const std::string& model_file);

// One search of a trace as a sequence of poses.

struct FilmOptions {
  store::AttitudeFilter cell;  ///< default: the spine cell of the first flexion
  bool contact_only = false;   ///< omit the seed and moves without contact (thesis 3.8)
  int every = 1;               ///< keep every Nth frame and the last
};

struct Film {
  Attitude attitude;
  std::vector<PoseCoordinates> frames;  ///< the seed, then the moves in order
};

/// Returns the search whose result is the requested cell of the motion model. Throws InputError naming `file`
/// if the search is missing or no frame remains.
Film film_of(const store::Trace& trace, const std::string& file, const FilmOptions& options);

}  // namespace vrda::store
