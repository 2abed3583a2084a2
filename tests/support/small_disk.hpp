/// A disk of limited size: a tmpfs in a mount namespace of this process and its children.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace vrda::test {

/// Reason why this process cannot mount a disk; empty if it can. Tests are skipped with this reason.
std::string mount_refusal();

class SmallDisk {
 public:
  /// Mounts in `folder`, which must exist. Throws std::runtime_error on failure.
  SmallDisk(std::filesystem::path folder, std::uintmax_t n_bytes);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  /// Enlarges the disk, keeping its contents.
  void resize(std::uintmax_t n_bytes);
  /// Makes the disk read-only, also for root. Throws while a file is open for writing.
  void forbid_writing();
  void permit_writing();

 private:
  std::filesystem::path folder_;
};

}  // namespace vrda::test
