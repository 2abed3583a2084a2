#include "prepare/template_joint.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/clean_mesh.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "solve/case_solver.hpp"
#include "solve/compliant_contact.hpp"
#include "solve/potential.hpp"

namespace vrda::prepare {
namespace {

constexpr const char* generic_job = R"(title = "Generic knee"
[reference]
name = "femur"
[[reference.component]]
name = "femur"
generate = { shape = "knee-template", part = "femur" }
[moving]
name = "tibia"
[[moving.component]]
name = "tibia"
generate = { shape = "knee-template", part = "tibia" }
[[moving.component]]
name = "fibula"
generate = { shape = "knee-template", part = "fibula" }
contact = false
[grid]
flexion = { from = 0, to = 90, step = 10 }
varus = "free"
[solver]
method = "equilibrium"
[ligaments]
generate = { shape = "knee-template" }
[[follower]]
name = "patella"
generate = { shape = "knee-template" }
[[follower.direction]]
bundle = "PT"
stiffness_nmm_per_rad = 3000
[[follower.component]]
name = "patella"
generate = { shape = "knee-template", part = "patella" }
)";

bool is_fibula(const std::string& name)
{
  return name.find("fibula") != std::string::npos;
}

Mesh fibula_of(const Body& body)
{
  Mesh fibula;
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      if (is_fibula(body.components[c].name)) append(fibula, select_triangles(part->mesh, rows[c]));
    }
  }
  return fibula;
}

Eigen::Vector3d flipped(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), -v.z()};
}

model::Ligaments mirrored(model::Ligaments ligaments)
{
  const Eigen::DiagonalMatrix<double, 3> flip(1.0, 1.0, -1.0);
  for (model::Fibre& fibre : ligaments.fibres) {
    fibre.reference_mm = flipped(fibre.reference_mm);
    fibre.moving_mm = flipped(fibre.moving_mm);
  }
  for (model::Wrap& wrap : ligaments.wraps) {
    // An ellipsoid and a cylinder are symmetric in their own Z = 0.
    const Eigen::Matrix3d R = flip * wrap.X_body_wrap.linear() * flip;
    wrap.X_body_wrap.linear() = R;
    wrap.X_body_wrap.translation() = flipped(wrap.X_body_wrap.translation());
  }
  return ligaments;
}

job::Follower mirrored(job::Follower follower)
{
  follower.body = mirrored_z(follower.body);
  follower.centre_mm = flipped(follower.centre_mm);
  follower.delta = flipped(follower.delta);
  follower.ligaments = mirrored(std::move(follower.ligaments));
  for (job::TendonDirection& direction : follower.directions) direction.axis = -flipped(direction.axis);
  return follower;
}

}  // namespace

geometry::BoneSurfaces surfaces_of(const Body& body)
{
  geometry::BoneSurfaces surfaces;
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      const Component& component = body.components[c];
      if (rows[c].empty() || is_fibula(component.name)) continue;
      const Mesh mesh = job::outer_surface(select_triangles(part->mesh, rows[c]));
      if (component.material == "bone") append(surfaces.bone, mesh);
      if (component.material == "cartilage") append(surfaces.cartilage, mesh);
    }
  }
  return surfaces;
}

TemplateJoint mirrored(const TemplateJoint& joint)
{
  TemplateJoint other = joint;
  job::Case& c = other.joint;
  c.frame.side = c.frame.side == Side::left ? Side::right : Side::left;
  c.frame.rotation_centre_mm = flipped(c.frame.rotation_centre_mm);
  c.reference = mirrored_z(c.reference);
  c.moving = mirrored_z(c.moving);
  c.ligaments = mirrored(c.ligaments);
  other.knee = {mirrored_z(joint.knee.surfaces), flipped(joint.knee.origin_mm)};
  other.fibula = mirrored_z(joint.fibula);
  if (joint.patella) other.patella = mirrored(*joint.patella);
  return other;
}

TemplateJoint template_of(const job::Case& joint)
{
  if (joint.joint != "knee" || joint.method != "equilibrium")
    throw InputError({"--template", "\"" + joint.title + "\"", joint.joint + ", " + joint.method,
                      "a knee with solver.method = \"equilibrium\""});
  TemplateJoint found{
      joint,
      {{surfaces_of(joint.reference), surfaces_of(joint.moving)}, joint.frame.rotation_centre_mm},
      fibula_of(joint.moving)};
  if (!joint.followers.empty()) found.patella = joint.followers.front();
  found.joint.followers.clear();
  return joint.frame.side == Side::left ? mirrored(found) : found;
}

TemplateJoint generic_template()
{
  TemplateJoint knee = template_of(job::load_case(job::parse_job("generic knee", generic_job), ""));
  knee.knee = geometry::generic_template();
  return knee;
}

