#include "core/fields.hpp"

#include <gtest/gtest.h>

#include "core/fields_json.hpp"
#include "core/framed_file.hpp"
#include "support/refusal.hpp"

namespace vrda::fields_test {

enum class Kind : std::int8_t { none = -1, ball = 0, dish = 4 };
inline constexpr Named<Kind> kind_names[] = {
    {Kind::none, "none"}, {Kind::ball, "ball", "a sphere"}, {Kind::dish, "dish"}};
constexpr const auto& names_of(Kind)
{
  return kind_names;
}

struct Turn {
  double angle_rad = 0.0;
  bool operator==(const Turn&) const = default;
};
constexpr auto fields_of(const Turn*)
{
  return std::tuple{Field{"angle_deg", &Turn::angle_rad, unit::radian}};
}
bool is_sound(const Turn& turn)
{
  return turn.angle_rad < 10.0;
}

struct Shape {
  Kind kind = Kind::none;
  Turn turn;
  std::int32_t n = 0;
  bool is_open = false;
  double size_mm = nan;
  std::string name;
  bool operator==(const Shape&) const = default;
};
constexpr auto fields_of(const Shape*)
{
  return std::tuple{Field{"kind", &Shape::kind},
                    Field{"", &Shape::turn},
                    Field{"n", &Shape::n, unit::one, "number of parts", Presence::unless_new},
                    Field{"is_open", &Shape::is_open},
                    Field{"size_mm", &Shape::size_mm, unit::mm},
                    Field{"name", &Shape::name}};
}

struct Cell {
  Kind kind = Kind::none;
  bool is_open = false;
  std::array<double, 2> sizes_mm{};
  std::optional<Turn> turn;
  std::vector<Turn> turns;
};
constexpr auto fields_of(const Cell*)
{
  return std::tuple{Field{"kind", &Cell::kind}, Field{"is_open", &Cell::is_open},
                    Field{"sizes_mm", &Cell::sizes_mm, unit::mm}, Field{"turn", &Cell::turn},
                    Field{"turns", &Cell::turns}};
}

const Shape shape{Kind::dish, {rad_from_deg(45.0)}, 0, true, 2.5, "a \"b\""};

TEST(Fields, NamesAndMeaningsOfAnEnum)
{
  EXPECT_STREQ(name_of(Kind::dish), "dish");
  EXPECT_STREQ(meaning_of(Kind::ball), "a sphere");
  EXPECT_EQ(value_named<Kind>("ball"), Kind::ball);
  EXPECT_EQ(value_named<Kind>("bowl"), std::nullopt);
  EXPECT_THROW(name_of(static_cast<Kind>(2)), InternalError);
}

TEST(Fields, JsonRoundTrip)
{
  const nlohmann::ordered_json json = shape;
  EXPECT_EQ(json.dump(), R"({"kind":"dish","angle_deg":45.0,"is_open":true,"size_mm":2.5,"name":"a \"b\""})");
  EXPECT_EQ(json.get<Shape>(), shape);
  const nlohmann::ordered_json cell = Cell{Kind::ball, false, {1.0, nan}, Turn{}, {}};
  EXPECT_EQ(cell.dump(),
            R"({"kind":"ball","is_open":false,"sizes_mm":[1.0,null],"turn":{"angle_deg":0.0},"turns":[]})");
  EXPECT_EQ(json_columns(std::vector{Cell{}, Cell{}})["kind"].dump(), R"(["none","none"])");
}

// A file that names no field, or a wrong value, is refused by file and key.
TEST(Fields, JsonRefusals)
{
  struct Row {
    const char *text, *field, *found, *wanted;
  };
  const Row rows[] = {
      {R"({"angle_deg":1})", "kind", "nothing", "text"},
      {R"({"kind":"bowl"})", "kind", "bowl", "text"},
      {R"({"kind":"ball","angle_deg":"x"})", "angle_deg", "x", "a number"},
      {R"({"kind":"ball","angle_deg":1,"is_open":true,"size_mm":1,"name":3})", "name", "3", "text"}};
  for (const Row& row : rows) {
    const JsonFile file("a.json", row.text, "a shape");
    EXPECT_THAT(test::input_error([&] { value_in<Shape>(file, "a.json"); }),
                test::refuses({"a.json", row.field, row.found, row.wanted}));
  }
}

TEST(Fields, Csv)
{
  EXPECT_EQ(csv_text(std::vector{shape}), "kind,angle_deg,n,is_open,size_mm,name\ndish,45,0,1,2.5,a \"b\"\n");
}

TEST(Fields, LengthsAreScaled)
{
  Cell cell{Kind::ball, false, {1.0, 2.0}, Turn{3.0}, {}};
  scale_lengths(cell, 2.0);
  EXPECT_EQ(cell.sizes_mm, (std::array{2.0, 4.0}));
  EXPECT_EQ(cell.turn->angle_rad, 3.0);
}

// Journals: every cut and every invalid value is refused, whatever number of elements the bytes claim.
TEST(Fields, Bytes)
{
  const Cell cell{Kind::dish, true, {1.0, nan}, Turn{2.0}, {{3.0}, {4.0}}};
  const std::string bytes = bytes_of_value(cell);
  EXPECT_EQ(bytes.size(), 1 + 1 + 2 * 8 + 1 + 8 + 4 + 2 * 8u);
  const std::optional<Cell> again = value_of_bytes<Cell>(bytes);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(bytes_of_value(*again), bytes);
  EXPECT_EQ(again->turns, cell.turns);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(value_of_bytes<Cell>(bytes.substr(0, size)).has_value()) << size;
  EXPECT_FALSE(value_of_bytes<Cell>(bytes + "x").has_value());
  struct Row {
    const char* what;
    std::size_t at;
    char value;
  };
  for (const Row& row : {Row{"enum", 0, 2}, Row{"flag", 1, 2}, Row{"number of elements", 30, '\x7f'},
                         Row{"unsound", 26, '\x41'}}) {
    std::string damaged = bytes;
    damaged[row.at] = row.value;
    EXPECT_FALSE(value_of_bytes<Cell>(damaged).has_value()) << row.what;
  }
}

}  // namespace vrda::fields_test
