/// [uncertainty] of a job: which inputs are uncertain and how they are distributed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vrda::job {

enum class DistributionKind { normal, lognormal, uniform, table };

/// Of one number: a factor or a change, in the unit of what it changes.
struct Distribution {
  DistributionKind kind = DistributionKind::normal;
  double mean = 0.0;           ///< normal: mean; lognormal: median, above 0
  double sd = 0.0;             ///< normal: standard deviation; lognormal: that of the natural logarithm
  double from = 0.0, to = 0.0; ///< uniform
  std::vector<double> values = {};  ///< table: ascending, equally likely, linear between neighbours
};

enum class UncertainQuantity { stiffness, reference_strain, attachment, load, rotation_centre, offset };

/// Which fibres share one draw.
enum class SharedBy { fibre, bundle, all };

enum class UncertainLoad { force, anterior_force, right_force, moment, varus_moment, applied, line };

/// One [[uncertainty.parameter]].
struct UncertainParameter {
  std::string name;
  UncertainQuantity quantity = UncertainQuantity::stiffness;
  Distribution distribution;
  bool is_factor = false;  ///< the distribution is that of a factor, else of a change
  /// Of stiffness, reference strain and attachment: rows of the case's fibres.
  std::vector<std::size_t> fibres;
  SharedBy shared_by = SharedBy::bundle;
  double correlation = 0.0;  ///< of the fibres of one bundle, with SharedBy::fibre
  bool is_moving = false;    ///< object of the attachment or offset
  std::int32_t component = 0;                          ///< of the offset, in its object
  UncertainLoad load = UncertainLoad::force;
  std::size_t load_row = 0;  ///< of an applied load or a line
};

enum class SampleSequence { sobol, latin_hypercube };

struct Uncertainty {
  std::int32_t n_samples = 0;  ///< at least 2
  SampleSequence sequence = SampleSequence::sobol;
  std::uint32_t seed = 1;
  std::vector<UncertainParameter> parameters;  ///< at least one
  /// [n_fibres] Reference strain at the pose of the meshes if the fibre is given by it, NaN if by its slack
  /// length. The former keep their strain when attachments move.
  std::vector<double> reference_strain;
};

}  // namespace vrda::job
