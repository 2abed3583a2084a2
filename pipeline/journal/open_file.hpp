/// An open file.
#pragma once

#include <utility>

namespace vrda {

/// A file descriptor that closes itself unless released.
class OpenFile {
 public:
  explicit OpenFile(int value) : value_(value) {}
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return value_; }
  int release() { return std::exchange(value_, -1); }

 private:
  int value_;
};

}  // namespace vrda
