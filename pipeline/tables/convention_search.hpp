/// Finds the convention of a table of poses from the gaps that it leaves between the bodies.
#pragma once

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "core/fields.hpp"
#include "model/frames.hpp"
#include "solve/sweep.hpp"
#include "tables/imported_model.hpp"
#include "tables/motion_table.hpp"

namespace vrda::tables {

/// The terms of a convention, named as the options of the command line.
enum class Term { unit, angles, order, direction, axes, side, lengths };
inline constexpr Named<Term> term_names[] = {
    {Term::unit, "unit"}, {Term::angles, "angles"}, {Term::order, "order"},    {Term::direction, "direction"},
    {Term::axes, "axes"}, {Term::side, "side"},     {Term::lengths, "lengths"}};
constexpr const auto& names_of(Term)
{
  return term_names;
}
inline constexpr auto all_terms = values_in(term_names);

/// The value of a term: "mm", "zxy", ...
std::string value_of(const Convention& convention, Term term);

struct SearchRequest {
  StatedConvention stated;   ///< by the user
  std::set<Term> automatic;  ///< tried even if the file states them
};

/// The signed gap along Delta of a compartment, or of the whole pair, over the frames.
struct GapSpread {
  double mean_mm = 0.0, deviation_mm = 0.0;
};

struct Candidate {
  Convention convention;
  std::vector<GapSpread> gaps;  ///< medial and lateral, or the whole pair; empty: nothing faces in some frame
  double motion_mm = 0.0;       ///< root mean square travel of the moving object about its mean position
  double deviation_mm = std::numeric_limits<double>::infinity();  ///< root mean square over `gaps`
  double share = std::numeric_limits<double>::infinity();         ///< deviation_mm / motion_mm
};

struct ConventionSearch {
  std::vector<Candidate> candidates;  ///< best first; of several with equal poses the first
  std::size_t n_best = 0;             ///< number that cannot be distinguished; 1: found
  std::vector<Term> undecided;        ///< terms in which they differ
};

/// Both bodies in S, for one Delta.
struct SearchScene {
  SolverFrame frame;
  const solve::Joint& joint;
  Box moving_box;  ///< of the moving contact mesh, canonical
};

/// The conventions that the request and the table leave open, in a fixed order. One if nothing is open.
std::vector<Convention> open_conventions(const MotionTable& table, const SearchRequest& request,
                                         const JointFrame& joint);

/// Ranks open_conventions() by Candidate::share. A gap beyond 10 mm on average, or a frame in which nothing
/// faces, is not ranked. Measures at most 31 frames. Same bits for any number of threads. Throws InputError
/// naming the table if nothing can be ranked; not for a single convention.
ConventionSearch find_convention(const MotionTable& table, const SearchRequest& request,
                                 const JointFrame& joint, const SearchScene& scene, int n_threads);

// Whether the angles of a table can be meant in the unit in which they are read.

/// Where the unit of the angles comes from.
enum class UnitSource {
  option,   ///< the user states it
  file,     ///< the table's names or header
  assumed,  ///< nothing states it
  found,    ///< the search of `vrda import`
};

/// Warnings, one line each, of angles that are hardly meant in `unit`: rotations that are small as degrees
/// and usual as radians, in all columns or in one, or the reverse; also that the unit is assumed, or that an
/// option replaces the file's. Throws InputError naming file and column instead where the unit is almost
/// certainly another one, unless `source` is an option or a search. schemas/motion-files.md lists the bounds.
std::vector<std::string> unit_warnings(const MotionTable& table, AngleUnit unit, UnitSource source,
                                       const JointFrame& joint);

}  // namespace vrda::tables
