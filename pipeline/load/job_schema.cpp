#include "load/job_schema.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda {

extern const char* const job_schema_text;  // schemas/job.schema.json, embedded by CMake

namespace {

constexpr const char* campaign_key = "campaign";

using Json = nlohmann::json;
using Schema = nlohmann::ordered_json;  // keeps the order of keys, which is the order of the resolved job

const Schema& job_schema()
{
  static const Schema schema = Schema::parse(job_schema_text);
  return schema;
}

// As the validator wants it, with these keys required at the top; to build it takes longer than to check a
// job.
std::unique_ptr<const valijson::Schema> compile_schema(const Json& required)
{
  Json json = Json::parse(job_schema_text);
  json["required"] = required;
  auto schema = std::make_unique<valijson::Schema>();
  valijson::SchemaParser parser(valijson::SchemaParser::kDraft7);
  parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(json), *schema);
  return schema;
}

const valijson::Schema& compiled_job_schema()
{
  static const std::unique_ptr<const valijson::Schema> schema = compile_schema(job_schema().at("required"));
  return *schema;
}

const valijson::Schema& compiled_campaign_schema()
{
  static const std::unique_ptr<const valijson::Schema> schema = compile_schema(Json::array({"campaign"}));
  return *schema;
}

std::string joined(const std::string& path, const std::string& key)
{
  return path.empty() ? key : path + "." + key;
}

const Schema& dereferenced(const Schema& node)
{
  if (!node.contains("$ref")) return node;
  return job_schema().at(Schema::json_pointer(node.at("$ref").get<std::string>().substr(1)));
}

bool has_type(const Schema& node, const JobValue& value)
{
  if (!node.contains("type")) return false;
  const std::string type = node.at("type");
  if (value.table() != nullptr) return type == "object";
  if (value.list() != nullptr) return type == "array";
  if (value.text() != nullptr) return type == "string";
  if (std::holds_alternative<bool>(value.data)) return type == "boolean";
  return type == "number" || type == "integer";
}

// The schema that speaks about this value: behind a $ref, and of several shapes the one of its type.
const Schema& schema_for(const Schema& node, const JobValue& value)
{
  const Schema& target = dereferenced(node);
  if (!target.contains("anyOf")) return target;
  for (const Schema& shape : target.at("anyOf")) {
    if (has_type(dereferenced(shape), value)) return dereferenced(shape);
  }
  return target;
}

// The schema of `key` in a table; null when there is none.
const Schema* schema_of_key(const Schema& table, const std::string& key)
{
  if (table.contains("properties") && table.at("properties").contains(key))
    return &table.at("properties").at(key);
  if (table.contains("additionalProperties") && table.at("additionalProperties").is_object()) {
    return &table.at("additionalProperties");
  }
  return nullptr;
}

std::string wanted_at(const Schema& node)
{
  if (node.contains("description")) return node.at("description");
  return dereferenced(node).value("description", "");
}

void collect_keys(const Schema& node, const std::string& path, std::vector<std::string>& keys)
{
  const Schema& target = dereferenced(node);
  if (target.contains("anyOf")) {
    for (const Schema& shape : target.at("anyOf")) collect_keys(shape, path, keys);
  }
  if (target.contains("items")) collect_keys(target.at("items"), path, keys);
  if (!target.contains("properties")) return;
  for (const auto& [key, below] : target.at("properties").items()) {
    keys.push_back(joined(path, key));
    collect_keys(below, joined(path, key), keys);
  }
}

// "reference.component.0.file" without its list positions, as collect_keys names it.
std::string without_positions(const std::string& path)
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

// Compares last names first; a key of another table is one further away.
std::string nearest_key(const std::string& path, const std::string& unknown)
{
  std::vector<std::string> keys;
  collect_keys(job_schema(), "", keys);
  const std::string table = without_positions(path);
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& key : keys) {
    const std::size_t dot = key.rfind('.');
    const std::string owner = dot == std::string::npos ? "" : key.substr(0, dot);
    const std::string name = dot == std::string::npos ? key : key.substr(dot + 1);
    const std::size_t distance = edit_distance(unknown, name) + (owner == table ? 0 : 1);
    if (distance < best_distance) {
      best = key;
      best_distance = distance;
    }
  }
  return best;
}

