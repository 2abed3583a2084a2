#include "tables/motion_convention.hpp"

#include "core/error.hpp"

namespace vrda::tables {

std::string length_unit_name(double length_mm)
{
  return length_mm == 1000.0 ? "m" : length_mm == 10.0 ? "cm" : "mm";
}

const char* name_of(AngleUnit unit)
{
  return unit == AngleUnit::degrees ? "deg" : "rad";
}

const char* name_of(AngleOrder order)
{
  switch (order) {
    case AngleOrder::xyz:
      return "xyz";
    case AngleOrder::xzy:
      return "xzy";
    case AngleOrder::yxz:
      return "yxz";
    case AngleOrder::yzx:
      return "yzx";
    case AngleOrder::zxy:
      return "zxy";
    case AngleOrder::zyx:
      return "zyx";
  }
  throw InternalError("an order of angles without a name");
}

const char* name_of(Direction direction)
{
  return direction == Direction::moving_in_reference ? "moving-in-reference" : "reference-in-moving";
}

const char* name_of(TableAxes axes)
{
  return axes == TableAxes::canonical ? "canonical" : "files";
}

const char* name_of(LengthPoint point)
{
  switch (point) {
    case LengthPoint::origin:
      return "origin";
    case LengthPoint::centre:
      return "centre";
    case LengthPoint::grood_suntay:
      return "grood-suntay";
  }
  throw InternalError("a point of lengths without a name");
}

const char* name_of_side(Side side)
{
  return side == Side::left ? "left" : "right";
}

std::optional<AngleUnit> angle_unit_named(const std::string& word)
{
  for (const AngleUnit unit : {AngleUnit::degrees, AngleUnit::radians})
    if (word == name_of(unit)) return unit;
  return std::nullopt;
}

std::map<std::string, std::string> names_by_coordinate(const std::string& command, const std::string& option,
                                                       const std::vector<std::string>& texts)
{
  std::map<std::string, std::string> names;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const bool has_sign = equals != std::string::npos && text.find_first_of("+-", equals) == equals + 1;
    if (equals == std::string::npos || equals == 0 || equals + (has_sign ? 2 : 1) >= text.size())
      throw InputError({command, option, text, "COORDINATE=NAME, such as flexion=knee_angle_r"});
    if (!names.emplace(text.substr(0, equals), text.substr(equals + 1)).second)
      throw InputError({command, option, text.substr(0, equals) + " twice", "once"});
  }
  return names;
}

Convention completed(const StatedConvention& stated, const StatedConvention& file, Side joint_side)
{
  const auto chosen = [](const auto& first, const auto& second, auto otherwise) {
    return first ? *first : second.value_or(otherwise);
  };
  const Convention standard;
  return {chosen(stated.length_mm, file.length_mm, standard.length_mm),
          chosen(stated.angles, file.angles, standard.angles),
          chosen(stated.order, file.order, standard.order),
          chosen(stated.direction, file.direction, standard.direction),
          chosen(stated.axes, file.axes, standard.axes),
          chosen(stated.side, file.side, joint_side),
          chosen(stated.lengths, file.lengths, standard.lengths)};
}

}  // namespace vrda::tables
