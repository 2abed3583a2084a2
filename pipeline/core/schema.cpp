#include "core/schema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "core/text.hpp"

namespace vrda::inline core {
namespace {

using Json = nlohmann::json;
using Node = DocumentValue;  // a node of the schema

const Node any_value = Node::object();

bool has_type(const Node& node, const DocumentValue& value)
{
  const std::string& type = text_or_empty(node, "type");
  if (value.is_object()) return type == "object";
  if (value.is_array()) return type == "array";
  if (value.is_string()) return type == "string";
  if (value.is_number()) return type == "number" || type == "integer";
  return type == "boolean";
}

// The schema of `key` in a table; null if the key is not permitted.
const Node* schema_of_key(const Node& table, const std::string& key)
{
  const Node* properties = find_key(table, "properties");
  const Node* known = properties == nullptr ? nullptr : find_key(*properties, key);
  if (known != nullptr) return known;
  const Node* others = find_key(table, "additionalProperties");
  if (others == nullptr) return &any_value;
  return others->is_object() ? others : nullptr;
}

std::ptrdiff_t n_known_keys(const Node& schema, const DocumentValue& value)
{
  std::ptrdiff_t n = 0;
  if (!value.is_object()) return n;
  for (const auto& [key, unused] : value.items()) n += schema_of_key(schema, key) != nullptr;
  return n;
}

// `items` is one schema for all items, or a list with one for each position.
const Node& schema_of_item(const Node& list, std::size_t index)
{
  const Node* items = find_key(list, "items");
  if (items == nullptr) return any_value;
  if (!items->is_array()) return *items;
  return index < items->size() ? items->at(index) : any_value;
}

std::string range_text(const Node& node)
{
  const auto limit = [&](const char* key, const std::string& word) {
    const Node* number = find_key(node, key);
    return number == nullptr ? "" : " " + word + " " + shortest_decimal(number_at(*number, ""));
  };
  const bool has_both = find_key(node, "minimum") != nullptr && find_key(node, "maximum") != nullptr;
  return limit("minimum", has_both ? "from" : "of at least") + limit("exclusiveMinimum", "above") +
         limit("maximum", has_both                                        ? "to"
                          : find_key(node, "exclusiveMinimum") != nullptr ? "up to"
                                                                          : "of at most");
}

std::string count_text(const Node& node, const char* min_key, const char* max_key)
{
  const Node* min = find_key(node, min_key);
  const Node* max = find_key(node, max_key);
  if (max == nullptr) return min == nullptr ? "" : "at least " + value_text(*min) + " ";
  const bool is_fixed = min != nullptr && value_text(*min) == value_text(*max);
  if (is_fixed) return value_text(*max) + " ";
  return (min == nullptr ? "up to " : value_text(*min) + " to ") + value_text(*max) + " ";
}

std::string words_text(const Node& words)
{
  std::vector<std::string> quoted;
  for (const Node& word : words) quoted.push_back(value_text(word));
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

// Texts from CSV tables and --set may not be UTF-8, which the validator requires.
void replace_bytes(Json& value)
{
  if (value.is_structured()) {
    for (Json& child : value) replace_bytes(child);
  } else if (value.is_string() && !is_utf8(value.get_ref<const std::string&>())) {
    value = std::string(value.get_ref<const std::string&>().size(), '?');
  }
}

// The validator's adapter is one of the unordered type.
Json json_of(const DocumentValue& value)
{
  Json json = value;
  replace_bytes(json);
  return json;
}

// "reference.component.file" from "reference.component.0.file", as collect_keys() writes it.
std::string without_indices(const std::string& path)
{
  std::string out;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string name = path.substr(begin, end - begin);
    if (name.find_first_not_of("0123456789") != std::string::npos) out = joined_key(out, name);
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
  if (number > 0.0) return find_key(schema, "maximum") == nullptr;
  return find_key(schema, "minimum") == nullptr && find_key(schema, "exclusiveMinimum") == nullptr;
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
  if (const Node* words = find_key(node, "enum")) return words_text(*words);
  const std::string& type = text_or_empty(node, "type");
  if (type == "boolean") return "true or false";
  if (type == "string") {
    const std::string count = count_text(node, "minLength", "maxLength");
    return count.empty() ? "a text" : "a text of " + count + "characters";
  }
  if (type == "array")
    return "a list of " + count_text(node, "minItems", "maxItems") + "items, each " +
           wanted_at(schema_of_item(node, 0));
  if (type == "integer" || find_key(node, "multipleOf") != nullptr)
    return "a whole number" + range_text(node);
  if (type == "number") return "a number" + range_text(node);
  return type == "object" ? "a table" : "a value";
}

void DocumentSchema::Compiled::collect_keys(const Node& node, const std::string& path,
                                            std::vector<std::string>& keys) const
{
  const Node& target = dereferenced(node);
  for (const Node& shape : list_or_empty(target, "anyOf")) collect_keys(shape, path, keys);
  if (find_key(target, "items") != nullptr) collect_keys(schema_of_item(target, 0), path, keys);
  const Node* properties = find_key(target, "properties");
  if (properties == nullptr) return;
  for (const auto& [key, property] : properties->items()) {
    keys.push_back(joined_key(path, key));
    collect_keys(property, joined_key(path, key), keys);
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
  if (value.is_number_float() && !std::isfinite(value.get<double>()) && !schema.contains("infinite"))
    document.refuse(path, shown(value), "a finite number");
  if (&schema != &any_value && is_beyond_all(schema, value))
    document.refuse(path, shown(value), "a number of at most 1e12 in size");
  for (std::size_t i = 0; value.is_array() && i < value.size(); ++i)
    check_known(document, schema_of_item(schema, i), value[i], joined_key(path, std::to_string(i)));
  if (!value.is_object() || (&schema != &any_value && !has_type(schema, value))) return;
  for (const auto& [name, given] : value.items()) {
    const std::string key = joined_key(path, name);
    const Node* child = schema_of_key(schema, name);
    if (child == nullptr) {
      document.refuse(key, "an unknown key",
                      "a known key; the nearest is \"" + nearest_key(path, name) + "\"");
    }
    check_known(document, *child, given, key);
  }
}

void DocumentSchema::Compiled::check_required(const Document& document, const Node& node,
                                              const DocumentValue& value, const std::string& path) const
{
  const Node& schema = schema_for(node, value);
  for (std::size_t i = 0; value.is_array() && i < value.size(); ++i)
    check_required(document, schema_of_item(schema, i), value[i], joined_key(path, std::to_string(i)));
  if (!value.is_object() || !has_type(schema, value)) return;
  for (const auto& [key, given] : value.items())
    check_required(document, *schema_of_key(schema, key), given, joined_key(path, key));
  for (const std::string& name : texts_at(schema, "required")) {
    if (!value.contains(name))
      document.refuse(joined_key(path, name), "nothing", wanted_at(value_at(schema, "properties." + name)));
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
    if (value->is_array()) {
      const std::size_t index = std::stoul(name);
      schema = &schema_of_item(here, index);
      value = &value->at(index);
    } else {
      schema = schema_of_key(here, name);
      value = find_key(*value, name);
    }
    check(schema != nullptr && value != nullptr, "a validation error has an unknown path");
    path = joined_key(path, name);
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
  DocumentValue out = DocumentValue::object();
  const Node* properties = find_key(schema, "properties");
  const Node& known = properties == nullptr ? any_value : *properties;
  for (const auto& [key, property] : known.items()) {
    const DocumentValue* given = find_key(value, key);
    if (given == nullptr) given = find_key(property, "default");
    if (given != nullptr) out[key] = completed(property, *given);
  }
  // Keys that the schema does not list (a generator's parameters) follow in alphabetical order.
  std::map<std::string, DocumentValue> additional;
  for (const auto& [key, given] : value.items()) {
    if (!known.contains(key)) additional[key] = completed(*schema_of_key(schema, key), given);
  }
  out.update(DocumentValue(additional));
  return out;
}

DocumentValue DocumentSchema::Compiled::completed(const Node& node, const DocumentValue& value) const
{
  const Node& schema = schema_for(node, value);
  if (value.is_object()) return completed_table(schema, value);
  if (text_or_empty(schema, "type") == "number") return number_at(value, "");
  DocumentValue out = value;
  for (std::size_t i = 0; out.is_array() && i < out.size(); ++i)
    out[i] = completed(schema_of_item(schema, i), out[i]);
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
  Document document = read_toml(text, file);
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
