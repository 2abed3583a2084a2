// Numbers that are read or measured on the person: the distance of the eyes with its check by a look at a
// drawn frame (thesis 8.4), and the distances of landmarks that give the scale of the model.
#include <cmath>
#include <limits>

#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/text.hpp"

namespace vrda::calibration {
namespace {

/// A number of the head: index of its task.
enum HeadNumber { pupils, left_arm, right_arm, image };
constexpr std::array<const char*, 4> head_numbers{"pupillary distance", "left arm", "right arm",
                                                  "image distance"};

struct HeadNumberTask final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task& task, const BenchFile&) const override
  {
    using enum DiagramInk;
    using Point = Eigen::Vector2d;
    const Point left(0.35, 0.35), right(0.65, 0.35);
    for (const Point& eye : {left, right}) {
      sketch.circle(plain, eye, 0.08);
      sketch.circle(plain, eye, 0.025);
    }
    const auto measure = [&](double from, double to) {
      sketch.arrow(lit, {0.5 * (from + to), 0.18}, {to, 0.18});
      sketch.arrow(lit, {0.5 * (from + to), 0.18}, {from, 0.18});
    };
    if (task.index == pupils) measure(left.x(), right.x());
    if (task.index == left_arm) measure(left.x(), 0.5);
    if (task.index == right_arm) measure(0.5, right.x());
    if (task.index == image) {
      sketch.box(real, {0.35, 0.02}, {0.65, 0.12});
      sketch.arrow(lit, {0.5, 0.5}, {0.5, 0.14});
    }
  }

  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    const Calibration& c = context.truth.calibration;
    const double left_mm = c.eyes.left.position_head_mm.x(), right_mm = c.eyes.right.position_head_mm.x();
    switch (context.task.index) {
      case pupils:
        return {right_mm - left_mm + context.noise.pupillometer_mm * context.draws.normal()};
      case left_arm:
        return {-left_mm};
      case right_arm:
        return {right_mm};
      default:
        return {c.image_distance_mm};
    }
  }
};

/// Comparison of a drawn and a real frame, for both eyes.
struct Look final : TaskKind {
  using TaskKind::TaskKind;

  /// Corners of the frame in the eyes' frame, at the image distance.
  static std::array<Eigen::Vector3d, 5> corners(const Calibration& calibration)
  {
    constexpr double half_mm = 0.5 * test_frame_size_mm;
    const double z_mm = -calibration.image_distance_mm;
    return {Eigen::Vector3d(-half_mm, -half_mm, z_mm),
            {half_mm, -half_mm, z_mm},
            {half_mm, half_mm, z_mm},
            {-half_mm, half_mm, z_mm},
            {-half_mm, -half_mm, z_mm}};
  }

  DrawnLines draw(const Task&, std::span<const double>, const Calibration& found) const override
  {
    DrawnLines lines;
    for (const bool is_right : {false, true}) {
      const view::Eye& eye = view::side_of(found.eyes, is_right);
      Pen pen(eye, is_right, lines);
      const std::array<Eigen::Vector3d, 5> frame = corners(found);
      for (std::size_t k = 0; k + 1 < frame.size(); ++k)
        pen.draw_shown(view::shown_px(eye, frame[k]), view::shown_px(eye, frame[k + 1]));
    }
    return lines;
  }

  void sketch(Sketch& sketch, const Task&, const BenchFile&) const override
  {
    sketch.eyes(0.5, 0.05);
    sketch.box(DiagramInk::real, {0.3, 0.06}, {0.68, 0.3});
    sketch.box(DiagramInk::lit, {0.32, 0.08}, {0.7, 0.32});
    sketch.label({0.02, 0.12}, "both at one depth?");
  }

  DrawnLines outlines(const Task&, const BenchFile&, const VirtualTruth& truth) const override
  {
    DrawnLines lines;
    for (const bool is_right : {false, true}) {
      Points2d points;
      for (const Eigen::Vector3d& corner : corners(truth.calibration))
        points.push_back(view::shown_px(view::side_of(truth.calibration.eyes, is_right), corner));
      lines.push_back(real_outline(is_right, std::move(points)));
    }
    return lines;
  }
};

