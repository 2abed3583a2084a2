#include "tables/imported_model.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <utility>

#include "analysis/audit.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/component_loader.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/linear_algebra.hpp"
#include "solve/case_solver.hpp"
#include "store/solved_cells.hpp"
#include "tables/convention_search.hpp"

namespace vrda::tables {
namespace {

/// Tables with three decimals are off by at most a few thousandths.
constexpr double rotation_tolerance = 1e-2;

/// As of a motion model.
constexpr double largest_length_mm = 1e9;

Eigen::Matrix3d mirrored(const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d m(1.0, 1.0, -1.0);
  return m.asDiagonal() * R * m.asDiagonal();
}

Eigen::Vector3d mirrored(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), -v.z()};
}

Pose pose_of(const Eigen::Matrix3d& R, const Eigen::Vector3d& t_mm)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = t_mm;
  return X;
}

Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& M, const MotionTable& table, std::size_t frame)
{
  const double error = (M.transpose() * M - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= rotation_tolerance) || M.determinant() < 0.0) {
    throw InputError(
        {table.file, "",
         M.determinant() < 0.0 ? "a matrix that mirrors" : "a matrix off by " + shortest_decimal(error),
         "a rotation: R^T R = 1 within 0.01 and determinant 1", table.line[frame]});
  }
  return nearest_rotation(M);
}

Pose matrix_pose(const MotionTable& table, const PoseEntries& e, std::size_t frame, double length_mm)
{
  Eigen::Matrix3d R;
  R << e[0], e[1], e[2], e[4], e[5], e[6], e[8], e[9], e[10];
  return pose_of(rotation_of(R, table, frame), length_mm * Eigen::Vector3d(e[3], e[7], e[11]));
}

Eigen::Matrix3d about(char axis, const Eigen::Vector3d& angle_rad)
{
  return axis == 'x'   ? rotation_x(angle_rad.x())
         : axis == 'y' ? rotation_y(angle_rad.y())
                       : rotation_z(angle_rad.z());
}

/// Displacement from Grood-Suntay translations, on a right joint (schemas/clinical.md, Remarks). With a varus
/// beyond 90 degrees the floating axis stays that of the flexion, (cf, -sf, 0).
Eigen::Vector3d displacement_mm(const Eigen::Matrix3d& R, const Eigen::Vector3d& q_mm, bool is_beyond)
{
  const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ(), e3 = R.col(1);
  const Eigen::Vector3d e2 = (is_beyond ? -1.0 : 1.0) * e3.cross(e1).normalized();
  const double sv = e3.z(), cv_sq = 1.0 - sv * sv;
  return q_mm.x() * e2 + ((q_mm.z() - q_mm.y() * sv) * e1 + (q_mm.y() - q_mm.z() * sv) * e3) / cv_sq;
}

/// Rotation and lengths of a row, signs of the joint's own side.
struct Numbers {
  Eigen::Matrix3d R;
  Eigen::Vector3d length_mm;
};

Numbers numbers_of(const MotionTable& table, const PoseCoordinates& row, const Convention& c, Side joint_side)
{
  const double to_rad = c.angles == AngleUnit::degrees ? pi / 180.0 : 1.0;
  const Eigen::Vector3d angle_rad = to_rad * Eigen::Vector3d(row.angle[0], row.angle[1], row.angle[2]);
  const Eigen::Vector3d length_mm =
      c.length_mm * Eigen::Vector3d(row.length[0], row.length[1], row.length[2]);
  const char* order = name_of(c.order);
  const Eigen::Matrix3d R =
      about(order[0], angle_rad) * about(order[1], angle_rad) * about(order[2], angle_rad);
  // Clinical numbers are positive on both sides: those of a left joint are of its mirror image.
  const bool flips_angles = table.are_angles_clinical ? c.side == Side::left : c.side != joint_side;
  const bool flips_lengths = table.are_lengths_clinical ? c.side == Side::left : c.side != joint_side;
  const Eigen::Vector3d d_mm =
      c.lengths == LengthPoint::grood_suntay
          ? displacement_mm(R, length_mm, table.are_angles_clinical && cosine(angle_rad.x()) < 0.0)
          : length_mm;
  return {flips_angles ? mirrored(R) : R, flips_lengths ? mirrored(d_mm) : d_mm};
}

/// The two bodies in the roles of the table: `second` is posed in `first`.
struct Roles {
  Pose X_canonical_first, X_canonical_second;
};

Roles roles_of(const Convention& c, const JointFrame& joint)
{
  if (c.axes == TableAxes::canonical) return {Pose::Identity(), Pose::Identity()};
  if (c.direction == Direction::moving_in_reference)
    return {joint.X_canonical_reference, joint.X_canonical_moving};
  return {joint.X_canonical_moving, joint.X_canonical_reference};
}

/// The pose of `second` in `first`, canonical.
Pose coordinate_pose(const Numbers& numbers, const Convention& c, const Roles& roles,
                     const Eigen::Vector3d& centre_mm)
{
  if (c.lengths == LengthPoint::origin)
    return roles.X_canonical_first * pose_of(numbers.R, numbers.length_mm) *
           roles.X_canonical_second.inverse();
  const Eigen::Matrix3d R_first = roles.X_canonical_first.linear();
  const Eigen::Matrix3d R = R_first * numbers.R * roles.X_canonical_second.linear().transpose();
  return pose_of(R, centre_mm + R_first * numbers.length_mm - R * centre_mm);
}

