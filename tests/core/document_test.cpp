#include <gmock/gmock.h>

#include <limits>

#include "core/document.hpp"
#include "core/schema.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::document_test {

TEST(Document, canonical_toml)
{
  const std::string text = R"(title = "quotes \" and \\, tab \t"
flag = true
numbers = [1, 2.5, 1e-300]

[a.b]
"odd key" = -3

[[list]]
x = 1

[list.inner]
y = "2"

[[list]]
x = 2
)";
  const std::string once = core::toml_text(core::parse_toml(text, "job.toml"));
  EXPECT_EQ(core::toml_text(core::parse_toml(once, "job.toml")), once);
}

TEST(Document, order_of_keys)
{
  const core::DocumentValue root = core::parse_toml(
      "z = 1\n[m.y]\nq.d = 1\nq.c = 2\na = { k = 1, b = 2 }\n[[c]]\nx = 1\n[m.a]\n[[c]]\n[b]\n", "j");
  const auto keys_of = [&](std::string_view key) {
    std::vector<std::string> keys;
    for (const auto& [name, value] : core::value_at(root, key).items()) keys.push_back(name);
    return keys;
  };
  using testing::ElementsAre;
  EXPECT_THAT(keys_of(""), ElementsAre("z", "m", "c", "b"));
  EXPECT_THAT(keys_of("m"), ElementsAre("y", "a"));
  EXPECT_THAT(keys_of("m.y"), ElementsAre("q", "a"));
  EXPECT_THAT(keys_of("m.y.q"), ElementsAre("d", "c"));
  EXPECT_THAT(keys_of("m.y.a"), ElementsAre("k", "b"));
}

TEST(Document, syntax_error)
{
  const InputError::Facts facts =
      test::input_error([] { core::parse_toml("a = 1\nb = = 2\n", "knee.toml"); });
  EXPECT_EQ(facts.file, "knee.toml");
  EXPECT_EQ(facts.field, "line 2, column 5");
  EXPECT_EQ(facts.wanted, "valid TOML");
}

TEST(Document, DatesAndNumbersThatAreNotFiniteAreRefusedWithTheirKey)
{
  EXPECT_EQ(test::input_error([] { core::parse_toml("[a]\nb = 1979-05-27", "j"); }).field, "a.b");
  EXPECT_EQ(test::input_error([] { core::parse_toml("a = [0, nan]", "j"); }).field, "a.1");
}

core::Document small_document()
{
  return core::read_toml("[a]\nb = 1\n[[list]]\nfile = \"x\"\n[[list]]\nfile = \"y\"\n", "job.toml");
}

TEST(Document, line_of_a_refusal)
{
  const core::Document whole = small_document();
  const auto refused = [&](const std::string& key) {
    return test::input_error([&] { whole.refuse(key, "a", "b"); });
  };
  EXPECT_EQ(refused("a.b").line, 2);
  EXPECT_EQ(refused("a.c").line, 1);
  EXPECT_EQ(refused("list.1.file").line, 6);
  EXPECT_EQ(refused("list.2.file").line, 3);
  EXPECT_EQ(refused("list.x").line, 3);
  EXPECT_EQ(refused("").line, 0);
  EXPECT_EQ(test::input_error([&] { whole.refuse_value("list.1", "b"); }).found, "{ file = \"y\" }");
}

TEST(Document, missing_and_huge_files)
{
  const test::Scratch scratch;
  const std::string missing = (scratch.path() / "none.toml").string();
  const InputError::Facts facts =
      test::input_error([&] { core::read_document_text(missing, "a bench file"); });
  EXPECT_EQ(facts.file, missing);
  EXPECT_EQ(facts.wanted, "a bench file");
  const std::string huge = scratch.write("huge.toml", std::string(8000001, '\n')).string();
  EXPECT_THAT(test::input_error([&] { core::read_document_text(huge, "x"); }),
              test::refuses({.found = "8000000"}));
  EXPECT_EQ(core::read_document_text(scratch.write("a.toml", "v = 1").string(), "x"), "v = 1");
}