TemplateJoint generated_knee()
{
  std::string text = generic_job;
  const std::string_view shape = "knee-template";
  for (std::size_t at = text.find(shape); at != std::string::npos; at = text.find(shape))
    text.replace(at, shape.size(), "knee");
  return template_of(job::load_case(job::parse_job("generated knee", text), ""));
}

namespace {

constexpr double eminence_half_width_mm = 6.0;
constexpr double largest_varus_rad = rad_from_deg(12.0);

// Balances the height and varus under a push on compliant surfaces, the other coordinates held: exact contact
// rests on the highest points, which noise moves. A balance that is not found leaves the pose.
void balance(const solve::Joint& bodies, double push_n, SettledPose& settled)
{
  constexpr double largest_step_mm = 0.5, balanced_share = 1e-6;
  constexpr int most_steps = 60;
  const solve::RotationScale scale = solve::rotation_scale_of(bodies.moving.tree_mesh.mesh);
  const solve::CompliantSurfaces& surfaces = bodies.compliant->of(bodies);
  const Eigen::Vector2d size(1.0, 1.0 / scale.lever_mm);
  solve::Configuration at = solve::configuration_at(settled.pose, settled.attitude.varus_rad, scale);
  for (int k = 0; k < most_steps; ++k) {
    const model::Potential u =
        solve::foundation_at({surfaces, at, scale}, contact_stiffness_n_per_mm3).potential;
    Eigen::Vector2d slope_n(u.gradient(model::along_y) - push_n, u.gradient(model::about_varus));
    Eigen::Matrix2d H;
    H << u.hessian(model::along_y, model::along_y), u.hessian(model::along_y, model::about_varus),
        u.hessian(model::about_varus, model::along_y), u.hessian(model::about_varus, model::about_varus);
    slope_n = size.cwiseProduct(slope_n).eval();
    H = (size.asDiagonal() * H * size.asDiagonal()).eval();
    if (slope_n.norm() <= balanced_share * push_n) {
      settled.attitude.varus_rad = at.varus_rad;
      settled.pose = solve::pose_at(at, scale);
      return;
    }
    // Where nothing is pressed yet, or one side only, the step is that of a stiff surface.
    H += (push_n / largest_step_mm) * Eigen::Matrix2d::Identity() * (H.determinant() > 0.0 ? 0.0 : 1.0);
    Eigen::Vector2d step_mm = -H.ldlt().solve(slope_n);
    if (step_mm.norm() > largest_step_mm) step_mm *= largest_step_mm / step_mm.norm();
    at.pivot_mm.y() += step_mm(0);
    at.varus_rad += step_mm(1) / scale.lever_mm;
  }
}

}  // namespace

geometry::GapTree plateau_tree(const Mesh& tibia, double side)
{
  std::vector<std::int32_t> rows;
  for (Eigen::Index t = 0; t < tibia.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(tibia, t);
    if (side * (a + b + c).z() / 3.0 > eminence_half_width_mm) rows.push_back(static_cast<std::int32_t>(t));
  }
  return {tibia, rows};
}

namespace {

SettledPose settled_pose_of(const job::Case& joint, const solve::Joint& bodies)
{
  const Mesh& moving = bodies.moving.tree_mesh.mesh;
  const geometry::GapTree medial_tree = plateau_tree(moving, -1.0), lateral_tree = plateau_tree(moving, 1.0);
  SettledPose settled;
  if (medial_tree.is_empty() || lateral_tree.is_empty()) return settled;
  geometry::GapQuery medial(bodies.reference_gap, medial_tree), lateral(bodies.reference_gap, lateral_tree);
  // Adduction closes the medial side: the difference falls with varus.
  const auto medial_excess_mm = [&](double varus_rad) {
    medial.set_attitude({0.0, varus_rad});
    lateral.set_attitude({0.0, varus_rad});
    return medial.travel_mm({}) - lateral.travel_mm({});
  };
  double low = -largest_varus_rad, high = largest_varus_rad;
  const double at_low = medial_excess_mm(low), at_high = medial_excess_mm(high);
  if (!std::isfinite(at_low) || !std::isfinite(at_high)) return settled;
  const bool falls = at_low > at_high;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    ((medial_excess_mm(middle) > 0.0) == falls ? low : high) = middle;
  }
  settled.attitude.varus_rad = 0.5 * (low + high);
  medial_excess_mm(settled.attitude.varus_rad);
  settled.pose.translation_mm.y() = std::min(medial.travel_mm({}), lateral.travel_mm({}));
  settled.has_contact = std::isfinite(settled.pose.translation_mm.y());
  if (settled.has_contact) balance(bodies, joint.push.front().force_n.norm(), settled);
  return settled;
}

}  // namespace

