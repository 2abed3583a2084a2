#include "cluster/case_spec.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "load/file_bytes.hpp"

namespace vrda {
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

void write_case_file(const std::string& path, const CaseFile& content)
{
  const CaseSpec& spec = content.spec;
  const nlohmann::ordered_json json = {{"name", spec.name},
                                       {"job", spec.job_file},
                                       {"data", spec.data_directory},
                                       {"set", spec.overrides},
                                       {"merged_sha256", content.merged_sha256}};
  // A path may hold any bytes.
  write_whole(path, {json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace), "\n"});
}

CaseFile read_case_file(const std::string& path)
{
  constexpr const char* wanted = "the case file that vrda run --spine or --shard wrote, or --job";
  const std::optional<std::string> text = text_of_file(path);
  if (!text) throw InputError({path, "", "no file", wanted});
  try {
    const auto json = nlohmann::json::parse(*text);
    return {{json.at("name"), json.at("job"), json.at("data"), json.at("set")}, json.at("merged_sha256")};
  } catch (const nlohmann::json::exception&) {
    throw InputError({path, "", "something that is no case file", wanted});
  }
}

std::string sha256_of_model(const std::string& output)
{
  return sha256_of(file_bytes(output, {output, "", "", "a motion model"}, largest_model_bytes));
}

bool is_only_to_clear_up(const std::string& output)
{
  std::error_code ignored;
  const std::string case_file = case_file_of(output);
  if (!fs::exists(case_file, ignored) || !fs::exists(output, ignored)) return false;
  const std::string sha256 = read_case_file(case_file).merged_sha256;
  return !sha256.empty() && sha256 == sha256_of_model(output);
}

}  // namespace vrda
