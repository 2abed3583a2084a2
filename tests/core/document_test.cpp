#include "core/document.hpp"

#include <gmock/gmock.h>

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

core::Document document()
{
  return core::read_toml("[a]\nb = 1\n[[list]]\nfile = \"x\"\n[[list]]\nfile = \"y\"\n", "job.toml");
}

TEST(Document, line_of_a_refusal)
{
  const core::Document whole = document();
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
  core::Document job = document();
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
    core::Document job = document();
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

}  // namespace vrda::document_test
