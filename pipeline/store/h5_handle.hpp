/// HDF5 behind two names: a handle that closes itself and one check of return codes. hdf5.h appears in
/// the sources of this room only, hence the plain integer.
#pragma once

#include <cstdint>
#include <string>

#include "store/dataset.hpp"

namespace vrda {

using H5Id = std::int64_t;

/// Owns one HDF5 identifier of any kind and gives it back when it goes.
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

/// Where a call was made; becomes the InputError's file and field.
struct H5Place {
  const std::string& file;
  std::string object;  ///< path inside the file; may be empty
};

/// Returns `code` when it is not negative; otherwise throws InputError with the library's own reason.
H5Id check_h5(H5Id code, const H5Place& place, const char* wanted);

/// The same for calls that return an identifier to own.
H5Handle own_h5(H5Id id, const H5Place& place, const char* wanted);

/// How numbers of a kind lie in memory.
H5Id native_type(ValueKind kind);

/// Stops the library from printing its error stack; errors come back through check_h5.
void silence_h5();

}  // namespace vrda
