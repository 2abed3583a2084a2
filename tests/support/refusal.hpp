/// A matcher of refusals by their values: EXPECT_THAT(input_error(action), refuses({.field = "grid.varus"}))
/// and EXPECT_THAT(run(command), refuses({.file = "a.toml", .field = "grid.varus", .found = "3"})).
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "support/input_error.hpp"
#include "support/process.hpp"

namespace vrda::inline core {

inline void PrintTo(const InputError::Facts& facts, std::ostream* out)
{
  *out << InputError(facts).what();
}

}  // namespace vrda::inline core

namespace vrda::test {

inline void PrintTo(const Ended& ended, std::ostream* out)
{
  *out << "exit code " << ended.exit_code << ", standard error:\n" << ended.err;
}

/// One value or a list of them.
struct Values {
  Values() = default;
  Values(const char* value) : all{value} {}
  Values(std::string value) : all{std::move(value)} {}
  Values(std::initializer_list<std::string> values) : all(values) {}
  std::vector<std::string> all = {};
};

/// What a test knows of a refusal. `found` and `wanted` are values, limits and names of keys, not sentences:
/// the wording around them is free.
struct Refusal {
  std::string file = {};   ///< path or its end, or the option; empty: not compared
  std::string field = {};  ///< whole, with its line ("line 3, name") or without
  Values found = {};       ///< values in the text
  Values wanted = {};      ///< the same
  int exit_code = 2;       ///< of a program
};

/// True if the text contains the value, not only a longer number or word that contains it.
inline bool names_value(const std::string& text, const std::string& value)
{
  const auto joins = [](char a, char b) {
    const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    return (is_word(a) && is_word(b)) || ((a == '-' || a == '.') && is_digit(b)) || (is_digit(a) && b == '.');
  };
  for (std::size_t at = text.find(value); at != std::string::npos; at = text.find(value, at + 1)) {
    const std::size_t end = at + value.size();
    const bool is_joined = !value.empty() && ((at > 0 && joins(text[at - 1], value.front())) ||
                                              (end < text.size() && joins(value.back(), text[end])));
    if (!is_joined) return true;
  }
  return false;
}

inline bool names_all(const std::string& text, const Values& values)
{
  return std::all_of(values.all.begin(), values.all.end(),
                     [&](const std::string& value) { return names_value(text, value); });
}

/// The parts of the last line "PROGRAM: FILE: line 3, FIELD: found X, wanted Y" of a program's standard
/// error; a line without "found" is its `found`.
inline InputError::Facts printed_facts(const std::string& said)
{
  // Removes and returns the text after the separator.
  const auto cut = [](std::string& text, const std::string& separator, std::size_t at) {
    const std::string rest = at == std::string::npos ? "" : text.substr(at + separator.size());
    text.erase(std::min(at, text.size()));
    return rest;
  };
  std::string text = said.substr(0, said.empty() ? 0 : said.size() - 1),
              line = text.substr(text.rfind('\n') + 1);
  std::string place = cut(line, ": ", line.find(": "));
  InputError::Facts facts;
  facts.found = cut(place, ": found ", place.find(": found "));
  if (facts.found.empty()) return {"", "", place, "", 0};
  facts.wanted = cut(facts.found, ", wanted ", facts.found.rfind(", wanted "));
  facts.field = cut(place, ": ", place.rfind(": "));
  facts.file = place;
  return facts;
}

/// "name" of "line 3, name".
inline std::string without_line(const std::string& place)
{
  if (!place.starts_with("line ")) return place;
  const std::size_t end = place.find(", ");
  return end == std::string::npos ? "" : place.substr(end + 2);
}

class RefusalMatcher {
 public:
  using is_gtest_matcher = void;
  explicit RefusalMatcher(Refusal expected) : expected_(std::move(expected)) {}

  bool MatchAndExplain(const InputError::Facts& facts, std::ostream* out) const
  {
    const std::string line = facts.line > 0 ? "line " + std::to_string(facts.line) : "";
    const std::string place = line + (line.empty() || facts.field.empty() ? "" : ", ") + facts.field;
    const auto differs = [&](bool is_same, const char* part, const std::string& actual) {
      if (!is_same && out != nullptr) *out << "whose " << part << " is " << testing::PrintToString(actual);
      return !is_same;
    };
    return !(differs(expected_.file.empty() || facts.file == expected_.file ||
                         facts.file.ends_with("/" + expected_.file),
                     "file", facts.file) ||
             differs(expected_.field == place || expected_.field == without_line(place), "field", place) ||
             differs(names_all(facts.found, expected_.found), "found", facts.found) ||
             differs(names_all(facts.wanted, expected_.wanted), "wanted", facts.wanted));
  }
  bool MatchAndExplain(const Ended& ended, std::ostream* out) const
  {
    if (ended.exit_code == expected_.exit_code) return MatchAndExplain(printed_facts(ended.err), out);
    if (out != nullptr) *out << "whose exit code is " << ended.exit_code;
    return false;
  }
  void DescribeTo(std::ostream* out) const
  {
    *out << "refuses file \"" << expected_.file << "\", field \"" << expected_.field << "\", found "
         << testing::PrintToString(expected_.found.all) << ", wanted "
         << testing::PrintToString(expected_.wanted.all) << ", exit code " << expected_.exit_code;
  }
  void DescribeNegationTo(std::ostream* out) const
  {
    *out << "not: ";
    DescribeTo(out);
  }

 private:
  Refusal expected_;
};

inline RefusalMatcher refuses(Refusal expected)
{
  return RefusalMatcher(std::move(expected));
}

}  // namespace vrda::test
