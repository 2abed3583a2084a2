// Motion models whose smoothed sets, zero-varus motion or audits break a rule: what the finding names.
#include <gtest/gtest.h>

#include <limits>

#include "store/changed_file.hpp"
#include "store/sample_derived.hpp"
#include "store/sample_model.hpp"

namespace vrda::derived_validate_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Of four flexions; the sources of the zero-varus motion are both_touch, interpolated, both_touch, none.
MotionModel model_with_a_hole()
{
  MotionModel model = test::with_derived(test::sample_model());
  ZeroVarus& motion = *model.zero_varus;
  motion.source[3] = static_cast<std::int8_t>(ZeroVarusSource::none);
  for (std::vector<double>* values :
       {&motion.varus_deg, &motion.varus_first_deg, &motion.varus_last_deg, &motion.tx_mm, &motion.ty_mm,
        &motion.tz_mm, &motion.theta_deg, &motion.clinical_flexion_deg, &motion.clinical_varus_deg,
        &motion.internal_rotation_deg, &motion.anterior_mm, &motion.proximal_mm, &motion.lateral_mm}) {
    (*values)[3] = nan;
  }
  std::fill(motion.X_reference_moving.begin() + 48, motion.X_reference_moving.end(), nan);
  std::fill(motion.medial_reference_mm.begin() + 9, motion.medial_reference_mm.end(), nan);
  std::fill(motion.medial_moving_mm.begin() + 9, motion.medial_moving_mm.end(), nan);
  for (std::vector<double>* values : {&motion.helical_rotation_deg, &motion.helical_translation_mm,
                                      &motion.medial_rolling_mm, &motion.medial_sliding_mm}) {
    (*values)[2] = nan;
  }
  std::fill(motion.helical_direction.begin() + 6, motion.helical_direction.end(), nan);
  std::fill(motion.helical_point_mm.begin() + 6, motion.helical_point_mm.end(), nan);
  std::fill(motion.instant_centre_mm.begin() + 4, motion.instant_centre_mm.end(), nan);
  return model;
}

void expect_finding(const test::Damage& damage)
{
  test::expect_finding(model_with_a_hole(), damage);
}

/// Damage to the zero-varus motion alone.
void expect_finding(const char* where, const char* found, const char* wanted,
                    const std::function<void(ZeroVarus&)>& act)
{
  expect_finding({where, found, wanted, [&](MotionModel& model) { act(*model.zero_varus); }});
}

/// Damage to the audit of the raw motion: its states run no_pose, free, overlapping, nothing_ahead, ...
void expect_finding(const char* where, const char* found, const char* wanted,
                    const std::function<void(AuditSet&)>& act)
{
  expect_finding({where, found, wanted, [&](MotionModel& model) { act(model.audits[2]); }});
}

const char* const where_posed = "where source is a pose's, NaN elsewhere";
const char* const between_poses = "between two poses, NaN elsewhere";

TEST(ValidateDerived, Recontact)
{
  expect_finding({"/smoothed/degree_1/recontact", "inf at entry 4", "a number or NaN",
                  [](MotionModel& m) { (*m.smoothed[0].recontact_mm)(1, 1) = infinity; }});
}

TEST(ValidateDerived, ASurfaceOfVarusNeedsAFreeOne)
{
  expect_finding({"/smoothed/degree_1/varus_solved", "a surface", "none where /varus has several values",
                  [](MotionModel& m) {
                    m.smoothed[0].surfaces.push_back(m.smoothed[0].surfaces[0]);
                    m.smoothed[0].surfaces[4].name = "varus";
                  }});
  const MotionModel free = test::with_derived(test::sample_model({4, 1, true, true, false}));
  test::expect_finding(free, {"/smoothed/degree_1/varus_solved", "at entry 2", "the value of the polynomial",
                              [](MotionModel& m) { m.smoothed[0].surfaces[4].values(2, 0) += 1e-6; }});
}

TEST(ValidateDerived, ZeroVarusSource)
{
  expect_finding("/zero_varus/source", "7 at entry 1", "flag_values", [](ZeroVarus& m) { m.source[1] = 7; });
  expect_finding("/zero_varus/source", "free at entry 1", "one value", [](ZeroVarus& m) { m.source[1] = 2; });
}

