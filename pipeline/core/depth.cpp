// The depth of a document, measured on its text: a parser and every tree it builds are recursive.
#include "core/depth.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "core/error.hpp"

namespace vrda::inline core {
namespace {

// A schema has about a dozen levels; a recursive function takes well below a kilobyte of stack for each.
constexpr std::size_t largest_depth = 40;

// Follows keys, headers and brackets only, so the text need not be valid.
class DepthScan {
 public:
  DepthScan(std::string_view text, Syntax syntax) : text_(text), has_headers_(syntax == Syntax::toml)
  {
    is_line_start_ = has_headers_;
    while (at_ < text_.size()) step(text_[at_++]);
  }

  std::size_t deepest() const { return deepest_; }
  int line_of_deepest() const { return line_of_deepest_; }

 private:
  void step(char c)
  {
    const bool is_line_start = is_line_start_;
    is_line_start_ = is_line_start && (c == ' ' || c == '\t');
    switch (c) {
      case '\n':
        end_line();
        break;
      case '#':
        at_ = std::min(text_.find('\n', at_), text_.size());
        break;
      case '"':
      case '\'':
        skip_string(c);
        break;
      case '.':
        ++n_parts_;
        break;
      case '=':
        reach(level_.emplace(level() + n_parts_));
        break;
      case ',':
        begin_key();
        break;
      case '[':
        if (open_.empty() && (is_line_start || n_header_brackets_ > 0)) {
          ++n_header_brackets_;
          begin_key();
        } else {
          open();
        }
        break;
      case '{':
        open();
        break;
      case ']':
      case '}':
        close();
        break;
      default:
        break;
    }
  }

  // Of the table that contains the current key.
  std::size_t level() const { return open_.empty() ? header_level_ : open_.back(); }

  void reach(std::size_t level)
  {
    if (level <= deepest_) return;
    deepest_ = level;
    line_of_deepest_ = line_;
  }

  void begin_key()
  {
    n_parts_ = 1;
    level_.reset();
  }

  void end_line()
  {
    ++line_;
    if (!open_.empty()) return;
    begin_key();
    n_header_brackets_ = 0;
    is_line_start_ = has_headers_;
  }

  void open()
  {
    open_.push_back(level_.value_or(level() + 1));
    reach(open_.back());
    begin_key();
  }

  void close()
  {
    if (n_header_brackets_ > 0) {
      reach(header_level_ = n_parts_ + n_header_brackets_ - 1);
      n_header_brackets_ = 0;
    }
    if (!open_.empty()) open_.pop_back();
    begin_key();
  }

  void skip_string(char quote)
  {
    const std::string three(3, quote);
    const bool is_long = has_headers_ && text_.substr(at_ - 1, 3) == three;
    if (is_long) at_ += 2;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\\' && quote == '"') {
        ++at_;
      } else if (is_long ? text_.substr(at_, 3) == three : text_[at_] == quote || text_[at_] == '\n') {
        break;
      }
      if (at_ < text_.size() && text_[at_] == '\n') ++line_;
    }
    if (is_long) at_ += 3;
    if (!is_long && at_ < text_.size() && text_[at_] == quote) ++at_;
    at_ = std::min(at_, text_.size());
  }

  std::string_view text_;
  bool has_headers_;
  std::size_t at_ = 0;
  int line_ = 1;
  bool is_line_start_ = false;
  std::size_t header_level_ = 0, n_header_brackets_ = 0;  // of the last header; of one that is being read
  std::size_t n_parts_ = 1;                               // of the current key
  std::optional<std::size_t> level_;                      // of the value after "="
  std::vector<std::size_t> open_;                         // levels of the open lists and tables
  std::size_t deepest_ = 0;
  int line_of_deepest_ = 0;
};

[[noreturn]] void refuse(std::size_t levels, const InputError::Facts& where)
{
  throw InputError({where.file, where.field, std::to_string(levels) + " nested keys, lists or tables",
                    "at most " + std::to_string(largest_depth), where.line});
}

}  // namespace

void require_shallow(std::string_view text, const std::string& file, Syntax syntax)
{
  const DepthScan scan(text, syntax);
  if (scan.deepest() > largest_depth) refuse(scan.deepest(), {file, "", "", "", scan.line_of_deepest()});
}

void require_shallow_override(std::string_view key, std::string_view value)
{
  const std::string with_key = "=" + std::string(value);  // a key of one part
  const auto n_dots = static_cast<std::size_t>(std::count(key.begin(), key.end(), '.'));
  const std::size_t levels = n_dots + DepthScan(with_key, Syntax::toml).deepest();
  if (levels > largest_depth) refuse(levels, {"--set", std::string(key.substr(0, key.find('.'))), "", "", 0});
}

}  // namespace vrda::inline core
