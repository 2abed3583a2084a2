#include "store/sample_model.hpp"

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"

namespace vrda::test {
namespace {

Part part_of(const Mesh& mesh, std::int32_t component)
{
  return {mesh, std::vector<std::int32_t>(static_cast<std::size_t>(mesh.triangles.rows()), component)};
}

Body sample_body(const std::string& name, bool has_visual)
{
  Body body;
  body.name = name;
  body.components = {{name, "bone"}, {name + " shaft", "bone"}};
  body.contact = part_of(ball(20.0, 8, 12), 0);
  if (has_visual) body.visual = part_of(box({0, 60, 0}, {10, 80, 10}), 1);
  body.visual.mesh.normals.resize(0, 3);  // one part with normals, one without
  return body;
}

void fill_cell(store::MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  const double flexion_deg = model.flexion_deg[static_cast<std::size_t>(i)];
  const double varus_deg = model.varus_deg[static_cast<std::size_t>(j)];
  const SolverFrame frame{Side::right, model.rotation_centre_mm, model.push.delta.row(i).transpose()};
  const Eigen::Vector3d t_mm =
      world_translation_mm(frame, {{0.1 * flexion_deg, -40.0 + 0.01 * varus_deg, 0.3}, 0.0});
  model.varus_solved_deg(i, j) = varus_deg;
  solve_cell(model, i, j, {t_mm.x(), t_mm.y(), t_mm.z(), 0.2 * flexion_deg});
  model.plausibility(i, j) = static_cast<std::int8_t>((i + j) % 3);
  model.iterations(i, j) = static_cast<std::int32_t>(10 + i);
  model.queries(i, j) = static_cast<std::int32_t>(30 + j);
  model.residual_mm(i, j) = 0.01;
  model.is_spine(i, j) = j == (model.varus_deg.size() > 1 ? 1 : 0) ? 1 : 0;
  if (model.has_compartments) model.gap_mm[0](i, j) = 0.02;  // the lateral one faces nothing: NaN
  model.is_in_contact[0](i, j) = model.has_compartments ? 1 : -1;
  model.is_in_contact[1](i, j) = model.has_compartments ? 0 : -1;
}

store::ContactRows sample_contacts(const store::MotionModel& model)
{
  store::ContactRows contacts;
  contacts.row_start = {0};
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    const bool is_stable = model.status.data()[cell] == 0;
    contacts.row_start.push_back(contacts.row_start.back() + (is_stable ? 2 : 0));
  }
  const std::size_t n = static_cast<std::size_t>(contacts.row_start.back());
  contacts.point_world_mm = Points::Constant(static_cast<Eigen::Index>(n), 3, 1.5);
  contacts.normal_world = Eigen::RowVector3d(0, -1, 0).replicate(static_cast<Eigen::Index>(n), 1);
  contacts.distance_mm.assign(n, 0.05);
  contacts.triangle_reference.assign(n, 7);
  contacts.triangle_moving.assign(n, 3);
  contacts.compartment.assign(n, model.has_compartments ? 1 : 0);
  return contacts;
}

store::SmoothedSet sample_smoothed(const store::MotionModel& model)
{
  store::SmoothedSet set;
  set.degree = 1;
  const bool has_varus = model.varus_deg.size() > 1;
  set.exponents.resize(has_varus ? 3 : 2, 2);
  set.exponents.topRows(2) << 0, 0, 1, 0;
  if (has_varus) set.exponents.row(2) << 0, 1;
  double level = 1.0;
  for (const char* name : {"tx", "ty", "tz", "theta"}) {
    store::SmoothedSurface surface;
    surface.name = name;
    surface.coefficients = {level, 0.5, -0.25};
    surface.coefficients.resize(static_cast<std::size_t>(set.exponents.rows()));
    surface.n_cells = 11;
    surface.rms = 0.03;
    surface.largest_residual = 0.1;
    surface.leave_one_out_rms = 0.04;
    surface.condition_number = 1.5;
    surface.values = grid_values(model, set, surface);
    set.surfaces.push_back(surface);
    level += 1.0;
  }
  return set;
}

bool is_stable(const store::MotionModel& model, std::size_t cell)
{
  return model.status.data()[cell] == status_stable;
}

store::PushRows turning_push(std::int32_t n_flexion)
{
  store::PushRows push = store::constant_push(Eigen::Vector3d::UnitY(), static_cast<std::size_t>(n_flexion));
  for (std::int32_t i = 0; i < n_flexion; ++i) {
    push.delta.row(i) = Eigen::RowVector3d(0.01 * i, 1.0, -0.002 * i).normalized();
    push.force_n.row(i) = 20.0 * push.delta.row(i) + Eigen::RowVector3d(0.5, 0.0, 0.25);
    push.moment_nmm[static_cast<std::size_t>(i)] = -500.0 + i;
    push.varus_moment_nmm[static_cast<std::size_t>(i)] = 40.0 * i;
  }
  push.point_mm = {0.5, -1.0, 2.0};
  return push;
}

store::ForceRows sample_forces(const store::MotionModel& model)
{
  store::ForceRows forces;
  forces.row_start = {0};
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(model.status.size()); ++cell) {
    const bool has_forces = is_stable(model, cell) && cell % 2 == 0;
    forces.row_start.push_back(forces.row_start.back() + (has_forces ? 2 : 0));
  }
  const std::size_t n = static_cast<std::size_t>(forces.row_start.back());
  forces.point_world_mm.resize(static_cast<Eigen::Index>(n), 3);
  forces.normal_world.resize(static_cast<Eigen::Index>(n), 3);
  for (std::size_t k = 0; k < n; ++k) {
    const bool is_medial = k % 2 == 0;
    const Eigen::Index row = static_cast<Eigen::Index>(k);
    forces.point_world_mm.row(row) << 1.0, -20.0, is_medial ? -22.0 : 23.0;
    forces.normal_world.row(row) = Eigen::RowVector3d(0.1, -1.0, is_medial ? 0.2 : -0.2).normalized();
    forces.along_delta_n.push_back(is_medial ? 15.0 : 5.0);
    forces.triangle_reference.push_back(static_cast<std::int32_t>(k % 100));
    forces.triangle_moving.push_back(3);
    forces.compartment.push_back(!model.has_compartments ? 0 : is_medial ? 1 : 2);
  }
  return forces;
}

