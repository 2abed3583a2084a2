/// What a page of `schemas/` lists, to hold it against the layout in the code.
#pragma once

#include <set>
#include <sstream>
#include <string>

namespace vrda::test {

/// Every path between backquotes in the first column of a table.
inline std::set<std::string> paths_of_page(const std::string& page)
{
  std::set<std::string> paths;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `/", 0) != 0) continue;
    std::istringstream words(line.substr(2, line.find(" |", 2) - 2));
    for (std::string word; std::getline(words, word, '`');) {
      if (!word.empty() && word[0] == '/') paths.insert(word);
    }
  }
  return paths;
}

}  // namespace vrda::test
