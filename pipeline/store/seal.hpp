/// A checksum over the whole file, behind the end of its HDF5 content: 8 bytes "VRDASEAL", the CRC-32 of what
/// stands before them and 4 zero bytes. HDF5 programs read past it and cut it off when they change the file.
/// Why: HDF5 1.10 guards its headers and our compressed values, but not its heaps; one flipped bit there
/// makes it read outside its memory (measured: a crash for most bytes of a heap).
#pragma once

#include <string>
#include <string_view>

namespace vrda {

/// The seal of a file with this HDF5 content, to stand behind it.
std::string seal_of(std::string_view content);

/// Throws InputError when the file is damaged: its seal does not match, or it is shorter or longer than its
/// HDF5 content and seal. A file without a seal passes when it ends where its HDF5 content does: another
/// program changed it, and only HDF5's own checks remain.
void require_sound(const std::string& path);

}  // namespace vrda
