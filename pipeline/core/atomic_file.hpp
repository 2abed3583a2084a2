/// Atomic file replacement: a reader finds the old file or the complete new one.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace vrda::inline core {

/// The error of a path that the system refuses: too long, a cycle of links, without permission.
InputError input_error_of(const std::filesystem::filesystem_error& error);

/// `path` with symbolic links resolved; the target need not exist. Throws InputError on a cycle of links.
std::string resolve_links(const std::string& path);

/// File type by its first bytes: "an HDF5 file", "a JSON file", "a text file", ...; empty for no bytes.
std::string_view file_type_of(std::string_view head);

/// Throws InputError where write_atomically would refuse `path`: a file without write permission, or of
/// another type than one that begins with `head`.
void require_same_file_type(const std::string& path, std::string_view head);

/// The content of a small file; empty where it cannot be opened.
std::optional<std::string> read_text_file(const std::string& path);

/// A complete new file beside `path`, which keeps its old content until swap_in(). Throws InputError as
/// write_atomically. The destructor removes the new file unless it was swapped in.
class NewFile {
 public:
  NewFile(const std::string& path, std::initializer_list<std::string_view> pieces);
  /// Takes `file`, which another program has written in the folder of the target.
  static NewFile of_written(const std::string& path, const std::string& file);
  NewFile(NewFile&&) noexcept;
  ~NewFile();

  /// Renames the file to its target.
  void swap_in();

 private:
  class Temporary;
  explicit NewFile(const std::string& path);
  std::string path_, target_;
  std::unique_ptr<Temporary> temporary_;  ///< none for a device, which was written directly
};

/// Writes the concatenated pieces to a unique temporary file in the same folder, flushes and renames it.
/// Links are followed; a replaced file's mode, owner and group are kept. Temporary files of dead writers are
/// removed. A target that is not a regular file (device, pipe) is written directly. Throws InputError naming
/// `path` and the system's reason, and where `path` has no write permission or another type than the new
/// file; the temporary file is then removed.
void write_atomically(const std::string& path, std::initializer_list<std::string_view> pieces);

}  // namespace vrda::inline core