struct LandmarkDistanceTask final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task& task, const BenchFile&) const override
  {
    sketch.circle(DiagramInk::real, {0.25, 0.3}, 0.012);
    sketch.circle(DiagramInk::real, {0.75, 0.3}, 0.012);
    sketch.arrow(DiagramInk::lit, {0.5, 0.3}, {0.26, 0.3});
    sketch.arrow(DiagramInk::lit, {0.5, 0.3}, {0.74, 0.3});
    sketch.label({0.25, 0.36}, task.name);
  }

  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    const CalibrationLandmarks& pair =
        context.bench.calibration.landmarks.at(static_cast<std::size_t>(context.task.index));
    return {context.truth.calibration.subject_scale * pair.model_mm +
            context.noise.landmark_mm * context.draws.normal()};
  }
};

const HeadNumberTask head_number(
    {.name = "head number", .typical_s = 20.0, .is_reading = true, .is_seen = false});
const Look look({.name = "look", .typical_s = 10.0, .n_numbers = 0, .shows_result = true});
const LandmarkDistanceTask landmark_distance(
    {.name = "landmarks", .typical_s = 20.0, .is_reading = true, .is_seen = false});

Estimate given(const std::string& name, const std::string& unit, double value, double sd)
{
  Estimate estimate;
  estimate.names = {name};
  estimate.units = {unit};
  estimate.values = Eigen::VectorXd::Constant(1, value);
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, sd * sd);
  estimate.dof = std::numeric_limits<double>::infinity();
  return estimate;
}

/// Number of a task of ipd; empty if the bench does not have the task.
std::optional<double> number_of(const PartInput& in, HeadNumber number)
{
  const CalibrationRecord& record = in.begun.records.at(CalibrationPart::ipd);
  const CalibrationMark* mark = find_mark(record, head_numbers.at(number));
  return mark == nullptr ? std::nullopt : std::optional<double>(mark->rows[0][0]);
}

Estimate measured_ipd(const PartInput& in)
{
  if (const std::optional<double> ipd_mm = number_of(in, pupils))
    return given("ipd", "mm", *ipd_mm, in.bench.calibration.pupillometer_sd_mm);
  const EyeRectangles left = solve_eye_rectangles(in, false);
  const EyeRectangles right = solve_eye_rectangles(in, true);
  const PupilDistance found = pupil_distance(left, right, in.bench.calibration.sight_sd_px);
  return given("ipd", "mm", found.ipd_mm, found.sd_mm);
}

struct IpdPart final : Part {
  using Part::Part;

  bool uses_rectangles(const BenchFile& bench) const override { return !bench.calibration.has_pupillometer; }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration&) const override
  {
    // Adults: 45 to 80 mm (Dodgson 2004, Proc SPIE 5291); arms that are set a little beyond.
    constexpr double usual_ipd_mm = 64.0, least_ipd_mm = 40.0, most_ipd_mm = 90.0;
    constexpr double least_adult_mm = 45.0, most_adult_mm = 80.0;
    constexpr double usual_image_mm = 800.0, most_image_mm = 10000.0;
    std::vector<Task> tasks;
    const auto add = [&](HeadNumber number, const std::string& instruction, const Dial& dial) {
      tasks.push_back({.kind = &head_number,
                       .name = head_numbers.at(number),
                       .instruction = instruction,
                       .dials = {dial},
                       .index = number});
    };
    if (bench.calibration.has_pupillometer) {
      add(pupils, "Measure the distance between the pupils with the pupillometer, set to the image distance.",
          within(dial("distance", "mm", usual_ipd_mm, least_ipd_mm, most_ipd_mm, dial_step_mm),
                 least_adult_mm, most_adult_mm));
    }
    for (const HeadNumber arm : {left_arm, right_arm}) {
      add(arm,
          "Move the " + std::string(side_name(arm == right_arm)) +
              " arm until its optical axis is in front of the pupil:\nhalf the pupillary distance "
              "from the middle. Read its scale.",
          within(dial("from the middle", "mm", 0.5 * usual_ipd_mm, 0.0, most_ipd_mm, dial_step_mm),
                 0.5 * least_adult_mm, 0.5 * most_adult_mm));
    }
    add(image, "Set the distance of the virtual image. Nominal: 800 mm.",
        within(dial("distance", "mm", usual_image_mm, 100.0, most_image_mm, 1.0), 200.0, 5000.0));
    tasks.back().is_start_valid = true;
    tasks.push_back(
        {.kind = &look,
         .name = "look",
         .instruction =
             "With both eyes: a frame 100 mm wide is drawn at the image distance. Hold a real one of that "
             "size\n"
             "there. If both appear at the same depth, press Enter; otherwise press R to measure again."});
    return tasks;
  }

  void apply(view::EyePair& eyes, const Estimate& found) const override
  {
    view::set_ipd(eyes, value_in(found, "ipd"));
  }

  void solve(const PartInput& in, Calibration& c) const override
  {
    Estimate estimate = measured_ipd(in);
    const double ipd_mm = estimate.values[0], depth_mm = *number_of(in, image);
    const double arms_mm = *number_of(in, left_arm) + *number_of(in, right_arm);
    constexpr double most_apart_mm = 1.0;
    if (std::abs(arms_mm - ipd_mm) > most_apart_mm) {
      estimate.remarks.push_back("distance of the arms " + short_decimal(arms_mm, 1) + " mm, of the eyes " +
                                 short_decimal(ipd_mm, 1) + " mm: adjust the arms");
    }
    estimate.remarks.push_back(
        "measured 1 mm too large, it shows an object at " + short_decimal(depth_mm, 0) + " mm " +
        short_decimal(-depth_error_mm(depth_mm, ipd_mm + 1.0, ipd_mm), 1) + " mm nearer to the viewer");
    c.records.at(id()).estimate = estimate;
    c.image_distance_mm = depth_mm;
    apply(c.eyes, estimate);
  }
};

