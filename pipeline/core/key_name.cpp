// The rule for names of the key of a sequence of frames ("time_s").
#include "core/text.hpp"

#include <algorithm>

namespace vrda::inline core {

bool is_key_name(const std::string& name)
{
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !name.empty() && name.size() <= 40 && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

}  // namespace vrda::inline core
