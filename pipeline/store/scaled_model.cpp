// Uniform scaling of a motion model to a subject's size, without a new run.
#include "store/motion_model.hpp"

#include <cmath>

#include "core/error.hpp"
#include "store/registry.hpp"

namespace vrda::store {
namespace {

/// Multiplies values by the factor to the length power of their unit.
class Scale : public RegistryVisitor {
 public:
  explicit Scale(double factor) : factor_(factor) {}

  template <typename Member>
  void attribute(const std::string&, const std::string&, Member& member, const Unit& units)
  {
    if constexpr (std::is_same_v<Member, double> || std::is_same_v<Member, Eigen::Vector3d>)
      member *= factor_of(units);
  }

  template <typename Member>
  void operator()(const Dataset& dataset, Member& member)
  {
    if constexpr (member_kind<Member>() == ValueKind::float64) {
      const double factor = factor_of(dataset.units);
      // In poses (4 x 4, row by row) only the translation is a length.
      const bool is_pose = dataset.valid.rule == Rule::rigid;
      const auto values = values_of(member);
      for (std::size_t k = 0; k < values.size(); ++k)
        if (!is_pose || (k % 4 == 3 && k % 16 != 15)) values[k] *= factor;
    }
  }

 private:
  double factor_of(const Unit& units) const { return units.length_power == 0 ? 1.0 : factor_; }

  double factor_;
};

}  // namespace

MotionModel scaled_model(MotionModel model, double factor)
{
  check(std::isfinite(factor) && factor > 0.0, "the scale factor must be above 0");
  Scale scale(factor);
  if (factor != 1.0) visit_motion_model(model, scale);
  return model;
}

}  // namespace vrda::store
