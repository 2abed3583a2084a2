#include "store/zero_varus_values.hpp"

#include <algorithm>
#include <cmath>

#include "store/derived_layout.hpp"
#include "store/layout.hpp"

namespace vrda {
namespace {

/// `width` numbers a row.
struct Rows {
  const std::vector<double>& values;
  std::size_t width = 1;

  bool are_nan(std::size_t row) const
  {
    return std::all_of(begin(row), begin(row) + width, [](double x) { return std::isnan(x); });
  }
  bool are_finite(std::size_t row) const
  {
    return std::all_of(begin(row), begin(row) + width, [](double x) { return is_number(x); });
  }
  const double* begin(std::size_t row) const { return values.data() + row * width; }
};

class ZeroVarusCheck {
 public:
  ZeroVarusCheck(const ZeroVarus& motion, const MotionModel& model, ValueFindings& findings)
      : motion_(motion), model_(model), findings_(findings), n_(motion.source.size())
  {
  }

  void run()
  {
    check_set();
    check_source();
    check_varus();
    check_poses();
    if (model_.has_compartments) {
      contacts("medial_reference", motion_.medial_reference_mm);
      contacts("medial_moving", motion_.medial_moving_mm);
      contacts("lateral_reference", motion_.lateral_reference_mm);
      contacts("lateral_moving", motion_.lateral_moving_mm);
    }
    check_intervals();
  }

 private:
  bool is(std::size_t i, ZeroVarusSource source) const
  {
    return motion_.source[i] == static_cast<std::int8_t>(source);
  }
  bool has_pose(std::size_t i) const { return !is(i, ZeroVarusSource::none); }

  /// A number where `is_known(row)`, NaN elsewhere.
  template <typename IsKnown>
  void answers(const char* name, const std::vector<double>& values, const char* wanted, IsKnown is_known)
  {
    findings_.each_number(
        std::string("/zero_varus/") + name, values.data(), values.size(), wanted,
        [&](std::size_t i) { return is_known(i) ? !is_number(values[i]) : !std::isnan(values[i]); });
  }

  void answers(const char* name, const std::vector<double>& values)
  {
    answers(name, values, "a number where source is a pose's, NaN elsewhere",
            [&](std::size_t i) { return has_pose(i); });
  }

  /// Whole rows of numbers or of NaN where `may_be(row)`, NaN elsewhere.
  template <typename MayBe>
  void rows(const char* name, const Rows& numbers, const char* wanted, MayBe may_be)
  {
    findings_.each(
        std::string("/zero_varus/") + name, numbers.values.size() / numbers.width, wanted,
        [&](std::size_t i) { return !numbers.are_nan(i) && !(may_be(i) && numbers.are_finite(i)); },
        [&](std::size_t i) { return may_be(i) ? "no numbers" : "numbers without a pose"; });
  }

  void contacts(const char* name, const std::vector<double>& points)
  {
    rows(name, {points, 3}, "a point or NaN where source is a pose's, NaN elsewhere",
         [&](std::size_t i) { return has_pose(i); });
  }

  void intervals(const char* name, const std::vector<double>& values, std::size_t width = 1)
  {
    rows(name, {values, width}, "numbers or NaN between two poses, NaN elsewhere",
         [&](std::size_t i) { return has_pose(i) && has_pose(i + 1); });
  }

  void check_set()
  {
    if (is_audit_name(motion_.set) && motion_.set != "zero_varus") return;
    findings_.find("/zero_varus@set", motion_.set, "raw, degree_N or degree_N_recontacted");
  }

  void check_source()
  {
    findings_.codes("/zero_varus/source", motion_.source.data(), n_,
                    flag_table(FlagSet::zero_varus_source).values);
    findings_.each(
        "/zero_varus/source", n_, "free only where /varus has one value",
        [&](std::size_t i) { return is(i, ZeroVarusSource::free) && model_.varus_deg.size() > 1; },
        [](std::size_t) { return "free"; });
  }

  void check_varus()
  {
    const std::vector<double>&varus = motion_.varus_deg, &first = motion_.varus_first_deg,
          &last = motion_.varus_last_deg;
    const auto is_mean = [&](std::size_t i) { return is(i, ZeroVarusSource::both_touch); };
    answers("varus", varus);
    answers("varus_first", first, "a number where source is both_touch, NaN elsewhere", is_mean);
    answers("varus_last", last, "a number where source is both_touch, NaN elsewhere", is_mean);
    findings_.each_number("/zero_varus/varus_last", last.data(), n_, "at least varus_first",
                          [&](std::size_t i) { return last[i] < first[i]; });
    findings_.each_number("/zero_varus/varus", varus.data(), n_, "the mean of varus_first and varus_last",
                          [&](std::size_t i) {
                            const double mean_deg = 0.5 * (first[i] + last[i]);
                            return is_mean(i) && std::abs(varus[i] - mean_deg) > exact_tolerance;
                          });
  }

  void check_poses()
  {
    answers("tx", motion_.tx_mm);
    answers("ty", motion_.ty_mm);
    answers("tz", motion_.tz_mm);
    answers("theta", motion_.theta_deg);
    const Rows X{motion_.X_reference_moving, 16};
    findings_.each(
        "/zero_varus/X_reference_moving", n_,
        "a rotation and a translation where source is a pose's, NaN elsewhere",
        [&](std::size_t i) { return has_pose(i) ? !is_rigid_pose(X.begin(i)) : !X.are_nan(i); },
        [&](std::size_t i) { return has_pose(i) ? "no rigid pose" : "numbers without a pose"; });
    answers("flexion_angle", motion_.clinical_flexion_deg);
    answers("varus_angle", motion_.clinical_varus_deg);
    answers("internal_rotation", motion_.internal_rotation_deg);
    answers("anterior", motion_.anterior_mm);
    answers("proximal", motion_.proximal_mm);
    answers("lateral", motion_.lateral_mm);
  }

  void check_intervals()
  {
    intervals("helical_rotation", motion_.helical_rotation_deg);
    intervals("helical_translation", motion_.helical_translation_mm);
    intervals("helical_direction", motion_.helical_direction, 3);
    intervals("helical_point", motion_.helical_point_mm, 3);
    intervals("instant_centre", motion_.instant_centre_mm, 2);
    const std::vector<double>& directions = motion_.helical_direction;
    const auto length = [&](std::size_t i) {
      return Eigen::Map<const Eigen::Vector3d>(&directions[3 * i]).norm();
    };
    findings_.each(
        "/zero_varus/helical_direction", directions.size() / 3, "unit vectors",
        [&](std::size_t i) {
          return Rows{directions, 3}.are_finite(i) && std::abs(length(i) - 1.0) > exact_tolerance;
        },
        [&](std::size_t i) { return "a vector of length " + text_of(length(i)); });
    if (!model_.has_compartments) return;
    intervals("medial_rolling", motion_.medial_rolling_mm);
    intervals("medial_sliding", motion_.medial_sliding_mm);
    intervals("lateral_rolling", motion_.lateral_rolling_mm);
    intervals("lateral_sliding", motion_.lateral_sliding_mm);
  }

  const ZeroVarus& motion_;
  const MotionModel& model_;
  ValueFindings& findings_;
  std::size_t n_;
};

}  // namespace

void check_zero_varus(const ZeroVarus& motion, const MotionModel& model, ValueFindings& findings)
{
  ZeroVarusCheck(motion, model, findings).run();
}

}  // namespace vrda
