/// One motion model to compute: the input of `vrda run`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace vrda::run {

struct CaseSpec {
  std::string name;                    ///< of letters, digits, '-', '_' and '.'; unique in a campaign
  std::string job_file;                ///< absolute
  std::string data_directory;          ///< absolute, or empty
  std::vector<std::string> overrides;  ///< "key.path=value", in order

  bool operator==(const CaseSpec&) const = default;
};

/// JSON keys of a CaseSpec within another struct (cluster/json_fields.hpp).
template <typename Fields>
void name_spec_fields(const Fields& fields, CaseSpec& spec)
{
  fields("name", spec.name);
  fields("job", spec.job_file);
  fields("data", spec.data_directory);
  fields("set", spec.overrides);
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

}  // namespace vrda::run
