#include "run/case_spec.hpp"

#include <filesystem>

#include "run/json_fields.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "job/input_file.hpp"

namespace vrda::run {
namespace {

namespace fs = std::filesystem;

std::string absolute(const std::string& path)
{
  return path.empty() ? path : fs::absolute(path).lexically_normal().string();
}

}  // namespace

CaseSpec case_of_job(const std::string& job_file, const std::string& data_directory,
                     const std::vector<std::string>& overrides)
{
  return {fs::path(job_file).stem().string(), absolute(job_file), absolute(data_directory), overrides};
}

std::string case_file_of(const std::string& output)
{
  return output + ".case.json";
}

template <typename Fields>
void name_fields(const Fields& fields, CaseFile& file)
{
  name_spec_fields(fields, file.spec);
  fields("merged_sha256", file.merged_sha256);
}

void write_case_file(const std::string& path, const CaseFile& content)
{
  const nlohmann::ordered_json json = content;
  // A path may contain invalid UTF-8.
  write_atomically(path, {json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace), "\n"});
}

CaseFile read_case_file(const std::string& path)
{
  constexpr const char* wanted = "the case file that vrda run --spine or --shard wrote, or --job";
  const std::optional<std::string> text = read_text_file(path);
  if (!text) throw InputError({path, "", "no file", wanted});
  return value_in<CaseFile>(core::JsonFile(path, *text, wanted), path);
}

InputError error_of_case_file(const std::string& path, const CaseSpec& spec, const InputError& error)
{
  InputError::Facts facts = error.facts();
  constexpr std::string_view with_override = " with --set ";
  if (facts.file == "--set") {
    facts.file = path;
    facts.field = facts.field.empty() ? "set" : "set: " + facts.field;
  } else if (const std::size_t with = facts.file.find(with_override); with != std::string::npos) {
    facts.file.replace(with, with_override.size(), " with " + path + ": set: ");
  } else if (facts.file == spec.job_file && facts.field.empty()) {
    facts.wanted += ", which " + path + " names";
  } else {
    return error;
  }
  facts.wanted += "; --job names another job";
  return InputError(facts);
}

std::string sha256_of_model(const std::string& output)
{
  return job::sha256_of(job::file_bytes(output, {output, "", "", "a motion model"}, largest_model_bytes));
}

namespace {

// Empty if the text is not a case file.
std::optional<CaseFile> parsed(const std::string& text)
{
  try {
    return nlohmann::ordered_json::parse(text).get<CaseFile>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

bool is_cleanup_pending(const std::string& output)
{
  const std::optional<std::string> text = read_text_file(case_file_of(output));
  const std::optional<CaseFile> case_file = text ? parsed(*text) : std::nullopt;
  if (!case_file || case_file->merged_sha256.empty()) return false;
  const std::optional<std::string> model = read_text_file(output);
  return model && case_file->merged_sha256 == job::sha256_of(*model);
}

}  // namespace vrda::run
