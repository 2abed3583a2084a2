// The convention of synthetic motions: both compartments of the generic knee stay in contact.
#include "tables/convention_search.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "core/units.hpp"
#include "geometry/gap_query.hpp"
#include "geometry/generic_knee.hpp"
#include "support/refusal.hpp"

namespace vrda::tables::convention_search_test {

constexpr int n_frames = 13;
const Eigen::Vector3d centre_mm(2.0, -5.0, 1.0);

/// The generic knee, coarse, and the gaps of its compartments.
struct Knee {
  SolverFrame frame;
  solve::Joint joint;
  Box moving_box;
  std::vector<Pose> poses;

  SearchScene scene() const { return {frame, joint, moving_box}; }
  JointFrame joint_frame() const { return {frame.side, centre_mm, Pose::Identity(), Pose::Identity()}; }
};

std::vector<Compartment> halves(const Mesh& mesh)
{
  std::vector<Compartment> halves;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    double z_mm = 0.0;
    for (const Eigen::Vector3d& corner : corners(mesh, t)) z_mm += corner.z();
    halves.push_back(z_mm < 0.0 ? Compartment::medial : Compartment::lateral);
  }
  return halves;
}

/// The pose with both gaps zero at the flexion, theta and place across Delta: regula falsi on varus.
MovingPose two_sided(const solve::Joint& joint, Attitude& attitude, MovingPose pose)
{
  geometry::GapQuery medial(joint.reference_gap, joint.compartment_gap[0]),
      lateral(joint.reference_gap, joint.compartment_gap[1]);
  const auto gaps_mm = [&](double varus_rad) {
    attitude.varus_rad = varus_rad;
    medial.set_attitude(attitude);
    lateral.set_attitude(attitude);
    return std::pair(medial.travel_mm(pose), lateral.travel_mm(pose));
  };
  double low = rad_from_deg(-15), high = rad_from_deg(15);
  const auto imbalance = [&](double varus_rad) {
    const auto [m, l] = gaps_mm(varus_rad);
    return m - l;
  };
  const double at_low = imbalance(low);
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (imbalance(middle) * at_low > 0.0 ? low : high) = middle;
  }
  pose.translation_mm.y() += gaps_mm(0.5 * (low + high)).first;
  return pose;
}

Knee knee_of(Side side)
{
  const Mesh right_femur = geometry::femur_meshes(0.35, 0.1).contact,
             right_tibia = geometry::tibia_meshes(0.35, 0.1).contact;
  Knee knee;
  const Eigen::Vector3d centre = side == Side::left ? Eigen::Vector3d(2, -5, -1) : centre_mm;
  knee.frame = {side, centre, Eigen::Vector3d::UnitY()};
  const auto own = [&](const Mesh& mesh) { return side == Side::left ? mirrored_z(mesh) : mesh; };
  knee.joint = solve::make_joint({solver_mesh(own(right_femur), knee.frame), {}},
                                 {solver_mesh(own(right_tibia), knee.frame), {}}, halves(right_tibia));
  knee.moving_box = bounding_box(own(right_tibia));
  for (int i = 0; i < n_frames; ++i) {
    const double s = 2.0 * pi * i / n_frames;
    Attitude attitude{rad_from_deg(40.0 - 38.0 * cosine(s)), 0.0};
    const MovingPose start{{1.5 * sine(s), -10.0, 0.8 * cosine(2 * s)}, rad_from_deg(14.0 * sine(s) + 4.0)};
    const MovingPose pose = two_sided(knee.joint, attitude, start);
    knee.poses.push_back(X_reference_moving(knee.frame, attitude, pose));
  }
  return knee;
}

const Knee& knee()
{
  static const Knee made = knee_of(Side::right);
  return made;
}

/// Angles of R = Ra Rb Rc for the order abc.
Eigen::Vector3d angles_rad(const Eigen::Matrix3d& R, AngleOrder order)
{
  const char* name = name_of(order);
  const int a = name[0] - 'x', b = name[1] - 'x', c = name[2] - 'x';
  const double sign = (b - a + 3) % 3 == 1 ? 1.0 : -1.0;
  Eigen::Vector3d angles;
  angles[a] = arc_tangent2(-sign * R(b, c), R(c, c));
  angles[b] = arc_sine(sign * R(a, c));
  angles[c] = arc_tangent2(-sign * R(a, b), R(a, a));
  return angles;
}

/// The poses as a table under a convention.
MotionTable table_under(const std::vector<Pose>& poses, const Convention& c)
{
  const Eigen::Vector3d m(1.0, 1.0, -1.0);
  std::string text = "rx,ry,rz,tx,ty,tz\n";
  for (const Pose& X_reference_moving : poses) {
    const Pose X =
        c.direction == Direction::moving_in_reference ? X_reference_moving : X_reference_moving.inverse();
    Eigen::Matrix3d R = X.linear();
    Eigen::Vector3d t = c.lengths == LengthPoint::centre ? Eigen::Vector3d(X * centre_mm - centre_mm)
                                                         : Eigen::Vector3d(X.translation());
    if (c.side == Side::left) {
      R = m.asDiagonal() * R * m.asDiagonal();
      t = m.cwiseProduct(t);
    }
    const Eigen::Vector3d a = angles_rad(R, c.order) * (c.angles == AngleUnit::degrees ? 180.0 / pi : 1.0);
    char row[300];
    std::snprintf(row, sizeof row, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", a.x(), a.y(), a.z(),
                  t.x() / c.length_mm, t.y() / c.length_mm, t.z() / c.length_mm);
    text += row;
  }
  return motion_table_from_text("m.csv", text, {});
}

