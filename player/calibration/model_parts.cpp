// Pose of the model on the leg's body, or of both bones on theirs: from points touched with the probe (thesis
// 8.5), or adjusted by eye.
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

using enum DiagramInk;

/// From the front and from the side: outline of the body, and all points, with the one to be touched lit.
void sketch_points(Sketch& sketch, const std::vector<CalibrationPoint>& points, int next)
{
  using Point = Eigen::Vector2d;
  sketch.drawn.height = 1.0;
  // Both views have the same scale.
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const CalibrationPoint& point : points) {
    low = low.cwiseMin(point.p_model_mm);
    high = high.cwiseMax(point.p_model_mm);
  }
  constexpr double margin_mm = 15.0, view_width = 0.46, view_height = 0.88;
  low.array() -= margin_mm;
  high.array() += margin_mm;
  const double mm = std::min({view_width / (high.z() - low.z()), view_width / (high.x() - low.x()),
                              view_height / (high.y() - low.y())});
  for (std::size_t view = 0; view < 2; ++view) {
    const double left = view == 0 ? 0.02 : 0.52;
    sketch.label({left, 0.0}, view == 0 ? "from the front" : "from the right");
    const auto flat = [&](const Eigen::Vector3d& p) {
      return view == 0 ? Point(-p.z(), p.y()) : Point(p.x(), p.y());
    };
    const Point middle = 0.5 * (flat(low) + flat(high));
    const auto placed = [&](const Point& p) {
      return Point(left + 0.5 * view_width + mm * (p.x() - middle.x()), 0.54 - mm * (p.y() - middle.y()));
    };
    if (sketch.outline != nullptr) {
      for (const auto& [from, to] : sketch.outline->pieces[view]) {
        const Point a = placed(from), b = placed(to);
        const auto fits = [&](const Point& p) {
          return p.x() >= left && p.x() <= left + view_width && p.y() >= 0.06 && p.y() <= 1.0;
        };
        if (fits(a) && fits(b)) sketch.line(plain, {a, b});
      }
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Point at = placed(flat(points[k].p_model_mm));
      const bool is_next = static_cast<int>(k) == next;
      sketch.circle(is_next ? lit : real, at, is_next ? 0.008 : 0.006);
      if (!is_next) continue;
      sketch.circle(lit, at, 0.025);
      if (view == 0) sketch.label(at + Point(0.03, -0.025), points[k].name);
    }
  }
}

/// The probe's tip on a point of the model.
struct TouchedPoint final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task& task, const BenchFile& bench) const override
  {
    sketch_points(sketch, points_of(task.body.value(), bench.calibration), task.index);
  }

  /// The probe has a different orientation for each point.
  BenchPoses poses(const TaskContext& context, double) const override
  {
    const VirtualTruth& truth = context.truth;
    const BodyRole role = context.task.body.value();
    const Eigen::Vector3d& p_model_mm = points_of(role, context.bench.calibration)
                                            .at(static_cast<std::size_t>(context.task.index))
                                            .p_model_mm;
    const Eigen::Vector3d off_mm = context.noise.touch_mm * context.draws.normal_vector();
    const Eigen::Vector3d tip_mm = X_tracker_body(truth, role) * X_body_model(truth.calibration, role) *
                                       (truth.calibration.subject_scale * p_model_mm) +
                                   off_mm;
    constexpr double lean_deg = 40.0;
    RandomSequence draws = draws_of_hand(truth, 1 + static_cast<std::uint64_t>(role), context.task.index);
    BenchPoses poses = resting_poses(truth);
    put_tip_at(truth, tip_mm, bench::rotation_of(even_vector(draws, rad_from_deg(lean_deg))), poses);
    return poses;
  }
};

