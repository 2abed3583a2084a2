#include "setup/tool_name.hpp"

#include "settings/settings_table.hpp"

namespace vrda {
namespace {

const std::string& required_short(const SettingsTable& table, const char* key, const std::string& name)
{
  if (name.size() > longest_tool_name) {
    table.refuse(key, "'" + name + "' of " + std::to_string(name.size()) + " bytes",
                 "at most " + std::to_string(longest_tool_name) + " bytes, as OpenIGTLink cuts them");
  }
  return name;
}

}  // namespace

std::string tool_name(const SettingsTable& table, const char* name)
{
  return required_short(table, name, table.text(name));
}

std::string tool_name_or(const SettingsTable& table, const char* name, const std::string& otherwise)
{
  return table.has(name) ? tool_name(table, name) : otherwise;
}

std::vector<std::string> tool_names(const SettingsTable& table, const char* name)
{
  std::vector<std::string> names = table.texts(name);
  for (const std::string& one : names) required_short(table, name, one);
  return names;
}

}  // namespace vrda
