#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/body_sheet.hpp"

namespace vrda::body_sheet_test {

using testing::HasSubstr;

TEST(BodySheet, MarkersAreSquaresBesideTheEdge)
{
  const auto markers = bench::marker_corners_mm({});
  for (const bench::MarkerCorners& marker : markers) {
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR((marker[(k + 1) % 4] - marker[k]).norm(), 40.0, 1e-12);
    EXPECT_NEAR((marker[2] - marker[0]).norm(), 40.0 * std::sqrt(2.0), 1e-12);
    // Seen from outside, clockwise from the upper left.
    const Eigen::Vector3d outward = (marker[0] - marker[1]).cross(marker[2] - marker[1]);
    EXPECT_GT(outward.z(), 0.0);
    EXPECT_GT(marker[0].y(), marker[3].y());
  }
  // A right angle at the edge: the inner sides are 8 mm from it on either face.
  EXPECT_NEAR((markers[1][0] - markers[0][1]).norm(), 8.0 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(markers[1][0].x(), 8.0 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(markers[1][0].y(), 44.0, 1e-12);
  EXPECT_NEAR(markers[2][3].y(), -44.0, 1e-12);
  // A print of another size.
  EXPECT_NEAR((bench::marker_corners_mm({20.0})[3][2] - 0.5 * markers[3][2]).norm(), 0.0, 1e-12);
}

TEST(BodySheet, ThePrintHasItsSizesInMillimetres)
{
  const std::string pdf = bench::sheets_pdf({"femur", "tibia", "probe"});
  EXPECT_THAT(pdf, testing::StartsWith("%PDF-1.4\n"));
  EXPECT_THAT(pdf, HasSubstr("/Count 3 "));
  EXPECT_THAT(pdf, HasSubstr("/PrintScaling /None"));
  // A millimetre is 72 / 25.4 points; a marker is 40 of them.
  EXPECT_THAT(pdf, HasSubstr("2.8346 0 0 2.8346 0 0 cm\n"));
  EXPECT_THAT(pdf, HasSubstr("q 40.0000 0.0000 0.0000 40.0000 113.0000 "));
  EXPECT_THAT(pdf, HasSubstr("(femur: markers 0 to 3, 40 mm each; this side up \\(proximal\\)) Tj"));
  EXPECT_THAT(pdf, HasSubstr("(probe: markers 8 to 11,"));
  // The board: 7 x 5 squares of 38 mm, its long side along the page.
  EXPECT_THAT(pdf, HasSubstr("q 190.0000 0.0000 0.0000 266.0000 10.0000 22.0000 cm"));
  EXPECT_THAT(pdf, HasSubstr("100 mm: print without scaling"));
  // The table at the end points at each object.
  const std::size_t table = pdf.find("xref\n");
  ASSERT_NE(table, std::string::npos);
  EXPECT_THAT(pdf, HasSubstr("startxref\n" + std::to_string(table) + "\n%%EOF\n"));
  EXPECT_EQ(pdf.substr(std::stoul(pdf.substr(pdf.find("65535 f \n", table) + 9, 10)), 8), "1 0 obj\n");
}

}  // namespace vrda::body_sheet_test
