/// HDF5 handles (RAII) and a check of return codes. No header includes hdf5.h, hence the integer.
#pragma once

#include <cstdint>
#include <string>

#include "store/dataset.hpp"

namespace vrda::store {

using H5Id = std::int64_t;

/// Owns one HDF5 identifier of any kind and releases it on destruction.
class H5Handle {
 public:
  H5Handle() = default;
  explicit H5Handle(H5Id id) : id_(id) {}
  H5Handle(H5Handle&& other) noexcept : id_(other.id_) { other.id_ = -1; }
  H5Handle& operator=(H5Handle&& other) noexcept;
  ~H5Handle() { reset(); }

  H5Id id() const { return id_; }
  void reset() noexcept;

 private:
  H5Id id_ = -1;
};

/// Location of a call; becomes the InputError's file and field.
struct H5Location {
  const std::string& file;
  std::string object;  ///< path inside the file; may be empty
};

/// Returns `code` when it is not negative; otherwise throws InputError with HDF5's error text.
H5Id check_h5(H5Id code, const H5Location& place, const char* wanted);

/// The same for calls that return an identifier to own.
H5Handle own_h5(H5Id id, const H5Location& place, const char* wanted);

/// HDF5's native type of a kind of numbers.
H5Id native_type(ValueKind kind);

/// Disables HDF5's printing of its error stack; check_h5 reports errors.
void silence_h5();

}  // namespace vrda::store
