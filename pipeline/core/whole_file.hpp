/// A file that appears whole or not at all.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace vrda {

/// `path`, or where the symbolic links that it names lead; that file need not exist. Throws InputError on a
/// ring of links.
std::string link_target(const std::string& path);

/// What the first bytes of a file say that it is: "an HDF5 file", "a JSON file", "a text file", ...; empty
/// for no bytes.
std::string_view kind_of_file(std::string_view head);

/// Throws InputError where `path` is a file without write permission, or of another kind than a file that
/// begins with `head`: what write_whole refuses.
void require_same_kind(const std::string& path, std::string_view head);

/// The whole content of a small file that may not be there: nothing where it cannot be opened.
std::optional<std::string> text_of_file(const std::string& path);

/// Writes the pieces, one after the other, under a temporary name of its own in the same folder, waits for
/// the disk and renames, so that `path` holds the old file or the new one. Links are followed; mode, owner
/// and group of a file that is replaced stay. Temporary files of writers that died are removed. What is no
/// regular file (a device, a pipe) is written as it is. Throws InputError naming `path` and the system's
/// reason, and where `path` is a file without write permission or of another kind than the new one; what was
/// written of the new one is removed then.
void write_whole(const std::string& path, std::initializer_list<std::string_view> pieces);

}  // namespace vrda
