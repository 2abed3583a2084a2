/// Rows of the registry: the motion of an uncertain job.
#include "store/registry_rows.hpp"

namespace vrda::store::registry {

// One line per dataset.
// clang-format off

void visit_uncertainty(UncertainMotion& motion, bool has_fibres, RowVisitor& visit)
{
  const std::string group = "/uncertainty";
  const std::string sample = group + "/sample", draw = group + "/draw", band = group + "/quantile";
  const ValueCondition stable = where_stable(motion.status);
  const auto at_least_minus_1 = ValueRule{.rule = Rule::number_or_nan, .least = -1.0};
  const auto at_least_0_or_nan = ValueRule{.rule = Rule::number_or_nan, .least = 0.0};
  visit.group(group);
  visit.attribute(group, "sequence", motion.sequence);
  visit.attribute(group, "seed", motion.seed);
  visit.dimension(draw, DimensionSize::counted(motion.draw.size()));
  visit.dimension(sample, DimensionSize::counted(motion.n_samples()));
  visit.dimension(group + "/angle", DimensionSize::fixed(3));
  visit.dimension(group + "/direction", DimensionSize::fixed(3));
  visit.dimension(group + "/compartment", DimensionSize::fixed(3));
  visit.dimension(band, DimensionSize::fixed(static_cast<std::int64_t>(band_probabilities.size())));
  visit.dimension(group + "/quantity", DimensionSize::fixed(static_cast<std::int64_t>(uncertain_quantities.size())));
  // netCDF finds dimensions in a group and those above it, so not in /ligaments.
  if (has_fibres) visit.dimension(group + "/fibre", DimensionSize::fixed(static_cast<std::int64_t>(visit.size("/ligaments/fibre"))));
  const std::vector<std::string> poses{sample, "/flexion"}, table{"/flexion", group + "/quantity", draw};
  const auto of_sample = [&](const char* of) { return std::vector<std::string>{sample, "/flexion", group + of}; };
  const auto of_band = [&](const std::string& of) { return std::vector<std::string>{band, "/flexion", of}; };
  visit({group + "/draw_name", {draw}, unit::none, rule(Rule::unique_names), "names of the independent draws"}, motion.draw);
  visit({group + "/quantity_name", {group + "/quantity"}, unit::none, rule(Rule::unique_names), "names of the results"}, motion.quantity);
  visit({group + "/probability", {band}, unit::one, ValueRule{.rule = Rule::number, .least = 0.0, .largest = 1.0}, "probabilities of the bands: smallest, 5 %, median, 95 %, largest"}, motion.probability);
  visit({group + "/value", {sample, draw}, unit::one, number(), "value of each draw: a factor, a change in the unit of its quantity, or a standard normal score"}, motion.value);
  visit({group + "/status", poses, unit::none, codes(FlagSet::solver_status), "how the motion step of the sample ended"}, motion.status);
  visit({group + "/rotation", of_sample("/angle"), unit::degree, number(stable), "Grood-Suntay flexion, varus and internal rotation of each sample"}, motion.rotation_deg);
  visit({group + "/translation", of_sample("/direction"), unit::mm, number(stable), "anterior, proximal and lateral translation of each sample, of the job's rotation centre"}, motion.translation_mm);
  visit({group + "/contact_force", of_sample("/compartment"), unit::n, at_least_0_or_nan, "resultant contact force of each sample: all, medial, lateral"}, motion.contact_force_n);
  visit({group + "/n_solved", {"/flexion"}, unit::one, count(), "samples with a stable pose"}, motion.n_solved);
  visit({group + "/rotation_band", of_band(group + "/angle"), unit::degree, number_or_nan(), "quantiles of the rotations"}, motion.rotation_band_deg);
  visit({group + "/translation_band", of_band(group + "/direction"), unit::mm, number_or_nan(), "quantiles of the translations"}, motion.translation_band_mm);
  visit({group + "/contact_force_band", of_band(group + "/compartment"), unit::n, at_least_0_or_nan, "quantiles of the contact forces"}, motion.contact_force_band_n);
  if (has_fibres) visit({group + "/tension_band", of_band(group + "/fibre"), unit::n, at_least_0_or_nan, "quantiles of the tensions of the fibres"}, motion.tension_band_n);
  const std::vector<std::string> motions{band, "/flexion"};
  const ValueCondition posed = where_stable(motion.quantile_status);
  visit({group + "/quantile_sample", {band}, unit::one, row_of(static_cast<Eigen::Index>(visit.size(sample))), "sample at each probability in the order of internal rotation, as mean over flexion"}, motion.quantile_sample);
  visit({group + "/quantile_status", motions, unit::none, codes(FlagSet::solver_status), "how the motion step of that sample ended"}, motion.quantile_status);
  visit({group + "/tx", motions, unit::mm, number(posed), "translation of that sample along X of the world frame W"}, motion.tx_mm);
  visit({group + "/ty", motions, unit::mm, number(posed), "translation of that sample along Y of the world frame W"}, motion.ty_mm);
  visit({group + "/tz", motions, unit::mm, number(posed), "translation of that sample along Z of the world frame W"}, motion.tz_mm);
  visit({group + "/theta", motions, unit::degree, number(posed), "rotation of that sample about Delta, right-knee sign"}, motion.theta_deg);
  visit({group + "/varus", motions, unit::degree, number(posed), "varus of that sample, adduction positive"}, motion.varus_deg);
  visit({group + "/rank_correlation", table, unit::one, at_least_minus_1, "Spearman's rank correlation of each result with each draw"}, motion.rank_correlation);
  visit({group + "/first_order", table, unit::one, at_least_0_or_nan, "first-order Sobol index: share of the variance that the draw explains alone"}, motion.first_order);
  visit({group + "/first_order_low", table, unit::one, at_least_0_or_nan, "lower end of its 90 % interval"}, motion.first_order_low);
  visit({group + "/first_order_high", table, unit::one, at_least_0_or_nan, "upper end of its 90 % interval"}, motion.first_order_high);
}

// clang-format on
}  // namespace vrda::store::registry