// Unknown keys, in the order the job has them: said better here than a validator can. `prefix` comes before
// `path` in messages.
void check_known_keys(const JobDocument& document, const Schema& node, const JobValue& value,
                      const std::string& path, const std::string& prefix)
{
  const Schema& schema = schema_for(node, value);
  if (const JobValue::List* list = value.list(); list != nullptr && schema.contains("items")) {
    for (std::size_t i = 0; i < list->size(); ++i) {
      check_known_keys(document, schema.at("items"), (*list)[i], joined(path, std::to_string(i)), prefix);
    }
  }
  if (value.table() == nullptr || !has_type(schema, value)) return;
  for (const JobEntry& entry : *value.table()) {
    const std::string key = joined(path, entry.key);
    const Schema* below = schema_of_key(schema, entry.key);
    if (below == nullptr) {
      throw InputError({document.source_of(prefix + key), prefix + key, "an unknown key",
                        "a key of the job; the nearest is \"" + nearest_key(path, entry.key) + "\""});
    }
    check_known_keys(document, *below, entry.value, key, prefix);
  }
}

void check_required_keys(const JobDocument& document, const Schema& node, const JobValue& value,
                         const std::string& path)
{
  const Schema& schema = schema_for(node, value);
  if (const JobValue::List* list = value.list(); list != nullptr && schema.contains("items")) {
    for (std::size_t i = 0; i < list->size(); ++i) {
      check_required_keys(document, schema.at("items"), (*list)[i], joined(path, std::to_string(i)));
    }
  }
  if (value.table() == nullptr || !has_type(schema, value)) return;
  for (const JobEntry& entry : *value.table()) {
    check_required_keys(document, *schema_of_key(schema, entry.key), entry.value, joined(path, entry.key));
  }
  for (const Schema& required : schema.value("required", Schema::array())) {
    const std::string name = required;
    if (value.find(name) != nullptr) continue;
    throw InputError({document.source_of(path), joined(path, name), "nothing",
                      wanted_at(schema.at("properties").at(name))});
  }
}

Json json_of(const JobValue& value)
{
  struct Visitor {
    Json operator()(bool flag) const { return flag; }
    Json operator()(std::int64_t number) const { return number; }
    Json operator()(double number) const { return number; }
    Json operator()(const std::string& text) const { return text; }
    Json operator()(const JobValue::List& list) const
    {
      Json out = Json::array();
      for (const JobValue& item : list) out.push_back(json_of(item));
      return out;
    }
    Json operator()(const JobValue::Table& table) const
    {
      Json out = Json::object();
      for (const JobEntry& entry : table) out[entry.key] = json_of(entry.value);
      return out;
    }
  };
  return std::visit(Visitor{}, value.data);
}

using Context = std::vector<std::string>;  // "<root>", "[grid]", "[flexion]", "[0]"

// Messages run from the leaf to the root; within the alternatives of an anyOf the deepest one is meant.
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

[[noreturn]] void throw_failure(const JobDocument& document, const Context& context)
{
  const Schema* schema = &job_schema();
  const JobValue* value = &document.root;
  std::string path;
  std::string wanted = wanted_at(*schema);
  for (std::size_t i = 1; i < context.size(); ++i) {
    const std::string name = context[i].substr(1, context[i].size() - 2);
    const Schema& here = schema_for(*schema, *value);
    if (const JobValue::List* list = value->list()) {
      schema = &here.at("items");
      value = &list->at(std::stoul(name));
    } else {
      schema = schema_of_key(here, name);
      value = value->find(name);
    }
    check(schema != nullptr && value != nullptr, "a failed check points to a key that is not there");
    path = joined(path, name);
    if (const std::string more = wanted_at(*schema); !more.empty()) wanted = more;
  }
  throw InputError({document.source_of(path), path, shown(*value), wanted});
}

JobValue value_of(const Schema& json)
{
  if (json.is_boolean()) return {json.get<bool>()};
  if (json.is_number_integer()) return {json.get<std::int64_t>()};
  if (json.is_number()) return {json.get<double>()};
  if (json.is_string()) return {json.get<std::string>()};
  if (json.is_object()) return {JobValue::Table{}};
  JobValue::List list;
  for (const Schema& item : json) list.push_back(value_of(item));
  return {list};
}

