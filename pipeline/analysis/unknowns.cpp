#include "analysis/unknowns.hpp"

#include <algorithm>
#include <array>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
namespace {

constexpr std::array<const char*, 5> load_names{"force", "anterior_force", "right_force", "moment",
                                                "varus_moment"};
constexpr std::array<const char*, 3> axis_names{"anterior", "proximal", "right"};
constexpr double least_strain = -0.9, largest_strain = 1.0;  // as an uncertain strain

template <std::size_t n>
std::size_t row_of_name(const std::array<const char*, n>& names, const std::string& name)
{
  for (std::size_t k = 0; k < n; ++k) {
    if (name == names[k]) return k;
  }
  check(false, "a word of the schema");
  return 0;
}

// Names of the groups that share an unknown, in the order of the fibres, with their rows.
struct FibreGroup {
  std::string name;
  std::vector<std::size_t> fibres;
};

std::vector<FibreGroup> groups_of(const job::Job& job, const std::vector<model::Fibre>& fibres,
                                  std::size_t number)
{
  const job::FitParameterJob& parameter = job.fit->parameters[number];
  std::vector<FibreGroup> groups;
  for (std::size_t k = 0; k < fibres.size(); ++k) {
    if (!parameter.fibre.empty() && fibres[k].name != parameter.fibre) continue;
    if (!parameter.bundle.empty() && fibres[k].bundle != parameter.bundle) continue;
    const std::string name = parameter.shared_by == "all"     ? "all"
                             : parameter.shared_by == "fibre" ? fibres[k].name
                                                              : fibres[k].bundle;
    auto at =
        std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.name == name; });
    if (at == groups.end()) at = groups.insert(groups.end(), {name, {}});
    at->fibres.push_back(k);
  }
  if (!groups.empty()) return groups;
  const bool is_fibre = !parameter.fibre.empty();
  std::vector<std::string> known;
  for (const model::Fibre& fibre : fibres) known.push_back(is_fibre ? fibre.name : fibre.bundle);
  const std::string& requested = is_fibre ? parameter.fibre : parameter.bundle;
  job.document.refuse("fit.parameter." + std::to_string(number) + (is_fibre ? ".fibre" : ".bundle"),
                      known.empty() ? "no fibres" : '"' + requested + '"',
                      known.empty()
                          ? "[ligaments]"
                          : "one of the job; the nearest is \"" + nearest_word(requested, known) + '"');
}

// Of an unknown at one of several angles: 1 there, 0 at the neighbours.
double hat(const Unknown& unknown, double flexion_rad)
{
  const std::vector<double>& nodes = unknown.all_flexions_rad;
  if (nodes.empty()) return 1.0;
  const double at = std::clamp(flexion_rad, nodes.front(), nodes.back());
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    if (at < nodes[k] || at > nodes[k + 1]) continue;
    const double share = (at - nodes[k]) / (nodes[k + 1] - nodes[k]);
    if (unknown.flexion_rad == nodes[k]) return 1.0 - share;
    if (unknown.flexion_rad == nodes[k + 1]) return share;
  }
  return 0.0;
}

void add_load(const job::Job& job, std::size_t number, Unknown unknown, std::vector<Unknown>& all)
{
  const job::FitParameterJob& parameter = job.fit->parameters[number];
  unknown.load = static_cast<FittedLoad>(row_of_name(load_names, parameter.load));
  unknown.name = parameter.load;
  const std::string key = "fit.parameter." + std::to_string(number);
  if (unknown.load == FittedLoad::force && !(job.push.force_n.value.minCoeff() + parameter.from > 0.0))
    job.document.refuse(key + ".from", shortest_decimal(parameter.from),
                        "a change that leaves push.force_n above 0");
  if (parameter.flexion_deg.empty()) all.push_back(unknown);
  for (const double flexion_deg : parameter.flexion_deg)
    unknown.all_flexions_rad.push_back(rad_from_deg(flexion_deg));
  for (const double flexion_deg : parameter.flexion_deg) {
    Unknown at = unknown;
    at.name += " at " + shortest_decimal(flexion_deg);
    at.flexion_rad = rad_from_deg(flexion_deg);
    all.push_back(at);
  }
}

}  // namespace

