#include "job/component_loader.hpp"

#include <gmock/gmock.h>

#include "job/mesh_text.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::axis_map_test {

using test::refuses;

job::Job job_with_frame(const test::Scratch& scratch, const std::string& frame)
{
  return job::read_job(scratch.write("job.toml", test::small_job("[frame]\n" + frame)).string());
}

TEST(AxisMap, words)
{
  const test::Scratch scratch;
  // Image axes: X the subject's left, Y posterior, Z up.
  const job::AxisMap map = job::axis_map(
      job_with_frame(scratch, "unit = \"cm\"\nanterior = \"-Y\"\nproximal = \"+Z\"\nright = \"-X\""));
  EXPECT_EQ(map({1, 2, 3}), Eigen::Vector3d(-20, 30, -10));
}

// +1 for a rotation, -1 for a left-handed map, 0 for an axis named twice.
int handedness_of(const std::string& anterior, const std::string& proximal, const std::string& right)
{
  job::Job job;
  job.frame = {"frame", "mm", anterior, proximal, right};
  try {
    EXPECT_DOUBLE_EQ(job::axis_map(job).X_canonical_native.linear().determinant(), 1.0);
    return 1;
  } catch (const InputError& error) {
    return error.facts().found.find("left-handed") != std::string::npos ? -1 : 0;
  }
}

TEST(AxisMap, every_map)
{
  const std::vector<std::string> axes{"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
  std::map<int, int> n;
  for (std::size_t i = 0; i < 216; ++i) ++n[handedness_of(axes[i % 6], axes[i / 6 % 6], axes[i / 36])];
  EXPECT_EQ(n[1], 24);
  EXPECT_EQ(n[-1], 24);
  EXPECT_EQ(n[0], 216 - 48);
}

TEST(AxisMap, ALeftHandedMapNamesTheSignThatMendsIt)
{
  const test::Scratch scratch;
  const job::Job job = job_with_frame(scratch, "right = \"-Z\"");
  EXPECT_THAT(test::input_error([&] { job::axis_map(job); }),
              refuses({"job.toml", "frame", "left-handed", "right = \"+Z\""}));
}

TEST(AxisMap, align)
{
  const test::Scratch scratch;
  const job::AxisMap map = job::axis_map(job_with_frame(scratch, R"(
unit = "m"
anterior = "+Y"
proximal = "+Z"
right = "+X"
align = { rotation_deg = [90, 0, 90], translation_mm = [1, 2, 3] }
)"));
  // (0, 1, 0) m -> 1000 Y; about X by 90: Z; about Z by 90: Z; shifted: (1, 2, 1003); renamed: Y, Z, X.
  constexpr double rounding_mm = 1e-9;
  EXPECT_LT((map({0, 1, 0}) - Eigen::Vector3d(2, 1003, 1)).norm(), rounding_mm);
}

}  // namespace vrda::axis_map_test
