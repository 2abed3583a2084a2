// Counts every operator new of this test program, so it stands in a file of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "core/units.hpp"
#include "motion/poses.hpp"
#include "motion/support/models.hpp"

namespace {
std::atomic<long> n_allocations{0};
}

// Not inlined: GCC would see malloc and delete, or new and free, and call them mismatched.
[[gnu::noinline]] void* operator new(std::size_t size)
{
  ++n_allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment)
{
  ++n_allocations;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept
{
  std::free(memory);
}

namespace vrda {
namespace {

TEST(MotionAllocation, AnEvaluationAllocatesNothing)
{
  test::ModelPlan plan;
  plan.turning_delta = [](double flexion_deg) {
    return Eigen::Vector3d(0.001 * flexion_deg, 1.0, 0.0).normalized();
  };
  MotionModel model = test::model_of(plan);
  test::unsolve(model, 1, 1);
  test::add_smoothed(model, 6, [](int i, int j) { return PoseNumbers{i + 1.0, j + 1.0, 1.0, 2.0}; });
  model.smoothed.front().recontact_mm = GridD::Constant(model.status.rows(), model.status.cols(), 0.1);
  const std::vector<double> column(model.flexion_deg.size(), 1.0);
  ZeroVarus table;
  table.source.assign(column.size(), static_cast<std::int8_t>(ZeroVarusSource::free));
  table.varus_deg = table.tx_mm = table.ty_mm = table.tz_mm = table.theta_deg = column;
  model.zero_varus = table;
  for (const std::string& set : set_names(model)) {
    const Motion motion(model, set);
    const long before = n_allocations;
    double sum = 0.0;
    int n_solved = 0;
    for (int k = 0; k < 1000; ++k) {
      const double flexion_rad = rad_from_deg(0.11 * k - 5.0);
      const JointPose pose =
          motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad) + rad_from_deg(0.01 * k - 6.0)});
      sum += pose.X_reference_moving.linear().trace();
      const JointRate rate = motion.rate_at(pose.attitude);
      sum += rate.by_flexion.twist.turn.squaredNorm() + rate.by_varus.twist.turn.squaredNorm();
      n_solved += pose.status == PoseStatus::solved ? 1 : 0;
    }
    EXPECT_EQ(n_allocations - before, 0) << set;
    EXPECT_GT(n_solved, 700);
    EXPECT_GT(sum, 0.0);
  }
  // The counter counts.
  const long before = n_allocations;
  ::operator delete(::operator new(1));
  EXPECT_GE(n_allocations - before, 1);
}

}  // namespace
}  // namespace vrda