// A parser or a tree of unlimited depth overflows the stack: 24 kB of one dotted key are enough.
TEST(DocumentDepth, forty_levels)
{
  const auto times = [](int n, const std::string& text) {
    std::string all;
    for (int i = 0; i < n; ++i) all += text;
    return all;
  };
  // `open` and `shut` give one level each; `before` and `between` as many as `fixed`.
  struct Row {
    std::string before, open, between, shut, after;
    int fixed;
  };
  const std::vector<Row> rows{{"x = \"\"\"\n[\"\"\"\n", "a.", "a = 1", "", "", 1},
                              {"\n\n", "\"a.b\" . ", "c = 1", "", "", 1},
                              {"\n# [\n[", "a.", "a]\n", "", "", 1},
                              {"\n\n[[", "a.", "a]]\n", "", "", 2},
                              {"[b.c]\n\n", "a.", "a = 1", "", "", 3},
                              {"\n\nb.c = ", "[", "1", "]", "", 1},
                              {"\n\nb = ", "{a = ", "1", "}", "", 1},
                              {"x = '['\n\n", "a.", "a = [1.5, [2.5]]", "", "", 2},
                              {"x = [1.2, {y.z = 3}]\n\nb = ", "{a = ", "[1]", "}", "", 1}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.before + row.open + row.between);
    const auto text = [&](int levels) {
      const int n = levels - row.fixed;
      return row.before + times(n, row.open) + row.between + times(n, row.shut) + row.after;
    };
    core::parse_toml(text(40), "j.toml");
    for (const int levels : {41, 12'000, 1'000'000}) {
      EXPECT_THAT(test::input_error([&] { core::parse_toml(text(levels), "j.toml"); }),
                  test::refuses({.file = "j.toml",
                                 .found = std::to_string(levels) + " nested keys, lists or tables",
                                 .wanted = "at most 40"}));
    }
  }
  for (const int levels : {41, 1'000'000}) {
    const std::string json =
        "{\"a\": \"[[\",\n\"b\": " + times(levels - 1, "[") + times(levels - 1, "]") + "}";
    EXPECT_THAT(test::input_error([&] { core::parse_json(json, "j.json", "a list"); }),
                test::refuses({.file = "j.json",
                               .field = "line 2",
                               .found = std::to_string(levels) + " nested keys, lists or tables",
                               .wanted = "at most 40"}));
    core::Document job{"j.toml", core::DocumentValue::object()};
    for (const std::string& set :
         {times(levels - 1, "a.") + "a=1", "a.a=" + times(levels - 1, "[") + times(levels - 1, "]")})
      EXPECT_THAT(test::input_error([&] { core::apply_override(job, set); }),
                  test::refuses({"--set", "a", std::to_string(levels) + " nested keys, lists or tables"}));
  }
  core::parse_json(times(40, "[") + times(40, "]"), "j.json", "a list");
}

TEST(Override, replaced_and_added)
{
  core::Document job = small_document();
  core::apply_override(job, "a.b=2.5");
  core::apply_override(job, "a.new={ x = [1, 2] }");
  core::apply_override(job, "list.1.file=meshes/z.stl");
  core::apply_override(job, "fresh.table.word=+X");
  EXPECT_EQ(core::number_at(job.root, "a.b"), 2.5);
  EXPECT_EQ(core::numbers_of(core::value_at(job.root, "a.new.x")), (std::vector<double>{1, 2}));
  EXPECT_EQ(core::text_at(core::value_at(job.root, "list").at(1), "file"), "meshes/z.stl");
  EXPECT_EQ(core::text_at(job.root, "fresh.table.word"), "+X");
  EXPECT_EQ(job.source_of("a.b"), "--set");
  EXPECT_EQ(job.source_of("fresh.table.word"), "--set");
  EXPECT_EQ(job.source_of("list.0.file"), "job.toml");
}

