// Removes copies of triangles.
#include <algorithm>
#include <compare>
#include <cstdint>
#include <numeric>

#include "job/clean_mesh.hpp"

namespace vrda::job {
namespace {

using Triangle = std::array<std::int32_t, 3>;

constexpr std::size_t no_copy = static_cast<std::size_t>(-1);

Triangle sorted(Triangle t)
{
  std::sort(t.begin(), t.end());
  return t;
}

// Whether the corners run through their sorted order forward.
bool is_forward(const Triangle& t)
{
  return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2;
}

// Whether two triangles may have the same vertices: nearly always exact, and much faster than a full sort.
bool may_have_copies(const std::vector<Triangle>& triangles)
{
  std::vector<std::uint64_t> keys;
  keys.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    std::uint64_t key = 0;
    for (const std::int32_t v : sorted(triangle))
      key = (key ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15U ^ key >> 29U;
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  return std::adjacent_find(keys.begin(), keys.end()) != keys.end();
}

// Triangles with the same vertices: the first one of each winding.
struct Copies {
  std::size_t first = no_copy, other = no_copy;

  bool is_open() const { return other != no_copy; }
  void choose_other() { first = other; }
  void close() { other = no_copy; }
};

std::vector<Copies> copies_of(const std::vector<Triangle>& triangles)
{
  std::vector<std::size_t> order(triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Triangle l = sorted(triangles[a]), r = sorted(triangles[b]);
    return l != r ? l < r : a < b;
  });
  std::vector<Copies> groups;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Triangle& t = triangles[order[k]];
    if (k == 0 || sorted(t) != sorted(triangles[order[k - 1]])) {
      groups.push_back({order[k], no_copy});
    } else if (!groups.back().is_open() && is_forward(t) != is_forward(triangles[groups.back().first])) {
      groups.back().other = order[k];
    }
  }
  std::sort(groups.begin(), groups.end(), [](const Copies& a, const Copies& b) { return a.first < b.first; });
  return groups;
}

bool runs_along(const Triangle& t, std::int32_t from, std::int32_t to)
{
  for (std::size_t k = 0; k < 3; ++k) {
    if (t[k] == from && t[(k + 1) % 3] == to) return true;
  }
  return false;
}

// Chooses the winding of open groups from neighbour to neighbour, over edges of two groups.
class Windings {
 public:
  Windings(const std::vector<Triangle>& triangles, std::vector<Copies>& groups)
      : triangles_(triangles), groups_(groups)
  {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const Triangle& t = triangles[groups[g].first];
      for (std::size_t k = 0; k < 3; ++k)
        edges_.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]), g});
    }
    std::sort(edges_.begin(), edges_.end());
  }

  void choose()
  {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!groups_[g].is_open()) known_.push_back(g);
    }
    spread();
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!groups_[g].is_open()) continue;
      groups_[g].close();
      known_.push_back(g);
      spread();
    }
  }

 private:
  struct Edge {
    std::int32_t low, high;
    std::size_t group;
    auto operator<=>(const Edge&) const = default;
  };

  void spread()
  {
    for (; next_ < known_.size(); ++next_) {
      const Triangle t = triangles_[groups_[known_[next_]].first];
      for (std::size_t k = 0; k < 3; ++k) reach(known_[next_], t[k], t[(k + 1) % 3]);
    }
  }

  void reach(std::size_t g, std::int32_t from, std::int32_t to)
  {
    const Edge edge{std::min(from, to), std::max(from, to), 0};
    const auto at = std::lower_bound(edges_.begin(), edges_.end(), edge);
    std::size_t n = 0, neighbour = no_copy;
    for (auto e = at; e != edges_.end() && e->low == edge.low && e->high == edge.high; ++e, ++n) {
      if (e->group != g) neighbour = e->group;
    }
    if (n != 2 || neighbour == no_copy || !groups_[neighbour].is_open()) return;
    if (!runs_along(triangles_[groups_[neighbour].first], to, from)) groups_[neighbour].choose_other();
    groups_[neighbour].close();
    known_.push_back(neighbour);
  }

  const std::vector<Triangle>& triangles_;
  std::vector<Copies>& groups_;
  std::vector<Edge> edges_;
  std::vector<std::size_t> known_;  // groups whose neighbours are reached, in order
  std::size_t next_ = 0;
};

}  // namespace

std::vector<Triangle> without_copies(const std::vector<Triangle>& triangles)
{
  if (!may_have_copies(triangles)) return triangles;
  std::vector<Copies> groups = copies_of(triangles);
  if (std::any_of(groups.begin(), groups.end(), [](const Copies& c) { return c.is_open(); }))
    Windings(triangles, groups).choose();
  std::vector<std::size_t> kept;
  for (const Copies& group : groups) kept.push_back(group.first);
  std::sort(kept.begin(), kept.end());
  std::vector<Triangle> out;
  for (const std::size_t t : kept) out.push_back(triangles[t]);
  return out;
}

}  // namespace vrda::job