/// Polyline through the points of a scaled model, subdivided so that curvature is visible.
std::vector<Eigen::Vector3d> polyline_mm(const std::vector<CalibrationPoint>& points, double scale)
{
  constexpr int n_pieces = 16;
  std::vector<Eigen::Vector3d> way;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d& to_mm = points[k].p_model_mm;
    const Eigen::Vector3d& from_mm = points[k == 0 ? 0 : k - 1].p_model_mm;
    const int n = k == 0 ? 1 : n_pieces;
    for (int i = 1; i <= n; ++i) way.emplace_back(scale * (from_mm + (to_mm - from_mm) * i / n));
  }
  return way;
}

/// The model placed by eye. The row is {shift_mm (3), turn_rad (3)} in the body's frame; the dials of the
/// turn are in degrees. A bench draws the model itself, a virtual bench the points in sequence.
struct PlacedModel final : TaskKind {
  using TaskKind::TaskKind;

  DrawnLines draw_simulated(const Task& task, std::span<const double> values, const Calibration& found,
                            const BenchFile& bench, const VirtualTruth& truth) const override
  {
    const Pose X_tracker_head = bench.head == HeadKind::stage ? X_tracker_eyes(found, 0.0)
                                                              : resting_poses(truth).X_tracker_headbody *
                                                                    bench::pose_of(found.X_headbody_eyes);
    const BodyRole role = task.body.value();
    const Pose X_eyes_model = X_tracker_head.inverse() * X_tracker_body(truth, role) *
                              bench::pose_of(bench::pose_parameters_of(values));
    DrawnLines lines;
    for (const bool is_right : {false, true}) {
      const view::Eye& eye = view::side_of(found.eyes, is_right);
      DrawnLine line{is_right, {}, 1.5};
      for (const Eigen::Vector3d& p_mm :
           polyline_mm(points_of(role, bench.calibration), found.subject_scale)) {
        const Eigen::Vector3d p_eyes_mm = X_eyes_model * p_mm;
        // Points next to or behind the head are not drawn.
        constexpr double nearest_mm = 50.0;
        if (eye.position_head_mm.z() - p_eyes_mm.z() > nearest_mm)
          line.points_px.push_back(view::drawn_px(eye, p_eyes_mm));
      }
      if (line.points_px.size() > 1) lines.push_back(std::move(line));
    }
    return lines;
  }

  void sketch(Sketch& sketch, const Task& task, const BenchFile& bench) const override
  {
    sketch_points(sketch, points_of(task.body.value(), bench.calibration), -1);
  }

  std::vector<double> mark_row(const Task&, std::span<const double> values, const Calibration&) const override
  {
    std::vector<double> row(values.begin(), values.end());
    for (std::size_t k = 3; k < row.size(); ++k) row[k] = rad_from_deg(row[k]);
    return row;
  }

  /// To within the alignment noise of marks 100 mm around, at 800 mm: better than a person achieves.
  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    constexpr double distance_mm = 800.0, distance_px = 880.0, about_mm = 100.0;
    const double noise_mm = context.noise.alignment_px * distance_mm / distance_px;
    Eigen::Matrix<double, 6, 1> off;
    off << noise_mm * context.draws.normal_vector(), noise_mm / about_mm * context.draws.normal_vector();
    const Pose X = X_body_model(context.truth.calibration, context.task.body.value());
    const bench::PoseParameters six = bench::pose_parameters_of(bench::moved(X, off));
    std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
    for (const double turn_rad : six.turn_rad) values.push_back(turn_rad / rad_from_deg(1.0));
    return values;
  }

  Deviation deviation(const TaskContext& context, std::span<const double> values) const override
  {
    const BodyRole role = context.task.body.value();
    const Calibration& c = context.truth.calibration;
    const Pose X = bench::pose_of(bench::pose_parameters_of(values)), X_true = X_body_model(c, role);
    const std::vector<CalibrationPoint>& points = points_of(role, context.bench.calibration);
    double sum_sq = 0.0;
    for (const CalibrationPoint& point : points) {
      const Eigen::Vector3d p_mm = c.subject_scale * point.p_model_mm;
      sum_sq += (X * p_mm - X_true * p_mm).squaredNorm();
    }
    return {std::sqrt(sum_sq / static_cast<double>(points.size())), "mm"};
  }

  /// The points of the whole leg, in sequence.
  DrawnLines outlines(const Task&, const BenchFile& bench, const VirtualTruth& truth) const override
  {
    const Calibration& c = truth.calibration;
    const Pose X_eyes_tracker = resting_poses(truth).X_tracker_eyes.inverse();
    DrawnLines lines;
    for (const CalibrationPart id : parts_of(bench)) {
      if (!is_model_part(id)) continue;
      const BodyRole role = role_of(id);
      const Pose X_eyes_model = X_eyes_tracker * X_tracker_body(truth, role) * X_body_model(c, role);
      for (const bool is_right : {false, true}) {
        Points2d points_px;
        for (const Eigen::Vector3d& p_mm : polyline_mm(points_of(role, bench.calibration), c.subject_scale))
          points_px.push_back(
              view::shown_px(view::side_of(c.eyes, is_right), Eigen::Vector3d(X_eyes_model * p_mm)));
        lines.push_back(real_outline(is_right, std::move(points_px)));
      }
    }
    return lines;
  }
};

