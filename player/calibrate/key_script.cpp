#include "calibrate/key_script.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "core/error.hpp"
#include "view/arguments.hpp"

namespace vrda {
namespace {

constexpr int most_presses = 10000;
constexpr double longest_s = 3600.0;

struct Where {
  const std::string& path;
  std::size_t line;
};

[[noreturn]] void refuse(const Where& where, const std::string& found, const std::string& wanted)
{
  throw InputError({where.path, "line " + std::to_string(where.line), "\"" + found + "\"", wanted});
}

std::optional<Key> key_named(const std::string& name)
{
  constexpr std::array<std::pair<const char*, Key>, 8> named{{{"Enter", Key::enter},
                                                              {"Backspace", Key::backspace},
                                                              {"Escape", Key::escape},
                                                              {"Space", Key::space},
                                                              {"Left", Key::left},
                                                              {"Right", Key::right},
                                                              {"Up", Key::up},
                                                              {"Down", Key::down}}};
  for (const auto& [known, key] : named)
    if (name == known) return key;
  const bool is_one = name.size() == 1;
  if (is_one && ((name[0] >= 'A' && name[0] <= 'Z') || (name[0] >= '0' && name[0] <= '9')))
    return key_of(name[0]);
  return std::nullopt;
}

KeyPress parsed_press(const std::string& text, const Where& where)
{
  KeyPress press;
  std::vector<std::string> parts = split(text, '+');
  const std::optional<Key> key = key_named(parts.back());
  if (!key)
    refuse(where, text, "a key: a capital letter, a digit, Enter, Backspace, Escape, Space, Left, ...");
  press.key = *key;
  parts.pop_back();
  for (const std::string& part : parts) {
    bool& has = part == "Shift" ? press.has_shift : press.has_control;
    if ((part != "Shift" && part != "Control") || has)
      refuse(where, text, "Shift+ or Control+ before the key");
    has = true;
  }
  return press;
}

template <typename Number>
Number parsed_number(const std::string& text, const Where& where, Number most, const char* wanted)
{
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = error == std::errc() && end == text.data() + text.size();
  if (!is_whole || !(value > Number{0} && value <= most)) refuse(where, text, wanted);
  return value;
}

ScriptLine parsed_line(const std::vector<std::string>& words, const Where& where)
{
  ScriptLine line;
  if (words[0] == "press" && (words.size() == 2 || words.size() == 3)) {
    line.press = parsed_press(words[1], where);
    line.n_presses = words.size() == 2 ? 1 : parsed_number(words[2], where, most_presses, "1 to 10000 times");
  } else if (words[0] == "wait" && words.size() == 2) {
    line.wait_s = parsed_number(words[1], where, longest_s, "seconds above 0, up to 3600");
  } else {
    std::string whole;
    for (const std::string& word : words) whole += (whole.empty() ? "" : " ") + word;
    refuse(where, whole, "\"press KEY\", \"press KEY TIMES\" or \"wait SECONDS\"");
  }
  return line;
}

}  // namespace

std::vector<ScriptLine> parsed_key_script(const std::string& text, const std::string& path)
{
  std::vector<ScriptLine> lines;
  std::istringstream all(text);
  std::size_t number = 0;
  for (std::string row; std::getline(all, row);) {
    ++number;
    std::istringstream rest(row.substr(0, row.find('#')));
    std::vector<std::string> words;
    for (std::string word; rest >> word;) words.push_back(word);
    if (!words.empty()) lines.push_back(parsed_line(words, {path, number}));
  }
  return lines;
}

const std::vector<KeyPress>& KeyScript::keys(double now_s)
{
  keys_.clear();
  if (is_over()) return keys_;
  const ScriptLine& line = lines_[next_];
  if (line.n_presses > 0) {
    keys_.assign(static_cast<std::size_t>(line.n_presses), line.press);
    ++next_;
  } else if (begun_s_ < 0.0) {
    begun_s_ = now_s;
  } else if (now_s - begun_s_ >= line.wait_s) {
    begun_s_ = -1.0;
    ++next_;
  }
  return keys_;
}

}  // namespace vrda
