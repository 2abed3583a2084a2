#include "tables/table_header.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/words.hpp"

namespace vrda::tables {
namespace {

constexpr double largest_coordinate_mm = 1e9;

enum class Key { in_degrees, translations, rotation_centre, key, negated };

struct KeyName {
  Key key;
  const char* written;  ///< as `vrda export` writes it
  const char* plain;    ///< plain_word() of it
};
constexpr KeyName key_names[] = {{Key::in_degrees, "inDegrees", "indegrees"},
                                 {Key::translations, "translations", "translations"},
                                 {Key::rotation_centre, "rotation_centre_mm", "rotationcentremm"},
                                 {Key::rotation_centre, "rotation_centre_mm", "rotationcentermm"},
                                 {Key::key, "key", "key"},
                                 {Key::negated, "negated", "negated"}};

/// Letters and digits alone, in lower case: "indegrees" of " In_Degrees".
std::string plain_word(std::string_view text)
{
  std::string word;
  for (const char c : text) {
    if (c >= 'A' && c <= 'Z') word += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) word += c;
  }
  return word;
}

/// Without the marks around it: quotes, and the separators that a spreadsheet appends.
std::string_view bare_value(std::string_view text)
{
  constexpr std::string_view marks = " \t\r\"';,";
  const std::size_t first = text.find_first_not_of(marks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(marks) - first + 1);
}

/// "No" is a truth value; "-1" and "n/o" are not.
std::optional<bool> truth_of(std::string_view text)
{
  const std::string word = plain_word(text);
  if (word.size() != bare_value(text).size()) return std::nullopt;
  for (const char* yes : {"yes", "y", "true", "t", "1", "on"})
    if (word == yes) return true;
  for (const char* no : {"no", "n", "false", "f", "0", "off"})
    if (word == no) return false;
  return std::nullopt;
}

std::optional<LengthPoint> point_named(std::string_view value)
{
  const std::string word = plain_word(value);
  for (const char* centre : {"rotationcentre", "rotationcenter", "centre", "center"})
    if (word == centre) return LengthPoint::centre;
  for (const char* origin : {"meshorigin", "origin"})
    if (word == origin) return LengthPoint::origin;
  return std::nullopt;
}

/// The words of a list, separated by blanks and `marks`.
std::vector<std::string> list_of(std::string value, std::string_view marks)
{
  for (char& c : value)
    if (marks.find(c) != std::string_view::npos) c = ' ';
  const std::vector<std::string_view> words = job::split_words(value);
  return {words.begin(), words.end()};
}

std::optional<Eigen::Vector3d> point_of(const std::string& value)
{
  std::vector<double> mm;
  for (const std::string& word : list_of(value, ",;()[]"))
    mm.push_back(job::parse_real(word).value_or(HUGE_VAL));
  if (mm.size() != 3 || !(Eigen::Map<Eigen::Array3d>(mm.data()).abs() <= largest_coordinate_mm).all())
    return {};
  return Eigen::Vector3d(mm[0], mm[1], mm[2]);
}

/// A line that may state something.
struct Statement {
  std::size_t line = 0;
  std::string key, value;  ///< as written, trimmed
  bool is_comment = false;
  bool has_equals = false;
};

/// Text in which a program finds no value.
bool is_comment(std::string_view trimmed)
{
  return trimmed.starts_with("//") ||
         (!trimmed.empty() && std::string_view("#%;!").find(trimmed[0]) != std::string_view::npos);
}

/// Empty for text. Without "=" or ":" only a line that begins with inDegrees is one ("inDegrees yes").
std::optional<Statement> statement_of(std::string_view line, std::size_t number)
{
  line = job::trimmed(line);
  Statement statement;
  statement.line = number;
  statement.is_comment = is_comment(line);
  std::size_t at = line.find('=');
  statement.has_equals = at != std::string_view::npos;
  if (at == std::string_view::npos) at = line.find(':');
  if (at == std::string_view::npos) {
    if (!plain_word(line).starts_with(key_names[0].plain)) return {};
    at = line.find_first_of(" \t,;");
    if (at == std::string_view::npos || !truth_of(line.substr(at))) {
      statement.key = std::string(line);
      return statement;
    }
  }
  statement.key = std::string(bare_value(line.substr(0, at)));
  statement.value = std::string(bare_value(line.substr(at + 1)));
  return statement;
}

/// Of an unknown key: whether it may be meant to state the unit of angles.
bool is_about_angles(const Statement& statement)
{
  const std::string key = plain_word(statement.key), value = plain_word(statement.value);
  for (const char* unit : {"deg", "degree", "degrees", "rad", "radian", "radians"})
    if (value == unit) return true;
  return key.find("degree") != std::string::npos || key.find("radian") != std::string::npos ||
         (truth_of(statement.value) && (key == "indeg" || key == "inrad")) ||
         value.find(key_names[0].plain) != std::string::npos;
}

/// The name that `word` is but for a typing slip; a short name has fewer.
const KeyName* slip_of(const std::string& word)
{
  for (const KeyName& name : key_names) {
    const std::string_view plain = name.plain;
    if (edit_distance(word, plain) <= (plain.size() < 6 ? 1u : 2u)) return &name;
  }
  return nullptr;
}

class HeaderReader {
 public:
  explicit HeaderReader(std::string file) : file_(std::move(file)) {}

