/// Checks and escapes for external text, numbers as text, and suggestions for misspelt names.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vrda::inline core {

/// Whether the bytes are UTF-8 (RFC 3629): no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view bytes);

/// Whether the text (UTF-8) contains a control character of ASCII or Latin-1 (U+0080 to U+009F) that is not
/// in `allowed`. Control characters can command a terminal.
bool has_control_characters(std::string_view text, std::string_view allowed = {});

/// The text with each byte of a control character escaped as "\\x1b": one line, safe for a terminal.
std::string escape_control_characters(std::string_view text);

/// The text with <, >, & and " as entities, for HTML and XML, attributes included.
std::string escape_markup(std::string_view text);

/// A string of TOML or JSON: in quotes, with quotes, backslashes and control characters of ASCII escaped.
std::string quoted_text(std::string_view text);
/// A field of CSV in quotes, which are doubled inside.
std::string quoted_csv(std::string_view text);
/// The same only if the text has a comma, a quote or a line end.
std::string csv_field(std::string_view text);

/// `value` in the fewest digits that read back as the same double; -0 gives "0", so that equal numbers give
/// equal text.
std::string shortest_decimal(double value);

/// `value` with `n_digits` significant digits, as printf's %g: "0.145", "1e-05", "nan".
std::string rounded_text(double value, int n_digits = 6);

/// Rounded to this many decimals, without zeros at the end: "0.5".
std::string short_decimal(double value, int most_decimals);

/// shortest_decimal() as a field of a CSV table; empty for a value that is not finite.
std::string csv_number(double value);
/// `value` with `n_decimals` digits after the point: "12.50".
std::string fixed_text(double value, int n_decimals);

/// Levenshtein distance: fewest insertions, deletions and replacements between two words.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `known` nearest to `word`, the first of equals; empty when `known` is empty.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// With the letters A to Z as a to z.
std::string lower_case(std::string text);

/// The text that printf would print.
std::string printed(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// The words with `separator` between them.
std::string joined(const std::vector<std::string>& words, std::string_view separator = ", ");

/// "a, b or c".
std::string join_alternatives(const std::vector<std::string>& words, std::string_view last = " or ");

/// Whether the text can be the name of the key of a sequence of frames ("time_s"): a lower-case letter, then
/// at most 39 lower-case letters, digits and underscores.
bool is_key_name(const std::string& name);

// The two exception types. The commands catch them (pipeline: app, run; player: app, loop); the
// few other handlers are listed in scripts/check_includes (CATCHES), each with its reason.

/// An error that the user can fix. what() is "file: line 3, field: found ..., wanted ...": one printable
/// line; control characters are escaped.
class InputError : public std::runtime_error {
 public:
  struct Facts {
    std::string file;    ///< file, or the command line's option
    std::string field;   ///< key, line or part of the file; may be empty
    std::string found;   ///< the value found
    std::string wanted;  ///< the value required
    int line = 0;        ///< line number in the file; 0: unknown
  };

  explicit InputError(Facts facts);
  const Facts& facts() const { return facts_; }

 private:
  Facts facts_;
};

/// A violated internal invariant: a defect of the program.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws InternalError with `why` unless the condition holds; active in release builds too.
void check(bool condition, const char* why);

}  // namespace vrda::inline core
