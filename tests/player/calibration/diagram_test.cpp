#include "calibration/drawing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "calibration/parts.hpp"
#include "calibration/truth.hpp"

namespace vrda::calibration::diagram_test {

/// A box with outward faces.
Body box_body(const Eigen::Vector3d& half_mm)
{
  Body body;
  Mesh& mesh = body.contact.mesh;
  mesh.vertices_mm.resize(8, 3);
  for (int k = 0; k < 8; ++k)
    mesh.vertices_mm.row(k) = half_mm.cwiseProduct(
        Eigen::Vector3d((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1));
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
      1, 3, 5, 3, 7, 5;
  return body;
}

TEST(Outline, OfABoxIsItsRectangleInBothViews)
{
  const BodyOutline outline = outline_of(box_body({20.0, 50.0, 30.0}));
  for (std::size_t view = 0; view < 2; ++view) {
    double length_mm = 0.0;
    for (const auto& [a, b] : outline.pieces[view]) length_mm += (a - b).norm();
    const double width_mm = view == 0 ? 60.0 : 40.0;
    EXPECT_NEAR(length_mm, 2.0 * (width_mm + 100.0), 1e-9) << view;
  }
}

TEST(Diagram, EveryTaskHasOneWithSomethingLitWithinTheFrame)
{
  for (const char* lines : {"", "distortion = \"adjust\"\nmodel = \"adjust\"\n"}) {
    std::string text = virtual_bench_text();
    const std::string table = "[calibration]\n";
    text.insert(text.find(table) + table.size(), lines);
    const BenchFile bench = bench::parse_bench_file(text, "bench.toml");
    const Calibration nominal = bench::nominal_calibration(bench);
    std::map<std::pair<CalibrationPart, std::string>, std::size_t> kinds;
    for (const CalibrationPart part : parts_of(bench)) {
      for (const Task& task : calibration::tasks_of(part, bench, nominal)) {
        SCOPED_TRACE(task.name);
        const Diagram diagram = diagram_of(task, bench, nullptr);
        const bool is_lit = std::ranges::any_of(
            diagram.lines, [](const DiagramLine& line) { return line.ink == DiagramInk::lit; });
        EXPECT_TRUE(is_lit || task.kind->traits().places_model);
        for (const DiagramLine& line : diagram.lines) {
          ASSERT_GE(line.points.size(), 2u);
          for (const Eigen::Vector2d& p : line.points) {
            EXPECT_TRUE(p.x() >= 0.0 && p.x() <= 1.0 && p.y() >= 0.0 && p.y() <= diagram.height)
                << p.transpose();
          }
        }
      }
    }
  }
}

/// Middle of the largest lit ring on the left half: the view from the front.
Eigen::Vector2d lit_point(const Diagram& diagram)
{
  Eigen::Vector2d middle(-1.0, -1.0);
  for (const DiagramLine& line : diagram.lines) {
    if (line.ink != DiagramInk::lit || line.points.front().x() > 0.5) continue;
    middle.setZero();
    for (std::size_t k = 1; k < line.points.size(); ++k)
      middle += line.points[k] / static_cast<double>(line.points.size() - 1);
  }
  return middle;
}

TEST(Diagram, TheNextPointIsLitWhereItIsOnTheModel)
{
  const BenchFile bench = bench::parse_bench_file(virtual_bench_text(), "bench.toml");
  const auto part = CalibrationPart::leg;
  const std::vector<Task> tasks = calibration::tasks_of(part, bench, bench::nominal_calibration(bench));
  const auto& points = points_of(BodyRole::leg, bench.calibration);
  const BodyOutline outline = outline_of(box_body({30.0, 30.0, 30.0}));
  std::vector<Eigen::Vector2d> lit;
  for (const Task& task : tasks) lit.push_back(lit_point(diagram_of(task, bench, &outline)));
  ASSERT_EQ(lit.size(), points.size());
  // From the front: the subject's right is on the left, up is up; one scale for all points.
  const auto flat = [&](std::size_t k) {
    return Eigen::Vector2d(-points[k].p_model_mm.z(), -points[k].p_model_mm.y());
  };
  const double scale = (lit[1] - lit[0]).norm() / (flat(1) - flat(0)).norm();
  EXPECT_GT(scale, 0.0);
  for (std::size_t k = 1; k < lit.size(); ++k)
    EXPECT_LT(((lit[k] - lit[0]) - scale * (flat(k) - flat(0))).norm(), 1e-9) << k;
  const auto n_plain = [&](const BodyOutline* of) {
    return std::ranges::count(diagram_of(tasks[0], bench, of).lines, DiagramInk::plain, &DiagramLine::ink);
  };
  EXPECT_GT(n_plain(&outline), n_plain(nullptr)) << "the model's outline";
}

}  // namespace vrda::calibration::diagram_test
