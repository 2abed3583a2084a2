/// The one operation that puts a result under its name: lock, check, write beside, swap.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"

namespace vrda::inline core {

/// A result of one file, or of several of which readers open `main`. `main` is removed before the first file
/// is replaced and written last, so that no reader takes files of two results for one.
class Publication {
 public:
  /// Takes the lock of `main`, held by the Publication; a device or pipe has none. Empty if the wait is
  /// cancelled. Throws InputError where `main` is a folder, or as OutputLock::acquire.
  static std::optional<Publication> begin(const std::string& main, const std::string& command,
                                          const OutputLock::WaitOptions& waiting = {});

  /// Throws InputError for the first of `files` that exists, with the other facts of `refusal`, unless a
  /// publication of `main` that was killed has left it.
  void require_absent(const std::vector<std::string>& files, InputError::Facts refusal) const;

  /// Writes another file of the result beside its target. Throws InputError as write_atomically.
  void add(const std::string& file, std::string_view bytes);

  /// Writes `main` and swaps all files in; removes those of `obsolete` that were not added.
  void publish(std::string_view main_bytes, const std::vector<std::string>& obsolete = {});

  /// The same with `file`, which another program has written in the folder of `main`, as `main`.
  void publish_written(const std::string& file);

 private:
  Publication(std::string main, std::optional<OutputLock> lock);

  std::string note() const;
  std::string name_in_note(const std::string& file) const;
  void publish(NewFile main, const std::vector<std::string>& obsolete);
  void start_swap();
  void swap_added();

  std::string main_;
  std::optional<OutputLock> lock_;
  std::set<std::string> left_;   ///< files of a killed publication, as in its note
  std::set<std::string> names_;  ///< files added, as in the note
  std::vector<NewFile> added_;   ///< not yet swapped in
};

}  // namespace vrda::inline core