TEST(Override, BadOnesAreRefused)
{
  struct Row {
    const char* given;
    const char* field;
    const char* found;
  };
  const std::vector<Row> rows{{"a.b", "", "a.b"},
                              {"=3", "", "=3"},
                              {"a..b=3", "", "a..b"},
                              {"a.b=", "a.b", "nothing"},
                              {"a.b=[1", "a.b", "[1"},
                              {"a.b.c=3", "a.b.c", "within 1"},
                              {"list.2.file=z", "list.2.file", "\"2\" within a list"},
                              {"list.x.file=z", "list.x.file", "\"x\" within a list"}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.given);
    core::Document job = small_document();
    EXPECT_THAT(test::input_error([&] { core::apply_override(job, row.given); }),
                test::refuses({"--set", row.field, row.found}));
  }
}

TEST(ParseToml, control_characters)
{
  const InputError::Facts facts =
      test::input_error([] { core::parse_toml("[a]\ntitle = \"\\u001b[31mred\"\n", "knee.toml"); });
  EXPECT_EQ(facts.field, "a.title");
  EXPECT_EQ(facts.found, "a text with control characters");
}

constexpr const char* bench_like = R"({
  "type": "object", "additionalProperties": false, "required": ["title"],
  "properties": {
    "title": {"type": "string", "maxLength": 3, "description": "a short title"},
    "display": {
      "type": "object", "additionalProperties": false, "default": {},
      "properties": {
        "width": {"type": "number", "multipleOf": 1.0, "minimum": 16, "maximum": 64, "default": 20},
        "layout": {"type": "string", "enum": ["left", "right"], "default": "left"}
      }
    },
    "force": {"type": "number", "exclusiveMinimum": 0, "default": 2},
    "limit": {"type": "number", "minimum": 1, "infinite": true},
    "flag": {"type": "boolean"},
    "count": {"type": "integer", "maximum": 9},
    "row": {"type": "array", "minItems": 2, "maxItems": 2, "items": [{"type": "number", "minimum": 1}, {"type": "number"}]},
    "names": {"type": "array", "minItems": 1, "maxItems": 3, "items": {"type": "string", "minLength": 1}},
    "turn": {"anyOf": [{"type": "number", "maximum": 5}, {"$ref": "#/definitions/pair"}]},
    "body": {"type": "array", "items": {"$ref": "#/definitions/body"}},
    "code": {"type": "string", "pattern": "^[a-z]+$", "not": {"enum": ["none"]}},
    "set": {"type": "array", "uniqueItems": true, "items": {"type": "number"}},
    "one": {"type": "object", "minProperties": 1, "maxProperties": 1},
    "open": {"type": "object", "additionalProperties": {"type": "number"}}
  },
  "definitions": {
    "pair": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "maximum": 7}},
    "body": {
      "type": "object", "additionalProperties": false, "required": ["tool"],
      "properties": {"tool": {"type": "string"}, "interval": {"type": "number", "default": 1}}
    }
  }
})";

const core::DocumentSchema& schema()
{
  static const core::DocumentSchema parsed(bench_like);
  return parsed;
}

InputError::Facts refused(const std::string& text)
{
  return test::input_error([&] { schema().read(text, "b.toml"); });
}

TEST(DocumentSchema, defaults)
{
  const core::Document document = schema().read("force = 3\ntitle = \"a\"\n[open]\nz = 1\nb = 2\n", "b.toml");
  EXPECT_EQ(core::toml_text(document.root),
            "title = \"a\"\nforce = 3\n\n[display]\nwidth = 20\nlayout = \"left\"\n\n[open]\nb = 2\nz = 1\n");
  EXPECT_TRUE(core::value_at(document.root, "force").is_number_float());
  EXPECT_EQ(core::integer_at(document.root, "display.width"), 20);
  EXPECT_EQ(core::number_at(document.root, "open.z"), 1.0);
}

