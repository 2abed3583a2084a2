// [fit] of a job: what `vrda fit --to` may change.
#include "job/command_jobs.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "core/value.hpp"

namespace vrda::job {
namespace {

// The keys of each quantity besides sd, from and to: those it may have, and of these those it must have.
struct QuantityKeys {
  const char* name;
  std::vector<std::string> may, must;
};

const QuantityKeys& keys_of(FitQuantity quantity)
{
  static const QuantityKeys all[] = {
      {"reference_strain", {"fibre", "bundle"}, {}},
      {"attachment", {"fibre", "bundle", "body", "axis"}, {"body", "axis"}},
      {"load", {"load", "flexion_deg"}, {"load"}},
  };
  return all[static_cast<std::size_t>(quantity)];
}

FitParameterJob parameter_of(const core::Document& document, const core::DocumentValue& value,
                             const std::string& key)
{
  FitParameterJob parameter;
  const std::string& quantity = core::text_at(value, "quantity");
  for (const FitQuantity known :
       {FitQuantity::reference_strain, FitQuantity::attachment, FitQuantity::load}) {
    if (quantity == keys_of(known).name) parameter.quantity = known;
  }
  const QuantityKeys& keys = keys_of(parameter.quantity);
  for (const char* name : {"fibre", "bundle", "body", "axis", "load", "flexion_deg"}) {
    const bool has = value.find(name) != nullptr;
    const auto is_in = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    if (has && !is_in(keys.may))
      document.refuse(key + "." + name, "this key", "no value: the quantity is " + quantity);
    if (!has && is_in(keys.must))
      document.refuse(key + "." + name, "nothing", "this key, since the quantity is " + quantity);
  }
  parameter.fibre = core::text_or_empty(value, "fibre");
  parameter.bundle = core::text_or_empty(value, "bundle");
  if (!parameter.fibre.empty() && !parameter.bundle.empty())
    document.refuse(key, "both fibre and bundle", "one of them, or none for all fibres");
  parameter.shared_by = core::text_at(value, "shared_by");
  parameter.body = core::text_or_empty(value, "body");
  parameter.axis = core::text_or_empty(value, "axis");
  parameter.load = core::text_or_empty(value, "load");
  if (value.find("flexion_deg") != nullptr)
    parameter.flexion_deg = core::numbers_at(value, "flexion_deg");
  const std::vector<double>& flexions = parameter.flexion_deg;
  if (std::adjacent_find(flexions.begin(), flexions.end(), std::greater_equal<>()) != flexions.end())
    document.refuse(key + ".flexion_deg", core::shown(core::value_at(value, "flexion_deg")),
                    "ascending angles");
  parameter.sd = core::number_at(value, "sd");
  parameter.from = core::number_at(value, "from");
  parameter.to = core::number_at(value, "to");
  if (parameter.from == parameter.to) document.refuse(key + ".to", "0, as from", "a range of changes");
  return parameter;
}

}  // namespace

std::optional<FitJob> fit_of(const core::Document& document)
{
  const core::DocumentValue* table = document.root.find("fit");
  if (table == nullptr) return std::nullopt;
  FitJob fit;
  fit.noise.fill(std::numeric_limits<double>::infinity());
  bool is_fitted = false;
  for (std::size_t k = 1; k < n_joint_coordinates; ++k) {
    const std::string key =
        std::string("noise.") + joint_coordinate_names[k] + (is_rotation(k) ? "_deg" : "_mm");
    const double noise = core::number_at(*table, key);
    fit.noise[k] = is_rotation(k) ? rad_from_deg(noise) : noise;
    is_fitted = is_fitted || noise < std::numeric_limits<double>::infinity();
  }
  if (!is_fitted) document.refuse("fit.noise", "no coordinate to fit", "at least one that is not inf");
  fit.independent_deg = core::number_at(*table, "independent_deg");
  for (const core::DocumentValue& value : *core::value_at(*table, "parameter").list()) {
    const std::string key = "fit.parameter." + std::to_string(fit.parameters.size());
    fit.parameters.push_back(parameter_of(document, value, key));
  }
  return fit;
}

}  // namespace vrda::job