/// The spine's pose, and where it has several optima another one after it.
store::SpineBranches sample_branches(const store::FreeSpine& spine)
{
  store::SpineBranches branches;
  branches.row_start = {0};
  for (std::size_t i = 0; i < spine.status.size(); ++i) {
    for (std::int32_t k = 0; k < spine.n_optima[i]; ++k) {
      branches.varus_deg.push_back(spine.varus_deg[i] + 0.5 * k);
      branches.tx_mm.push_back(spine.tx_mm[i]);
      branches.ty_mm.push_back(spine.ty_mm[i]);
      branches.tz_mm.push_back(spine.tz_mm[i] - 0.25 * k);
      branches.theta_deg.push_back(spine.theta_deg[i] + 6.5 * k);
      branches.energy_nmm.push_back(spine.energy_nmm[i] + 1.75 * k);
      branches.is_chosen.push_back(k == 0 ? 1 : 0);
    }
    branches.row_start.push_back(static_cast<std::int64_t>(branches.energy_nmm.size()));
  }
  return branches;
}

store::FreeSpine sample_spine(store::FreeSpine spine)
{
  for (std::size_t i = 0; i + 1 < spine.status.size(); ++i) {  // the last one is not stable
    const double x = static_cast<double>(i);
    spine.status[i] = status_stable;
    spine.varus_deg[i] = -0.3 + 0.01 * x;
    spine.tx_mm[i] = 0.1 * x;
    spine.ty_mm[i] = -40.0 + 0.02 * x;
    spine.tz_mm[i] = 0.3;
    spine.theta_deg[i] = 0.2 * x;
    spine.energy_nmm[i] = 800.0 - x;
    if (i > 0) spine.theta_low_deg[i] = 0.2 * x - 3.5;  // the first has no band
    if (i > 0) spine.theta_high_deg[i] = 0.2 * x + 4.5;
    spine.n_optima[i] = i == 1 ? 2 : 1;
    spine.optima_theta_spread_deg[i] = i == 1 ? 6.5 : 0.0;
    spine.optima_energy_spread_nmm[i] = i == 1 ? 1.75 : 0.0;
  }
  spine.status.back() = static_cast<std::int8_t>(StepStatus::unbounded);
  spine.n_optima.back() = 0;
  spine.branches = sample_branches(spine);
  return spine;
}

