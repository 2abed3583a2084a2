/// One motion model to compute: the input of `vrda run`.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "core/fields.hpp"
#include "core/text.hpp"
#include "job/case.hpp"
#include "solve/sweep.hpp"

namespace vrda::run {

struct CaseSpec {
  std::string name;                    ///< of letters, digits, '-', '_' and '.'; unique in a campaign
  std::string job_file;                ///< absolute
  std::string data_directory;          ///< absolute, or empty
  std::vector<std::string> overrides;  ///< "key.path=value", in order

  bool operator==(const CaseSpec&) const = default;
  job::JobSource source() const { return {{data_directory, overrides}, job_file}; }
};

constexpr auto fields_of(const CaseSpec*)
{
  return std::tuple{Field{"name", &CaseSpec::name}, Field{"job", &CaseSpec::job_file},
                    Field{"data", &CaseSpec::data_directory}, Field{"set", &CaseSpec::overrides}};
}

/// The case of one job file, named after it; relative paths are relative to the working folder.
CaseSpec case_of_job(const std::string& job_file, const std::string& data_directory,
                     const std::vector<std::string>& overrides);

/// "<output>.case.json", which records the case of the journals next to it.
std::string case_file_of(const std::string& output);

struct CaseFile {
  CaseSpec spec;
  std::string merged_sha256;  ///< of the motion model once merged; an interrupted merge then only cleans up
};
constexpr auto fields_of(const CaseFile*)
{
  return std::tuple{Field{"", &CaseFile::spec}, Field{"merged_sha256", &CaseFile::merged_sha256}};
}

/// Both throw InputError naming the file.
void write_case_file(const std::string& path, const CaseFile& content);
CaseFile read_case_file(const std::string& path);

/// Maps an error of a case file's job to the case file if the value comes from it (e.g. a damaged file),
/// since the user did not type a --set.
InputError error_of_case_file(const std::string& path, const CaseSpec& spec, const InputError& error);

/// Larger motion models are rejected.
constexpr std::uintmax_t largest_model_bytes = std::uintmax_t{1} << 34;

/// Throws InputError when there is no such file.
std::string sha256_of_model(const std::string& output);

/// Whether a merge was interrupted during clean-up: the model matches its case file, journals may be removed.
/// False if either file cannot be read; the merge then reports the error.
bool is_cleanup_pending(const std::string& output);

// A campaign: motion models for the product of axes of named levels (schemas/campaign.md).

struct CampaignCase {
  CaseSpec spec;
  std::vector<std::string> levels;  ///< [axes] names
  /// For the first spec.overrides, which come from levels: key of the level, "campaign.size.1.set".
  std::vector<std::string> override_keys = {};
};

struct Campaign {
  std::string file;  ///< path as given
  std::string title;
  std::vector<std::string> axes;    ///< in the order written: "subject", "method", ...
  std::vector<CampaignCase> cases;  ///< the last axis fastest
};

/// The cases of a campaign file or of a job with a [campaign] table; for a plain job one case named after the
/// file, without axes. `data_directory` is the default for subjects, `overrides` are appended to every case.
/// Opens no mesh. Throws InputError naming file, key, found and wanted.
Campaign campaign_of(const std::string& job_or_campaign, const std::string& data_directory,
                     const std::vector<std::string>& overrides);

/// Maps an error of a case to the campaign's file and key if a level caused it, and names the case.
InputError error_of_case(const Campaign& campaign, const CampaignCase& one, const InputError& error);

// Cost estimate of a case: steps counted from its plan, and seconds, memory and bytes by constants measured
// on one machine. For the accuracy see `cost_spread`.

/// Steps of a sweep. Exact if the balance stays in an inner column of the grid, no equilibrium is propagated
/// to a neighbouring flexion and every spine cell is stable.
struct StepCounts {
  std::int64_t chain = 0;     ///< of the spine, sequential
  std::int64_t restarts = 0;  ///< of a free spine, parallel over flexions
  std::int64_t bands = 0;     ///< steps with additional moments, in the rows
  std::int64_t cells = 0;     ///< other steps of the rows
  std::int64_t records = 0;   ///< final number of journal records, including spine cells found by walking

  std::int64_t spine() const { return chain + restarts; }
  std::int64_t rows() const { return bands + cells; }
  std::int64_t all() const { return spine() + rows(); }
};

/// Steps of the spine and of the rows in `plan`.
StepCounts step_counts(const solve::SweepPlan& plan);

/// Quantities that determine step times and file sizes.
struct CaseSize {
  bool is_search = false;  ///< stability search instead of equilibrium
  std::int64_t n_contact_triangles = 0;
  std::int64_t n_triangles = 0;  ///< including display-only meshes
  std::int64_t n_fibres = 0;
  std::int64_t n_flexion = 0;
  std::int64_t n_varus = 0;
  std::int64_t n_smoothed = 0;  ///< sets
  std::int64_t n_samples = 0;   ///< of an uncertain job; of a shard: its own
};

/// Processor seconds and bytes.
struct CaseCost {
  StepCounts steps;
  double load_s = 0.0;   ///< per task: meshes, trees
  double spine_s = 0.0;  ///< includes the sequential part chain_s
  double chain_s = 0.0;
  double rows_s = 0.0;
  double finish_s = 0.0;       ///< of a run or merge: smoothing, recontacting, file
  double memory_bytes = 0.0;   ///< peak of one process
  double journal_bytes = 0.0;  ///< of all journals
  double model_bytes = 0.0;

  double solving_s() const { return spine_s + rows_s; }
  double processor_s() const { return load_s + solving_s() + finish_s; }
};

CaseCost cost_of(const CaseSize& size, const StepCounts& steps);

/// Measured times are between the estimate divided and multiplied by this factor.
extern const double cost_spread;

}  // namespace vrda::run