JobValue completed(const Schema& node, const JobValue& value);

JobValue completed_table(const Schema& schema, const JobValue& value)
{
  JobValue::Table out;
  const Schema properties = schema.value("properties", Schema::object());
  for (const auto& [key, below] : properties.items()) {
    if (const JobValue* given = value.find(key)) {
      out.push_back({key, completed(below, *given)});
    } else if (below.contains("default")) {
      out.push_back({key, completed(below, value_of(below.at("default")))});
    }
  }
  // Keys the schema leaves open (a generator's parameters) follow in alphabetical order.
  std::vector<JobEntry> open;
  for (const JobEntry& entry : *value.table()) {
    if (!schema.contains("properties") || !schema.at("properties").contains(entry.key)) open.push_back(entry);
  }
  std::sort(open.begin(), open.end(), [](const JobEntry& a, const JobEntry& b) { return a.key < b.key; });
  for (const JobEntry& entry : open)
    out.push_back({entry.key, completed(*schema_of_key(schema, entry.key), entry.value)});
  return {out};
}

JobValue completed(const Schema& node, const JobValue& value)
{
  const Schema& schema = schema_for(node, value);
  if (value.table() != nullptr) return completed_table(schema, value);
  if (const JobValue::List* list = value.list()) {
    JobValue::List out;
    for (const JobValue& item : *list) out.push_back(completed(schema.at("items"), item));
    return {out};
  }
  if (schema.value("type", "") == "number") return {number_at(value, "")};
  return value;
}

void validate(const JobDocument& document, const valijson::Schema& schema)
{
  const Json json = json_of(document.root);
  const valijson::adapters::NlohmannJsonAdapter adapter(json);
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  valijson::ValidationResults results;
  if (!validator.validate(schema, adapter, &results)) throw_failure(document, first_failure(results));
}

JobValue without_campaign(const JobValue& root)
{
  JobValue::Table kept;
  for (const JobEntry& entry : *root.table()) {
    if (entry.key != campaign_key) kept.push_back(entry);
  }
  return {kept};
}

}  // namespace

JobValue checked_job(const JobDocument& document)
{
  if (is_campaign_alone(document.root)) {
    throw InputError({document.file, "reference", "a campaign of jobs and no joint of its own",
                      "a job here; a campaign is for vrda plan and vrda submit"});
  }
  check_known_keys(document, job_schema(), document.root, "", "");
  check_required_keys(document, job_schema(), document.root, "");
  validate(document, compiled_job_schema());
  return completed(job_schema(), without_campaign(document.root));
}

bool is_campaign_alone(const JobValue& root)
{
  return root.find(campaign_key) != nullptr && root.find("reference") == nullptr &&
         root.find("moving") == nullptr;
}

void check_campaign(const JobDocument& document)
{
  if (is_campaign_alone(document.root) && document.root.table()->size() > 1) {
    for (const JobEntry& entry : *document.root.table()) {
      if (entry.key == campaign_key) continue;
      throw InputError({document.file, entry.key, "a key beside [campaign] in a file that is no job",
                        "[campaign] alone, or a whole job with [reference] and [moving]"});
    }
  }
  const JobValue* table = document.root.find(campaign_key);
  check(table != nullptr, "check_campaign: a document with a campaign");
  const JobDocument alone{document.file, {JobValue::Table{{campaign_key, *table}}}, {}};
  const Schema& schema = job_schema().at("properties").at(campaign_key);
  check_known_keys(alone, schema, *table, campaign_key, "");
  check_required_keys(alone, schema, *table, campaign_key);
  validate(alone, compiled_campaign_schema());
  for (const JobEntry& axis : *table->table()) {
    const JobValue::List* levels = axis.value.list();
    for (std::size_t i = 0; levels != nullptr && i < levels->size(); ++i) {
      const JobValue* settings = (*levels)[i].find("set");
      if (settings == nullptr) continue;
      const std::string prefix =
          std::string(campaign_key) + "." + axis.key + "." + std::to_string(i) + ".set.";
      check_known_keys(alone, job_schema(), *settings, "", prefix);
    }
  }
}

}  // namespace vrda
