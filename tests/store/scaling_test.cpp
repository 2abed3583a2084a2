// How a motion model says that its joint was scaled.
#include <gmock/gmock.h>

#include <cmath>

#include "core/units.hpp"
#include "store/changed_file.hpp"
#include "store/equal_models.hpp"
#include "store/motion_model_file.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::scaling_test {

/// By 1.036 after two pairs of landmarks (3 and 4 mm of model, 3.3 and 4 of subject).
MotionModel scaled_model()
{
  MotionModel model = test::sample_model();
  Scaling& scaling = model.job.scaling.emplace();
  scaling.factor.setConstant(1.036);
  scaling.keeps_steps = true;
  scaling.landmark = {"a", "b"};
  scaling.model_mm = {3, 4};
  scaling.subject_mm = {3.3, 4};
  scaling.residual_mm = {3.3 - 1.036 * 3, 4 - 1.036 * 4};
  scaling.residual_rms_mm = std::sqrt(0.0576 / 2);
  scaling.standard_error = 0.048;
  return model;
}

MotionModel stretched_model()
{
  MotionModel model = test::sample_model();
  model.job.scaling.emplace().factor = {1.2, 1.0, 0.9};
  return model;
}

TEST(StoredScaling, GoesThroughAFileUnchanged)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5", again = scratch.path() / "again.h5";
  for (const MotionModel& model : {scaled_model(), stretched_model()}) {
    write_motion_model(path, model);
    EXPECT_THAT(validate_hdf5(path), testing::IsEmpty());
    const MotionModel read = read_motion_model(path);
    test::expect_equal(read, model);
    write_motion_model(again, read);
    EXPECT_EQ(test::read_bytes(again), test::read_bytes(path));
  }
}

TEST(StoredScaling, OlderFilesAreValidWithoutIt)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  write_motion_model(path, test::sample_model());
  test::change(path, [](hid_t file) {
    test::remove_plausibility(file);
    test::set_text(file, "/", "format_version", "1.2");
  });
  EXPECT_THAT(validate_hdf5(path), testing::IsEmpty());
  test::expect_equal(read_motion_model(path), test::without_plausibility(test::sample_model()));
}

TEST(StoredScaling, IsIgnoredInAFileThatDidNotKnowIt)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  write_motion_model(path, scaled_model());
  test::change(path, [](hid_t file) {
    test::remove_plausibility(file);
    test::set_text(file, "/", "format_version", "1.2");
  });
  EXPECT_FALSE(read_motion_model(path).job.scaling);
}

TEST(StoredScaling, ItsPartsBelongTogether)
{
  for (const char* path : {"/job/scaling/landmark", "/job/scaling/model", "/job/scaling/subject",
                           "/job/scaling/residual", "/job/scaling/pair"}) {
    SCOPED_TRACE(path);
    const std::vector<Finding> findings =
        test::findings_after(scaled_model(), [&](hid_t file) { test::remove(file, path); });
    test::expect_first(findings, path, "nothing", "a");
  }
  for (const char* name : {"factor", "keeps_steps", "standard_error", "residual_rms_mm"}) {
    SCOPED_TRACE(name);
    const std::vector<Finding> findings = test::findings_after(
        scaled_model(), [&](hid_t file) { H5Adelete_by_name(file, "/job/scaling", name, H5P_DEFAULT); });
    test::expect_first(findings, (std::string("/job/scaling@") + name).c_str(), "nothing", "of ");
  }
}

TEST(StoredScaling, ItsValuesAgree)
{
  const auto expect_finding = [](const test::Damage& damage) {
    test::expect_finding(scaled_model(), damage);
  };
  expect_finding(
      {"/job/scaling@factor", "-1.036", "above 0", [](MotionModel& m) {
         m.job.scaling->factor *= -1.0;
         for (std::size_t i : {0U, 1U})
           m.job.scaling->residual_mm[i] = m.job.scaling->subject_mm[i] + 1.036 * m.job.scaling->model_mm[i];
         m.job.scaling->residual_rms_mm =
             std::hypot(m.job.scaling->residual_mm[0], m.job.scaling->residual_mm[1]) / std::sqrt(2.0);
       }});
  expect_finding({"/job/scaling@factor", "differ", "three times",
                  [](MotionModel& m) { m.job.scaling->factor.z() = 1.1; }});
  expect_finding({"/job/scaling/landmark", "nothing", "a name",
                  [](MotionModel& m) { m.job.scaling->landmark[1] = ""; }});
  expect_finding({"/job/scaling/residual", "0.2 at entry 0", "less the factor", [](MotionModel& m) {
                    m.job.scaling->residual_mm[0] = 0.2;
                    m.job.scaling->residual_rms_mm =
                        std::hypot(0.2, m.job.scaling->residual_mm[1]) / std::sqrt(2.0);
                  }});
  expect_finding({"/job/scaling@residual_rms_mm", "1", "that of the residuals",
                  [](MotionModel& m) { m.job.scaling->residual_rms_mm = 1.0; }});
  expect_finding({"/job/scaling@standard_error", "nan", "at least 0",
                  [](MotionModel& m) { m.job.scaling->standard_error = nan; }});
  test::expect_finding(stretched_model(), {"/job/scaling@standard_error", "0", "NaN below two pairs",
                                           [](MotionModel& m) { m.job.scaling->standard_error = 0.0; }});
  test::expect_finding(stretched_model(), {"/job/scaling@residual_rms_mm", "0", "NaN without landmarks",
                                           [](MotionModel& m) { m.job.scaling->residual_rms_mm = 0.0; }});
  test::expect_finding(stretched_model(), {"/job/scaling@factor", "differ", "three times",
                                           [](MotionModel& m) { m.job.scaling->keeps_steps = true; }});
}

}  // namespace vrda::scaling_test
