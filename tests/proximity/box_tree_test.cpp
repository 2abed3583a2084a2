#include "proximity/box_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "core/units.hpp"
#include "proximity/placed.hpp"
#include "support/meshes.hpp"

namespace vrda::box_tree_test {

bool holds(const BoxTree::Node& node, const Eigen::Vector3d& p)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const double value = p[static_cast<Eigen::Index>(k)];
    if (value < node.min_mm[k] || value > node.max_mm[k]) return false;
  }
  return true;
}

// Rows of the triangles below node `n`.
std::vector<std::int32_t> below(const BoxTree& tree, std::size_t n)
{
  const BoxTree::Node& node = tree.nodes()[n];
  if (node.is_leaf())
    return {tree.order().begin() + node.first, tree.order().begin() + node.first + node.count};
  std::vector<std::int32_t> rows = below(tree, n + 1);
  const std::vector<std::int32_t> right = below(tree, static_cast<std::size_t>(node.first));
  rows.insert(rows.end(), right.begin(), right.end());
  return rows;
}

TEST(BoxTree, EveryTriangleStandsOnceAndInsideItsBoxes)
{
  const Mesh ball = test::ball(10, 9, 14);
  const BoxTree tree(ball);
  std::vector<std::int32_t> all = below(tree, 0);
  std::sort(all.begin(), all.end());
  std::vector<std::int32_t> expected(static_cast<std::size_t>(ball.triangles.rows()));
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(all, expected);
  for (std::size_t n = 0; n < tree.nodes().size(); ++n) {
    for (const std::int32_t t : below(tree, n)) {
      for (const Eigen::Vector3d& p : corners(ball, t)) EXPECT_TRUE(holds(tree.nodes()[n], p));
    }
  }
}

TEST(BoxTree, RefitEqualsABuildOfTheSameTopology)
{
  const TreeMesh ball = make_tree_mesh(test::ball(10, 9, 14));
  const TreeMesh there = turned(ball, {rad_from_deg(40), rad_from_deg(5)});
  for (std::size_t n = 0; n < there.tree.nodes().size(); ++n) {
    for (const std::int32_t t : below(there.tree, n)) {
      for (const Eigen::Vector3d& p : corners(there.mesh, t)) EXPECT_TRUE(holds(there.tree.nodes()[n], p));
    }
  }
}

TEST(BoxTree, ClosePairsMissNoneThatAreClose)
{
  const TreeMesh reference = make_tree_mesh(test::ball(10, 9, 14));
  const TreeMesh moving = make_tree_mesh(test::ball(7, 8, 12));
  const MovingPose pose{{3.0, -16.0, 1.0}, 0.4};
  const double band_mm = 1.0;
  std::set<TrianglePair> found;
  visit_close_pairs(reference.tree, moving.tree, Placement(pose), band_mm, [&](const TrianglePair& pair) {
    found.insert(pair);
    return false;
  });
  // Any pair with two corners within the band must be among them.
  const Placement place(pose);
  int n_close = 0;
  for (std::int32_t r = 0; r < reference.mesh.triangles.rows(); ++r) {
    for (std::int32_t m = 0; m < moving.mesh.triangles.rows(); ++m) {
      const Corners a = corners(reference.mesh, r), b = place(corners(moving.mesh, m));
      bool close = false;
      for (const Eigen::Vector3d& p : a) {
        for (const Eigen::Vector3d& q : b) close = close || (p - q).norm() <= band_mm;
      }
      if (!close) continue;
      ++n_close;
      EXPECT_TRUE(found.contains({r, m}));
    }
  }
  EXPECT_GT(n_close, 20);
  EXPECT_LT(found.size(),
            static_cast<std::size_t>(reference.mesh.triangles.rows() * moving.mesh.triangles.rows()) / 4);
}

TEST(BoxTree, EmptyTreesHaveNoPairs)
{
  const BoxTree empty(test::ball(1), {});
  EXPECT_TRUE(empty.is_empty());
  EXPECT_FALSE(visit_close_pairs(empty, make_tree_mesh(test::ball(1)).tree, Placement({}), 1.0,
                                 [](const TrianglePair&) { return true; }));
}

}  // namespace vrda::box_tree_test
