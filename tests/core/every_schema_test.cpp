// Every key of every schema: values at the limits are accepted, values beyond them are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/schema.hpp"
#include "core/text.hpp"
#include "support/scratch.hpp"

namespace vrda::every_schema_test {

using Node = core::DocumentValue;
using Table = core::DocumentValue::Table;
using List = core::DocumentValue::List;

constexpr double infinite = std::numeric_limits<double>::infinity();

class Walk {
 public:
  explicit Walk(const std::string& text) : schema_(text), root_(core::parse_json(text, "schema", "JSON")) {}

  int n_accepted = 0, n_refused = 0;

  void run()
  {
    visit(root_, "", [](const core::DocumentValue& value) { return value; });
  }

 private:
  using Put = std::function<core::DocumentValue(const core::DocumentValue&)>;  // the document with
                                                                               // the value inserted

  const Node& dereferenced(const Node& node) const
  {
    const Node* reference = node.find("$ref");
    if (reference == nullptr) return node;
    std::string path = reference->text()->substr(2);
    std::replace(path.begin(), path.end(), '/', '.');
    return core::value_at(root_, path);
  }

  const Node& item_of(const Node& node, std::size_t i) const
  {
    const Node& items = core::value_at(node, "items");
    return items.list() != nullptr ? items.list()->at(i) : items;
  }

  // The smallest value that the schema accepts.
  core::DocumentValue example(const Node& given) const
  {
    const Node& node = dereferenced(given);
    if (const Node* preset = given.find("default"); preset != nullptr && preset->table() == nullptr)
      return *preset;
    if (const Node* shapes = node.find("anyOf")) return example(shapes->list()->front());
    if (const Node* words = node.find("enum")) return words->list()->front();
    const std::string& type = core::text_at(node, "type");
    if (type == "boolean") return {true};
    if (type == "string") return {std::string("a")};
    if (type == "object") return {example_table(node)};
    if (type != "array") return typed(node, example_number(node));
    List items;
    const std::size_t n =
        node.find("minItems") == nullptr ? 0 : static_cast<std::size_t>(core::integer_at(node, "minItems"));
    for (std::size_t i = 0; i < n; ++i) items.push_back(example(item_of(node, i)));
    return {items};
  }

  static core::DocumentValue typed(const Node& node, double value)
  {
    if (core::text_at(node, "type") != "integer") return {value};
    return {static_cast<std::int64_t>(value)};
  }

  static double example_number(const Node& node)
  {
    if (node.find("minimum") != nullptr) return core::number_at(node, "minimum");
    if (node.find("exclusiveMinimum") != nullptr) return core::number_at(node, "exclusiveMinimum") + 1.0;
    return node.find("maximum") != nullptr ? core::number_at(node, "maximum") : 1.0;
  }

  Table example_table(const Node& node) const
  {
    Table table;
    for (const std::string& name : core::texts_at(node, "required"))
      table.push_back({name, example(core::value_at(node, "properties." + name))});
    if (table.empty() && node.find("minProperties") != nullptr) {
      const core::DocumentEntry& first = node.find("properties")->table()->front();
      table.push_back({first.key, example(first.value)});
    }
    return table;
  }

  void accept(const core::DocumentValue& document, const std::string& path)
  {
    ++n_accepted;
    try {
      schema_.checked({"a.toml", document});
    } catch (const InputError& error) {
      ADD_FAILURE() << path << ": " << error.what();
    }
  }

  void refuse(const core::DocumentValue& document, const std::string& path)
  {
    ++n_refused;
    try {
      schema_.checked({"a.toml", document});
      ADD_FAILURE() << path << ": accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.facts().field, path) << error.what();
      EXPECT_NE(error.facts().wanted, "");
    }
  }

  void visit(const Node& given, const std::string& path, const Put& put)
  {
    const Node& node = dereferenced(given);
    accept(put(example(given)), path);
    if (const Node* shapes = node.find("anyOf")) {
      for (const Node& shape : *shapes->list()) accept(put(example(shape)), path);
      refuse(put({true}), path);
      return;
    }
    const std::string& type = core::text_at(node, "type");
    if (type == "object") visit_table(node, path, put);
    if (type == "array") visit_list(node, path, put);
    if (type == "string") visit_text(node, path, put);
    if (type == "number" || type == "integer") visit_number(node, path, put);
    if (type != "boolean") return;
    accept(put({false}), path);
    refuse(put({std::int64_t{1}}), path);
  }

