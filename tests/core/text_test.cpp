#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/canvas.hpp"
#include "core/fields.hpp"
#include "core/fields_json.hpp"
#include "core/framed_file.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "support/messages.hpp"
#include "support/refusal.hpp"

namespace vrda::text_test {

TEST(Utf8, TakesEveryCharacter)
{
  for (const std::string text :
       {"", "knee", "genou \xC3\xA9tal\xC3\xB3n", "\xE8\x86\x9D", "\xF0\x9F\xA6\xB5", "\x7F\xC2\x80",
        "\xDF\xBF\xE0\xA0\x80", "\xEF\xBF\xBF\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF", "\xED\x9F\xBF"}) {
    EXPECT_TRUE(is_utf8(text)) << text;
  }
}

TEST(Utf8, RefusesAllElse)
{
  struct Row {
    const char* why;
    std::string bytes;
  };
  for (const Row& row :
       {Row{"alone", "\x80"}, Row{"latin-1", "\xE9tal"}, Row{"cut", "ab\xC3"}, Row{"cut", "\xF0\x9F\xA6"},
        Row{"overlong", "\xC0\x80"}, Row{"overlong", "\xE0\x9F\xBF"}, Row{"overlong", "\xF0\x8F\xBF\xBF"},
        Row{"surrogate", "\xED\xA0\x80"}, Row{"too large", "\xF4\x90\x80\x80"}, Row{"no first byte", "\xF8"},
        Row{"no first byte", "\xFF"}}) {
    EXPECT_FALSE(is_utf8(row.bytes)) << row.why;
  }
}

TEST(Printable, control_characters)
{
  EXPECT_EQ(escape_control_characters("a\x1b[31m\n\x7f\xc2\x9b\xc2\xa0\xc3\xa9\xc2"),
            "a\\x1b[31m\\x0a\\x7f\\xc2\\x9b\xc2\xa0\xc3\xa9\xc2");
  EXPECT_TRUE(has_control_characters("a\xc2\x9b"));
  EXPECT_TRUE(has_control_characters("a\tb"));
  EXPECT_FALSE(has_control_characters("a\tb\n", "\t\n"));
  EXPECT_FALSE(has_control_characters("genou \xC3\xA9tal\xC3\xB3n"));
}

TEST(NumberText, fewest_digits)
{
  EXPECT_EQ(shortest_decimal(0.1), "0.1");
  EXPECT_EQ(shortest_decimal(-0.0), "0");
  EXPECT_EQ(shortest_decimal(5.0), "5");
  EXPECT_EQ(shortest_decimal(0.1 + 0.2), "0.30000000000000004");
}

TEST(EditDistance, edits)
{
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("vraus", "varus"), 2U);
  EXPECT_EQ(edit_distance("flexon", "flexion"), 1U);
  EXPECT_EQ(edit_distance("same", "same"), 0U);
  EXPECT_EQ(nearest_word("tibai", {"femur", "tibia"}), "tibia");
  EXPECT_EQ(nearest_word("x", {}), "");
}

// As printf prints them, with every digit of a large number.
TEST(NumberText, DigitsAndDecimals)
{
  EXPECT_EQ(rounded_text(0.14549), "0.14549");
  EXPECT_EQ(rounded_text(-1234.5678, 3), "-1.23e+03");
  EXPECT_EQ(rounded_text(nan), "nan");
  EXPECT_EQ(fixed_text(12.345, 1), "12.3");
  EXPECT_EQ(fixed_text(1e30, 0), "1000000000000000019884624838656");
}

TEST(InputError, message)
{
  EXPECT_STREQ(InputError({"a.toml", "grid.varus", "0", "a step"}).what(),
               "a.toml: grid.varus: found 0, wanted a step");
  EXPECT_STREQ(InputError({"a.toml", "grid.varus", "0", "a step", 7}).what(),
               "a.toml: line 7, grid.varus: found 0, wanted a step");
  EXPECT_STREQ(InputError({"a.toml", "", "0", "a step", 7}).what(), "a.toml: line 7: found 0, wanted a step");
  EXPECT_STREQ(InputError({"a.stl", "", "nothing", ""}).what(), "a.stl: found nothing");
  EXPECT_STREQ(InputError({"", "", "nothing", "room"}).what(), "found nothing, wanted room");
}

