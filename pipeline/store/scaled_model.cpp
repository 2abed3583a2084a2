#include "store/scaled_model.hpp"

#include <cmath>

#include "core/error.hpp"
#include "store/member_visitor.hpp"

namespace vrda::store {
namespace {

/// Multiplies values by the factor to the length power of their unit.
class Scale : public MemberVisitor {
 public:
  explicit Scale(double factor) : factor_(factor) {}

 protected:
  void change_attribute(std::span<double> values, const Unit& units) override
  {
    for (double& value : values) value *= factor_of(units);
  }

  void change(const Dataset& dataset, const Values& values, const Resize&) override
  {
    const auto* numbers = std::get_if<std::span<double>>(&values);
    if (numbers == nullptr) return;
    const double factor = factor_of(dataset.units);
    // In poses (4 x 4, row by row) only the translation is a length.
    const bool is_pose = dataset.valid.rule == Rule::rigid;
    for (std::size_t k = 0; k < numbers->size(); ++k)
      if (!is_pose || (k % 4 == 3 && k % 16 != 15)) (*numbers)[k] *= factor;
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
  if (factor != 1.0) visit_members(model, scale);
  return model;
}

}  // namespace vrda::store
