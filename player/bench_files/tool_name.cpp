#include "bench_files/tool_name.hpp"

#include "documents/document.hpp"

namespace vrda::bench_files {
namespace {

const std::string& required_short(const documents::Document& document, const std::string& key,
                                  const std::string& name)
{
  if (name.size() > longest_tool_name) {
    document.refuse(
        key, "'" + name + "' of " + std::to_string(name.size()) + " bytes",
        "at most " + std::to_string(longest_tool_name) + " bytes (OpenIGTLink truncates longer names)");
  }
  return name;
}

}  // namespace

std::string tool_name(const documents::Document& document, const std::string& key)
{
  return required_short(document, key, documents::text_at(document.root, key));
}

std::vector<std::string> tool_names(const documents::Document& document, const std::string& key)
{
  std::vector<std::string> names = documents::texts_at(document.root, key);
  for (const std::string& one : names) required_short(document, key, one);
  return names;
}

}  // namespace vrda::bench_files
