/// A temporary folder, removed at the end of the test.
#pragma once

#include <filesystem>
#include <string>

namespace vrda::test {

class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Writes `bytes` to `name` in the folder and returns its path.
  std::filesystem::path write(const std::string& name, const std::string& bytes) const;

 private:
  std::filesystem::path path_;
};

/// Contents of a file.
std::string read_bytes(const std::filesystem::path& file);

}  // namespace vrda::test
