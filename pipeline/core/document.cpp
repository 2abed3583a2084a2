#include "core/document.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>

#include "core/error.hpp"

namespace vrda::inline core {
namespace {

// The largest documents are calibrations with about ten thousand poses.
constexpr std::size_t max_bytes = 8'000'000;

bool is_inside(const std::string& key, const std::string& outer)
{
  return key == outer || (key.size() > outer.size() && key.starts_with(outer) && key[outer.size()] == '.');
}

// The value of a table's key or the list item with this index; null if missing.
const DocumentValue* child_of(const DocumentValue& value, const std::string& name)
{
  const DocumentValue::List* list = value.list();
  if (list == nullptr) return value.find(name);
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool is_index = error == std::errc() && end == name.data() + name.size();
  return is_index && index < list->size() ? &(*list)[index] : nullptr;
}

// The path from the root to the value of a key, or to its innermost existing parent.
std::vector<const DocumentValue*> path_to(const DocumentValue& root, const std::string& key)
{
  std::vector<const DocumentValue*> values{&root};
  for (std::size_t from = 0; from < key.size();) {
    const std::size_t dot = std::min(key.find('.', from), key.size());
    const DocumentValue* next = child_of(*values.back(), key.substr(from, dot - from));
    if (next == nullptr) break;
    values.push_back(next);
    from = dot + 1;
  }
  return values;
}

}  // namespace

std::string Document::source_of(const std::string& key) const
{
  for (const std::string& set : overridden) {
    if (is_inside(key, set)) return "--set";
  }
  // A conflict between keys of a table may include one from the command line.
  for (const std::string& set : overridden) {
    if (is_inside(set, key)) return file + " with --set " + set;
  }
  return file;
}

std::string Document::source_of_conflict(const std::vector<std::string>& keys) const
{
  for (const std::string& key : keys) {
    if (source_of(key) != file) return file + " with --set " + key;
  }
  return file;
}

int Document::line_of(const std::string& key) const
{
  int line = 0;
  if (source_of(key) != file) return line;
  for (const DocumentValue* value : path_to(root, key)) {
    if (value->line > 0) line = value->line;
  }
  return line;
}

void Document::refuse(const std::string& key, const std::string& found, const std::string& wanted) const
{
  throw InputError({source_of(key), key.empty() ? "" : prefix + key, found, wanted, line_of(key)});
}

void Document::refuse_value(const std::string& key, const std::string& wanted) const
{
  refuse(key, shown(*path_to(root, key).back()), wanted);
}

std::string read_document_text(const std::string& path, const std::string& wanted)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError({path, "", "no readable file", wanted});
  std::string text(max_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw InputError({path, "", "no readable file", wanted});
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > max_bytes)
    throw InputError({path, "", "more than " + std::to_string(max_bytes) + " bytes", wanted});
  return text;
}

}  // namespace vrda::inline core
