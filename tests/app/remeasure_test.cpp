#include "app/remeasure.hpp"

#include <gtest/gtest.h>

#include "store/sample_model.hpp"

namespace vrda {
namespace {

test::SampleOptions equilibrium_options()
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  return options;
}

void expect_same(const PoseAudit& a, const PoseAudit& b)
{
  EXPECT_EQ(a.is_overlapping, b.is_overlapping);
  EXPECT_EQ(a.penetration_mm, b.penetration_mm);
  EXPECT_EQ(a.gap_mm, b.gap_mm);
}

TEST(Remeasured, EachFlexionAlongItsOwnDelta)
{
  const MotionModel turning = test::sample_model(equilibrium_options());
  const std::vector<PoseAudit> found = remeasured(turning, 2);
  const std::size_t n_varus = turning.varus_deg.size();
  for (std::size_t i = 0; i < turning.flexion_deg.size(); ++i) {
    SCOPED_TRACE(i);
    MotionModel constant = turning;
    constant.delta = turning.push.delta.row(static_cast<Eigen::Index>(i)).transpose();
    constant.push = constant_push(constant.delta, turning.flexion_deg.size());
    const std::vector<PoseAudit> expected = remeasured(constant, 1);
    for (std::size_t j = 0; j < n_varus; ++j) expect_same(found[i * n_varus + j], expected[i * n_varus + j]);
  }
  // The last row's Delta is another than the first's, and so is what is measured.
  MotionModel wrong = turning;
  wrong.push = constant_push(turning.delta, turning.flexion_deg.size());
  EXPECT_NE(remeasured(wrong, 1).back().gap_mm, found.back().gap_mm);
}

TEST(Remeasured, AFreeVarusAtWhatWasFound)
{
  test::SampleOptions options;
  options.n_varus = 1;
  const MotionModel given = test::sample_model(options);  // at varus -1
  MotionModel free = given;
  free.varus_deg = {0.0};
  const std::vector<PoseAudit> expected = remeasured(given, 1), found = remeasured(free, 2);
  for (std::size_t cell = 0; cell < found.size(); ++cell) expect_same(found[cell], expected[cell]);
}

}  // namespace
}  // namespace vrda
