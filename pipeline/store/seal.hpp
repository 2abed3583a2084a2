/// Seal: a trailer after the HDF5 content with 8 bytes "VRDASEAL", the CRC-32 of all bytes before it and 4
/// zero bytes. HDF5 programs ignore it, and truncate it when they change the file. Why: HDF5 1.10 has
/// checksums for its headers and for compressed values, but not for its heaps; one flipped bit there causes
/// reads out of bounds (measured: a crash for most bytes of a heap).
#pragma once

#include <string>
#include <string_view>

namespace vrda::store {

/// The "wanted" text of messages about damaged files.
inline constexpr const char* intact_file = "an intact motion model or trace (HDF5)";

/// An HDF5 file in memory, without its seal.
struct Hdf5Content {
  std::string file;  ///< its name, for messages
  std::string bytes;
};

/// The seal to append to a file with this HDF5 content.
std::string seal_of(std::string_view content);

/// Sets whether this process accepts files without a seal (changed by another program). Default: no.
void accept_unsealed_files(bool accepts = true);

/// Reads the whole file. Throws InputError when it is absent, not a regular HDF5 file, or damaged, or when
/// its seal does not match or is missing and unsealed files are not accepted.
Hdf5Content read_hdf5(const std::string& file);

}  // namespace vrda::store