TEST(ValidateDerived, ZeroVarus)
{
  expect_finding("/zero_varus/varus", "nan at entry 1", where_posed,
                 [](ZeroVarus& m) { m.varus_deg[1] = nan; });
  expect_finding("/zero_varus/varus", "1 at entry 3", where_posed,
                 [](ZeroVarus& m) { m.varus_deg[3] = 1.0; });
  expect_finding("/zero_varus/varus", "-0.9 at entry 2", "the mean of varus_first and varus_last",
                 [](ZeroVarus& m) { m.varus_deg[2] += 0.1; });
  expect_finding("/zero_varus/varus_first", "nan at entry 0", "both_touch, NaN elsewhere",
                 [](ZeroVarus& m) { m.varus_first_deg[0] = nan; });
  expect_finding("/zero_varus/varus_last", "0 at entry 1", "both_touch, NaN elsewhere",
                 [](ZeroVarus& m) { m.varus_last_deg[1] = 0.0; });
  expect_finding("/zero_varus/varus_last", "-1.5 at entry 0", "at least varus_first",
                 [](ZeroVarus& m) { std::swap(m.varus_first_deg[0], m.varus_last_deg[0]); });
}

TEST(ValidateDerived, ZeroVarusPoses)
{
  expect_finding("/zero_varus/tx", "inf at entry 0", where_posed,
                 [](ZeroVarus& m) { m.tx_mm[0] = infinity; });
  expect_finding("/zero_varus/ty", "nan at entry 0", where_posed, [](ZeroVarus& m) { m.ty_mm[0] = nan; });
  expect_finding("/zero_varus/tz", "nan at entry 1", where_posed, [](ZeroVarus& m) { m.tz_mm[1] = nan; });
  expect_finding("/zero_varus/theta", "2 at entry 3", where_posed,
                 [](ZeroVarus& m) { m.theta_deg[3] = 2.0; });
  expect_finding("/zero_varus/X_reference_moving", "no rigid pose at entry 1", "a rotation and a translation",
                 [](ZeroVarus& m) { m.X_reference_moving[16] += 1e-6; });
  expect_finding("/zero_varus/X_reference_moving", "without a pose at entry 3", "NaN elsewhere",
                 [](ZeroVarus& m) { m.X_reference_moving[63] = 1.0; });
  expect_finding("/zero_varus/flexion_angle", "nan", where_posed,
                 [](ZeroVarus& m) { m.clinical_flexion_deg[0] = nan; });
  expect_finding("/zero_varus/varus_angle", "nan", where_posed,
                 [](ZeroVarus& m) { m.clinical_varus_deg[0] = nan; });
  expect_finding("/zero_varus/internal_rotation", "nan", where_posed,
                 [](ZeroVarus& m) { m.internal_rotation_deg[0] = nan; });
  expect_finding("/zero_varus/anterior", "nan", where_posed, [](ZeroVarus& m) { m.anterior_mm[0] = nan; });
  expect_finding("/zero_varus/proximal", "nan", where_posed, [](ZeroVarus& m) { m.proximal_mm[0] = nan; });
  expect_finding("/zero_varus/lateral", "nan", where_posed, [](ZeroVarus& m) { m.lateral_mm[0] = nan; });
}

TEST(ValidateDerived, ZeroVarusContacts)
{
  expect_finding("/zero_varus/medial_reference", "no numbers at entry 0", where_posed,
                 [](ZeroVarus& m) { m.medial_reference_mm[1] = nan; });
  expect_finding("/zero_varus/medial_moving", "no numbers at entry 1", where_posed,
                 [](ZeroVarus& m) { m.medial_moving_mm[3] = infinity; });
  expect_finding("/zero_varus/lateral_reference", "no numbers at entry 2", where_posed,
                 [](ZeroVarus& m) { m.lateral_reference_mm[6] = 1.0; });
  expect_finding("/zero_varus/lateral_moving", "without a pose at entry 3", where_posed, [](ZeroVarus& m) {
    std::fill(m.lateral_moving_mm.begin() + 9, m.lateral_moving_mm.end(), 1.0);
  });
}

