/// One departure of a file from its specification.
#pragma once

#include <string>

namespace vrda::store {

struct Finding {
  std::string where;  ///< path of the object in the file, "@name" for an attribute
  std::string found;
  std::string wanted;
};

}  // namespace vrda::store
