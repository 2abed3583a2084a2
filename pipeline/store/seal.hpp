/// A checksum over the whole file, behind the end of its HDF5 content: 8 bytes "VRDASEAL", the CRC-32 of what
/// stands before them and 4 zero bytes. HDF5 programs read past it and cut it off when they change the file.
/// Why: HDF5 1.10 guards its headers and our compressed values, but not its heaps; one flipped bit there
/// makes it read outside its memory (measured: a crash for most bytes of a heap).
#pragma once

#include <string>
#include <string_view>

namespace vrda {

/// What readers of these files want, in messages.
inline constexpr const char* intact_file = "an intact motion model or trace (HDF5)";

/// An HDF5 file in memory, without its seal.
struct Hdf5Content {
  std::string file;  ///< its name, for messages
  std::string bytes;
};

/// The seal of a file with this HDF5 content, to stand behind it.
std::string seal_of(std::string_view content);

/// Whether this process also takes files without a seal, those that another program wrote or changed; at
/// first it does not.
void accept_unsealed_files(bool accepts = true);

/// The whole file. Throws InputError when it is absent, no regular HDF5 file, or damaged: its seal does not
/// match, or there is none and files without one are not accepted.
Hdf5Content read_hdf5(const std::string& file);

}  // namespace vrda
