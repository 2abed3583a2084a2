/// Values one after the other, as they lie in memory.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/error.hpp"

namespace vrda {

/// pass() appends a value, with(n) the number of things that follow; as a visitor of visit_datasets it
/// appends their values.
class PlainWriter {
 public:
  void reserve(std::size_t size) { bytes_.reserve(size); }
  std::string take() { return std::move(bytes_); }

  template <typename Number>
  void pass(const Number& value)
  {
    static_assert(std::is_arithmetic_v<Number>);
    append(&value, sizeof value);
  }
  void pass(const std::string& text)
  {
    pass(static_cast<std::uint32_t>(text.size()));
    append(text.data(), text.size());
  }
  void pass(const Eigen::Vector3d& v) { append(v.data(), 3 * sizeof(double)); }

  template <typename Scalar>
  void operator()(const std::string&, const std::vector<Scalar>& values)
  {
    if constexpr (std::is_same_v<Scalar, std::string>) {
      for (const std::string& text : values) pass(text);
    } else {
      append(values.data(), values.size() * sizeof(Scalar));
    }
  }
  void operator()(const std::string&, const std::string& value) { pass(value); }
  template <typename Derived>
  void operator()(const std::string&, const Eigen::PlainObjectBase<Derived>& values)
  {
    append(values.data(), static_cast<std::size_t>(values.size()) * sizeof(typename Derived::Scalar));
  }

 private:
  void append(const void* data, std::size_t size)
  {
    if (size > 0) bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

/// The way back: pass() fills a value, read() a span. Throws InputError naming `file` where the bytes end.
class PlainReader {
 public:
  PlainReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  std::size_t left() const { return bytes_.size(); }

  template <typename Number>
  void pass(Number& value)
  {
    static_assert(std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>);
    take(&value, sizeof value);
  }
  void pass(std::string& text)
  {
    std::uint32_t size = 0;
    pass(size);
    require(size);
    text.assign(bytes_.substr(0, size));
    bytes_.remove_prefix(size);
  }
  void pass(Eigen::Vector3d& v) { take(v.data(), 3 * sizeof(double)); }

  template <typename Number>
  void read(const std::string&, std::span<Number> values)
  {
    if constexpr (std::is_same_v<Number, std::string>) {
      for (std::string& text : values) pass(text);
    } else {
      take(values.data(), values.size_bytes());
    }
  }

  /// Unless there are `size` more bytes.
  void require(std::uint64_t size) const
  {
    if (size <= bytes_.size()) return;
    throw InputError({file_, "", std::to_string(bytes_.size()) + " bytes of values passed on",
                      std::to_string(size) + " bytes"});
  }

 private:
  void take(void* data, std::size_t size)
  {
    require(size);
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
  const std::string& file_;
};

}  // namespace vrda
