/// Numbers as little-endian bytes; doubles as their 64 bits.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

namespace vrda::inline core {

void append_u32(std::string& bytes, std::uint32_t value);
void append_i8(std::string& bytes, std::int8_t value);
void append_i32(std::string& bytes, std::int32_t value);
void append_double(std::string& bytes, double value);
void append_vector(std::string& bytes, const Eigen::Vector3d& v);

std::uint32_t u32_at(std::string_view bytes, std::size_t offset);

/// Reads values sequentially; past the end it returns zeros and becomes invalid.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  std::size_t n_bytes_left() const { return bytes_.size() - at_; }
  bool is_valid() const { return is_sound_; }
  /// Marks the bytes as invalid, for a value out of range.
  void mark_invalid() { is_sound_ = false; }

  /// An integer of at most 8 bytes.
  std::uint64_t take(std::size_t n_bytes)
  {
    if (n_bytes_left() < n_bytes) {
      is_sound_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n_bytes; ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[at_ + i])} << (8 * i);
    }
    at_ += n_bytes;
    return value;
  }
  std::int8_t take_i8() { return static_cast<std::int8_t>(take(1)); }
  std::int32_t take_i32() { return static_cast<std::int32_t>(take(4)); }
  double take_double() { return std::bit_cast<double>(take(8)); }
  bool take_bool()
  {
    const std::uint64_t value = take(1);
    if (value > 1) is_sound_ = false;
    return value == 1;
  }
  Eigen::Vector3d take_vector()
  {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = take_double();
    return v;
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool is_sound_ = true;
};

}  // namespace vrda::inline core
