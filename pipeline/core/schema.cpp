#include "core/schema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "core/text.hpp"

namespace vrda::inline core {
namespace {

using Json = nlohmann::json;
using Node = DocumentValue;  // a node of the schema

const Node any_value{DocumentValue::Table{}};

std::string joined(const std::string& path, const std::string& key)
{
  return path.empty() ? key : path + "." + key;
}

bool has_type(const Node& node, const DocumentValue& value)
{
  const std::string& type = text_or_empty(node, "type");
  if (value.table() != nullptr) return type == "object";
  if (value.list() != nullptr) return type == "array";
  if (value.text() != nullptr) return type == "string";
  if (value.is_number()) return type == "number" || type == "integer";
  return type == "boolean";
}

// The schema of `key` in a table; null if the key is not permitted.
const Node* schema_of_key(const Node& table, const std::string& key)
{
  const Node* properties = table.find("properties");
  const Node* known = properties == nullptr ? nullptr : properties->find(key);
  if (known != nullptr) return known;
  const Node* others = table.find("additionalProperties");
  if (others == nullptr) return &any_value;
  return others->table() != nullptr ? others : nullptr;
}

std::ptrdiff_t n_known_keys(const Node& schema, const DocumentValue& value)
{
  if (value.table() == nullptr) return 0;
  return std::count_if(value.table()->begin(), value.table()->end(), [&](const DocumentEntry& entry) {
    return schema_of_key(schema, entry.key) != nullptr;
  });
}

// `items` is one schema for all items, or a list with one for each position.
const Node& schema_of_item(const Node& list, std::size_t index)
{
  const Node* items = list.find("items");
  if (items == nullptr) return any_value;
  if (items->list() == nullptr) return *items;
  return index < items->list()->size() ? items->list()->at(index) : any_value;
}

std::string range_text(const Node& node)
{
  const auto limit = [&](const char* key, const std::string& word) {
    const Node* number = node.find(key);
    return number == nullptr ? "" : " " + word + " " + shortest_decimal(number_at(*number, ""));
  };
  const bool has_both = node.find("minimum") != nullptr && node.find("maximum") != nullptr;
  return limit("minimum", has_both ? "from" : "of at least") + limit("exclusiveMinimum", "above") +
         limit("maximum", has_both                                   ? "to"
                          : node.find("exclusiveMinimum") != nullptr ? "up to"
                                                                     : "of at most");
}

std::string count_text(const Node& node, const char* min_key, const char* max_key)
{
  const Node* min = node.find(min_key);
  const Node* max = node.find(max_key);
  if (max == nullptr) return min == nullptr ? "" : "at least " + value_text(*min) + " ";
  const bool is_fixed = min != nullptr && value_text(*min) == value_text(*max);
  if (is_fixed) return value_text(*max) + " ";
  return (min == nullptr ? "up to " : value_text(*min) + " to ") + value_text(*max) + " ";
}

std::string words_text(const Node& words)
{
  std::vector<std::string> quoted;
  for (const Node& word : *words.list()) quoted.push_back(value_text(word));
  return join_alternatives(quoted);
}

// Path to a failed check: "<root>", "[grid]", "[flexion]", "[0]".
using Context = std::vector<std::string>;

// Errors are ordered from leaf to root. Among the alternatives of an anyOf the deepest error is reported.
Context first_failure(valijson::ValidationResults& results)
{
  Context chosen;
  valijson::ValidationResults::Error error;
  while (results.popError(error)) {
    const Context& context = error.context;
    const bool goes_deeper =
        context.size() > chosen.size() && std::equal(chosen.begin(), chosen.end(), context.begin());
    if (goes_deeper) chosen = context;
  }
  return chosen;
}

Json json_of(const DocumentValue& value)
{
  struct Visitor {
    Json operator()(bool flag) const { return flag; }
    Json operator()(std::int64_t number) const { return number; }
    Json operator()(double number) const { return number; }
    // Texts from CSV tables and --set may not be UTF-8, which the validator requires.
    Json operator()(const std::string& text) const
    {
      return is_utf8(text) ? text : std::string(text.size(), '?');
    }
    Json operator()(const DocumentValue::List& list) const
    {
      Json out = Json::array();
      for (const DocumentValue& item : list) out.push_back(json_of(item));
      return out;
    }
    Json operator()(const DocumentValue::Table& table) const
    {
      Json out = Json::object();
      for (const DocumentEntry& entry : table) out[entry.key] = json_of(entry.value);
      return out;
    }
  };
  return std::visit(Visitor{}, value.data);
}

// "reference.component.file" from "reference.component.0.file", as collect_keys() writes it.
std::string without_indices(const std::string& path)
{
  std::string out;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string name = path.substr(begin, end - begin);
    if (name.find_first_not_of("0123456789") != std::string::npos) out = joined(out, name);
    begin = end + 1;
  }
  return out;
}

// Beyond what any quantity needs, where the schema itself has no limit in this direction.
bool is_beyond_all(const Node& schema, const DocumentValue& value)
{
  constexpr double largest = 1e12;
  if (!value.is_number()) return false;
  const double number = number_at(value, "");
  if (!std::isfinite(number) || std::abs(number) <= largest) return false;
  if (number > 0.0) return schema.find("maximum") == nullptr;
  return schema.find("minimum") == nullptr && schema.find("exclusiveMinimum") == nullptr;
}

}  // namespace

