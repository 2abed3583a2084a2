#include "report/curve_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "exports/csv_tables.hpp"
#include "store/sample_model.hpp"
#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::curve_file_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(CurveFile, ReadsTheColumnsOfThePublishedCurves)
{
  const CurveFile file =
      curve_from_text("folder/walker.v2.csv",
                      "# cadavers, passive\r\n#convention: internal +\n\n"
                      "frame,flexion_deg, varus_deg ,internal_deg,ant_mm,prox_mm,lat_mm,T11,T34\r\n"
                      "1,0,0.5,-1,1e1,2,-3,0,zero\r\n"
                      "2, 10.5 ,,+2,11,3,-4,0,0\n");
  EXPECT_EQ(file.curve.name, "walker.v2");
  EXPECT_THAT(file.notes, ElementsAre("cadavers, passive", "convention: internal +"));
  EXPECT_THAT(file.curve.flexion_deg, ElementsAre(0.0, 10.5));
  EXPECT_THAT(file.curve.of(Quantity::internal), ElementsAre(-1.0, 2.0));
  EXPECT_THAT(file.curve.of(Quantity::origin_anterior), ElementsAre(10.0, 11.0));
  EXPECT_THAT(file.curve.of(Quantity::origin_proximal), ElementsAre(2.0, 3.0));
  EXPECT_THAT(file.curve.of(Quantity::origin_lateral), ElementsAre(-3.0, -4.0));
  EXPECT_THAT(file.curve.of(Quantity::anterior), IsEmpty());
  ASSERT_EQ(file.curve.of(Quantity::varus).size(), 2u);
  EXPECT_EQ(file.curve.of(Quantity::varus)[0], 0.5);
  EXPECT_TRUE(std::isnan(file.curve.of(Quantity::varus)[1]));
}

TEST(CurveFile, ReadsWhatIsExported)
{
  const FlexionMotion motion = flexion_motion(test::sample_model(), "knee.h5", {});
  const CurveFile file = curve_from_text("knee.csv", flexion_csv(motion));
  ASSERT_EQ(file.curve.flexion_deg.size(), motion.frames.size());
  for (const Quantity quantity : {Quantity::internal, Quantity::varus, Quantity::origin_anterior,
                                  Quantity::origin_proximal, Quantity::origin_lateral}) {
    EXPECT_EQ(file.curve.of(quantity).size(), motion.frames.size());
  }
  // The surfaces and the Grood-Suntay translations are no columns of a curve.
  EXPECT_THAT(file.curve.of(Quantity::anterior), IsEmpty());
}

TEST(CurveFile, RefusesWhatItWouldHaveToGuess)
{
  struct Row {
    const char* text;
    const char* field;
    const char* found;
    const char* wanted;
  };
  const Row rows[] = {
      {"flexion_deg,fx_n\n0,1\n", "column 'fx_n'", "unknown column", "internal_deg, varus_deg, ant_mm"},
      {"internal_deg\n1\n", "header", "no column flexion_deg", "flexion_deg and at least one"},
      {"flexion_deg,frame\n0,1\n", "header", "no clinical number", "at least one of"},
      {"flexion_deg,varus_deg,varus_deg\n0,1,1\n", "column 'varus_deg'", "twice", "once"},
      {"flexion_deg,varus_deg\n0,1\n5\n", "line 3", "1 fields", "2"},
      {"flexion_deg,varus_deg\n0,1,2\n", "line 2", "3 fields", "2"},
      {"flexion_deg,varus_deg\n0,one\n", "line 2, varus_deg", "'one'", "finite number"},
      {"flexion_deg,varus_deg\n0,inf\n", "line 2, varus_deg", "'inf'", "finite number"},
      {"flexion_deg,varus_deg\n,1\n", "line 2, flexion_deg", "''", "finite number"},
      {"flexion_deg,varus_deg\n", "", "no rows", "rows of numbers"},
      {"# only words\n", "", "no header", "flexion_deg"},
      {"", "", "no header", "flexion_deg"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.text);
    const InputError::Facts facts = test::input_error([&] { curve_from_text("curve.csv", row.text); });
    EXPECT_EQ(facts.file, "curve.csv");
    EXPECT_EQ(facts.field, row.field);
    EXPECT_THAT(facts.found, HasSubstr(row.found));
    EXPECT_THAT(facts.wanted, HasSubstr(row.wanted));
  }
}

TEST(CurveFile, RefusesAFileThatIsNotThere)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "none.csv").string();
  EXPECT_EQ(test::input_error([&] { read_curve_file(path); }).file, path);
  const std::string there = scratch.write("curve.csv", "flexion_deg,varus_deg\n0,1\n").string();
  EXPECT_EQ(read_curve_file(there).curve.name, "curve");
}

}  // namespace vrda::curve_file_test
