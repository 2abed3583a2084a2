/// Matchers of the lines that a program prints, by values instead of wording:
/// EXPECT_THAT(ended.err, reports("knee.h5", {"35", "stable"})) and EXPECT_THAT(ended.err,
/// warns("push.delta")).
#pragma once

#include <sstream>

#include "support/refusal.hpp"

namespace vrda::test {

/// What a test knows of a line "[PROGRAM: ][warning: ]ABOUT: text".
struct Message {
  std::string about = {};  ///< key, option, or a path or its end; empty: not compared
  Values values = {};      ///< numbers, names, commands in the text; the words around them are free
  bool is_warning = false;
};

/// What follows "ABOUT: " where that is at the start, after another part ("FILE: KEY: ") or the end of a
/// path.
inline std::string text_about(const std::string& line, const std::string& about)
{
  const std::string mark = about + ": ";
  for (std::size_t at = line.find(mark); at != std::string::npos; at = line.find(mark, at + 1)) {
    const std::string before = line.substr(at < 2 ? 0 : at - 2, std::min<std::size_t>(at, 2));
    if (at == 0 || before.ends_with('/') || before == ": " || before == ", ")
      return line.substr(at + mark.size());
  }
  return "";
}

inline bool is_line(const std::string& line, const Message& expected)
{
  if (expected.is_warning && line.find("warning: ") != 0) return false;
  const std::string text = expected.about.empty() ? line : text_about(line, expected.about);
  return !text.empty() && names_all(text, expected.values);
}

MATCHER_P(has_line, expected,
          "has a line about \"" + expected.about + "\" that names " +
              testing::PrintToString(expected.values.all))
{
  std::istringstream lines(arg);
  for (std::string line; std::getline(lines, line);) {
    if (is_line(line, expected)) return true;
  }
  return false;
}

/// A line of any kind.
inline auto reports(std::string about, Values values = {})
{
  return has_line(Message{std::move(about), std::move(values)});
}

inline auto warns(std::string about, Values values = {})
{
  return has_line(Message{std::move(about), std::move(values), true});
}

}  // namespace vrda::test