  void visit_number(const Node& node, const std::string& path, const Put& put)
  {
    const bool is_whole = node.find("multipleOf") != nullptr || core::text_at(node, "type") == "integer";
    const auto next = [&](double value, double towards) {
      return is_whole ? value + std::copysign(1.0, towards) : std::nextafter(value, towards);
    };
    const auto limit = [&](const char* key, double outward) {
      if (node.find(key) == nullptr) return;
      accept(put(typed(node, core::number_at(node, key))), path);
      refuse(put(typed(node, next(core::number_at(node, key), outward))), path);
    };
    limit("minimum", -infinite);
    limit("maximum", infinite);
    if (node.find("exclusiveMinimum") != nullptr) {
      const double least = core::number_at(node, "exclusiveMinimum");
      accept(put({std::nextafter(least, infinite)}), path);
      refuse(put({least}), path);
    }
    if (is_whole) refuse(put({example_number(node) + 0.5}), path);
    if (const Node* excluded = node.find("not")) refuse(put(core::value_at(*excluded, "const")), path);
    if (node.find("infinite") == nullptr) refuse(put({infinite}), path);
    refuse(put({1e300}), path);
    refuse(put({-1e300}), path);
    refuse(put({std::string("a word")}), path);
    refuse(put({true}), path);
  }

  void visit_text(const Node& node, const std::string& path, const Put& put)
  {
    for (const Node& word : core::list_or_empty(node, "enum")) accept(put(word), path);
    if (node.find("enum") != nullptr) refuse(put({std::string("no such word")}), path);
    if (node.find("pattern") != nullptr) refuse(put({std::string("not/a name")}), path);
    if (node.find("not") != nullptr) refuse(put({std::string("two\nlines")}), path);
    if (node.find("minLength") != nullptr) refuse(put({std::string()}), path);
    if (node.find("maxLength") != nullptr) {
      const auto most = static_cast<std::size_t>(core::integer_at(node, "maxLength"));
      accept(put({std::string(most, 'x')}), path);
      refuse(put({std::string(most + 1, 'x')}), path);
    }
    refuse(put({3.5}), path);
  }

  void visit_list(const Node& node, const std::string& path, const Put& put)
  {
    const List least = *example_list(node).list();
    const auto of_size = [&](std::size_t n) {
      List items = least;
      const core::DocumentValue item = example(item_of(node, 0));
      while (items.size() < n) items.push_back(item);
      items.resize(n);
      return put({items});
    };
    if (node.find("minItems") != nullptr) refuse(of_size(least.size() - 1), path);
    if (node.find("maxItems") != nullptr && node.find("uniqueItems") == nullptr) {
      const auto most = static_cast<std::size_t>(core::integer_at(node, "maxItems"));
      accept(of_size(most), path);
      refuse(of_size(most + 1), path);
    }
    refuse(put({true}), path);
    for (std::size_t i = 0; i < std::max<std::size_t>(1, least.size()); ++i) {
      visit(item_of(node, i), joined(path, std::to_string(i)), [&](const core::DocumentValue& value) {
        List items = least;
        items.resize(std::max(items.size(), i + 1));
        items[i] = value;
        return put({items});
      });
      if (core::value_at(node, "items").list() == nullptr) break;
    }
  }

  // Without the default, which may have more items than the minimum.
  core::DocumentValue example_list(const Node& node) const
  {
    Table plain = *node.table();
    std::erase_if(plain, [](const core::DocumentEntry& entry) { return entry.key == "default"; });
    return example({plain});
  }

  void visit_table(const Node& node, const std::string& path, const Put& put)
  {
    const Table least = example_table(node);
    const auto with = [&](const std::string& key, const core::DocumentValue& value) {
      Table table = node.find("maxProperties") != nullptr ? Table{} : least;
      std::erase_if(table, [&](const core::DocumentEntry& entry) { return entry.key == key; });
      table.push_back({key, value});
      return put({table});
    };
    if (const Node* others = node.find("additionalProperties");
        others != nullptr && others->table() == nullptr)
      refuse(with("no_such_key", {1.0}), joined(path, "no_such_key"));
    if (!path.empty()) refuse(put({std::int64_t{3}}), path);
    for (const std::string& name : core::texts_at(node, "required")) {
      Table table = least;
      std::erase_if(table, [&](const core::DocumentEntry& entry) { return entry.key == name; });
      refuse(put({table}), joined(path, name));
    }
    const Node* properties = node.find("properties");
    if (properties == nullptr) return;
    for (const core::DocumentEntry& entry : *properties->table()) {
      visit(entry.value, joined(path, entry.key),
            [&](const core::DocumentValue& value) { return with(entry.key, value); });
    }
  }

  static std::string joined(const std::string& path, const std::string& key)
  {
    return path.empty() ? key : path + "." + key;
  }

  core::DocumentSchema schema_;
  Node root_;
};

class EverySchema : public testing::TestWithParam<const char*> {};

TEST_P(EverySchema, TakesEveryKeyAtItsLimitsAndRefusesItBeyond)
{
  Walk walk(test::read_bytes(std::string(VRDA_SCHEMAS "/") + GetParam() + ".schema.json"));
  walk.run();
  EXPECT_GT(walk.n_accepted, 10);
  EXPECT_GT(walk.n_refused, 20);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EverySchema,
                         testing::Values("bench", "calibration", "campaign", "job", "landmarks", "lights",
                                         "wraps"),
                         [](const auto& kind) { return std::string(kind.param); });

}  // namespace vrda::every_schema_test
