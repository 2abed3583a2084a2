/// One motion model to make: what `vrda run` is told.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace vrda {

struct CaseSpec {
  std::string name;                    ///< of letters, digits, '-', '_' and '.'; unique in a campaign
  std::string job_file;                ///< absolute
  std::string data_directory;          ///< absolute, or empty
  std::vector<std::string> overrides;  ///< "key.path=value", in order

  bool operator==(const CaseSpec&) const = default;
};

/// Its keys in JSON (cluster/json_fields.hpp), of whatever holds one.
template <typename Fields>
void name_spec_fields(const Fields& fields, CaseSpec& spec)
{
  fields("name", spec.name);
  fields("job", spec.job_file);
  fields("data", spec.data_directory);
  fields("set", spec.overrides);
}

/// The case of one job file, named after it; relative paths are taken from the working folder.
CaseSpec case_of_job(const std::string& job_file, const std::string& data_directory,
                     const std::vector<std::string>& overrides);

/// "<output>.case.json": whose the journals beside it are.
std::string case_file_of(const std::string& output);

struct CaseFile {
  CaseSpec spec;
  std::string merged_sha256;  ///< of the motion model, once it is merged; a merge cut short then clears up
};

/// Both throw InputError naming the file.
void write_case_file(const std::string& path, const CaseFile& content);
CaseFile read_case_file(const std::string& path);

/// What is wrong with the job of a case file, told as a fault of that file where it gives the value, as when
/// it was damaged: nobody typed a --set.
InputError fault_of_case_file(const std::string& path, const CaseSpec& spec, const InputError& error);

/// Larger motion models are refused, not read.
constexpr std::uintmax_t largest_model_bytes = std::uintmax_t{1} << 34;

/// Throws InputError when there is no such file.
std::string sha256_of_model(const std::string& output);

/// Whether a merge was killed while it cleared up: the model is whole by its case file, journals may be gone.
/// False where either cannot be read: the merge says what is wrong.
bool is_only_to_clear_up(const std::string& output);

}  // namespace vrda