const TouchedPoint touched_point({.name = "touched point",
                                  .typical_s = 15.0,
                                  .samples = TaskKind::Samples::hold});
const PlacedModel placed_model(
    {.name = "placed model", .thing = "model", .n_numbers = 6, .places_model = true});

Task place_task(BodyRole role, const bench::PoseParameters& begin, int repeat)
{
  // Well below the scatter of a hand: otherwise equal rounded poses would seem exact.
  constexpr double most_mm = 10000.0, step_mm = 0.1, step_deg = 0.1;
  const auto shift = [&](const char* name, double mm) {
    return dial(name, "mm", mm, -most_mm, most_mm, step_mm);
  };
  const auto turn = [&](const char* name, double rad) {
    return dial(name, "deg", deg_from_rad(rad), -360.0, 360.0, step_deg);
  };
  return {.kind = &placed_model,
          .name = "place " + std::to_string(repeat + 1),
          .instruction = std::string("Move and rotate the model of the ") + bench::name_of(role) +
                         " until it matches the real one;\nthen check from other positions and correct. "
                         "Up and Down select, Left and Right change.",
          .dials = {shift("shift x", begin.shift_mm.x()), shift("shift y", begin.shift_mm.y()),
                    shift("shift z", begin.shift_mm.z()), turn("turn x", begin.turn_rad.x()),
                    turn("turn y", begin.turn_rad.y()), turn("turn z", begin.turn_rad.z())},
          .body = role,
          .index = repeat};
}

/// Touched points in the body frame and the orientation of the probe.
struct Touched {
  std::vector<Fiducial> points;
  std::vector<Eigen::Matrix3d> R_body_probe;
};

Touched touched_of(std::span<const MarkedTask> tasks, std::span<const CalibrationPoint> points,
                   const Eigen::Vector3d& tip_probe_mm, double scale)
{
  Touched touched;
  for (const MarkedTask& t : tasks) {
    const CalibrationPoint& point = points[static_cast<std::size_t>(t.task.index)];
    std::vector<Eigen::Vector3d> tips;
    for (const std::vector<double>& row : t.mark->rows)
      tips.push_back(sampled_pose(row, 7).inverse() * (sampled_pose(row) * tip_probe_mm));
    touched.points.push_back(
        {point.name, scale * point.p_model_mm, mean_position(tips).p_mm, point.is_target});
    const std::vector<double>& first = t.mark->rows[0];
    touched.R_body_probe.push_back((sampled_pose(first, 7).inverse() * sampled_pose(first)).linear());
  }
  return touched;
}