SettledPose settled_pose(const job::Case& joint)
{
  return settled_pose_of(joint, solve::joint_of(joint, joint.frame));
}

std::vector<double> fibre_lengths_mm(const job::Case& joint, const SettledPose& at)
{
  const model::Ligaments ligaments = model::solver_ligaments(joint.ligaments, joint.frame);
  std::vector<double> lengths;
  for (const model::FibreState& state : model::fibre_states(ligaments, at.attitude, at.pose))
    lengths.push_back(state.length_mm);
  return lengths;
}

FibreLoads SlackLengths::solved_loads(const job::Case& joint, const Bodies& bodies) const
{
  job::Case coarse = joint;
  coarse.grid = {{}, {0.0}};
  for (int k = 0; k < 10; ++k) coarse.grid.flexion_deg.push_back(10.0 * k);
  coarse.is_varus_free = true;
  coarse.push.assign(10, joint.push.front());
  // Steps of 2 degrees along the spine and few restarts: strains to a hundredth.
  coarse.path_flexion_deg.clear();
  for (int k = 0; k <= 45; ++k) coarse.path_flexion_deg.push_back(2.0 * k);
  coarse.path_push.assign(coarse.path_flexion_deg.size(), joint.push.front());
  coarse.spine = {0, 0.0};
  coarse.prior.clear();
  coarse.followers.clear();
  coarse.equilibrium.contact_stiffness_n_per_mm3 = contact_stiffness_n_per_mm3;
  coarse.equilibrium.contact_thickness_mm = contact_thickness_mm;
  solve::CaseSolver solver(coarse, n_threads_, bodies);
  const solve::SweepResult result = solve::sweep(
      solve::plan_of(coarse), [&](const solve::StepTask& task) { return solver(task); },
      {{}, {}, is_stopped_}, n_threads_);
  const model::Ligaments ligaments = model::solver_ligaments(joint.ligaments, joint.frame);
  FibreLoads loads;
  loads.largest_strain.assign(ligaments.fibres.size(), -1.0);
  loads.largest_tension_n.assign(ligaments.fibres.size(), 0.0);
  loads.n_flexions = static_cast<int>(result.cells.size());
  for (const StepRecord& cell : result.cells) {
    if (cell.status != StepStatus::stable) continue;
    ++loads.n_solved;
    const double flexion_rad =
        rad_from_deg(coarse.grid.flexion_deg[static_cast<std::size_t>(cell.key.flexion)]);
    const Attitude attitude{flexion_rad, cell.varus_rad};
    loads.flexion_rad.push_back(flexion_rad);
    loads.X_reference_moving.push_back(X_reference_moving(joint.frame, attitude, cell.pose));
    const std::vector<model::FibreState> states = model::fibre_states(ligaments, attitude, cell.pose);
    for (std::size_t i = 0; i < states.size(); ++i) {
      loads.largest_strain[i] = std::max(loads.largest_strain[i], states[i].strain);
      loads.largest_tension_n[i] = std::max(loads.largest_tension_n[i], states[i].force_n);
    }
  }
  return loads;
}

SlackLengths::SlackLengths(job::Case& subject, const job::Case& reference, int n_threads,
                           std::function<bool()> is_stopped)
    : subject_(subject),
      reference_(reference),
      n_threads_(n_threads),
      is_stopped_(std::move(is_stopped)),
      bodies_(std::make_shared<const solve::Joint>(solve::joint_of(subject, subject.frame)))
{
  check(subject.ligaments.fibres.size() == reference.ligaments.fibres.size(),
        "a transferred fibre for each of the template");
  const auto of_template = std::make_shared<const solve::Joint>(solve::joint_of(reference, reference.frame));
  // Half of the time is that of both distance fields.
  SettledPose of_reference;
  for_each_index(2, n_threads, [&] {
    return [&](std::size_t k) {
      if (k == 0) settled_ = settled_pose_of(subject, *bodies_);
      if (k == 1) of_reference = settled_pose_of(reference, *of_template);
    };
  });
  template_mm_ = fibre_lengths_mm(reference, of_reference);
  template_strain_ = solved_loads(reference, of_template).largest_strain;
}

