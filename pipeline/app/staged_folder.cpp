#include "app/staged_folder.hpp"

#include <cstdlib>
#include <system_error>

#include "core/error.hpp"
#include "job_run/run_output.hpp"

namespace vrda::app {

namespace fs = std::filesystem;

StagedFolder::StagedFolder(const std::string& folder) : folder_(folder)
{
  was_made_ = !fs::exists(folder_);
  job_run::make_folder(folder);
  std::string name = (folder_ / ".vrda-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw InputError({folder, "-o", "a folder that cannot be written to", "a folder for the files"});
  stage_ = name;
}

StagedFolder::~StagedFolder()
{
  std::error_code ignored;
  fs::remove_all(stage_, ignored);
  if (was_made_) fs::remove(folder_, ignored);  // only if it is empty
}

void StagedFolder::check_replaced(const std::vector<std::string>& names,
                                  const std::vector<std::string>& inputs, bool may_replace) const
{
  for (const std::string& name : names) {
    const fs::path target = folder_ / name;
    std::error_code ignored;
    if (!fs::exists(target, ignored)) continue;
    for (const std::string& input : inputs) {
      if (fs::equivalent(target, input, ignored))
        throw InputError({target.string(), "-o", "an input file that would be replaced", "another folder"});
    }
    if (!may_replace)
      throw InputError({target.string(), "-o", "an existing file", "a new folder, or --replace"});
  }
}

void StagedFolder::publish(const std::string& name) const
{
  fs::rename(stage_ / name, folder_ / name);
}

void StagedFolder::publish_all(const std::string& last, const std::vector<std::string>& obsolete) const
{
  for (const std::string& name : obsolete) {
    if (!fs::exists(stage_ / name)) fs::remove(folder_ / name);
  }
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(stage_)) {
    const std::string name = entry.path().filename().string();
    if (name != last) names.push_back(name);
  }
  for (const std::string& name : names) publish(name);
  publish(last);
}

}  // namespace vrda::app