/// Adds the covariance from tip and scale errors, by a linear fit of the pose to the displacements that they
/// cause: a tip error displaces each point by the probe's rotation of it, a scale error along the point's
/// position vector.
void add_known_errors(FiducialFit& fit, const Touched& touched, const Eigen::Matrix3d& tip_covariance,
                      double scale_variance, double scale)
{
  // Least squares of translation + rotation x r = displacement, r from the model's origin to the point in
  // body axes.
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < touched.points.size(); ++k) {
    if (!touched.points[k].is_target) used.push_back(k);
  }
  Matrix6 N = Matrix6::Zero();
  Eigen::Matrix<double, 6, 3> of_tip = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Matrix<double, 6, 1> of_scale = Eigen::Matrix<double, 6, 1>::Zero();
  for (const std::size_t k : used) {
    const Eigen::Vector3d r = fit.X_body_model.linear() * touched.points[k].p_model_mm;
    Eigen::Matrix<double, 3, 6> G;
    G << Eigen::Matrix3d::Identity(), -cross_matrix(r);
    N += G.transpose() * G;
    of_tip += G.transpose() * touched.R_body_probe[k];
    of_scale += G.transpose() * r / scale;
  }
  const Eigen::LDLT<Matrix6> solver(N);
  Matrix6 units = Matrix6::Identity();
  units.bottomRightCorner<3, 3>() *= deg_from_rad(1.0);
  const Eigen::Matrix<double, 6, 3> A = units * solver.solve(of_tip);
  const Eigen::Matrix<double, 6, 1> b = units * solver.solve(of_scale);
  fit.estimate.covariance.topLeftCorner<6, 6>() +=
      A * tip_covariance * A.transpose() + scale_variance * b * b.transpose();
}

/// The probe's tip and the subject's scale.
struct Equipment {
  Eigen::Vector3d tip_probe_mm;
  Eigen::Matrix3d tip_covariance;
  double scale = 1.0, scale_variance = 0.0;
};

Equipment equipment_of(const PartInput& in)
{
  const Estimate& probe = estimate_of(CalibrationPart::probe, in);
  const std::vector<std::string> tip = bench::shared_estimate_names(CalibrationPart::probe);
  Equipment equipment;
  equipment.tip_probe_mm = {value_in(probe, tip[0]), value_in(probe, tip[1]), value_in(probe, tip[2])};
  equipment.tip_covariance = prior_covariance(probe, tip);
  equipment.scale = in.begun.subject_scale;
  if (const Estimate* subject = find_estimate(in.begun, CalibrationPart::subject)) {
    equipment.scale = value_in(*subject, "subject.scale");
    equipment.scale_variance = prior_covariance(*subject, {"subject.scale"})(0, 0);
  }
  return equipment;
}

constexpr CalibrationPart part_of(BodyRole role)
{
  using enum CalibrationPart;
  return role == BodyRole::leg ? leg : role == BodyRole::femur ? femur : tibia;
}

struct ModelPart final : Part {
  constexpr explicit ModelPart(BodyRole role)
      : Part({.id = part_of(role),
              .is_tracking = true,
              .bench_key = role == BodyRole::tibia ? "calibration.tibia_point" : "calibration.point"}),
        role_(role)
  {
  }

  bool applies_to(const BenchFile& bench) const override
  {
    return (bench.leg == LegKind::rigid) == (role_ == BodyRole::leg);
  }

  /// Adjustment by eye depends on the whole optical calibration.
  std::vector<CalibrationPart> below(const BenchFile& bench) const override
  {
    using enum CalibrationPart;
    if (bench.calibration.is_model_adjusted) return {subject, bullseye, head};
    return {probe, subject};
  }

  void require_bench_data(const BenchFile& bench) const override
  {
    constexpr std::ptrdiff_t least_fiducials = 4;
    if (bench.calibration.is_model_adjusted) return;
    const auto n =
        std::ranges::count(points_of(role_, bench.calibration), false, &CalibrationPoint::is_target);
    if (n < least_fiducials)
      refuse_bench(bench, std::to_string(n) + " points that are not targets", "four or more, not coplanar");
  }

