/// The unknowns of [fit], and a case with them changed.
#pragma once

#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/job.hpp"

namespace vrda::analysis {

/// The loads that may change.
enum class FittedLoad { force, anterior_force, right_force, moment, varus_moment };

/// One number that is fitted: a change of strain, length (mm), force (N) or moment (N mm).
struct Unknown {
  std::string name;  ///< "reference_strain ACLam", "moment at 30"
  job::FitQuantity quantity = job::FitQuantity::reference_strain;
  std::vector<std::size_t> fibres;  ///< rows that change together
  bool is_moving = false;           ///< object of an attachment
  Eigen::Index axis = 0;            ///< of an attachment, canonical
  FittedLoad load = FittedLoad::force;
  double flexion_rad = nan;               ///< of a load that changes over flexion
  std::vector<double> all_flexions_rad;   ///< of the same load, ascending; empty: constant
  double sd = 0.0, from = 0.0, to = 0.0;  ///< prior and bounds of the change

  const char* unit() const;
};

/// Expands the parameters of the job: one unknown per bundle, fibre or flexion. Throws InputError naming the
/// key: a fibre or bundle that the case does not have, or a load that leaves no force along Delta at `from`.
std::vector<Unknown> unknowns_of(const job::Job& job, const job::Case& job_case);

/// The changes of all loads at a flexion: linear between the angles of an unknown, constant beyond.
struct LoadChange {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< anterior, proximal, right
  double moment_nmm = 0.0, varus_moment_nmm = 0.0;
};
/// The part of the change that an unknown of this kind sets.
double& component(LoadChange& change, FittedLoad load);
LoadChange load_change_at(const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change,
                          double flexion_rad);

/// Fibres with changed attachments and slack lengths: the reference strain (at the pose of the meshes) is the
/// case's plus its change, wherever the attachments are.
model::Ligaments changed_ligaments(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                                      const Eigen::VectorXd& change);

/// The case with the changes applied to fibres and loads.
job::Case changed_case(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                        const Eigen::VectorXd& change);

}  // namespace vrda::analysis