struct DocumentSchema::Compiled {
  Node root;
  valijson::Schema rules;  // built once: building takes longer than a check

  const Node& dereferenced(const Node& node) const;
  const Node& schema_for(const Node& node, const DocumentValue& value) const;
  std::string wanted_at(const Node& node) const;
  std::string wanted_by_type(const Node& node) const;
  void collect_keys(const Node& node, const std::string& path, std::vector<std::string>& keys) const;
  std::string nearest_key(const std::string& path, const std::string& unknown) const;
  void check_known(const Document& document, const Node& node, const DocumentValue& value,
                   const std::string& path) const;
  void check_required(const Document& document, const Node& node, const DocumentValue& value,
                      const std::string& path) const;
  void validate(const Document& document) const;
  [[noreturn]] void refuse_failure(const Document& document, const Context& context) const;
  DocumentValue completed(const Node& node, const DocumentValue& value) const;
  DocumentValue completed_table(const Node& schema, const DocumentValue& value) const;
};

const Node& DocumentSchema::Compiled::dereferenced(const Node& node) const
{
  const std::string& reference = text_or_empty(node, "$ref");
  if (reference.empty()) return node;
  std::string path = reference.substr(2);  // "#/definitions/eye"
  std::replace(path.begin(), path.end(), '/', '.');
  return value_at(root, path);
}

// The schema that applies to this value: $ref resolved, and the anyOf alternative of its type; of several
// tables the one that knows the most of the value's keys.
const Node& DocumentSchema::Compiled::schema_for(const Node& node, const DocumentValue& value) const
{
  const Node& target = dereferenced(node);
  const Node* best = nullptr;
  std::ptrdiff_t most_known = -1;
  for (const Node& shape : list_or_empty(target, "anyOf")) {
    const Node& candidate = dereferenced(shape);
    if (!has_type(candidate, value)) continue;
    const std::ptrdiff_t known = n_known_keys(candidate, value);
    if (known <= most_known) continue;
    most_known = known;
    best = &candidate;
  }
  return best == nullptr ? target : *best;
}

std::string DocumentSchema::Compiled::wanted_at(const Node& node) const
{
  const Node& target = dereferenced(node);
  for (const Node* source : {&node, &target}) {
    if (const std::string& text = text_or_empty(*source, "description"); !text.empty()) return text;
  }
  return wanted_by_type(target);
}

std::string DocumentSchema::Compiled::wanted_by_type(const Node& node) const
{
  std::vector<std::string> shapes;
  for (const Node& shape : list_or_empty(node, "anyOf")) shapes.push_back(wanted_at(shape));
  if (!shapes.empty()) return join_alternatives(shapes);
  if (const Node* words = node.find("enum")) return words_text(*words);
  const std::string& type = text_or_empty(node, "type");
  if (type == "boolean") return "true or false";
  if (type == "string") {
    const std::string count = count_text(node, "minLength", "maxLength");
    return count.empty() ? "a text" : "a text of " + count + "characters";
  }
  if (type == "array")
    return "a list of " + count_text(node, "minItems", "maxItems") + "items, each " +
           wanted_at(schema_of_item(node, 0));
  if (type == "integer" || node.find("multipleOf") != nullptr) return "a whole number" + range_text(node);
  if (type == "number") return "a number" + range_text(node);
  return type == "object" ? "a table" : "a value";
}

