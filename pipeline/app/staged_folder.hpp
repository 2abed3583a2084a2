/// The files of a command that writes a folder, made in a hidden folder inside it and published at the end: a
/// command that fails, is refused or is interrupted leaves the earlier files as they were.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace vrda::app {

class StagedFolder {
 public:
  /// Makes the folder, waits for the lock of its file `main` and makes the hidden folder; removes hidden
  /// folders of writers that were killed. Throws InputError if that fails.
  StagedFolder(const std::string& folder, const std::string& main, const std::string& command);
  /// Removes the hidden folder, and the folder if it was made here and stays empty.
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// False if the wait for the lock was interrupted.
  bool is_locked() const { return publication_.has_value(); }

  /// The path of a file that is being made.
  std::string file(const std::string& name) const { return (stage_ / name).string(); }

  /// Throws InputError if a file of one of these names exists and `may_replace` is false, or if it is one of
  /// `inputs`.
  void check_replaced(const std::vector<std::string>& names, const std::vector<std::string>& inputs,
                      bool may_replace) const;

  /// Copies one file to the folder, over an earlier one.
  void publish(const std::string& name) const;
  /// Publishes all files that were made; removes the files of `obsolete` that were not made again.
  void publish_all(const std::vector<std::string>& obsolete);

 private:
  std::filesystem::path folder_, stage_;
  std::string main_;
  bool was_made_ = false;
  std::optional<Publication> publication_;
};

}  // namespace vrda::app
