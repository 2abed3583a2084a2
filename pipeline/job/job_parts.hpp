/// The parts of a job that have a table of their own: [fit], [laxity], [push], [coordinates], [scaling],
/// [uncertainty].
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"

namespace vrda::job {

/// [fit]: what `vrda fit --to` may change. Absent if the job has none. Throws InputError naming the key: one
/// that the quantity does not have or lacks, angles that do not ascend, no coordinate to fit.
std::optional<FitJob> fit_of(const core::Document& document);

/// [laxity]: the loads of `vrda laxity`. Absent if the job has none. Throws InputError naming the key: angles
/// that do not ascend, no load.
std::optional<LaxityJob> laxity_of(const core::Document& document);

/// The job over these flexions (degrees, ascending) with varus free and nothing smoothed, whatever its grid.
/// Its texts are those of the given job. Throws InputError naming the key unless the method is the
/// equilibrium, Delta is +Y and turns with the moving object, and the job has a grid.
Job over_flexions(const Job& job, const std::vector<double>& flexion_deg);

// The loads of a job, [push]: parsing, and their values at one flexion.

/// Throws InputError naming the key: a zero direction, load or tension, a name twice, a list of another
/// length than its flexions, a line whose objects' points coincide.
PushJob push_of(const core::Document& document);

/// All settings that may have columns, with the least value that each may have (NaN: any).
struct PushTable {
  FlexionTable* table = nullptr;
  double least = 0.0;
  bool excludes_least = false;
};
std::vector<PushTable> tables_of(PushJob& push);

/// The loads at a flexion and, of a sequence, at a frame; `delta` is the unit direction there. The lateral
/// force acts across Delta, along X and Z rotated by the shortest rotation from +Y to Delta.
Push push_at(const PushJob& job, const Eigen::Vector3d& delta, double flexion_rad, std::size_t frame = 0);

/// [[prior]]: springs to published curves (schemas/prior.md); empty if the job has none. `band_moment_nmm`:
/// measures the joint's own stiffness. Throws InputError naming the key: a coordinate twice, a curve that is
/// not published for it, factors without their definition, a method, direction or axes without springs.
std::vector<PriorTerm> prior_of(const core::Document& document, const PushJob& push, double band_moment_nmm);

// [coordinates] and [frames] of a job: roles of the joint's six coordinates and their values.

/// [coordinates] and [frames], parsed; absent if the job has neither.
std::optional<CoordinatesJob> coordinates_of(const Job& job);

/// Tables over the driving coordinate become tables over flexion where that drives. Refuses them where
/// nothing drives, a direction over another coordinate, and loads over a flexion that is free.
void resolve_driving_tables(Job& job);

/// Flexion driven, varus driven or free, the rest free: what [grid] expresses.
bool is_plain_grid(const CoordinatesJob& coordinates);

/// Roles, values and, of a sequence of frames, keys.
struct LoadedCoordinates {
  CoordinateRows rows;  ///< over the path's flexions, or one per frame
  GridAxes grid;        ///< flexion of each frame (0 where free), or the job's grid
  std::vector<double> path_flexion_deg;
  std::vector<LoadedInput> inputs;
  PushJob push;  ///< of the job, with the columns of the frames
};

/// Reads the tables. Throws InputError naming file, line and column; for a combination that the method or the
/// frame cannot solve it names the key.
LoadedCoordinates load_coordinates(const Job& job, const CoordinatesJob& coordinates,
                                   const std::string& data_directory);

/// The grid's flexions with as many between them as keep steps of at most 1 degree.
std::vector<double> path_of(const std::vector<double>& flexion_deg);

// [[follower]]: bodies that follow the joint (schemas/followers.md).

/// { shape = "knee", ... } of a document.
GenerateJob generate_of(const core::DocumentValue& value);

class ComponentLoader;

/// The row of the follower of that name; `key` is that of the name, for the message.
std::size_t follower_named(const core::Document& document, const std::string& key, const std::string& name);

/// Names by BodyIndex, of the objects before the follower in `row`, or all.
BodyNames names_before(const Job& job, std::size_t row);

/// The body of that name, any object of the job. Throws InputError naming the key.
BodyIndex attached_body(const Job& job, const std::string& name, const std::string& key);

/// [n_fibres] NaN where the fibre is given by its slack length.
std::vector<double> given_strains(const std::vector<FibreJob>& fibres);

/// The list, parsed; `bodies` reads the components. Throws InputError naming the key: a name twice, an
/// object that is not before it, no direction.
std::vector<FollowerJob> followers_of(
    const Job& job, const std::function<BodyJob(const std::string& key, const std::string& name)>& bodies);

/// Reads meshes, fibres and wraps; adds inputs, survey and warnings to `loaded`, which has its two objects.
/// Throws InputError like load_ligaments().
std::vector<Follower> load_followers(const Job& job, const std::string& data_directory,
                                     ComponentLoader& source, Case& loaded);

/// The strains of a follower's fibres, or of `ligaments` in their place, where the scan found all objects.
std::vector<double> scan_strains(const std::vector<Follower>& followers, std::size_t row,
                                 const model::Ligaments& ligaments);
inline std::vector<double> scan_strains(const std::vector<Follower>& followers, std::size_t row)
{
  return scan_strains(followers, row, followers.at(row).ligaments);
}

/// The fibres of a follower by its row or of the joint, and the body of a component or attachment.
template <typename AnyCase>
auto& ligaments_of(AnyCase& of, std::optional<std::size_t> follower)
{
  return follower ? of.followers.at(*follower).ligaments : of.ligaments;
}
template <typename AnyCase>
auto& body_of(AnyCase& of, const UncertainParameter& parameter)
{
  return model::row_of(parameter.body) < 2 ? part_of(of, parameter.body)
                                           : of.followers.at(model::follower_row(parameter.body)).body;
}
/// Tension of all its lines of constant tension together.
double tension_n(const Follower& follower);
/// Its push, or that tension.
double load_n(const Follower& follower, InputLoad load);
/// Sets it; lines keep their shares of a tension above 0.
void set_load(Follower& follower, InputLoad load, double force_n);

/// The words of a parameter, as in the job; empty where it has none.
struct FibreWords {
  const std::string &fibre, &bundle, &body;
};
/// Sets the fibres of a stiffness, strain or attachment: those of `words.fibre` or of `words.bundle`, or all;
/// without lines of constant tension, and of an attachment those that end on its body. Throws InputError
/// naming `key` if no fibre remains.
void choose_fibres(const core::Document& document, const std::string& key,
                   const std::vector<model::Fibre>& fibres, const FibreWords& words, Parameter& parameter);
/// The name of the draw or unknown of a fibre: its own, that of its bundle, or "all".
const std::string& shared_name(const model::Fibre& fibre, SharedBy shared_by);

/// Components of a body in canonical axes. Adds inputs, survey and warnings to `loaded`. `small_shells`:
/// those of the mesh files in contact, as triangles of the body.
Body loaded_body(const Job& job, const BodyJob& body_job, ComponentLoader& source, Case& loaded,
                 std::vector<std::vector<Eigen::Index>>& small_shells);

// Reads [uncertainty] of a job.

struct LoadedUncertainty {
  std::optional<Uncertainty> uncertainty;  ///< empty without [uncertainty]
  std::vector<LoadedInput> inputs;         ///< tables of values
};

/// `loaded` has bodies, fibres, loads and lines. Throws InputError naming the key: a fibre, bundle, component
/// or load that the job does not have, a distribution without its numbers, one that would make a stiffness
/// negative, or a method other than the equilibrium.
LoadedUncertainty load_uncertainty(const Job& job, const std::string& data_directory, const Case& loaded,
                                   const LoadedLigaments& ligaments);

// Distributions of one number (job/case.hpp): quantiles from probabilities.

/// Standard normal distribution: probability below `score`, and its inverse for a probability above 0 and
/// below 1.
double probability_of_score(double score);
double score_of_probability(double probability);

/// The radius within which the unit ball has the same share of its volume as the three-dimensional standard
/// normal distribution has of its probability within `size`: maps three scores to a uniform point of the
/// ball.
double radius_in_ball(double size);

/// The value below which the distribution has this probability.
double quantile_of(const job::Distribution& distribution, double probability);

/// The same for the distribution truncated to values above `least`. Throws InternalError if nothing is left.
double quantile_above(const job::Distribution& distribution, double probability, double least);

}  // namespace vrda::job
