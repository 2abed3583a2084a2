#include "analysis/measured_joints.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

namespace vrda::test {

Mesh stl_mesh(const std::filesystem::path& file)
{
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, 4);
  Mesh mesh;
  mesh.triangles.resize(n, 3);
  std::map<std::array<float, 3>, std::int32_t> rows;
  std::vector<std::array<float, 3>> vertices;
  for (std::uint32_t t = 0; t < n; ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      std::array<float, 3> p{};
      std::memcpy(p.data(), bytes.data() + 84 + 50 * t + 12 + 12 * c, 12);
      const auto [row, is_new] = rows.emplace(p, static_cast<std::int32_t>(vertices.size()));
      if (is_new) vertices.push_back(p);
      mesh.triangles(t, c) = row->second;
    }
  }
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k)
      mesh.vertices_mm(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(k)) = vertices[v][k];
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

analysis::MeasuredMotion motion_table(const std::filesystem::path& file)
{
  std::ifstream in(file);
  analysis::MeasuredMotion motion;
  motion.name = file.string();
  std::vector<std::string> names;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream fields(line);
    std::vector<std::string> row;
    for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
    if (names.empty()) {
      names = row;
      continue;
    }
    Pose X = Pose::Identity();
    for (std::size_t c = 0; c < names.size(); ++c) {
      if (names[c].size() != 3 || names[c][0] != 'T') continue;
      X.matrix()(names[c][1] - '1', names[c][2] - '1') = std::stod(row[c]);
    }
    // Five digits: the nearest rotation is found by one step of Newton's method.
    const Eigen::Matrix3d R = X.linear();
    X.linear() = 0.5 * R * (3.0 * Eigen::Matrix3d::Identity() - R.transpose() * R);
    motion.key.push_back(std::stod(row.front()));
    motion.X_reference_moving.push_back(X);
  }
  return motion;
}

MeasuredJoint subtalar_joint(const std::filesystem::path& folder)
{
  return {stl_mesh(folder / "talus.stl"), stl_mesh(folder / "calcaneus.stl"),
          motion_table(folder / "motion.csv")};
}

}  // namespace vrda::test