  std::optional<std::vector<double>> made_with(const PartInput& in) const override
  {
    std::vector<double> numbers;
    if (in.bench.calibration.is_model_adjusted) return numbers;
    for (const CalibrationPoint& point : points_of(role_, in.bench.calibration)) {
      const Eigen::Vector3d& p = point.p_model_mm;
      numbers.insert(numbers.end(), {p.x(), p.y(), p.z(), point.is_target ? 1.0 : 0.0});
    }
    return numbers;
  }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration& calibration) const override
  {
    const CalibrationSettings& settings = bench.calibration;
    std::vector<Task> tasks;
    if (settings.is_model_adjusted) {
      const bench::PoseParameters& begin = calibration.X_body_model[role_];
      for (int repeat = 0; repeat < settings.model_repeats; ++repeat)
        tasks.push_back(place_task(role_, begin, repeat));
      return tasks;
    }
    for (const CalibrationPoint& point : points_of(role_, settings)) {
      tasks.push_back({.kind = &touched_point,
                       .name = point.name,
                       .instruction = "Touch with the probe's tip: " + point.name +
                                      (point.is_target ? " (target, not part of the fit).\n" : ".\n") +
                                      "Press Enter and keep probe and leg still until sampling is done.",
                       .n_samples = settings.hold_samples,
                       .tool = settings.probe,
                       .body = role_,
                       .index = static_cast<int>(tasks.size())});
    }
    return tasks;
  }

  /// After new landmarks of one bone, those of the other replace its functional placement.
  void solve(const PartInput& in, Calibration& c) const override
  {
    const FiducialFit fit = pose_fit(in);
    c.records.at(id()).estimate = fit.estimate;
    put_model(c, role_, fit.X_body_model);
    if (find_estimate(c, CalibrationPart::functional) == nullptr) return;
    for (const CalibrationPart bone : {CalibrationPart::femur, CalibrationPart::tibia}) {
      if (const Estimate* landmarks = find_estimate(c, bone))
        put_model(c, role_of(bone), pose_in(*landmarks, bench::name_of(bone)));
    }
  }

 private:
  /// The covariance includes the errors of probe tip and scale.
  FiducialFit pose_fit(const PartInput& in) const
  {
    const std::vector<MarkedTask> tasks = marked_tasks(id(), in);
    if (in.bench.calibration.is_model_adjusted) {
      std::vector<Pose> poses;
      for (const MarkedTask& t : tasks) {
        const std::vector<double>& v = t.mark->rows[0];
        poses.push_back(bench::pose_of(bench::PoseParameters{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}));
      }
      return run_fit({}, [&] { return mean_adjusted_pose(poses, name(), in.path); });
    }
    const Equipment equipment = equipment_of(in);
    const Touched touched =
        touched_of(tasks, points_of(role_, in.bench.calibration), equipment.tip_probe_mm, equipment.scale);
    FiducialFit fit = run_fit(names_of(tasks), [&] {
      return fit_fiducials(touched.points, name(), in.path, {equipment.scale_variance == 0.0});
    });
    add_known_errors(fit, touched, equipment.tip_covariance, equipment.scale_variance, equipment.scale);
    return fit;
  }

  BodyRole role_;
};

const ModelPart leg_object(BodyRole::leg);
const ModelPart femur_object(BodyRole::femur);
const ModelPart tibia_object(BodyRole::tibia);

}  // namespace

void put_model(Calibration& c, BodyRole role, const Pose& X_body_model)
{
  c.X_body_model[role] = bench::pose_parameters_of(X_body_model);
}

std::vector<Fiducial> touched_points(BodyRole role, const PartInput& in)
{
  const Equipment equipment = equipment_of(in);
  return touched_of(marked_tasks(part_of(role), in), points_of(role, in.bench.calibration),
                    equipment.tip_probe_mm, equipment.scale)
      .points;
}

const Part &leg_part = leg_object, &femur_part = femur_object, &tibia_part = tibia_object;

}  // namespace vrda::calibration
