/// Table of a campaign's results with one row per case. schemas/campaign.md specifies the columns.
#pragma once

#include <string>
#include <vector>

#include "core/fields.hpp"
#include "core/files.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {

enum class CaseStatus : std::int8_t { done, partial, failed, missing };
inline constexpr Named<CaseStatus> case_status_names[] = {
    {CaseStatus::done, "done", "the motion model exists and is valid"},
    {CaseStatus::partial, "partial", "no model, but a start file or journals"},
    {CaseStatus::failed, "failed", "the model cannot be read, or its task failed"},
    {CaseStatus::missing, "missing", "no files"}};
constexpr const auto& names_of(CaseStatus)
{
  return case_status_names;
}

/// Times and host from <model>.run.json. They differ between runs, so they are not part of the index.
/// NaN and empty without such a file.
struct CaseTimes {
  std::string begun;  ///< UTC
  std::string host;
  double seconds = nan;                    ///< wall clock
  double solving_processor_seconds = nan;  ///< of all threads
  double n_threads = nan, n_processors = nan;
  double n_recalled = nan;  ///< steps recalled from journals
};
constexpr auto fields_of(const CaseTimes*)
{
  return std::tuple{Field{"begun", &CaseTimes::begun},
                    Field{"host", &CaseTimes::host},
                    Field{"seconds", &CaseTimes::seconds},
                    Field{"solving_processor_seconds", &CaseTimes::solving_processor_seconds},
                    Field{"threads", &CaseTimes::n_threads},
                    Field{"processors", &CaseTimes::n_processors},
                    Field{"steps_recalled", &CaseTimes::n_recalled}};
}

struct IndexRow {
  std::string name;
  std::vector<std::string> levels;  ///< [axes]
  CaseStatus status = CaseStatus::missing;
  std::string remark;  ///< reason of the failure
  // Only with a model; empty otherwise.
  std::string title, joint, side, solver;
  std::string curve;            ///< motion of the columns over flexion: "zero_varus" or "spine"
  std::vector<double> numbers;  ///< one for each of index_numbers(); NaN: no value
  std::string sha256;           ///< of the file
  std::string file;             ///< absolute
  CaseTimes times;
};

struct IndexNumber {
  const char* name;  ///< column of the table
  const char* units;
  const char* long_name;
};

/// The numeric columns, in order.
const std::vector<IndexNumber>& index_numbers();

/// Values of index_numbers() for `model`; `model_bytes` is the file's size.
std::vector<double> index_numbers_of(const store::MotionModel& model, double model_bytes);

/// "zero_varus" if the model has that motion, otherwise "spine" if a spine cell is stable, otherwise empty.
std::string index_curve_of(const store::MotionModel& model);

/// A case and the path of its motion model.
struct IndexedCase {
  std::string name;
  std::vector<std::string> levels;  ///< [axes]
  std::string model_path;
};

/// Reads the files of each case; one row per case. An unreadable model becomes a row, not an error. Up to
/// `n_processes` separate processes read models (store/read_separately.hpp); no other thread may use HDF5.
std::vector<IndexRow> index_rows(const std::vector<IndexedCase>& cases, int n_processes);

/// The main file of the result.
std::string index_file_of(const std::string& folder);

/// Publishes folder/index.csv and folder/index.h5, equal bytes for equal results, and folder/index.times.csv.
/// `publication`: of index_file_of(folder), locked while the rows are read. File names are written relative
/// to the folder. Throws InputError when a file cannot be written.
void publish_index(Publication& publication, const std::string& folder, const std::string& title,
                   const std::vector<std::string>& axes, const std::vector<IndexRow>& rows);

}  // namespace vrda::run
