/// A table of a TOML file, whose values are checked as they are read.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vrda {

/// No length or coordinate of a bench is larger.
inline constexpr double largest_mm = 1e5;

/// The text of a file of settings. Throws InputError when there is none or it is longer than such files are;
/// `what` completes "wanted ...".
std::string settings_file_text(const std::string& path, const std::string& what);

/// Inclusive.
struct NumberRange {
  double least = 0.0, most = 0.0;
};

/// Every method throws InputError naming file and key when what stands there is not what it returns. Copies
/// share the file.
class SettingsTable {
 public:
  /// `what` completes "wanted ..." when there is no such file.
  static SettingsTable read(const std::string& path, const std::string& what);
  /// The same from the text of a file; `name` is for errors.
  static SettingsTable parsed(const std::string& text, const std::string& name);

  /// Throws for the first key that is none of `names`.
  void require_known(std::initializer_list<const char*> names) const;
  bool has(std::string_view name) const;

  double number(std::string_view name, const NumberRange& range) const;
  double number_or(std::string_view name, double otherwise, const NumberRange& range) const;
  int whole(std::string_view name, const NumberRange& range) const;
  int whole_or(std::string_view name, int otherwise, const NumberRange& range) const;
  bool flag_or(std::string_view name, bool otherwise) const;
  /// Not empty, of at most 4,096 bytes, without control characters.
  std::string text(std::string_view name) const;
  std::string text_or(std::string_view name, const std::string& otherwise) const;
  /// Index of the word in `words`.
  std::size_t word(std::string_view name, const std::vector<std::string>& words) const;
  /// As many numbers as `n`.
  std::vector<double> numbers(std::string_view name, std::size_t n, const NumberRange& range) const;
  /// A list of rows of `n` numbers each; at least one row.
  std::vector<std::vector<double>> rows(std::string_view name, std::size_t n, const NumberRange& range) const;
  /// A list of any length up to `most`.
  std::vector<double> list(std::string_view name, std::size_t most, const NumberRange& range) const;
  /// A list of up to `most` rows, each of up to `most_across` numbers.
  std::vector<std::vector<double>> lists(std::string_view name, std::size_t most, std::size_t most_across,
                                         const NumberRange& range) const;
  std::vector<std::string> texts(std::string_view name) const;

  SettingsTable table(std::string_view name) const;
  /// A list of tables, [[name]]; empty when there is none. Throws when there are more than `most`.
  std::vector<SettingsTable> tables(std::string_view name, std::size_t most) const;

  /// "display.layout": the key's place in the file.
  std::string place_of(std::string_view name) const;
  const std::string& file() const;
  [[noreturn]] void refuse(std::string_view name, const std::string& found, const std::string& wanted) const;

 private:
  struct File;
  struct Node;
  SettingsTable(std::shared_ptr<const File> file, std::shared_ptr<const Node> node);

  std::shared_ptr<const File> file_;
  std::shared_ptr<const Node> node_;
};

}  // namespace vrda