void fill_equilibrium(store::MotionModel& model)
{
  store::EquilibriumSurfaces& equilibrium = *model.equilibrium;
  equilibrium.band_moment_nmm = 500.0;
  equilibrium.forces = sample_forces(model);
  equilibrium.spine = sample_spine(equilibrium.spine);
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(model.status.size()); ++cell) {
    if (!is_stable(model, cell)) continue;
    const double x = static_cast<double>(cell);
    equilibrium.energy_nmm.data()[cell] = 800.0 + x;
    equilibrium.balance_residual_n.data()[cell] = 1e-4 * (x + 1.0);
    equilibrium.complementarity_mm.data()[cell] = 1e-7 * x;
    equilibrium.worst_gap_mm.data()[cell] = -1e-6 * x;
    equilibrium.flexion_moment_nmm.data()[cell] = 100.0 * x;
    equilibrium.varus_moment_nmm.data()[cell] = -3.0 * x;
    if (!model.has_compartments) continue;
    Eigen::Vector3d sums[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    const Eigen::RowVector3d delta =
        model.push.delta.row(static_cast<Eigen::Index>(cell) / model.status.cols());
    for (std::int64_t k = equilibrium.forces.row_start[cell]; k < equilibrium.forces.row_start[cell + 1];
         ++k) {
      const std::size_t row = static_cast<std::size_t>(k);
      const Eigen::RowVector3d normal = equilibrium.forces.normal_world.row(k);
      sums[equilibrium.forces.compartment[row]] +=
          (equilibrium.forces.along_delta_n[row] / -normal.dot(delta)) * normal.transpose();
    }
    Eigen::Map<Eigen::Vector3d>(&equilibrium.force_n[0][3 * cell]) = sums[1];
    Eigen::Map<Eigen::Vector3d>(&equilibrium.force_n[1][3 * cell]) = sums[2];
  }
}

store::LigamentRows sample_ligaments(const SampleOptions& options)
{
  store::LigamentRows ligaments;
  const Eigen::Index n = options.n_fibres, n_wraps = options.n_wraps;
  ligaments.reference_mm.resize(n, 3);
  ligaments.moving_mm.resize(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double x = static_cast<double>(k);
    ligaments.name.push_back("fibre " + std::to_string(k));
    ligaments.bundle.push_back(k % 2 == 0 ? "ACL" : "MCL");
    ligaments.reference_mm.row(k) << x, 10.0, -30.0;
    ligaments.moving_mm.row(k) << x, -40.0, -25.0;
    ligaments.stiffness_n.push_back(1000.0 + x);
    ligaments.slack_length_mm.push_back(45.0 + x);
    ligaments.wrap.push_back(options.n_wraps > 0 && k % 2 == 1 ? options.n_wraps - 1 : -1);
  }
  ligaments.transition_strain = 0.05;
  ligaments.wrap_radii_mm.resize(n_wraps, 3);
  for (Eigen::Index k = 0; k < n_wraps; ++k) {
    ligaments.wrap_name.push_back("condyle " + std::to_string(k));
    ligaments.wrap_shape.push_back(static_cast<std::int8_t>(k % 2));
    ligaments.wrap_body.push_back(static_cast<std::int8_t>(k % 2));
    Pose X = Pose::Identity();
    X.linear() = rotation_x(0.1 * static_cast<double>(k + 1));
    X.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix = X.matrix();
    ligaments.X_body_wrap.insert(ligaments.X_body_wrap.end(), matrix.data(), matrix.data() + 16);
    ligaments.wrap_radii_mm.row(k) << 20.0, 20.0, 30.0;
  }
  return ligaments;
}

