/// One table of a campaign's results: a row a case. schemas/campaign.md says what each column is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "store/motion_model.hpp"

namespace vrda {

enum class CaseStatus : std::int8_t {
  done = 0,     ///< the motion model is there, and keeps to its specification
  partial = 1,  ///< no model; a start file or journals are
  failed = 2,   ///< the model cannot be read, or the task that was to make it failed
  missing = 3,  ///< nothing is there
};

const char* name_of(CaseStatus status);

/// How long it took and where, from <model>.run.json: differs from run to run, so it stays out of the index.
struct CaseTimes {
  std::string begun;  ///< UTC
  std::string host;
  double seconds = 0.0;                    ///< by the clock
  double solving_processor_seconds = 0.0;  ///< of all threads
  int n_threads = 0;
  int n_processors = 0;
  int n_recalled = 0;  ///< steps that were solved before
};

struct IndexRow {
  std::string name;
  std::vector<std::string> levels;  ///< [axes]
  CaseStatus status = CaseStatus::missing;
  std::string remark;  ///< why failed
  // Of a model only; empty otherwise.
  std::string title, joint, side, solver;
  std::string curve;            ///< what the columns over flexion are of: "zero_varus" or "spine"
  std::vector<double> numbers;  ///< one for each of index_numbers(); NaN: no answer
  std::string sha256;           ///< of the file
  std::string file;             ///< absolute
  std::optional<CaseTimes> times;
};

struct IndexNumber {
  const char* name;  ///< column of the table
  const char* units;
  const char* long_name;
};

/// The columns of numbers, in their order.
const std::vector<IndexNumber>& index_numbers();

/// What `model` has to say to each of index_numbers() but the file's size, which is `model_bytes`.
std::vector<double> index_numbers_of(const MotionModel& model, double model_bytes);

/// "zero_varus" where the model has that motion, "spine" where a spine cell is stable, else empty.
std::string index_curve_of(const MotionModel& model);

/// A case and where its motion model goes.
struct IndexedCase {
  std::string name;
  std::vector<std::string> levels;  ///< [axes]
  std::string model_path;
};

/// Looks at the files of each case, one row a case. A model that cannot be read is a row, not an error. At
/// most `n_processes` read models at once, each apart (store/read_apart.hpp): no other thread may use HDF5.
std::vector<IndexRow> index_rows(const std::vector<IndexedCase>& cases, int n_processes);

/// Writes folder/index.csv and folder/index.h5, equal bytes for equal results, and folder/index.times.csv.
/// File names are written relative to the folder. Throws InputError when a file cannot be written.
void write_index(const std::string& folder, const std::string& title, const std::vector<std::string>& axes,
                 const std::vector<IndexRow>& rows);

}  // namespace vrda