TEST(DocumentSchema, every_kind_of_fault)
{
  const std::string title = "title = \"a\"\n";
  struct Row {
    std::string text;
    int line;
    std::string field, found, wanted;
  };
  for (const Row& row : {
           // Unknown keys, with the nearest one: in its table, in another one, within a list.
           Row{title + "forces = 1", 2, "forces", "an unknown key", "a known key; the nearest is \"force\""},
           Row{title + "[display]\nwidht = 1", 3, "display.widht", "an unknown key",
               "a known key; the nearest is \"display.width\""},
           Row{title + "layout = 1", 2, "layout", "an unknown key",
               "a known key; the nearest is \"display.layout\""},
           Row{title + "[[body]]\ntool = \"x\"\n[[body]]\ntol = \"y\"", 5, "body.1.tol", "an unknown key",
               "a known key; the nearest is \"body.tool\""},
           // Of two equally near keys the one of the same table.
           Row{title + "[[body]]\ntool = \"x\"\ntole = 1", 4, "body.0.tole", "an unknown key",
               "a known key; the nearest is \"body.tool\""},
           // Missing keys.
           Row{"flag = true", 0, "title", "nothing", "a short title"},
           Row{title + "\n[[body]]", 3, "body.0.tool", "nothing", "a text"},
           // Wrong types.
           Row{"title = 3", 1, "title", "3", "a short title"},
           Row{title + "display = 3", 2, "display", "3", "a table"},
           Row{title + "flag = 1", 2, "flag", "1", "true or false"},
           Row{title + "count = 1.5", 2, "count", "1.5", "a whole number of at most 9"},
           Row{title + "force = \"much\"", 2, "force", "\"much\"", "a number above 0"},
           Row{title + "row = 1", 2, "row", "1", "a list of 2 items, each a number of at least 1"},
           Row{title + "body = 1", 2, "body", "1", "a list of items, each a table"},
           Row{title + "turn = true", 2, "turn", "true",
               "a number of at most 5 or a list of 2 items, each a number of at most 7"},
           // Ranges.
           Row{"title = \"abcd\"", 1, "title", "\"abcd\"", "a short title"},
           Row{title + "force = 0", 2, "force", "0", "a number above 0"},
           Row{title + "display.width = 15", 2, "display.width", "15", "a whole number from 16 to 64"},
           Row{title + "display.width = 65", 2, "display.width", "65", "a whole number from 16 to 64"},
           Row{title + "display.width = 20.5", 2, "display.width", "20.5", "a whole number from 16 to 64"},
           Row{title + "display.layout = \"up\"", 2, "display.layout", "\"up\"", "\"left\" or \"right\""},
           Row{title + "limit = 0.5", 2, "limit", "0.5", "a number of at least 1"},
           Row{title + "names = []", 2, "names", "[]",
               "a list of 1 to 3 items, each a text of at least 1 characters"},
           Row{title + "names = [\n\"\"]", 3, "names.0", "\"\"", "a text of at least 1 characters"},
           Row{title + "row = [1, 2, 3]", 2, "row", "[1, 2, 3]",
               "a list of 2 items, each a number of at least 1"},
           Row{title + "row = [0, 2]", 2, "row.0", "0", "a number of at least 1"},
           Row{title + "turn = [1,\n8]", 3, "turn.1", "8", "a number of at most 7"},
           // Patterns, excluded and repeated values, numbers of keys.
           Row{title + "code = \"a/b\"", 2, "code", "\"a/b\"", "a text"},
           Row{title + "code = \"none\"", 2, "code", "\"none\"", "a text"},
           Row{title + "set = [1, 2, 1]", 2, "set", "[1, 2, 1]", "a list of items, each a number"},
           Row{title + "one = {}", 2, "one", "{}", "a table"},
           Row{title + "[one]\na = 1\nb = 2", 2, "one", "{ a = 1, b = 2 }", "a table"},
           // Numbers that are not finite.
           Row{title + "force = inf", 2, "force", "inf", "a finite number"},
           Row{title + "open.x = -inf", 2, "open.x", "-inf", "a finite number"},
           Row{title + "limit = nan", 2, "limit", "nan", "a number"},
       }) {
    SCOPED_TRACE(row.text);
    const InputError::Facts facts = refused(row.text);
    EXPECT_EQ(facts.file, "b.toml");
    EXPECT_EQ(facts.line, row.line);
    EXPECT_EQ(facts.field, row.field);
    EXPECT_EQ(facts.found, row.found);
    EXPECT_EQ(facts.wanted, row.wanted);
  }
}

