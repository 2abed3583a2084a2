#include "settings/settings_table.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::settings_table_test {

constexpr NumberRange range{-1.5, 10.0};
const std::vector<std::string> words{"red", "green"};

TEST(SettingsTable, GivesWhatStandsThere)
{
  const SettingsTable table = SettingsTable::parsed(
      "n = 1.5\nw = 3\nf = true\nt = \"a word\"\nc = \"green\"\nl = [1, 2.5]\nr = [[1, 2], [3, 4]]\n"
      "s = [\"a\", \"b\"]\n[in]\nx = 4\n[[many]]\nx = 5\n[[many]]\nx = 6\n",
      "my.toml");
  EXPECT_EQ(table.number("n", range), 1.5);
  EXPECT_EQ(table.number("w", range), 3.0);
  EXPECT_EQ(table.whole("w", range), 3);
  EXPECT_TRUE(table.flag_or("f", false));
  EXPECT_EQ(table.text("t"), "a word");
  EXPECT_EQ(table.word("c", words), 1u);
  EXPECT_EQ(table.numbers("l", 2, range), (std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(table.rows("r", 2, range), (std::vector<std::vector<double>>{{1, 2}, {3, 4}}));
  EXPECT_EQ(table.texts("s"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(table.table("in").whole("x", range), 4);
  EXPECT_EQ(table.table("in").place_of("x"), "in.x");
  ASSERT_EQ(table.tables("many", 2).size(), 2u);
  EXPECT_EQ(table.tables("many", 2)[1].whole("x", range), 6);
  EXPECT_EQ(table.file(), "my.toml");
}

TEST(SettingsTable, WhatIsLeftOutTakesItsDefault)
{
  const SettingsTable table = SettingsTable::parsed("", "a");
  EXPECT_FALSE(table.has("n"));
  EXPECT_EQ(table.number_or("n", 2.5, range), 2.5);
  EXPECT_EQ(table.whole_or("n", 7, range), 7);
  EXPECT_TRUE(table.flag_or("n", true));
  EXPECT_EQ(table.text_or("n", "otherwise"), "otherwise");
  EXPECT_TRUE(table.tables("n", 1).empty());
}

TEST(SettingsTable, EndsOfARangeBelongToIt)
{
  EXPECT_EQ(SettingsTable::parsed("v = -1.5", "a").number("v", range), -1.5);
  EXPECT_EQ(SettingsTable::parsed("v = 10", "a").whole("v", range), 10);
}

TEST(SettingsTable, WhatIsWrongIsNamed)
{
  using Table = const SettingsTable&;
  const std::string a_number = "a number from -1.5 to 10", a_line = "a line of text in quotes";
  const auto number = [](Table t) { t.number("v", range); };
  const auto whole = [](Table t) { t.whole("v", range); };
  const auto flag = [](Table t) { t.flag_or("v", true); };
  const auto text = [](Table t) { t.text("v"); };
  const auto word = [](Table t) { t.word("v", words); };
  const auto numbers = [](Table t) { t.numbers("v", 2, range); };
  const auto rows = [](Table t) { t.rows("v", 2, range); };
  const auto list = [](Table t) { t.list("v", 2, range); };
  const auto lists = [](Table t) { t.lists("v", 2, 3, range); };
  const auto texts = [](Table t) { t.texts("v"); };
  const auto table = [](Table t) { t.table("v"); };
  const auto tables = [](Table t) { t.tables("v", 2); };
  const std::string up_to_two = "a list of up to 2 numbers from -1.5 to 10";
  const std::string up_to_three = "a list of up to 2 rows, each of up to 3 numbers from -1.5 to 10";
  struct Row {
    std::function<void(Table)> read;
    std::string text, found, wanted;
  };
  for (const Row& row : {
           Row{number, "", "nothing", a_number},
           Row{number, "v = 10.5", "10.5", a_number},
           Row{number, "v = nan", "nan", a_number},
           Row{number, "v = inf", "inf", a_number},
           Row{number, "v = \"3\"", "'3'", a_number},
           Row{number, "[v]\nx = 1", "a table", a_number},
           Row{number, "v = []", "[]", a_number},
           Row{whole, "v = 1.5", "1.5", "a whole number from -1.5 to 10"},
           Row{whole, "v = 11", "11", a_number},
           Row{flag, "v = 1", "1", "true or false"},
           Row{flag, "v = \"true\"", "'true'", "true or false"},
           Row{text, "", "nothing", a_line},
           Row{text, "v = 3", "3", a_line},
           Row{text, "v = \"\"", "''", a_line},
           Row{word, "v = \"blue\"", "'blue'", "one of red, green"},
           Row{word, "v = 0", "0", "one of red, green"},
           Row{word, "", "nothing", "one of red, green"},
           Row{numbers, "v = [1]", "[1]", "2 numbers from -1.5 to 10"},
           Row{numbers, "v = [1, 20]", "[1, 20]", "2 numbers from -1.5 to 10"},
           Row{numbers, "v = [1, \"a\"]", "[1, 'a']", "2 numbers from -1.5 to 10"},
           Row{numbers, "v = 1", "1", "2 numbers from -1.5 to 10"},
           Row{rows, "v = []", "[]", "a list of rows of 2 numbers from -1.5 to 10"},
           Row{rows, "v = [[1, 2], [3]]", "[[ 1, 2 ], [ 3 ]]", "a list of rows of 2 numbers from -1.5 to 10"},
           Row{rows, "v = [1, 2]", "[1, 2]", "a list of rows of 2 numbers from -1.5 to 10"},
           Row{rows, "v = [[1, 11]]", "[[ 1, 11 ]]", "a list of rows of 2 numbers from -1.5 to 10"},
           Row{list, "v = [1, 2, 3]", "[1, 2, 3]", up_to_two},
           Row{list, "v = [nan]", "[nan]", up_to_two},
           Row{list, "v = 1", "1", up_to_two},
           Row{lists, "v = 1", "1", up_to_three},
           Row{lists, "v = [[], [], []]", "3 rows", up_to_three},
           Row{lists, "v = [[1], 2]", "row 2, which is none", up_to_three},
           Row{lists, "v = [[1, 2, 3, 4]]", "row 1, which is none", up_to_three},
           Row{lists, "v = [[11]]", "row 1, which is none", up_to_three},
           Row{texts, "v = [\"a\", 2]", "['a', 2]", "a list of texts in quotes"},
           Row{texts, "v = \"a\"", "'a'", "a list of texts in quotes"},
           Row{texts, "v = [\"\"]", "['']", "a list of texts in quotes"},
           Row{table, "", "nothing", "a table"},
           Row{table, "v = 1", "no table", "a table"},
           Row{tables, "v = 1", "no list", "a list of tables: [[v]]"},
           Row{tables, "v = [1]", "an item that is no table", "a list of tables: [[v]]"},
           Row{tables, "[[v]]\n[[v]]\n[[v]]\n", "3 tables", "at most 2"},
       }) {
    SCOPED_TRACE(row.text);
    const InputError::Facts facts =
        test::input_error([&] { row.read(SettingsTable::parsed(row.text, "my.toml")); });
    EXPECT_EQ(facts.file, "my.toml");
    EXPECT_EQ(facts.field, "v");
    EXPECT_EQ(facts.found, row.found);
    EXPECT_EQ(facts.wanted, row.wanted);
  }
}

TEST(SettingsTable, ListsMayBeShort)
{
  const SettingsTable table = SettingsTable::parsed("a = []\nb = [1]\nc = [[], [1, 2], [3]]", "x");
  EXPECT_TRUE(table.list("a", 2, range).empty());
  EXPECT_EQ(table.list("b", 2, range), std::vector<double>{1.0});
  EXPECT_TRUE(table.lists("a", 2, 2, range).empty());
  EXPECT_EQ(table.lists("c", 3, 2, range), (std::vector<std::vector<double>>{{}, {1.0, 2.0}, {3.0}}));
}

TEST(SettingsTable, TextsAreLinesOfBoundedLength)
{
  const auto read = [](const std::string& value) {
    return SettingsTable::parsed("v = \"" + value + "\"", "a").text("v");
  };
  EXPECT_EQ(read(std::string(4096, 'x')).size(), 4096u);
  for (const std::string& value : {std::string(4097, 'x'), std::string("a\\nb"), std::string("a\\u007F")})
    EXPECT_EQ(test::input_error([&] { read(value); }).field, "v");
}

TEST(SettingsTable, AnUnknownKeyIsToldWithTheNearestOne)
{
  const SettingsTable table = SettingsTable::parsed("[display]\nwidht = 3\n", "a").table("display");
  const InputError::Facts facts = test::input_error([&] { table.require_known({"height", "width"}); });
  EXPECT_EQ(facts.field, "display.widht");
  EXPECT_EQ(facts.found, "an unknown key");
  EXPECT_EQ(facts.wanted, "such a key as width");
  table.require_known({"widht"});
}

TEST(SettingsTable, TablesOfAListAreNamedByTheirNumber)
{
  const SettingsTable table = SettingsTable::parsed("[[v]]\nx = 1\n[[v]]\nx = 20\n", "a");
  const InputError::Facts facts = test::input_error([&] { table.tables("v", 2)[1].number("x", range); });
  EXPECT_EQ(facts.field, "v.1.x");
}

TEST(SettingsTable, FilesThatAreNoneAreRefused)
{
  const test::Scratch scratch;
  const std::string missing = (scratch.path() / "none.toml").string();
  const InputError::Facts facts = test::input_error([&] { SettingsTable::read(missing, "a bench file"); });
  EXPECT_EQ(facts.file, missing);
  EXPECT_EQ(facts.wanted, "a bench file");
  const std::string huge = scratch.write("huge.toml", std::string(8000001, '\n')).string();
  EXPECT_EQ(test::input_error([&] { SettingsTable::read(huge, "x"); }).found, "more than 8000000 bytes");
  const std::string wrong = scratch.write("wrong.toml", "a = 1\nb = = 2\n").string();
  const InputError::Facts syntax = test::input_error([&] { SettingsTable::read(wrong, "x"); });
  EXPECT_EQ(syntax.wanted, "valid TOML");
  EXPECT_EQ(syntax.field.substr(0, 6), "line 2");
  EXPECT_EQ(SettingsTable::read(scratch.write("a.toml", "v = 1").string(), "x").number("v", range), 1.0);
}

}  // namespace vrda::settings_table_test
