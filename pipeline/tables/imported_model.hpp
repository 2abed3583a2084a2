/// From a table to the poses of a joint.
#pragma once

#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/job.hpp"
#include "store/motion_model.hpp"
#include "tables/motion_table.hpp"

namespace vrda::tables {

/// A measured motion: one pose per frame.
struct MotionSequence {
  std::string key_name;                          ///< as store::FrameSequence
  std::vector<double> key;                       ///< [n] strictly ascending
  std::vector<Pose> X_reference_moving;          ///< [n] canonical, stored vertices, as in a motion model
  std::vector<std::string> absent_columns = {};  ///< as MotionTable
  std::vector<std::string> warnings = {};        ///< one line each: of the table, and unit_warnings()
  /// [n followers of the job][n] coordinates of each frame; empty for one that was not measured.
  std::vector<std::vector<JointCoordinates>> followers = {};
};

/// Reads a motion. What neither `convention` nor the file states has the default of Convention. Throws
/// InputError as read_motion_table(), unit_warnings() and poses_of().
MotionSequence read_motion(const std::string& file, const MotionConvention& convention = {});

// The motion model of a measured motion.

struct ImportFrame {
  JointFrame joint;
  bool has_file_axes = true;  ///< false for a scaled job, whose bodies are not those of the files
};

/// Side, rotation centre and frames of the mesh files of `job`, whose case is `job_case`.
ImportFrame import_frame(const job::Job& job, const job::Case& job_case);

/// `job_case`, which has one Delta, at the subject's size as the case of an import: method "import", a row of
/// the grid for each frame, no roles of coordinates, `record` appended to the resolved job.
job::Case import_case(const job::Case& job_case, const MotionSequence& motion, const std::string& record);

/// The model of import_case(): each frame is a stable cell with attitude, theta and translation about Delta,
/// signed gaps of the compartments, contact flags (gap at most the contact resolution) and contacts within
/// it; measured followers likewise, without energy and balance; and the audit of all frames. Same bits for
/// any number of threads.
store::MotionModel imported_model(const job::Case& import_case, const MotionSequence& motion, int n_threads);

}  // namespace vrda::tables
