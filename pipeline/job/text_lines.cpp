#include "job/text_lines.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "job/words.hpp"

namespace vrda::job {
namespace {

constexpr std::string_view separators = " \t\r,";

bool is_letter(char c)
{
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

}  // namespace

bool TextLines::next()
{
  const std::string_view text = source_.text;
  words_.clear();
  while (words_.empty() && at_ < text.size()) {
    const std::size_t end = std::min(text.find('\n', at_), text.size());
    std::string_view line = text.substr(at_, end - at_);
    line = line.substr(0, std::min(line.find('#'), line.size()));
    at_ = end + 1;
    ++line_;
    std::size_t begin = line.find_first_not_of(separators);
    while (begin != std::string_view::npos) {
      const std::size_t stop = std::min(line.find_first_of(separators, begin), line.size());
      words_.push_back(line.substr(begin, stop - begin));
      begin = line.find_first_not_of(separators, stop);
    }
  }
  return !words_.empty();
}

double TextLines::real(std::size_t k, const std::string& wanted) const
{
  const std::optional<double> number = k < words_.size() ? job::parse_real(words_[k]) : std::nullopt;
  if (!number || !std::isfinite(*number)) refuse(shown_word(k), wanted);
  return *number;
}

std::int64_t TextLines::whole(std::size_t k, const std::string& wanted) const
{
  const std::optional<std::int64_t> number =
      k < words_.size() ? job::parse_integer(words_[k]) : std::nullopt;
  if (!number) refuse(shown_word(k), wanted);
  return *number;
}

std::string TextLines::shown_word(std::size_t k) const
{
  return k < words_.size() ? quoted(words_[k]) : "the end of the line";
}

void TextLines::refuse(const std::string& found, const std::string& wanted) const
{
  refuse_at(line_, found, wanted);
}

void TextLines::refuse_at(std::size_t line, const std::string& found, const std::string& wanted) const
{
  throw InputError({source_.file, "line " + std::to_string(std::max<std::size_t>(line, 1)), found, wanted});
}

std::string quoted(std::string_view word)
{
  constexpr std::size_t longest = 40;
  return "\"" + std::string(word.substr(0, longest)) + "\"";
}

bool is_component_name(std::string_view word)
{
  constexpr std::size_t longest = 100;
  if (word.empty() || word.size() > longest || !is_letter(word.front())) return false;
  return std::all_of(word.begin(), word.end(), [](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
  });
}

}  // namespace vrda::job
