// The record of scaling in a motion model.
#include <gmock/gmock.h>

#include <cmath>

#include "core/units.hpp"
#include "store/changed_file.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::scaling_test {

store::MotionModel stretched_model()
{
  store::MotionModel model = test::sample_model();
  model.job.scaling.emplace().factor = {1.2, 1.0, 0.9};
  return model;
}

TEST(StoredScaling, GoesThroughAFileUnchanged)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5", again = scratch.path() / "again.h5";
  for (const store::MotionModel& model : {test::whole_model(), stretched_model()}) {
    store::write_motion_model(path, model);
    EXPECT_THAT(store::validate_hdf5(path), testing::IsEmpty());
    const store::MotionModel read = store::read_motion_model(path);
    test::expect_equal(read, model);
    store::write_motion_model(again, read);
    EXPECT_EQ(test::read_bytes(again), test::read_bytes(path));
  }
}

TEST(StoredScaling, ItsValuesAgree)
{
  const auto expect_finding = [](const test::Damage& damage) {
    test::expect_finding(test::whole_model(), damage);
  };
  expect_finding(
      {"/job/scaling@factor", "-1.036", "above 0", [](store::MotionModel& m) {
         m.job.scaling->factor *= -1.0;
         for (std::size_t i : {0U, 1U})
           m.job.scaling->residual_mm[i] = m.job.scaling->subject_mm[i] + 1.036 * m.job.scaling->model_mm[i];
         m.job.scaling->residual_rms_mm =
             std::hypot(m.job.scaling->residual_mm[0], m.job.scaling->residual_mm[1]) / std::sqrt(2.0);
       }});
  expect_finding({"/job/scaling@factor", "unequal", "three equal",
                  [](store::MotionModel& m) { m.job.scaling->factor.z() = 1.1; }});
  expect_finding({"/job/scaling/landmark", "\"\"", "non-empty",
                  [](store::MotionModel& m) { m.job.scaling->landmark[1] = ""; }});
  expect_finding({"/job/scaling/residual", "0.2 at entry 0", "minus the factor", [](store::MotionModel& m) {
                    m.job.scaling->residual_mm[0] = 0.2;
                    m.job.scaling->residual_rms_mm =
                        std::hypot(0.2, m.job.scaling->residual_mm[1]) / std::sqrt(2.0);
                  }});
  expect_finding({"/job/scaling@residual_rms_mm", "1", "from the residuals",
                  [](store::MotionModel& m) { m.job.scaling->residual_rms_mm = 1.0; }});
  expect_finding({"/job/scaling@standard_error", "nan", "at least 0",
                  [](store::MotionModel& m) { m.job.scaling->standard_error = nan; }});
  test::expect_finding(stretched_model(),
                       {"/job/scaling@standard_error", "0", "NaN with fewer than two",
                        [](store::MotionModel& m) { m.job.scaling->standard_error = 0.0; }});
  test::expect_finding(stretched_model(),
                       {"/job/scaling@residual_rms_mm", "0", "NaN without landmarks",
                        [](store::MotionModel& m) { m.job.scaling->residual_rms_mm = 0.0; }});
  test::expect_finding(stretched_model(), {"/job/scaling@factor", "unequal", "three equal",
                                           [](store::MotionModel& m) { m.job.scaling->keeps_steps = true; }});
}

}  // namespace vrda::scaling_test