SlackResult SlackLengths::set()
{
  constexpr double allowed_excess = 0.05;
  constexpr double tolerance = 0.005;  // of strain
  constexpr int most_solutions = 4;
  std::vector<model::Fibre>& fibres = subject_.ligaments.fibres;
  SlackResult result;
  result.settled = settled_;
  const std::vector<double> own_mm = fibre_lengths_mm(subject_, settled_);
  for (std::size_t i = 0; i < fibres.size(); ++i)
    fibres[i].slack_length_mm = reference_.ligaments.fibres[i].slack_length_mm * own_mm[i] / template_mm_[i];
  result.template_strain = template_strain_;
  result.loads = solved_loads(subject_, bodies_);
  for (int k = 0; k < most_solutions; ++k) {
    std::int32_t n = 0;
    for (std::size_t i = 0; i < fibres.size(); ++i) {
      const double limit = std::max(result.template_strain[i], 0.0) + allowed_excess;
      if (result.loads.largest_strain[i] <= limit + tolerance) continue;
      fibres[i].slack_length_mm *= (1.0 + result.loads.largest_strain[i]) / (1.0 + limit);
      ++n;
    }
    result.lengthenings.push_back(n);
    if (n == 0) break;
    result.loads = solved_loads(subject_, bodies_);
  }
  return result;
}

namespace {

// Knees prepared by the template are fitted as closely. Frames defined by different people differ by some 15
// degrees and mm.
constexpr double largest_reliable_residual_mm = 3.5;
constexpr double certain_side_margin = 1.15;
constexpr double largest_turn_deg = 30.0, largest_offset_mm = 30.0;

double turn_deg(const Eigen::Matrix3d& R)
{
  const Eigen::Quaterniond q(R);
  return deg_from_rad(2.0 * arc_tangent2(q.vec().norm(), std::abs(q.w())));
}

// The bones are compared together, so that both frames are meant.
std::string both(const FrameKeys& keys, const std::string& ending)
{
  if (keys.reference == keys.moving) return keys.reference + ending;
  return keys.reference + ending + ", " + keys.moving + ending;
}

}  // namespace

std::vector<std::string> frame_warnings(const job::Case& knee, const FrameKeys& keys)
{
  geometry::KneeSurfaces bones{surfaces_of(knee.reference), surfaces_of(knee.moving)};
  const Mesh femur = joined(bones.femur), tibia = joined(bones.tibia);
  if (knee.joint != "knee" || femur.triangles.rows() == 0 || tibia.triangles.rows() == 0) return {};
  const std::string remedy = "; vrda prepare finds unit, side and frame";
  const double unit_mm = geometry::unit_mm_of(femur, tibia);
  if (unit_mm != 1.0)
    return {both(keys, ".unit") + ": the bones have the size of a knee in " + job::unit_of_mm(unit_mm) +
            remedy};
  const geometry::TemplateKnee reference = geometry::generic_template();
  const geometry::CoarseFit fit = coarse_fit(bones, reference, 2.0 * largest_reliable_residual_mm);
  const bool is_left = fit.left.residual_mm < fit.right.residual_mm;
  const Side side = is_left ? Side::left : Side::right;
  const geometry::SimilarityFit& best = is_left ? fit.left : fit.right;
  if (!(best.residual_mm < largest_reliable_residual_mm)) return {};
  std::vector<std::string> warnings;
  const double margin = (is_left ? fit.right : fit.left).residual_mm / best.residual_mm;
  if (margin > certain_side_margin && side != knee.frame.side)
    warnings.push_back("side: the bones are those of a " + side_name(side) + " knee in these axes" + remedy);
  const double turned_deg = turn_deg(best.R);
  const double off_mm =
      (best.t_mm - knee.frame.rotation_centre_mm).norm();  // the template's origin is its centre
  if (turned_deg > largest_turn_deg)
    warnings.push_back(both(keys, "") + ": the bones are turned by " + short_decimal(turned_deg, 0) +
                       " degrees from these axes" + remedy);
  else if (off_mm > largest_offset_mm)
    warnings.push_back(keys.reference + ".origin: " + short_decimal(off_mm, 0) +
                       " mm from the flexion axis between the condyles" + remedy);
  return warnings;
}

// Thickness of cartilage where a scan shows bones only.

double scanned_gap_mm(const geometry::KneeFit& fit, const geometry::KneeSurfaces& subject)
{
  const auto in_tibia_frame = [&](const geometry::BoneSurfaces& surfaces) {
    Mesh mesh = joined(surfaces);
    mesh.vertices_mm *= fit.unit_mm;
    return transformed(mesh, fit.X_scan_tibia.inverse());
  };
  const Mesh femur = in_tibia_frame(subject.femur), tibia = in_tibia_frame(subject.tibia);
  const geometry::GapTree above(femur);
  double sum = 0.0;
  for (const double side : {-1.0, 1.0}) {
    const geometry::GapTree below = plateau_tree(tibia, side);
    sum += below.is_empty() ? nan : geometry::GapQuery(above, below).travel_mm({});
  }
  return std::isfinite(sum) ? 0.5 * sum : nan;
}

double cartilage_in_gap_mm(double gap_mm)
{
  constexpr double least_mm = 1.5, most_mm = 5.0;
  return std::isfinite(gap_mm) ? std::clamp(gap_mm, least_mm, most_mm) : most_mm;
}

}  // namespace vrda::prepare
