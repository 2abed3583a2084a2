#include "journal/open_file.hpp"

#include <unistd.h>

namespace vrda {

OpenFile::~OpenFile()
{
  if (value_ >= 0) ::close(value_);
}

}  // namespace vrda
