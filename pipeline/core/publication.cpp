#include "core/publication.hpp"

#include <cstdio>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

namespace vrda::inline core {
namespace {

namespace fs = std::filesystem;

// Each new file is open until it is swapped in; a process may open 1024.
constexpr std::size_t most_open_files = 200;

// Throws if it stays.
void remove_file(const std::string& file)
{
  std::error_code error;
  fs::remove(file, error);
  if (error) throw InputError({file, "", error.message(), "a file that can be replaced"});
}

}  // namespace

std::optional<Publication> Publication::begin(const std::string& main, const std::string& command,
                                              const OutputLock::WaitOptions& waiting)
{
  std::error_code error;
  const fs::file_status status = fs::status(main, error);
  if (fs::is_directory(status)) throw InputError({main, "", "a folder", "a name for a file"});
  if (fs::exists(status) && !fs::is_regular_file(status)) return Publication(main, std::nullopt);
  std::optional<OutputLock> lock = OutputLock::acquire(main, command, waiting);
  if (!lock) return std::nullopt;
  return Publication(main, std::move(lock));
}

Publication::Publication(std::string main, std::optional<OutputLock> lock)
    : main_(std::move(main)), lock_(std::move(lock))
{
  if (!lock_) return;
  if (fs::exists(main_)) {  // complete
    remove_file(note());
    return;
  }
  std::istringstream names(read_text_file(note()).value_or(""));
  for (std::string name; std::getline(names, name);) left_.insert(name);
}

// Lists the files from before the first swap until after the last one. While `main` is absent, they belong to
// no process.
std::string Publication::note() const
{
  return resolve_links(main_) + ".publishing";
}

std::string Publication::name_in_note(const std::string& file) const
{
  const fs::path folder = fs::path(main_).parent_path();
  return fs::path(file).lexically_normal().lexically_relative(folder.lexically_normal()).string();
}

void Publication::require_absent(const std::vector<std::string>& files, InputError::Facts refusal) const
{
  for (const std::string& file : files) {
    if (!fs::exists(file) || left_.count(name_in_note(file)) > 0) continue;
    refusal.file = file;
    throw InputError(std::move(refusal));
  }
}

void Publication::add(const std::string& file, std::string_view bytes)
{
  added_.emplace_back(file, std::initializer_list<std::string_view>{bytes});
  names_.insert(name_in_note(file));
  if (added_.size() >= most_open_files) swap_added();
}

void Publication::start_swap()
{
  if (!lock_) return;
  std::string text = name_in_note(main_) + '\n';
  for (const std::set<std::string>* names : {&left_, &names_}) {
    for (const std::string& name : *names) text += name + '\n';
  }
  write_atomically(note(), {text});
  remove_file(resolve_links(main_));
}

void Publication::swap_added()
{
  start_swap();
  for (NewFile& file : added_) file.swap_in();
  added_.clear();
}

void Publication::publish(std::string_view main_bytes, const std::vector<std::string>& obsolete)
{
  publish(NewFile(main_, {main_bytes}), obsolete);
}

void Publication::publish_written(const std::string& file)
{
  publish(NewFile::of_written(main_, file), {});
}

void Publication::publish(NewFile main, const std::vector<std::string>& obsolete)
{
  const bool is_one_of_several = !names_.empty() || !obsolete.empty();
  if (is_one_of_several) {
    swap_added();
    for (const std::string& file : obsolete) {
      if (names_.count(name_in_note(file)) == 0) remove_file(file);
    }
  }
  main.swap_in();
  if (lock_) remove_file(note());
}

}  // namespace vrda::inline core