TEST(InputError, any_bytes)
{
  const std::string bytes("a\n\r\t\x1b[31m\0\x7f\xc3\xa9", 13);
  EXPECT_EQ(std::string(InputError({"f", "", bytes, ""}).what()),
            "f: found a\\x0a\\x0d\\x09\\x1b[31m\\x00\\x7f\xc3\xa9");
  EXPECT_EQ(InputError({"f", "", bytes, ""}).facts().found, bytes);
}

TEST(InputError, long_fact)
{
  const std::string text = InputError({"f", std::string(1'000'000, 'k'), "b", "c"}).what();
  EXPECT_LT(text.size(), 6000u);
  EXPECT_NE(text.find("k...: found b, wanted c"), std::string::npos);
}

using test::refuses;
using testing::Not;

const InputError::Facts facts{"/jobs/a.toml", "grid.varus", "-3 of \"x y\"", "at most 1.5", 7};

TEST(Refusal, IsComparedByItsValues)
{
  EXPECT_THAT(facts, refuses({.field = "grid.varus"}));
  for (const test::Refusal& same : {test::Refusal{"/jobs/a.toml", "line 7, grid.varus", "-3", "1.5"},
                                    {"a.toml", "grid.varus", {"\"x y\"", "-3"}}})
    EXPECT_THAT(facts, refuses(same));
  for (const test::Refusal& other : {test::Refusal{"b.toml", "grid.varus"},
                                     {".toml", "grid.varus"},
                                     {"", "grid"},
                                     {"", "varus"},
                                     {"", ""},
                                     {"", "line 8, grid.varus"},
                                     {"", "grid.varus", "3"},
                                     {"", "grid.varus", {"-3", "2"}},
                                     {"", "grid.varus", "-33"},
                                     {"", "grid.varus", "z"},
                                     {"", "grid.varus", "", "1"},
                                     {"", "grid.varus", "", "5"},
                                     {"", "grid.varus", "", "mos"}})
    EXPECT_THAT(facts, Not(refuses(other))) << other.field;
}

TEST(Refusal, OfAProgramIsReadFromItsLastLine)
{
  test::Ended ended{2, "",
                    std::string("warning: a: found b, wanted c\nvrda: ") + InputError(facts).what() + "\n"};
  EXPECT_THAT(ended, refuses({"a.toml", "grid.varus", "-3", "1.5"}));
  EXPECT_THAT(ended, refuses({"/jobs/a.toml", "line 7, grid.varus"}));
  EXPECT_THAT(ended, Not(refuses({.file = "a.toml"})));
  EXPECT_THAT(ended, Not(refuses({"a.toml", "grid.varus", "1.5"})));
  EXPECT_THAT(ended, Not(refuses({"a.toml", "grid.varus", "-3", "3"})));
  EXPECT_THAT(ended, Not(refuses({.field = "grid.varus", .exit_code = 5})));
  ended.exit_code = 0;
  EXPECT_THAT(ended, Not(refuses({.field = "grid.varus"})));
  ended = {2, "", "vrda: --shard: found \"3\" (see vrda run --help)\n"};
  EXPECT_THAT(ended, refuses({.file = "--shard", .found = "\"3\""}));
  EXPECT_THAT((test::Ended{2, "", ""}), Not(refuses({.found = "3"})));
}

