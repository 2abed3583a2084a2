/// One departure of an HDF5 file from its specification (schemas/motion-model.md, trace.md): the result of a
/// validation, which lists all of them instead of throwing at the first.
#pragma once

#include <string>

namespace vrda::store {

struct Finding {
  std::string where;  ///< path of the object in the file, "@name" for an attribute
  std::string found;
  std::string wanted;
};

}  // namespace vrda::store