void DocumentSchema::Compiled::collect_keys(const Node& node, const std::string& path,
                                            std::vector<std::string>& keys) const
{
  const Node& target = dereferenced(node);
  for (const Node& shape : list_or_empty(target, "anyOf")) collect_keys(shape, path, keys);
  if (target.find("items") != nullptr) collect_keys(schema_of_item(target, 0), path, keys);
  const Node* properties = target.find("properties");
  if (properties == nullptr) return;
  for (const DocumentEntry& entry : *properties->table()) {
    keys.push_back(joined(path, entry.key));
    collect_keys(entry.value, joined(path, entry.key), keys);
  }
}

// Nearest by edit distance of the last name; plus one for a key of another table.
std::string DocumentSchema::Compiled::nearest_key(const std::string& path, const std::string& unknown) const
{
  constexpr std::size_t max_compared = 100;  // characters: bounds the cost of the edit distance
  std::vector<std::string> keys;
  collect_keys(root, "", keys);
  const std::string table = without_indices(path), compared = unknown.substr(0, max_compared);
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& key : keys) {
    const std::size_t dot = key.rfind('.');
    const std::string owner = dot == std::string::npos ? "" : key.substr(0, dot);
    const std::string name = dot == std::string::npos ? key : key.substr(dot + 1);
    const std::size_t distance = edit_distance(compared, name) + (owner == table ? 0 : 1);
    if (distance < best_distance) {
      best = key;
      best_distance = distance;
    }
  }
  return best;
}

// Unknown keys in document order, infinite numbers, and numbers whose squares could overflow. The messages
// are clearer than those of the validator.
void DocumentSchema::Compiled::check_known(const Document& document, const Node& node,
                                           const DocumentValue& value, const std::string& path) const
{
  const Node& schema = schema_for(node, value);
  if (const auto* number = std::get_if<double>(&value.data)) {
    const bool is_permitted = std::isfinite(*number) || schema.find("infinite") != nullptr;
    if (!is_permitted) document.refuse(path, shown(value), "a finite number");
  }
  if (&schema != &any_value && is_beyond_all(schema, value))
    document.refuse(path, shown(value), "a number of at most 1e12 in size");
  if (const DocumentValue::List* list = value.list()) {
    for (std::size_t i = 0; i < list->size(); ++i)
      check_known(document, schema_of_item(schema, i), (*list)[i], joined(path, std::to_string(i)));
  }
  if (value.table() == nullptr || (&schema != &any_value && !has_type(schema, value))) return;
  for (const DocumentEntry& entry : *value.table()) {
    const std::string key = joined(path, entry.key);
    const Node* child = schema_of_key(schema, entry.key);
    if (child == nullptr) {
      document.refuse(key, "an unknown key",
                      "a known key; the nearest is \"" + nearest_key(path, entry.key) + "\"");
    }
    check_known(document, *child, entry.value, key);
  }
}

void DocumentSchema::Compiled::check_required(const Document& document, const Node& node,
                                              const DocumentValue& value, const std::string& path) const
{
  const Node& schema = schema_for(node, value);
  if (const DocumentValue::List* list = value.list()) {
    for (std::size_t i = 0; i < list->size(); ++i)
      check_required(document, schema_of_item(schema, i), (*list)[i], joined(path, std::to_string(i)));
  }
  if (value.table() == nullptr || !has_type(schema, value)) return;
  for (const DocumentEntry& entry : *value.table())
    check_required(document, *schema_of_key(schema, entry.key), entry.value, joined(path, entry.key));
  for (const std::string& name : texts_at(schema, "required")) {
    if (value.find(name) == nullptr)
      document.refuse(joined(path, name), "nothing", wanted_at(value_at(schema, "properties." + name)));
  }
}

