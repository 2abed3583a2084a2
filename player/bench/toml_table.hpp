/// One list of fields for reading and writing a TOML table: a function calls `visit(key, member)` for each
/// key, where `visit` is a TableReader or a TableWriter. The documents are schema-checked, so that every
/// required key is there with its type.
#pragma once

#include <Eigen/Core>

#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

#include "core/document.hpp"
#include "core/units.hpp"
#include "show/session.hpp"
#include "view/eye.hpp"

namespace vrda::bench {

/// Sets members from the keys of a table.
class TableReader {
 public:
  explicit TableReader(const core::DocumentValue& table) : table_(table) {}

  /// `comment`: for the writer.
  template <typename Member>
  void operator()(const char* key, Member& member, const char* /*comment*/ = "") const
  {
    if constexpr (std::is_same_v<Member, bool>) {
      member = core::flag_at(table_, key);
    } else if constexpr (std::is_integral_v<Member>) {
      member = static_cast<Member>(core::integer_at(table_, key));
    } else if constexpr (std::is_same_v<Member, double>) {
      member = core::number_at(table_, key);
    } else if constexpr (std::is_same_v<Member, std::string>) {
      member = core::text_at(table_, key);
    } else if constexpr (std::is_same_v<Member, std::vector<std::string>>) {
      member = core::texts_at(table_, key);
    } else if constexpr (std::is_same_v<Member, std::vector<double>>) {
      member = core::numbers_at(table_, key);
    } else if constexpr (std::is_same_v<Member, std::vector<std::vector<double>>>) {
      member = core::rows_at(table_, key);
    } else if constexpr (std::is_same_v<Member, view::Viewport>) {
      const std::vector<double> v = core::numbers_at(table_, key);
      member = {static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]),
                static_cast<int>(v[3])};
    } else {
      member = Member::Map(core::numbers_at(table_, key).data());  // a vector of fixed size
    }
  }
  /// Degrees in the file, radians in the program: a number or a vector.
  template <typename Angle>
  void degrees(const char* key, Angle& angle_rad) const
  {
    (*this)(key, angle_rad);
    angle_rad *= rad_from_deg(1.0);
  }
  /// A key that may be missing.
  template <typename Member>
  void optional(const char* key, Member& member, const char* /*comment*/ = "") const
  {
    if (table_.contains(key)) (*this)(key, member);
  }

 private:
  const core::DocumentValue& table_;
};

/// Writes "key = value  # comment" for each member.
class TableWriter {
 public:
  explicit TableWriter(std::ostream& out) : out_(out) {}

  template <typename Member>
  void operator()(const char* key, const Member& member, const char* comment = "") const
  {
    out_ << key << " = " << text_of(member) << (*comment == '\0' ? "" : "  # ") << comment << "\n";
  }
  template <typename Angle>
  void degrees(const char* key, const Angle& angle_rad) const
  {
    (*this)(key, Angle(angle_rad / rad_from_deg(1.0)));
  }
  /// Only if the member is not empty, or true.
  template <typename Member>
  void optional(const char* key, const Member& member, const char* comment = "") const
  {
    if (member != Member()) (*this)(key, member, comment);
  }

 private:
  template <typename Member>
  static std::string text_of(const Member& member)
  {
    if constexpr (std::is_same_v<Member, bool>) {
      return member ? "true" : "false";
    } else if constexpr (std::is_integral_v<Member>) {
      return std::to_string(member);
    } else if constexpr (std::is_same_v<Member, double>) {
      return show::number_text(member);
    } else if constexpr (std::is_same_v<Member, std::string>) {
      return core::quoted_text(member);
    } else if constexpr (std::is_same_v<Member, std::vector<std::string>>) {
      return list_of(member, ", ");
    } else if constexpr (std::is_same_v<Member, std::vector<std::vector<double>>>) {
      return list_of(member, ",\n  ");
    } else if constexpr (std::is_same_v<Member, view::Viewport>) {
      return list_of(std::vector<int>{member.x, member.y, member.width, member.height}, ", ");
    } else {
      return show::list_text({member.data(), static_cast<std::size_t>(member.size())});
    }
  }
  template <typename Item>
  static std::string list_of(const std::vector<Item>& items, const char* separator)
  {
    std::string text = "[";
    for (const Item& item : items) text += (text.size() > 1 ? separator : "") + text_of(item);
    return text + "]";
  }

  std::ostream& out_;
};

}  // namespace vrda::bench