void fill_fibre_states(store::MotionModel& model)
{
  store::LigamentRows& ligaments = *model.ligaments;
  const std::size_t n = ligaments.name.size();
  for (std::size_t i = 0; i < ligaments.length_mm.size(); ++i) {
    if (!is_stable(model, i / n)) continue;
    const double strain = 0.001 * static_cast<double>(i % n) - 0.002;
    ligaments.strain[i] = strain;
    ligaments.length_mm[i] = ligaments.slack_length_mm[i % n] * (1.0 + strain);
    ligaments.tension_n[i] =
        strain > 0.0 ? 0.25 * ligaments.stiffness_n[i % n] * strain * strain / 0.05 : 0.0;
    ligaments.energy_nmm[i] = ligaments.tension_n[i] * strain * ligaments.slack_length_mm[i % n] / 3.0;
    ligaments.is_wrapped[i] = ligaments.wrap[i % n] >= 0 ? 1 : 0;
  }
}

/// Flexion 0, 1, 2, 1, 0, ...: neither ascending nor without repetition.
void set_frames(store::MotionModel& model)
{
  model.method = model.method == "equilibrium" ? model.method : "import";
  model.varus_deg = {0.0};
  model.frames.emplace().key_name = "time_s";
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    model.frames->key.push_back(0.5 * static_cast<double>(i) - 0.25);
    model.flexion_deg[i] = static_cast<double>(i % 4 == 3 ? 1 : i % 4);
  }
}

/// Internal rotation and anterior translation given with flexion, the rest free.
void set_roles(store::MotionModel& model)
{
  model.coordinates.emplace().role = {1, 2, 1, 1, 2, 2};
}

void fill_coordinates(store::MotionModel& model)
{
  store::CoordinateSurfaces& coordinates = *model.coordinates;
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(model.status.size()); ++cell) {
    if (model.status.data()[cell] != status_stable) continue;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      const bool is_free = coordinates.role[k] == static_cast<std::int8_t>(CoordinateRole::free);
      if (is_free) {
        coordinates.determined[n_joint_coordinates * cell + k] = k == 5 ? 0 : 1;
      } else {
        (is_rotation(k) ? coordinates.holding_moment_nmm : coordinates.holding_force_n)[3 * cell + k % 3] =
            3.5 * static_cast<double>(k) - 2.0;
      }
    }
  }
}

}  // namespace

store::MotionModel sample_model(const SampleOptions& options)
{
  store::MotionModel model;
  model.title = "Sample joint, knee-like (genou \xC3\xA9tal\xC3\xB3n)";
  model.joint = options.has_compartments ? "knee" : "other";
  model.side = "right";
  model.method = options.is_equilibrium ? "equilibrium" : "stability-search";
  model.rotation_centre_mm = {1.0, -2.0, 3.0};
  model.contact_resolution_mm = 0.1;
  model.has_compartments = options.has_compartments;
  for (std::int32_t i = 0; i < options.n_flexion; ++i) model.flexion_deg.push_back(1.0 * i);
  for (std::int32_t j = 0; j < options.n_varus; ++j) model.varus_deg.push_back(-1.0 + j);
  if (options.has_frames) {
    set_frames(model);
    set_roles(model);
  }
  model.reference = sample_body("femur", options.has_visual);
  model.moving = sample_body("tibmen", options.has_visual);
  model.job = {"title = \"Sample joint\"\n",
               "title = \"Sample joint\"\njoint = \"knee\"\n",
               {{"femur.stl", std::string(64, 'a')}, {"tibia.stl", std::string(64, '0')}}};
  if (options.has_compartments)
    model.compartment_of_triangle.assign(model.moving.contact.component.size(), 1);
  if (options.is_equilibrium) model.push = turning_push(options.n_flexion);
  if (options.n_fibres > 0) model.ligaments = sample_ligaments(options);
  model = store::with_pending_cells(model);
  for (Eigen::Index i = 0; i < model.tx_mm.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.tx_mm.cols(); ++j) {
      const bool fails = options.has_failed_cell && i == 1 && j == 2;
      if (fails) {
        model.status(i, j) = static_cast<std::int8_t>(StepStatus::no_clearance);
      } else {
        fill_cell(model, i, j);
      }
    }
  }
  model.contacts = sample_contacts(model);
  if (model.equilibrium) fill_equilibrium(model);
  if (model.coordinates) fill_coordinates(model);
  if (model.ligaments) fill_fibre_states(model);
  if (model.has_compartments) model.contact_paths = store::contact_paths_of(model);
  if (!model.frames) model.smoothed = {sample_smoothed(model)};
  return model;
}

}  // namespace vrda::test
