/// A disk that fills up: a tmpfs in a mount namespace of this process and those it starts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace vrda::test {

/// Why this process may not mount a disk of its own; empty when it may. A test skips then, saying this.
std::string mount_refusal();

class SmallDisk {
 public:
  /// Mounts in `folder`, which must be there. Throws std::runtime_error when that fails.
  SmallDisk(std::filesystem::path folder, std::uintmax_t n_bytes);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  /// Makes the disk larger; what is on it stays.
  void resize(std::uintmax_t n_bytes);
  /// From now on everything on it can only be read, by root too. Throws while a file is open for writing.
  void forbid_writing();
  void permit_writing();

 private:
  std::filesystem::path folder_;
};

}  // namespace vrda::test