TEST(Messages, AreComparedByTheirValues)
{
  const std::string said =
      "vrda: 15 attitudes\nwarning: push.force_n: found 50, no effect\n/a/knee.h5: 35 of 40 stable\n"
      "a.toml: line 8, grid.varus: 3; use vrda plan\n";
  for (const auto& same : {test::reports("", {"15", "attitudes"}), test::reports("push.force_n"),
                           test::warns("push.force_n", "50"), test::reports("knee.h5", {"40", "35"}),
                           test::reports("/a/knee.h5"), test::reports("grid.varus", "vrda plan"),
                           test::reports("a.toml", {"grid.varus", "3"}), test::warns("", "50")})
    EXPECT_THAT(said, same);
  for (const auto& other :
       {test::reports("", {"15", "stable"}), test::reports("force_n"), test::warns("push.force_n", "5"),
        test::warns("knee.h5"), test::reports("h5"), test::reports("knee.h5", "15"), test::warns("", "35")})
    EXPECT_THAT(said, Not(other));
}

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

// One unit in the last place of a result near 1, doubled for the reference's own rounding.
constexpr double two_ulp = 4.5e-16;

TEST(Trig, sine_and_cosine)
{
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-50.0, 50.0);
  for (int k = 0; k < 200000; ++k) {
    const double x = angle(random);
    EXPECT_NEAR(sine(x), std::sin(x), two_ulp);
    EXPECT_NEAR(cosine(x), std::cos(x), two_ulp);
  }
}

TEST(Trig, arcs)
{
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> side(-3.0, 3.0);
  for (int k = 0; k < 200000; ++k) {
    const double x = side(random), y = side(random);
    EXPECT_NEAR(arc_tangent2(y, x), std::atan2(y, x), 2 * two_ulp);
    EXPECT_NEAR(arc_sine(x / 3.0), std::asin(x / 3.0), two_ulp);
    EXPECT_NEAR(arc_cosine(x / 3.0), std::acos(x / 3.0), 2 * two_ulp);
  }
}

TEST(Trig, axes_and_signs)
{
  EXPECT_EQ(sine(0.0), 0.0);
  EXPECT_EQ(cosine(0.0), 1.0);
  EXPECT_EQ(arc_tangent2(0.0, 1.0), 0.0);
  EXPECT_EQ(arc_tangent2(0.0, -1.0), std::acos(-1.0));
  EXPECT_EQ(arc_tangent2(1.0, 0.0), std::acos(0.0));
  EXPECT_EQ(arc_tangent2(-1.0, 0.0), -std::acos(0.0));
  EXPECT_EQ(arc_sine(1.0), std::acos(0.0));
  for (const double x : {0.1, 1.0, 2.0, 40.0}) {
    EXPECT_EQ(sine(-x), -sine(x));
    EXPECT_EQ(cosine(-x), cosine(x));
    EXPECT_EQ(arc_tangent2(-x, 0.7), -arc_tangent2(x, 0.7));
  }
}

TEST(Trig, OfNaNAndInfinityAreNaN)
{
  EXPECT_TRUE(std::isnan(sine(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(cosine(std::numeric_limits<double>::infinity())));
}

std::string text_at(const Eigen::Vector2d& at_px, TextAlign align)
{
  Canvas canvas(200, 60);
  canvas.set_clip({20.0, 0.0}, {180.0, 60.0});
  canvas.draw_text(at_px, 20.0, "push, 20 N", align, Colour::Zero());
  return canvas.png();
}

TEST(Canvas, text_stays_inside)
{
  const std::string at_the_left = text_at({20.0, 40.0}, TextAlign::left);
  for (const TextAlign align : {TextAlign::left, TextAlign::centre, TextAlign::right})
    EXPECT_EQ(text_at({-30.0, 40.0}, align), at_the_left);
  const std::string at_the_right = text_at({230.0, 40.0}, TextAlign::left);
  for (const TextAlign align : {TextAlign::centre, TextAlign::right})
    EXPECT_EQ(text_at({230.0, 40.0}, align), at_the_right);
  EXPECT_NE(at_the_right, at_the_left);
}

TEST(Canvas, text_that_fits)
{
  EXPECT_NE(text_at({40.0, 40.0}, TextAlign::left), text_at({20.0, 40.0}, TextAlign::left));
}

}  // namespace vrda::text_test
