#include "journal/descriptor.hpp"

#include <unistd.h>

namespace vrda {

Descriptor::~Descriptor()
{
  if (value_ >= 0) ::close(value_);
}

}  // namespace vrda