void DocumentSchema::Compiled::refuse_failure(const Document& document, const Context& context) const
{
  const Node* schema = &root;
  const DocumentValue* value = &document.root;
  std::string path;
  for (std::size_t i = 1; i < context.size(); ++i) {
    const std::string name = context[i].substr(1, context[i].size() - 2);
    const Node& here = schema_for(*schema, *value);
    if (const DocumentValue::List* list = value->list()) {
      const std::size_t index = std::stoul(name);
      schema = &schema_of_item(here, index);
      value = &list->at(index);
    } else {
      schema = schema_of_key(here, name);
      value = value->find(name);
    }
    check(schema != nullptr && value != nullptr, "a validation error has an unknown path");
    path = joined(path, name);
  }
  document.refuse(path, shown(*value), wanted_at(*schema));
}

void DocumentSchema::Compiled::validate(const Document& document) const
{
  const Json json = json_of(document.root);
  const valijson::adapters::NlohmannJsonAdapter adapter(json);
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  valijson::ValidationResults results;
  if (!validator.validate(rules, adapter, &results)) refuse_failure(document, first_failure(results));
}

DocumentValue DocumentSchema::Compiled::completed_table(const Node& schema, const DocumentValue& value) const
{
  DocumentValue::Table out;
  const Node* properties = schema.find("properties");
  const Node& known = properties == nullptr ? any_value : *properties;
  for (const DocumentEntry& entry : *known.table()) {
    if (const DocumentValue* given = value.find(entry.key)) {
      out.push_back({entry.key, completed(entry.value, *given)});
    } else if (const Node* preset = entry.value.find("default")) {
      out.push_back({entry.key, completed(entry.value, *preset)});
    }
  }
  // Keys that the schema does not list (a generator's parameters) follow in alphabetical order.
  std::vector<DocumentEntry> additional;
  for (const DocumentEntry& entry : *value.table()) {
    if (known.find(entry.key) == nullptr) additional.push_back(entry);
  }
  std::sort(additional.begin(), additional.end(),
            [](const DocumentEntry& a, const DocumentEntry& b) { return a.key < b.key; });
  for (const DocumentEntry& entry : additional)
    out.push_back({entry.key, completed(*schema_of_key(schema, entry.key), entry.value)});
  return {out};
}

DocumentValue DocumentSchema::Compiled::completed(const Node& node, const DocumentValue& value) const
{
  const Node& schema = schema_for(node, value);
  DocumentValue out = value;
  if (value.table() != nullptr) {
    out = completed_table(schema, value);
  } else if (auto* list = std::get_if<DocumentValue::List>(&out.data)) {
    for (std::size_t i = 0; i < list->size(); ++i)
      (*list)[i] = completed(schema_of_item(schema, i), (*list)[i]);
  } else if (text_or_empty(schema, "type") == "number") {
    out.data = number_at(value, "");
  }
  out.line = value.line;
  return out;
}

DocumentSchema::DocumentSchema(std::string_view text)
{
  auto compiled = std::make_unique<Compiled>();
  compiled->root = parse_json(text, "schema", "a JSON schema");
  const Json json = json_of(compiled->root);
  valijson::SchemaParser parser(valijson::SchemaParser::kDraft7);
  parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(json), compiled->rules);
  compiled_ = std::move(compiled);
}

DocumentSchema::~DocumentSchema() = default;

DocumentValue DocumentSchema::checked(const Document& document) const
{
  check_known_keys(document);
  check_required_keys(document);
  compiled_->validate(document);
  return compiled_->completed(compiled_->root, document.root);
}

Document DocumentSchema::read(std::string_view text, const std::string& file) const
{
  Document document{file, parse_toml(text, file)};
  document.root = checked(document);
  return document;
}

void DocumentSchema::check_known_keys(const Document& document) const
{
  compiled_->check_known(document, compiled_->root, document.root, "");
}

void DocumentSchema::check_required_keys(const Document& document) const
{
  compiled_->check_required(document, compiled_->root, document.root, "");
}

}  // namespace vrda::inline core