struct SubjectPart final : Part {
  using Part::Part;

  bool applies_to(const BenchFile& bench) const override { return !bench.calibration.landmarks.empty(); }

  void require_bench_data(const BenchFile& bench) const override
  {
    constexpr std::size_t least_distances = 3;
    const std::size_t n = bench.calibration.landmarks.size();
    if (n < least_distances)
      refuse_bench(bench, std::to_string(n) + " distances", "three or more distances between landmarks");
  }

  std::optional<std::vector<double>> made_with(const PartInput& in) const override
  {
    std::vector<double> numbers;
    for (const CalibrationLandmarks& pair : in.bench.calibration.landmarks) numbers.push_back(pair.model_mm);
    return numbers;
  }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration&) const override
  {
    std::vector<Task> tasks;
    for (const CalibrationLandmarks& pair : bench.calibration.landmarks) {
      const double mm = pair.model_mm;
      const Dial distance = dial("distance", "mm", mm, 0.1, 10.0 * mm, dial_step_mm);
      tasks.push_back({.kind = &landmark_distance,
                       .name = pair.name,
                       .instruction = "Measure on the subject: " + pair.name +
                                      ".\nDistance in the model: " + short_decimal(mm, 1) + " mm.",
                       .dials = {within(distance, 0.5 * mm, 2.0 * mm)},
                       .index = static_cast<int>(tasks.size())});
    }
    return tasks;
  }

  void solve(const PartInput& in, Calibration& c) const override
  {
    std::vector<LandmarkDistance> distances;
    const std::vector<MarkedTask> tasks = marked_tasks(id(), in);
    for (const MarkedTask& t : tasks) {
      const CalibrationLandmarks& pair =
          in.bench.calibration.landmarks[static_cast<std::size_t>(t.task.index)];
      distances.push_back({pair.name, pair.model_mm, t.mark->rows[0][0]});
    }
    const ScaleFit fit = run_fit(names_of(tasks), [&] { return fit_scale(distances, in.path); });
    if (fit.is_nonuniform) {
      std::string ratios;
      for (const LandmarkDistance& d : distances)
        ratios += (ratios.empty() ? "" : ", ") + d.name + " " + short_decimal(d.subject_mm / d.model_mm, 3);
      throw PartRefusal({in.path, "subject", "distances with different scales: " + ratios,
                         "distances with one scale; measure again, or run the pipeline with these landmarks "
                         "(schemas/scaling.md)"});
    }
    c.records.at(id()).estimate = fit.estimate;
    c.subject_scale = fit.scale;
  }
};

const IpdPart ipd_object({.id = CalibrationPart::ipd, .below = {CalibrationPart::eyepoints}});
const SubjectPart subject_object({.id = CalibrationPart::subject, .bench_key = "calibration.landmarks"});

}  // namespace

const Part &ipd_part = ipd_object, &subject_part = subject_object;

}  // namespace vrda::calibration
