#include "app/staged_folder.hpp"

#include <cstdlib>
#include <system_error>

#include "core/text.hpp"
#include "run/run_output.hpp"

namespace vrda::app {

namespace fs = std::filesystem;

namespace {

constexpr const char* stage_template = ".vrda-XXXXXX";

void remove_stages_of_dead_writers(const fs::path& folder)
{
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool is_stage = name.starts_with(".vrda-") && name.size() == std::string(stage_template).size();
    if (is_stage && fs::is_directory(entry.symlink_status(ignored))) fs::remove_all(entry.path(), ignored);
  }
}

std::optional<Publication> begun(const fs::path& folder, const std::string& main, const std::string& command)
{
  run::make_folder(folder.string());
  return run::begin_result((folder / main).string(), command);
}

std::string bytes_of(const std::string& file)
{
  std::optional<std::string> bytes = read_text_file(file);
  check(bytes.has_value(), "a file that was made can be read");
  return *std::move(bytes);
}

}  // namespace

StagedFolder::StagedFolder(const std::string& folder, const std::string& main, const std::string& command)
    : folder_(folder),
      main_(main),
      was_made_(!fs::exists(folder_)),
      publication_(begun(folder_, main, command))
{
  if (!publication_) return;
  remove_stages_of_dead_writers(folder_);
  std::string name = (folder_ / stage_template).string();
  if (mkdtemp(name.data()) == nullptr)
    throw InputError({folder, "-o", "a folder that cannot be written to", "a folder for the files"});
  stage_ = name;
}

StagedFolder::~StagedFolder()
{
  std::error_code ignored;
  if (!stage_.empty()) fs::remove_all(stage_, ignored);
  publication_.reset();
  if (was_made_) fs::remove(folder_, ignored);  // only if it is empty
}

void StagedFolder::check_replaced(const std::vector<std::string>& names,
                                  const std::vector<std::string>& inputs, bool may_replace) const
{
  std::vector<std::string> targets;
  for (const std::string& name : names) {
    const fs::path& target = targets.emplace_back((folder_ / name).string());
    for (const std::string& input : inputs) {
      std::error_code ignored;
      if (fs::equivalent(target, input, ignored))
        throw InputError({target.string(), "-o", "an input file that would be replaced", "another folder"});
    }
  }
  if (!may_replace)
    publication_->require_absent(targets, {"", "-o", "an existing file", "a new folder, or --replace"});
}

void StagedFolder::publish(const std::string& name) const
{
  write_atomically((folder_ / name).string(), {bytes_of(file(name))});
}

void StagedFolder::publish_all(const std::vector<std::string>& obsolete)
{
  for (const fs::directory_entry& entry : fs::directory_iterator(stage_)) {
    const std::string name = entry.path().filename().string();
    if (name != main_) publication_->add((folder_ / name).string(), bytes_of(file(name)));
  }
  std::vector<std::string> targets;
  for (const std::string& name : obsolete) targets.push_back((folder_ / name).string());
  publication_->publish(bytes_of(file(main_)), targets);
}

}  // namespace vrda::app