const char* Unknown::unit() const
{
  if (quantity == job::FitQuantity::reference_strain) return "";
  if (quantity == job::FitQuantity::attachment) return "mm";
  return load == FittedLoad::moment || load == FittedLoad::varus_moment ? "N mm" : "N";
}

std::vector<Unknown> unknowns_of(const job::Job& job, const job::Case& job_case)
{
  std::vector<Unknown> all;
  for (std::size_t k = 0; k < job.fit->parameters.size(); ++k) {
    const job::FitParameterJob& parameter = job.fit->parameters[k];
    Unknown unknown;
    unknown.quantity = parameter.quantity;
    unknown.sd = parameter.sd;
    unknown.from = parameter.from;
    unknown.to = parameter.to;
    if (parameter.quantity == job::FitQuantity::load) {
      add_load(job, k, unknown, all);
      continue;
    }
    const bool is_strain = parameter.quantity == job::FitQuantity::reference_strain;
    if (!is_strain) {
      unknown.is_moving = parameter.body == "moving";
      unknown.axis = static_cast<Eigen::Index>(row_of_name(axis_names, parameter.axis));
    }
    for (const FibreGroup& group : groups_of(job, job_case.ligaments.fibres, k)) {
      unknown.fibres = group.fibres;
      unknown.name = is_strain ? "reference_strain " + group.name
                               : "attachment " + parameter.body + ' ' + group.name + ' ' + parameter.axis;
      all.push_back(unknown);
    }
  }
  return all;
}

double& component(LoadChange& change, FittedLoad load)
{
  switch (load) {
    case FittedLoad::anterior_force:
      return change.force_n.x();
    case FittedLoad::force:
      return change.force_n.y();
    case FittedLoad::right_force:
      return change.force_n.z();
    case FittedLoad::moment:
      return change.moment_nmm;
    case FittedLoad::varus_moment:
      break;
  }
  return change.varus_moment_nmm;
}

LoadChange load_change_at(const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change,
                          double flexion_rad)
{
  LoadChange loads;
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    if (unknowns[k].quantity == job::FitQuantity::load)
      component(loads, unknowns[k].load) +=
          hat(unknowns[k], flexion_rad) * change(static_cast<Eigen::Index>(k));
  }
  return loads;
}

model::Ligaments changed_ligaments(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                                      const Eigen::VectorXd& change)
{
  model::Ligaments ligaments = job_case.ligaments;
  std::vector<double> strain_change(ligaments.fibres.size(), 0.0);
  std::vector<bool> is_changed(ligaments.fibres.size(), false);
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    const double by = change(static_cast<Eigen::Index>(k));
    for (const std::size_t row : unknowns[k].fibres) {
      is_changed[row] = is_changed[row] || by != 0.0;
      model::Fibre& fibre = ligaments.fibres[row];
      if (unknowns[k].quantity == job::FitQuantity::attachment) {
        (unknowns[k].is_moving ? fibre.moving_mm : fibre.reference_mm)(unknowns[k].axis) += by;
      } else {
        strain_change[row] += by;
      }
    }
  }
  const std::vector<model::FibreState> before = model::fibre_states(job_case.ligaments, {}, {});
  const std::vector<model::FibreState> after = model::fibre_states(ligaments, {}, {});
  for (std::size_t row = 0; row < before.size(); ++row) {
    if (!is_changed[row] || !(after[row].length_mm > 0.0)) continue;
    const double strain =
        before[row].length_mm / ligaments.fibres[row].slack_length_mm - 1.0 + strain_change[row];
    ligaments.fibres[row].slack_length_mm =
        after[row].length_mm / (1.0 + std::clamp(strain, least_strain, largest_strain));
  }
  return ligaments;
}

job::Case changed_case(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                        const Eigen::VectorXd& change)
{
  job::Case changed = job_case;
  changed.ligaments = changed_ligaments(job_case, unknowns, change);
  const auto change_rows = [&](std::vector<job::Push>& rows, const std::vector<double>& flexions_deg) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const LoadChange by = load_change_at(unknowns, change, rad_from_deg(flexions_deg[k]));
      rows[k].force_n += by.force_n;
      rows[k].moment_nmm += by.moment_nmm;
      rows[k].varus_moment_nmm += by.varus_moment_nmm;
    }
  };
  change_rows(changed.push, changed.grid.flexion_deg);
  change_rows(changed.path_push, changed.path_flexion_deg);
  return changed;
}

}  // namespace vrda::analysis
