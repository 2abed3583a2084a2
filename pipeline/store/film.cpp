#include "store/film.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "model/step_record.hpp"
#include "core/units.hpp"

namespace vrda::store {
namespace {

bool is_node(const store::Trace& trace, std::size_t search, StepKind kind)
{
  return trace.searches.node[search] == static_cast<std::int8_t>(kind);
}

// Without a varus the spine cell of the flexion; otherwise the search of the attitude's cell.
std::size_t chosen_search(const store::Trace& trace, const std::string& file, store::AttitudeFilter cell)
{
  const bool wants_spine = !cell.varus_deg.has_value();
  if (!cell.flexion_deg) {
    const std::vector<std::size_t> any = store::searches_at(trace, file, cell);
    cell.flexion_deg = trace.searches.flexion_deg[any.front()];
  }
  const std::vector<std::size_t> found = store::searches_at(trace, file, cell);
  const auto chosen = std::find_if(found.begin(), found.end(), [&](std::size_t s) {
    return wants_spine ? is_node(trace, s, StepKind::spine) : !is_node(trace, s, StepKind::spine_probe);
  });
  if (chosen != found.end()) return *chosen;
  throw InputError({file, "/searches/node", "only probes at that attitude",
                    wants_spine ? "a spine cell, or a varus" : "the search of its cell"});
}

PoseCoordinates numbers_of(const store::Points32& translation_mm, std::size_t row, float theta_deg)
{
  const auto i = static_cast<Eigen::Index>(row);
  return {translation_mm(i, 0), translation_mm(i, 1), translation_mm(i, 2),
          rad_from_deg(static_cast<double>(theta_deg))};
}

}  // namespace

Film film_of(const store::Trace& trace, const std::string& file, const FilmOptions& options)
{
  check(options.every > 0, "a film keeps every Nth frame, N above 0");
  const std::size_t search = chosen_search(trace, file, options.cell);
  std::vector<PoseCoordinates> all;
  if (!options.contact_only) {
    all.push_back(
        numbers_of(trace.searches.seed_translation_mm, search, trace.searches.seed_theta_deg[search]));
  }
  const store::MoveRange range = store::moves_of(trace, search);
  for (std::size_t m = range.first; m < range.end; ++m) {
    if (options.contact_only && trace.moves.in_contact[m] == 0) continue;
    all.push_back(numbers_of(trace.moves.translation_mm, m, trace.moves.theta_deg[m]));
  }
  if (all.empty()) throw InputError({file, "/moves/in_contact", "no move in contact", "at least one"});
  Film film;
  film.attitude = {rad_from_deg(trace.searches.flexion_deg[search]),
                   rad_from_deg(trace.searches.varus_deg[search])};
  const auto every = static_cast<std::size_t>(options.every);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k % every == 0 || k + 1 == all.size()) film.frames.push_back(all[k]);
  }
  return film;
}

}  // namespace vrda::store
