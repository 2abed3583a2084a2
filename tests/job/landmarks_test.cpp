#include "job/ligament_files.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "job/mesh_text.hpp"
#include "support/refusal.hpp"

namespace vrda::landmarks_test {

const std::string header = "name,ax,ay,az,bx,by,bz,subject_mm\n";

std::vector<job::LandmarkPair> read(const std::string& rows)
{
  return job::read_landmarks("marks.csv", header + rows);
}

void expect_refused(const std::string& text, const std::string& field, const std::string& found = "",
                    const std::string& wanted = "")
{
  const InputError::Facts facts = test::input_error([&] { job::read_landmarks("marks.csv", text); });
  EXPECT_THAT(facts, test::refuses({"marks.csv", field, found, wanted}));
}

TEST(Landmarks, columns)
{
  const auto pairs =
      job::read_landmarks("marks.csv",
                          "# epicondyles and more\r\n\r\nsubject_mm, bz,by,bx ,az,ay,ax,name\r\n"
                          "82.5,6,5,4,3,2,1, epicondyles\r\n#\n+1e2,0,0,0,0,-1.5,0,shaft");
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].name, "epicondyles");
  EXPECT_EQ(pairs[0].a_native, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pairs[0].b_native, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(pairs[0].subject_mm, 82.5);
  EXPECT_EQ(pairs[1].subject_mm, 100.0);
}

TEST(Landmarks, WhatIsNoTableIsRefusedByLineAndColumn)
{
  expect_refused("", "", "no line");
  expect_refused(header, "line 1");
  expect_refused("name,ax,ay,az,bx,by,bz\n", "line 1, subject_mm", "nothing");
  expect_refused("name,ax,ay,az,bx,by,bz,subject_mm,ax\n", "line 1, ax");
  expect_refused("name,ax,ay,az,bx,by,bz,subject_m\n", "line 1, subject_m", "", "\"subject_mm\"");
  expect_refused(header + "a,0,0,0,1,0,0\n", "line 2", "7", "8");
  expect_refused(header + "a,0,0,0,1,0,x,5\n", "line 2, bz", "\"x\"");
  expect_refused(header + "a,0,0,0,1,0,,5\n", "line 2, bz", "nothing");
  expect_refused(header + "a,0,0,nan,1,0,0,5\n", "line 2, az", "\"nan\"");
  expect_refused(header + "a,0,0,1e200,1,0,0,5\n", "line 2, az", "1e+200");
  expect_refused(header + ",0,0,0,1,0,0,5\n", "line 2, name", "nothing");
  expect_refused(header + "a,1,2,3,1,2,3,5\n", "line 2", "coincident");
  expect_refused(header + "a,1,2,3,1,2,3.0000000001,5\n", "line 2", "coincident");
  expect_refused(header + "a,0,0,0,1,0,0,1e-300\n", "line 2, subject_mm", "1e-300", "0");
  expect_refused(header + "a,0,0,0,1,0,0,0\n", "line 2, subject_mm", "0", "0");
  expect_refused(header + "a,0,0,0,1,0,0,-5\n", "line 2, subject_mm", "-5", "0");
  expect_refused(header + "a,0,0,0,1,0,0,5\na,0,0,0,2,0,0,5\n", "line 3, name", "\"a\"");
}

// Rounding of sums of a few products.
constexpr double rounding = 1e-14;

TEST(Landmarks, known_factor)
{
  const Scaling fit =
      job::fit_scaling(read("a,0,0,0,80,0,0,85.6\nb,1,1,1,1,4,5,5.35\nc,0,0,-2,0,0,10,12.84\n"), 1.0);
  EXPECT_NEAR(fit.factor.x(), 1.07, rounding);
  EXPECT_TRUE(is_uniform(fit.factor));
  EXPECT_EQ(fit.model_mm, (std::vector<double>{80, 5, 12}));
  for (const double residual_mm : fit.residual_mm) EXPECT_NEAR(residual_mm, 0.0, 85.6 * rounding);
  EXPECT_NEAR(fit.residual_rms_mm, 0.0, 85.6 * rounding);
  EXPECT_NEAR(fit.standard_error, 0.0, rounding);
}

TEST(Landmarks, by_hand)
{
  // s = (3 x 3.3 + 4 x 4) / (9 + 16) = 25.9 / 25
  const Scaling fit = job::fit_scaling(read("a,0,0,0,3,0,0,3.3\nb,0,0,0,0,4,0,4\n"), 1.0);
  EXPECT_NEAR(fit.factor.x(), 1.036, rounding);
  EXPECT_NEAR(fit.residual_mm.at(0), 0.192, 4 * rounding);
  EXPECT_NEAR(fit.residual_mm.at(1), -0.144, 4 * rounding);
  EXPECT_NEAR(fit.residual_rms_mm, std::sqrt(0.0576 / 2), 4 * rounding);
  EXPECT_NEAR(fit.standard_error, 0.24 / 5, 4 * rounding);
}

TEST(Landmarks, one_pair)
{
  const Scaling fit = job::fit_scaling(read("a,0,0,0,0,0,50,45\n"), 1.0);
  EXPECT_NEAR(fit.factor.x(), 0.9, rounding);
  EXPECT_TRUE(std::isnan(fit.standard_error));
  EXPECT_NEAR(fit.residual_rms_mm, 0.0, 50 * rounding);
}

TEST(Landmarks, invariances)
{
  const Scaling fit =
      job::fit_scaling(read("a,0,0,0,80,0,0,84\nb,0,0,0,0,30,0,33\nc,5,5,5,5,5,45,41\n"), 1.0);
  // Least-squares residuals are orthogonal to the distances of the model.
  double along_sq_mm2 = 0.0;
  for (std::size_t i = 0; i < 3; ++i) along_sq_mm2 += fit.residual_mm[i] * fit.model_mm[i];
  EXPECT_NEAR(along_sq_mm2, 0.0, 84 * 84 * rounding);
  // Swapped ends, a common translation, cm, and another order give the same fit.
  const Scaling other =
      job::fit_scaling(read("c,1,1,5,1,1,1,41\na,9,1,1,1,1,1,84\nb,1,4,1,1,1,1,33\n"), 10.0);
  EXPECT_NEAR(other.factor.x(), fit.factor.x(), rounding);
  EXPECT_NEAR(other.residual_rms_mm, fit.residual_rms_mm, 84 * rounding);
  EXPECT_NEAR(other.standard_error, fit.standard_error, rounding);
  // Twice the subject's distances give twice the factor, residuals and error.
  const Scaling twice =
      job::fit_scaling(read("a,0,0,0,80,0,0,168\nb,0,0,0,0,30,0,66\nc,5,5,5,5,5,45,82\n"), 1.0);
  EXPECT_NEAR(twice.factor.x(), 2 * fit.factor.x(), rounding);
  EXPECT_NEAR(twice.residual_rms_mm, 2 * fit.residual_rms_mm, 168 * rounding);
  EXPECT_NEAR(twice.standard_error, 2 * fit.standard_error, rounding);
}

}  // namespace vrda::landmarks_test