std::string text_of(const Convention& c)
{
  std::string text;
  for (const Term term : all_terms) text += value_of(c, term) + " ";
  return text;
}

double largest_difference(const std::vector<Pose>& a, const std::vector<Pose>& b)
{
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, (a[i].matrix() - b[i].matrix()).cwiseAbs().maxCoeff());
  return largest;
}

/// Every second of the combinations, 20 of them, each value of each term several times.
std::vector<Convention> twenty()
{
  std::vector<Convention> all;
  const double units[] = {1.0, 10.0, 1000.0};
  for (std::size_t k = 0; k < 20; ++k) {
    all.push_back({units[k % 3], k % 4 < 2 ? AngleUnit::degrees : AngleUnit::radians, all_orders[k % 6],
                   k % 2 == 0 ? Direction::moving_in_reference : Direction::reference_in_moving,
                   TableAxes::canonical, k % 5 < 3 ? Side::right : Side::left,
                   k % 7 < 4 ? LengthPoint::origin : LengthPoint::centre});
  }
  return all;
}

TEST(ConventionSearch, FindsTwentyMotionsOrNamesWhatCannotBeDistinguished)
{
  int n_found = 0;
  for (const Convention& truth : twenty()) {
    SCOPED_TRACE(text_of(truth));
    const MotionTable table = table_under(knee().poses, truth);
    const ConventionSearch search = find_convention(table, {}, knee().joint_frame(), knee().scene(), 2);
    bool is_among_best = false;
    for (std::size_t i = 0; i < search.n_best; ++i) {
      const std::vector<Pose> poses = poses_of(table, search.candidates[i].convention, knee().joint_frame());
      is_among_best = is_among_best || largest_difference(poses, knee().poses) < 1e-9;
    }
    EXPECT_TRUE(is_among_best) << text_of(search.candidates.front().convention);
    EXPECT_EQ(search.n_best == 1, search.undecided.empty());
    // The knee's varus is small, so orders that differ in its place only may leave the same gaps.
    for (const Term term : search.undecided)
      EXPECT_TRUE(term == Term::side || term == Term::order) << name_of(term);
    n_found += search.n_best == 1 ? 1 : 0;
    // With the undecided terms stated the right one remains.
    SearchRequest request;
    request.stated.side = truth.side;
    request.stated.order = truth.order;
    const ConventionSearch stated = find_convention(table, request, knee().joint_frame(), knee().scene(), 2);
    EXPECT_EQ(stated.n_best, 1u);
    EXPECT_LT(largest_difference(poses_of(table, stated.candidates[0].convention, knee().joint_frame()),
                                 knee().poses),
              1e-9);
  }
  EXPECT_GE(n_found, 15);
}

TEST(ConventionSearch, DoesNotDependOnTheNumberOfThreads)
{
  const MotionTable table = table_under(knee().poses, twenty()[5]);
  std::vector<std::string> texts;
  for (const int n_threads : {1, 3}) {
    const ConventionSearch search =
        find_convention(table, {}, knee().joint_frame(), knee().scene(), n_threads);
    std::string text;
    for (const Candidate& c : search.candidates) {
      char share[40];
      std::snprintf(share, sizeof share, "%a", c.share);
      text += text_of(c.convention) + share + "\n";
    }
    texts.push_back(text);
  }
  EXPECT_EQ(texts[0], texts[1]);
}

TEST(ConventionSearch, TriesWhatIsNotStated)
{
  const JointFrame joint = knee().joint_frame();
  const MotionTable bare = table_under(knee().poses, {});
  EXPECT_EQ(open_conventions(bare, {}, joint).size(), 3u * 2 * 6 * 2 * 2 * 2 * 2);
  SearchRequest request;
  request.stated.order = AngleOrder::zyx;
  EXPECT_EQ(open_conventions(bare, request, joint).size(), 3u * 2 * 2 * 2 * 2 * 2);
  const MotionTable clinical = motion_table_from_text(
      "m.csv", "flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n1,2,3,4,5,6\n", {});
  EXPECT_EQ(open_conventions(clinical, {}, joint).size(), 1u);
  request = {};
  request.automatic = {Term::order, Term::side};
  EXPECT_EQ(open_conventions(clinical, request, joint).size(), 6u * 2);
  const MotionTable matrices = motion_table_from_text("m.tra", "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1\n", {});
  EXPECT_EQ(open_conventions(matrices, {}, joint).size(), 3u * 2 * 2);
}

TEST(ConventionSearch, PosesOfOtherBodiesAreRefused)
{
  std::vector<Pose> far = knee().poses;
  for (Pose& X : far) X.translation() += Eigen::Vector3d(0, -500, 0);
  EXPECT_THAT(test::input_error([&] {
                find_convention(table_under(far, {}), {}, knee().joint_frame(), knee().scene(), 2);
              }),
              test::refuses({"m.csv", "", {"10 mm"}, {"--unit", "--order", "frames"}}));
}

TEST(ConventionSearch, OneFrameDecidesNothing)
{
  const ConventionSearch search =
      find_convention(table_under({knee().poses[0]}, {}), {}, knee().joint_frame(), knee().scene(), 1);
  EXPECT_GT(search.n_best, 1u);
  EXPECT_FALSE(search.undecided.empty());
}

}  // namespace vrda::tables::convention_search_test
