/// The files of a command that writes a folder, made in a hidden folder inside it and moved at the end: a
/// command that fails, is refused or is interrupted leaves the earlier files as they were.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vrda::app {

class StagedFolder {
 public:
  /// Makes the hidden folder. Throws InputError if that fails.
  explicit StagedFolder(const std::string& folder);
  /// Removes what was not moved, and the folder if it was made here and stays empty.
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// The path of a file that is being made.
  std::string file(const std::string& name) const { return (stage_ / name).string(); }

  /// Throws InputError if a file of one of these names exists and `may_replace` is false, or if it is one of
  /// `inputs`.
  void check_replaced(const std::vector<std::string>& names, const std::vector<std::string>& inputs,
                      bool may_replace) const;

  /// Moves one file to the folder, over an earlier one.
  void publish(const std::string& name) const;
  /// Moves all files to the folder, `last` at the end, and removes the files of `obsolete` that were not made
  /// again.
  void publish_all(const std::string& last, const std::vector<std::string>& obsolete) const;

 private:
  std::filesystem::path folder_, stage_;
  bool was_made_ = false;
};

}  // namespace vrda::app