TEST(DocumentSchema, infinity)
{
  EXPECT_EQ(core::number_at(schema().read("title = \"a\"\nlimit = inf", "b").root, "limit"),
            std::numeric_limits<double>::infinity());
}

TEST(DocumentSchema, whole_number_with_a_point)
{
  EXPECT_EQ(core::integer_at(schema().read("title = \"a\"\ndisplay.width = 32.0", "b").root, "display.width"),
            32);
}

TEST(DocumentSchema, key_of_an_override)
{
  core::Document document = core::read_toml("title = \"a\"\n[display]\nwidth = 20\n", "b.toml");
  core::apply_override(document, "display.width=5");
  const InputError::Facts facts = test::input_error([&] { schema().checked(document); });
  EXPECT_EQ(facts.file, "--set");
  EXPECT_EQ(facts.field, "display.width");
  EXPECT_EQ(facts.line, 0);
}

TEST(DocumentSchema, part_of_a_file)
{
  const core::Document part{"b.toml", core::parse_toml("widht = 1", "b.toml"), {}, "campaign.size.0.set."};
  EXPECT_THAT(test::input_error([&] { schema().check_known_keys(part); }),
              test::refuses({.field = "campaign.size.0.set.widht"}));
  schema().check_known_keys({"b.toml", core::parse_toml("force = \"of any type\"", "b.toml")});
}

TEST(DocumentSchema, texts_of_any_bytes)
{
  const auto title = [](const std::string& text) { return core::DocumentValue{{"title", text}}; };
  EXPECT_EQ(core::text_at(schema().checked({"b", title("\xff\xfe")}), "title"), "\xff\xfe");
  EXPECT_THAT(test::input_error([&] {
                schema().checked({"b", title("\xff\xff\xff\xff")});
              }),
              test::refuses({.field = "title"}));
}

TEST(DocumentSchema, huge_key)
{
  const std::string key(1'000'000, 'k');
  EXPECT_THAT(refused("title = \"a\"\n" + key + " = 1\n"), test::refuses({.field = "line 2, " + key}));
}

TEST(ParseJson, order_of_keys)
{
  const core::DocumentValue value =
      core::parse_json(R"({"b": [1, -2.5, true], "a": {"x": "y"}, "b2": 1, "b2": 3})", "j", "x");
  EXPECT_EQ(core::value_text(value), "{ b = [1, -2.5, true], a = { x = \"y\" }, b2 = 3 }");
  EXPECT_EQ(core::number_at(core::parse_json("[18446744073709551615]", "j", "x").front(), ""),
            18446744073709551615.0);
}

TEST(ParseJson, InvalidJsonIsRefused)
{
  struct Row {
    std::string text, field, found;
    int line;
  };
  for (const Row& row : {Row{"[1,\n2,,]", "", "invalid JSON", 2}, Row{"", "", "invalid JSON", 1},
                         Row{"[1e999]", "", "a number beyond the range of doubles", 1},
                         Row{R"([1, {"a": null}])", "1.a", "null", 0}}) {
    const InputError::Facts facts =
        test::input_error([&] { core::parse_json(row.text, "j.json", "a list"); });
    EXPECT_EQ(facts.file, "j.json");
    EXPECT_EQ(facts.field, row.field);
    EXPECT_EQ(facts.found, row.found);
    EXPECT_EQ(facts.line, row.line);
    EXPECT_THAT(facts.wanted, testing::AnyOf("a list", "a value"));
  }
}

}  // namespace vrda::document_test