Pose matrix_in_roles(const MotionTable& table, std::size_t frame, const Convention& c, const Roles& roles,
                     Side joint_side)
{
  Pose X = matrix_pose(table, table.matrices[frame], frame, c.length_mm);
  if (!table.of_reference.empty())
    X = matrix_pose(table, table.of_reference[frame], frame, c.length_mm).inverse() * X;
  if (c.side != joint_side)
    X = pose_of(mirrored(Eigen::Matrix3d(X.linear())), mirrored(Eigen::Vector3d(X.translation())));
  return roles.X_canonical_first * X * roles.X_canonical_second.inverse();
}

}  // namespace

std::vector<Pose> poses_of(const MotionTable& table, const Convention& convention, const JointFrame& joint)
{
  const Roles roles = roles_of(convention, joint);
  Eigen::Vector3d point_mm = joint.rotation_centre_mm;
  if (table.point_mm) point_mm = convention.side == joint.side ? *table.point_mm : mirrored(*table.point_mm);
  std::vector<Pose> poses;
  poses.reserve(table.key.size());
  for (std::size_t frame = 0; frame < table.key.size(); ++frame) {
    const Pose X = table.has_matrices()
                       ? matrix_in_roles(table, frame, convention, roles, joint.side)
                       : coordinate_pose(numbers_of(table, table.coordinates[frame], convention, joint.side),
                                         convention, roles, point_mm);
    if (!(X.matrix().array().abs() <= largest_length_mm).all()) {
      throw InputError({table.file, "",
                        "a position beyond 1e9 mm, or a varus of 90 degrees with Grood-Suntay lengths",
                        "poses within 1e9 mm", table.line[frame]});
    }
    poses.push_back(convention.direction == Direction::moving_in_reference ? X : X.inverse(Eigen::Isometry));
  }
  return poses;
}

MotionSequence read_motion(const std::string& file, const MotionConvention& convention)
{
  const MotionTable table = read_motion_table(file, convention.columns);
  const Convention complete = completed(convention.stated, table.stated, convention.joint.side);
  const UnitSource source = convention.stated.angles ? UnitSource::option
                            : table.stated.angles    ? UnitSource::file
                                                     : UnitSource::assumed;
  std::vector<std::string> warnings = table.warnings;
  for (std::string& line : unit_warnings(table, complete.angles, source, convention.joint))
    warnings.push_back(std::move(line));
  return {table.key_name, table.key, poses_of(table, complete, convention.joint), table.absent_columns,
          std::move(warnings)};
}

ImportFrame import_frame(const job::Job& job, const job::Case& job_case)
{
  const job::Job found = job_case.found_frames ? job::with_found_frames(job, *job_case.found_frames) : job;
  const job::BodyMaps maps = job::body_maps(found);
  const job::Case subject = job::scaled_to_subject(job_case);
  ImportFrame frame;
  frame.joint = {subject.frame.side, subject.frame.rotation_centre_mm, maps.reference.X_canonical_native,
                 maps.moving.X_canonical_native, joint_kind(job.joint).has_large_flexion};
  frame.has_file_axes = !job_case.scaling;
  return frame;
}

job::Case import_case(const job::Case& job_case, const MotionSequence& motion, const std::string& record)
{
  job::Case result = job::scaled_to_subject(job_case);
  const job::Push push = result.push.front();
  if (result.method == "equilibrium")
    result.search.translation_resolution_mm = result.equilibrium.contact_resolution_mm;
  result.method = "import";
  result.is_varus_free = true;
  result.coordinates.reset();  // roles of a solver
  result.grid = {{}, {0.0}};
  for (const Pose& X : motion.X_reference_moving)
    result.grid.flexion_deg.push_back(deg_from_rad(solver_position(result.frame, X).attitude.flexion_rad));
  result.push.assign(motion.key.size(), push);
  result.path_flexion_deg.clear();
  result.path_push.clear();
  result.smooth_degrees.clear();
  result.resolved_job += record;
  return result;
}

store::MotionModel imported_model(const job::Case& job_case, const MotionSequence& motion, int n_threads)
{
  store::MotionModel model = solve::pending_model_of(job_case);
  model.frames = store::FrameSequence{motion.key_name, motion.key};
  const solve::Joint joint = solve::joint_of(job_case, job_case.frame);
  analysis::FrameMeter meter(joint, model.contact_resolution_mm);
  solve::SweepResult result;
  std::vector<StepRecord>& records = result.cells;
  for (std::size_t i = 0; i < motion.key.size(); ++i) {
    const SolverPosition at = solver_position(job_case.frame, motion.X_reference_moving[i]);
    records.push_back(meter.record(static_cast<std::int32_t>(i), at, meter.gaps(at)));
    store::set_cell(model, records.back());
    model.is_spine(static_cast<Eigen::Index>(i), 0) = 1;
  }
  model.contacts = store::contact_rows(model, records);
  solve::add_balance(model, job_case, result);  // contact paths and fibres
  model.audits = {analysis::audit(model, "raw", 1, n_threads)};
  return model;
}

}  // namespace vrda::tables
