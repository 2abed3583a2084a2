#include "core/little_endian.hpp"

namespace vrda::inline core {
namespace {

void append_u64(std::string& bytes, std::uint64_t value)
{
  for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
}

}  // namespace

void append_u32(std::string& bytes, std::uint32_t value)
{
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
}

void append_i8(std::string& bytes, std::int8_t value)
{
  bytes.push_back(static_cast<char>(value));
}

void append_i32(std::string& bytes, std::int32_t value)
{
  append_u32(bytes, static_cast<std::uint32_t>(value));
}

void append_double(std::string& bytes, double value)
{
  append_u64(bytes, std::bit_cast<std::uint64_t>(value));
}

void append_vector(std::string& bytes, const Eigen::Vector3d& v)
{
  for (int i = 0; i < 3; ++i) append_double(bytes, v[i]);
}

std::uint32_t u32_at(std::string_view bytes, std::size_t offset)
{
  return static_cast<std::uint32_t>(ByteReader(bytes.substr(offset)).take(4));
}

}  // namespace vrda::inline core
