#include "store/h5_handle.hpp"

#include <hdf5.h>

#include <type_traits>
#include <utility>

#include "core/error.hpp"

namespace vrda::store {
namespace {

static_assert(std::is_same_v<hid_t, H5Id>, "HDF5 1.10 identifiers are 64-bit integers");

herr_t keep_innermost(unsigned depth, const H5E_error2_t* error, void* reason)
{
  if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(reason) = error->desc;
  return 0;
}

}  // namespace

H5Id native_type(ValueKind kind)
{
  switch (kind) {
    case ValueKind::float64:
      return H5T_NATIVE_DOUBLE;
    case ValueKind::float32:
      return H5T_NATIVE_FLOAT;
    case ValueKind::int64:
      return H5T_NATIVE_INT64;
    case ValueKind::int32:
      return H5T_NATIVE_INT32;
    case ValueKind::int8:
      return H5T_NATIVE_INT8;
    case ValueKind::text:
      break;
  }
  throw InternalError("text has no fixed memory type");
}

H5Handle& H5Handle::operator=(H5Handle&& other) noexcept
{
  std::swap(id_, other.id_);
  return *this;
}

void H5Handle::reset() noexcept
{
  if (id_ >= 0) H5Idec_ref(id_);
  id_ = -1;
}

H5Id check_h5(H5Id code, const H5Location& place, const char* wanted)
{
  if (code >= 0) return code;
  std::string reason = "no reason given";
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &reason);
  H5Eclear2(H5E_DEFAULT);
  throw InputError({place.file, place.object, "an HDF5 error (" + reason + ")", wanted});
}

H5Handle own_h5(H5Id id, const H5Location& place, const char* wanted)
{
  return H5Handle(check_h5(id, place, wanted));
}

void silence_h5()
{
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

}  // namespace vrda::store
