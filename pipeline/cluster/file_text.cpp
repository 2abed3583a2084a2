#include "cluster/file_text.hpp"

#include <fstream>
#include <sstream>

namespace vrda {

std::optional<std::string> text_of_file(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::stringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

}  // namespace vrda