  void take(const Statement& s)
  {
    const std::string word = plain_word(s.key);
    const auto* name = std::find_if(std::begin(key_names), std::end(key_names),
                                    [&](const KeyName& known) { return word == known.plain; });
    if (name == std::end(key_names)) {
      const KeyName* meant = s.is_comment ? nullptr : slip_of(word);
      if (meant) warn(s, "is not used: no such key; " + std::string(meant->written) + " is one");
      if (!meant && is_about_angles(s)) unused_units_.push_back(s);
      return;
    }
    const auto before = stated_.find(name->key);
    if (s.is_comment) {  // states the unit if no other line does
      if (name->key != Key::in_degrees || before != stated_.end() || !truth_of(s.value)) return;
      warn(s, "is a comment, read as " + std::string(name->written) + "=" + s.value);
    } else if (!s.has_equals && name->key != Key::in_degrees) {  // text
      return warn(s, "is not used without \"=\": " + std::string(name->written) + "=VALUE");
    }
    const std::string meaning = set(*name, s);
    if (before != stated_.end() && before->second.meaning != meaning) {
      refuse(*name, s,
             '"' + s.value + "\" after another value in line " + std::to_string(before->second.line),
             "one value");
    }
    stated_.emplace(name->key, Stated{s.line, meaning});
  }

  TableHeader finish()
  {
    if (!header_.angles) {
      for (const Statement& s : unused_units_)
        warn(s, "is not used: a line inDegrees=yes or inDegrees=no states the unit of angles");
    }
    return std::move(header_);
  }

 private:
  struct Stated {
    std::size_t line;
    std::string meaning;
  };

  void warn(const Statement& s, const std::string& what)
  {
    header_.warnings.push_back(file_ + ": line " + std::to_string(s.line) + ": \"" + s.key + "\" " + what);
  }

  [[noreturn]] void refuse(const KeyName& name, const Statement& s, const std::string& found,
                           const std::string& wanted) const
  {
    throw InputError({file_, name.written, found, wanted, static_cast<int>(s.line)});
  }

  /// Stores the value; returns its meaning, equal for values that mean the same.
  std::string set(const KeyName& name, const Statement& s)
  {
    const std::string found = '"' + s.value + '"';
    switch (name.key) {
      case Key::in_degrees: {
        const std::optional<bool> is_true = truth_of(s.value);
        if (!is_true) refuse(name, s, found, "yes or no");
        header_.angles = *is_true ? AngleUnit::degrees : AngleUnit::radians;
        return name_of(*header_.angles);
      }
      case Key::translations:
        header_.lengths = point_named(s.value);
        if (!header_.lengths) refuse(name, s, found, "rotation-centre or mesh-origin");
        return name_of(*header_.lengths);
      case Key::rotation_centre: {
        header_.point_mm = point_of(s.value);
        if (!header_.point_mm) refuse(name, s, found, "three numbers of magnitude up to 1e9");
        const Eigen::Vector3d& p = *header_.point_mm;
        return shortest_decimal(p.x()) + " " + shortest_decimal(p.y()) + " " + shortest_decimal(p.z());
      }
      case Key::key:
        if (s.value.empty()) refuse(name, s, "nothing", "the name of the key");
        header_.key_name = s.value;
        return s.value;
      case Key::negated:
        header_.negated_columns = list_of(s.value, ",;");
        return s.value;
    }
    throw InternalError("a key of a header without a meaning");
  }

  std::string file_;
  TableHeader header_;
  std::map<Key, Stated> stated_;
  std::vector<Statement> unused_units_;
};

}  // namespace

TableHeader table_header(const std::string& file, std::string_view text, std::size_t end_line)
{
  std::vector<Statement> statements;
  for (std::size_t number = 1; number < end_line; ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (const auto statement = statement_of(text.substr(0, end), number)) statements.push_back(*statement);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  std::stable_partition(statements.begin(), statements.end(),
                        [](const Statement& s) { return !s.is_comment; });
  HeaderReader reader(file);
  for (const Statement& statement : statements) reader.take(statement);
  return reader.finish();
}

}  // namespace vrda::tables