TEST(ValidateDerived, ZeroVarusIntervals)
{
  expect_finding("/zero_varus/helical_rotation", "no numbers at entry 1", between_poses, [](ZeroVarus& m) {
    m.helical_rotation_deg = {0.0, infinity, nan};
  });
  expect_finding("/zero_varus/helical_translation", "without a pose at entry 2", between_poses,
                 [](ZeroVarus& m) { m.helical_translation_mm[2] = 1.0; });
  expect_finding("/zero_varus/helical_direction", "no numbers at entry 1", between_poses,
                 [](ZeroVarus& m) { m.helical_direction[3] = nan; });
  expect_finding("/zero_varus/helical_direction", "length 2 at entry 1", "unit vectors", [](ZeroVarus& m) {
    for (std::size_t k = 3; k < 6; ++k) m.helical_direction[k] *= 2.0;
  });
  expect_finding("/zero_varus/helical_point", "no numbers at entry 0", between_poses,
                 [](ZeroVarus& m) { m.helical_point_mm[2] = 1.0; });
  expect_finding("/zero_varus/instant_centre", "no numbers at entry 1", between_poses,
                 [](ZeroVarus& m) { m.instant_centre_mm[2] = nan; });
  expect_finding("/zero_varus/medial_rolling", "without a pose at entry 2", between_poses,
                 [](ZeroVarus& m) { m.medial_rolling_mm[2] = 0.0; });
  expect_finding("/zero_varus/medial_sliding", "no numbers at entry 0", between_poses,
                 [](ZeroVarus& m) { m.medial_sliding_mm[0] = -infinity; });
  expect_finding("/zero_varus/lateral_rolling", "without a pose at entry 2", between_poses,
                 [](ZeroVarus& m) { m.lateral_rolling_mm[2] = 0.0; });
  expect_finding("/zero_varus/lateral_sliding", "without a pose at entry 2", between_poses,
                 [](ZeroVarus& m) { m.lateral_sliding_mm[2] = 0.0; });
}

TEST(ValidateDerived, AuditGrid)
{
  expect_finding("/audit/raw@refine", "0", "at least 1", [](AuditSet& a) { a.refine = 0; });
  expect_finding("/audit/raw/flexion", "0 at entry 1", "strictly increasing",
                 [](AuditSet& a) { a.flexion_deg[1] = 0.0; });
  expect_finding("/audit/raw/varus", "nan at entry 0", "strictly increasing", [](AuditSet& a) {
    a.varus_deg = {nan, 0.0, 1.0};
  });
}

TEST(ValidateDerived, AuditValues)
{
  expect_finding("/audit/raw/state", "4 at entry 3", "flag_values", [](AuditSet& a) { a.state(1, 0) = 4; });
  expect_finding("/audit/raw/gap", "nan at entry 1", "where state is free, NaN elsewhere",
                 [](AuditSet& a) { a.gap_mm(0, 1) = nan; });
  expect_finding("/audit/raw/gap", "-0.5 at entry 1", "at least 0",
                 [](AuditSet& a) { a.gap_mm(0, 1) = -0.5; });
  expect_finding("/audit/raw/gap", "0 at entry 3", "NaN elsewhere",
                 [](AuditSet& a) { a.gap_mm(1, 0) = 0.0; });
  expect_finding("/audit/raw/penetration", "0 at entry 0", "NaN without a pose",
                 [](AuditSet& a) { a.penetration_mm(0, 0) = 0.0; });
  expect_finding("/audit/raw/penetration", "0.25 at entry 1", "0 elsewhere",
                 [](AuditSet& a) { a.penetration_mm(0, 1) = 0.25; });
  expect_finding("/audit/raw/penetration", "-1 at entry 2", "at least 0 where state is overlapping",
                 [](AuditSet& a) { a.penetration_mm(0, 2) = -1.0; });
  expect_finding("/audit/raw/penetration", "nan at entry 3", "0 elsewhere",
                 [](AuditSet& a) { a.penetration_mm(1, 0) = nan; });
}

}  // namespace vrda::derived_validate_test
