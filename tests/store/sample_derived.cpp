// Sample models with derived data, and an index.

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "store/sample_model.hpp"

namespace vrda::test {
namespace {

struct Row {
  std::size_t i = 0;
  std::size_t cell = 0;  ///< of the first column
};

void put_numbers(store::ZeroVarus& motion, const store::MotionModel& model, const Row& row)
{
  motion.tx_mm[row.i] = model.tx_mm.data()[row.cell];
  motion.ty_mm[row.i] = model.ty_mm.data()[row.cell];
  motion.tz_mm[row.i] = model.tz_mm.data()[row.cell];
  motion.theta_deg[row.i] = model.theta_deg.data()[row.cell];
  std::copy_n(&model.X_reference_moving[16 * row.cell], 16, &motion.X_reference_moving[16 * row.i]);
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    motion.clinical[k][row.i] = model.clinical[k].data()[row.cell];
  if (!model.has_compartments) return;
  // The lateral compartment is not in contact and remains NaN.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    motion.centres[0].reference_mm[3 * row.i + axis] = 1.0 + static_cast<double>(axis);
    motion.centres[0].moving_mm[3 * row.i + axis] = -2.0 * static_cast<double>(axis);
  }
}

void put_varus(store::ZeroVarus& motion, const store::MotionModel& model, const Row& row)
{
  const double varus_deg = model.varus_solved_deg.data()[row.cell];
  motion.varus_deg[row.i] = varus_deg;
  store::ZeroVarusSource source = store::ZeroVarusSource::free;
  if (model.varus_deg.size() > 1)
    source = row.i % 2 == 0 ? store::ZeroVarusSource::both_touch : store::ZeroVarusSource::interpolated;
  motion.source[row.i] = static_cast<std::int8_t>(source);
  if (source != store::ZeroVarusSource::both_touch) return;
  motion.varus_first_deg[row.i] = varus_deg - 0.5;
  motion.varus_last_deg[row.i] = varus_deg + 0.5;
}

void put_interval(store::ZeroVarus& motion, std::size_t i, bool has_compartments)
{
  const auto at = [](std::vector<double>& values, std::size_t row, std::initializer_list<double> numbers) {
    std::copy(numbers.begin(), numbers.end(), &values[numbers.size() * row]);
  };
  const double x = static_cast<double>(i);
  motion.helical_rotation_deg[i] = 0.01 * x;
  if (has_compartments) {
    motion.rolling[0].rolling_mm[i] = 0.2;
    motion.rolling[0].sliding_mm[i] = -0.1 * x;
  }
  if (i == 0) return;  // rotation too small for an axis
  motion.helical_translation_mm[i] = 0.003;
  at(motion.helical_direction, i, {0.0, 0.6, 0.8});
  at(motion.helical_point_mm, i, {1.0, 2.0, x});
  at(motion.instant_centre_mm, i, {4.0, -x});
}

store::ZeroVarus empty_motion(std::size_t n, bool has_compartments)
{
  store::ZeroVarus motion;
  motion.source.assign(n, static_cast<std::int8_t>(store::ZeroVarusSource::none));
  motion.is_cut_off.assign(n, 0);
  motion.resize(n);
  for (std::vector<double>* values : {&motion.varus_first_deg, &motion.varus_last_deg})
    values->assign(n, nan);
  motion.clinical.fill(std::vector<double>(n, nan));
  motion.X_reference_moving.assign(16 * n, nan);
  motion.helical_rotation_deg.assign(n - 1, nan);
  motion.helical_translation_mm.assign(n - 1, nan);
  motion.helical_direction.assign(3 * (n - 1), nan);
  motion.helical_point_mm.assign(3 * (n - 1), nan);
  motion.instant_centre_mm.assign(2 * (n - 1), nan);
  if (!has_compartments) return motion;
  for (std::vector<double>* values : {&motion.centres[0].reference_mm, &motion.centres[0].moving_mm,
                                      &motion.centres[1].reference_mm, &motion.centres[1].moving_mm}) {
    values->assign(3 * n, nan);
  }
  for (std::vector<double>* values : {&motion.rolling[0].rolling_mm, &motion.rolling[0].sliding_mm,
                                      &motion.rolling[1].rolling_mm, &motion.rolling[1].sliding_mm}) {
    values->assign(n - 1, nan);
  }
  return motion;
}

store::ZeroVarus sample_zero_varus(const store::MotionModel& model)
{
  const std::size_t n = model.flexion_deg.size(), n_varus = model.varus_deg.size();
  store::ZeroVarus motion = empty_motion(n, model.has_compartments);
  motion.set = "degree_1";
  for (std::size_t i = 0; i < n; ++i) {
    const Row row{i, i * n_varus};
    if (model.status.data()[row.cell] != status_stable) continue;
    put_varus(motion, model, row);
    put_numbers(motion, model, row);
    const bool has_pose_before =
        i > 0 && motion.source[i - 1] != static_cast<std::int8_t>(store::ZeroVarusSource::none);
    if (has_pose_before) put_interval(motion, i - 1, model.has_compartments);
  }
  return motion;
}

/// Two cells per cell of the model; cycles through all states.
store::AuditSet sample_audit(const std::string& name, const store::MotionModel& model)
{
  store::AuditSet audit;
  audit.name = name;
  audit.refine = 2;
  for (std::size_t i = 0; i + 1 < 2 * model.flexion_deg.size(); ++i)
    audit.flexion_deg.push_back(model.flexion_deg[0] + 0.5 * static_cast<double>(i));
  audit.varus_deg = {0.0};
  if (name != "zero_varus" && model.varus_deg.size() > 1) audit.varus_deg = {-1.0, -0.5, 0.0};
  const auto n_flexion = static_cast<Eigen::Index>(audit.flexion_deg.size());
  const auto n_varus = static_cast<Eigen::Index>(audit.varus_deg.size());
  audit.state = store::GridB::Zero(n_flexion, n_varus);
  audit.gap_mm = store::GridD::Constant(n_flexion, n_varus, nan);
  audit.penetration_mm = store::GridD::Zero(n_flexion, n_varus);
  if (model.has_compartments) audit.compartment_gap_mm[0] = audit.compartment_gap_mm[1] = audit.gap_mm;
  for (Eigen::Index k = 0; k < audit.state.size(); ++k) {
    const auto state = static_cast<store::AuditState>(k % 4 - 1);
    const double level = 0.25 * static_cast<double>(k - k % 4);
    audit.state.data()[k] = static_cast<std::int8_t>(state);
    if (state == store::AuditState::no_pose) audit.penetration_mm.data()[k] = nan;
    if (state == store::AuditState::free) audit.gap_mm.data()[k] = 0.125 * level;
    if (state == store::AuditState::overlapping) audit.penetration_mm.data()[k] = 0.25 * level;
    if (!model.has_compartments || state == store::AuditState::no_pose) continue;
    audit.compartment_gap_mm[0].data()[k] = 0.125 * level;
    audit.compartment_gap_mm[1].data()[k] = state == store::AuditState::overlapping ? -0.25 * level : nan;
  }
  return audit;
}

/// Two flexions per flexion of the model; cycles through all states.
store::TwoSided sample_two_sided(const store::MotionModel& model)
{
  store::TwoSided motion;
  motion.degree = 3;
  for (std::size_t i = 0; i + 1 < 2 * model.flexion_deg.size(); ++i) {
    const double x = static_cast<double>(i);
    const auto contact = static_cast<store::TwoSidedContact>(static_cast<int>((i + 1) % 4) - 1);
    const double value = contact == store::TwoSidedContact::no_pose ? nan : 1.0;
    motion.flexion_deg.push_back(model.flexion_deg[0] + 0.5 * x);
    motion.contact.push_back(store::code_of(contact));
    motion.varus_deg.push_back(0.25 * x * value);
    motion.tx_mm.push_back(1.0 * value);
    motion.ty_mm.push_back(-0.125 * x * value);
    motion.tz_mm.push_back(0.5 * value);
    motion.theta_deg.push_back(2.0 * x * value);
    motion.gap_mm[0].push_back(contact == store::TwoSidedContact::lateral ? 0.5 : 0.0 * value);
    motion.gap_mm[1].push_back(contact == store::TwoSidedContact::medial ? 0.25 : 0.0 * value);
  }
  return motion;
}

// Three samples of two draws; the second one fails at the first flexion.
store::UncertainMotion sample_uncertainty(const store::MotionModel& model)
{
  const std::size_t n_samples = 3, n_flexion = model.flexion_deg.size();
  store::UncertainMotion motion;
  motion.sequence = "sobol";
  motion.seed = 7;
  motion.draw = {"stiffness ACLam", "reference_strain MCL"};
  motion.value = {0.75, 0.01, 1.0, -0.02, 1.5, 0.0};
  motion.quantity.assign(store::uncertain_quantities.begin(), store::uncertain_quantities.end());
  motion.probability.assign(store::band_probabilities.begin(), store::band_probabilities.end());
  motion.n_solved.assign(n_flexion, 3);
  motion.n_solved[0] = 2;
  for (std::size_t at = 0; at < n_samples * n_flexion; ++at) {
    const bool is_solved = at != n_flexion;
    const double value = is_solved ? 0.5 * static_cast<double>(at) : nan;
    motion.status.push_back(is_solved ? 0 : 3);
    for (const double k : {1.0, 2.0, 3.0}) {
      motion.rotation_deg.push_back(k * value);
      motion.translation_mm.push_back(-k * value);
      motion.contact_force_n.push_back(k < 3.0 ? k * value : nan);
    }
  }
  for (std::size_t at = 0; at < store::band_probabilities.size() * n_flexion * 3; ++at) {
    motion.rotation_band_deg.push_back(-0.25 * static_cast<double>(at));
    motion.translation_band_mm.push_back(0.125 * static_cast<double>(at));
    motion.contact_force_band_n.push_back(at % 3 == 2 ? nan : static_cast<double>(at));
  }
  motion.quantile_sample = {2, 0, 1, 0, 2};
  for (std::size_t at = 0; at < store::band_probabilities.size() * n_flexion; ++at) {
    const double value = at == 2 * n_flexion ? nan : static_cast<double>(at);
    motion.quantile_status.push_back(at == 2 * n_flexion ? 3 : 0);
    for (std::vector<double>* column :
         {&motion.tx_mm, &motion.ty_mm, &motion.tz_mm, &motion.theta_deg, &motion.varus_deg})
      column->push_back(0.25 * value);
  }
  const std::size_t n_fibres = model.ligaments ? model.ligaments->name.size() : 0;
  motion.tension_band_n.assign(store::band_probabilities.size() * n_flexion * n_fibres, 12.5);
  const std::size_t n_shares = n_flexion * store::uncertain_quantities.size() * motion.draw.size();
  motion.rank_correlation.assign(n_shares, -0.5);
  motion.first_order.assign(n_shares, 0.25);
  motion.first_order_low.assign(n_shares, 0.125);
  motion.first_order_high.assign(n_shares, 0.5);
  motion.first_order.front() = nan;
  return motion;
}

// Two terms; the spine without the prior fails at the first flexion.
store::PriorRows sample_prior(const store::MotionModel& model)
{
  store::PriorRows prior;
  for (const PriorCoordinate coordinate : {PriorCoordinate::internal, PriorCoordinate::centre_anterior}) {
    store::PriorTermRows& term = prior.terms.emplace_back();
    term.coordinate = static_cast<std::int8_t>(coordinate);
    term.shape = "walker-1988";
    term.level = -1.5;
    term.is_level_free = true;
  }
  store::BonesAlone& alone = prior.bones_alone;
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    const double value = 0.25 * static_cast<double>(i);
    for (store::PriorTermRows& term : prior.terms) {
      term.curve.push_back(value);
      term.value.push_back(i == 1 ? nan : 2.0 * value);
      term.stiffness.push_back(4.0 + value);
      term.force.push_back(i == 1 ? nan : -value);
      term.energy_nmm.push_back(i == 1 ? nan : value);
    }
    prior.own_stiffness.push_back(i == 2 ? nan : 3000.0);
    for (std::vector<double>* share : {&prior.rotation_share, &prior.moment_share, &prior.energy_share})
      share->push_back(i == 1 ? nan : 0.75);
    alone.status.push_back(i == 0 ? 3 : 0);
    alone.n_optima.push_back(i == 0 ? 0 : 2);
    for (std::vector<double>* column :
         {&alone.tx_mm, &alone.ty_mm, &alone.tz_mm, &alone.theta_deg, &alone.varus_deg, &alone.energy_nmm})
      column->push_back(i == 0 ? nan : value);
  }
  return prior;
}

void add_varus_surface(store::SmoothedSet& set)
{
  store::SmoothedSurface surface = set.surfaces.front();
  surface.name = "varus";
  surface.leave_one_out_rms = 0.5;
  set.surfaces.push_back(surface);
}

}  // namespace

store::MotionModel with_derived(store::MotionModel model)
{
  for (store::SmoothedSet& set : model.smoothed) {
    set.is_robust = true;
    set.recontact_mm = store::GridD::Constant(model.tx_mm.rows(), model.tx_mm.cols(), 0.02);
    (*set.recontact_mm)(0, 0) = nan;
    if (model.varus_deg.size() == 1) add_varus_surface(set);
  }
  model.zero_varus = sample_zero_varus(model);
  if (model.has_compartments) model.two_sided = sample_two_sided(model);
  model.default_motion = store::DefaultMotion{"raw", "degree_1 is rough"};
  if (model.equilibrium) model.uncertainty = sample_uncertainty(model);
  if (model.equilibrium) model.prior = sample_prior(model);
  for (const char* name : {"raw", "degree_1", "zero_varus", "degree_1_recontacted"})
    model.audits = store::with_audit(model.audits, sample_audit(name, model));
  return model;
}

namespace {

// Two loads and two lines, of three and two points, at each flexion.
void add_loads(store::MotionModel& model)
{
  store::LoadRows& loads = model.push.loads.emplace();
  loads.name = {"drawer", "weight"};
  loads.frame = {2, 0};
  loads.point_mm = Points(2, 3);
  loads.point_mm << 1, -20, 3, 0, -40, 0;
  store::LineRows& lines = model.push.lines.emplace();
  lines.name = {"quadriceps", "hamstrings"};
  lines.point_mm = Points(5, 3);
  lines.point_mm << 5, 60, 0, 10, 20, 1, 15, -30, 2, -30, 50, 0, -20, -40, 0;
  lines.point_line = {0, 0, 0, 1, 1};
  lines.point_body = {0, 0, 1, 0, 1};
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    const double x = static_cast<double>(i);
    loads.force_n.insert(loads.force_n.end(), {10.0 + x, 0.5, 0, 0, -x, 1});
    loads.moment_nmm.insert(loads.moment_nmm.end(), {0, 0, 0, 100, x, -20});
    lines.tension_n.insert(lines.tension_n.end(), {30.0 + x, 5.0});
  }
}

}  // namespace

// A bead that follows wherever the joint has a pose, with a line and a fibre and a force in every cell.
void add_follower(store::MotionModel& model)
{
  store::FollowerRows& bead = model.followers.emplace_back();
  bead.name = "bead";
  bead.touches = {0, 1};
  bead.centre_mm = {40.0, -3.0, 2.0};
  bead.push_n = 1.5;
  bead.has_reaction = true;
  bead.body = model.moving;
  bead.body.name = "bead";
  store::LigamentRows& fibres = bead.ligaments.emplace(*model.ligaments);
  const std::size_t n_fibres = fibres.name.size();
  fibres.from_body.assign(n_fibres, 0);
  fibres.to_body.assign(n_fibres, 2);
  fibres.from_body[1] = 1;
  fibres.constant_tension_n.assign(n_fibres, 0.0);
  fibres.constant_tension_n[0] = 12.5;
  fibres.stiffness_n[0] = 0.0;
  bead.status = model.status;
  bead.iterations = model.iterations;
  bead.queries = model.queries;
  const store::GridD none = store::GridD::Constant(model.tx_mm.rows(), model.tx_mm.cols(), nan);
  std::vector<store::GridD*> grids;
  for (store::GridD& grid : bead.coordinates) grids.push_back(&grid);
  grids.insert(grids.end(),
               {&bead.energy_nmm, &bead.balance_residual_n, &bead.complementarity_mm, &bead.worst_gap_mm});
  for (store::GridD* grid : grids) *grid = none;
  bead.plausibility = model.plausibility;
  bead.X_of_follower = model.X_reference_moving;
  store::UncertainFollower& uncertain = model.uncertainty->followers.emplace_back();
  static_cast<store::UncertainPose&>(uncertain) = *model.uncertainty;
  uncertain.name = bead.name;
  const std::size_t n_shares =
      model.flexion_deg.size() * n_joint_coordinates * model.uncertainty->draw.size();
  for (std::vector<double>* table : {&uncertain.rank_correlation, &uncertain.first_order,
                                     &uncertain.first_order_low, &uncertain.first_order_high})
    table->resize(n_shares);
  std::vector<double> points;
  bead.forces.row_start = {0};
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    if (model.status.data()[cell] == status_stable) {
      for (std::size_t k = 0; k < grids.size(); ++k)
        grids[k]->data()[cell] = 0.25 * static_cast<double>(k) + 0.125 * static_cast<double>(cell);
      bead.forces.along_delta_n.push_back(2.0 + static_cast<double>(cell));
      bead.forces.triangle_reference.push_back(1);
      bead.forces.triangle_moving.push_back(2);
      bead.forces.compartment.push_back(0);
    }
    bead.forces.row_start.push_back(static_cast<std::int64_t>(bead.forces.along_delta_n.size()));
  }
  bead.touches_drawn = {0, 1};
  store::SmoothedSet& set = model.smoothed.front();
  store::SmoothedFollower& smooth = set.followers.emplace_back();
  smooth.name = bead.name;
  for (const char* name : store::follower_surface_names) {
    smooth.surfaces.push_back(set.surfaces.front());
    smooth.surfaces.back().name = name;
  }
  smooth.recontact_mm = set.recontact_mm;
  store::FollowerAudit& own = model.audits.front().followers.emplace_back();
  own.name = bead.name;
  own.state = model.audits.front().state;
  own.gap_mm = model.audits.front().gap_mm;
  own.penetration_mm = model.audits.front().penetration_mm;
  const auto n = static_cast<Eigen::Index>(bead.forces.along_delta_n.size());
  bead.forces.point_world_mm = Eigen::RowVector3d(1.0, 2.0, 3.0).replicate(n, 1);
  bead.forces.normal_world = Eigen::RowVector3d(0.6, 0.0, 0.8).replicate(n, 1);
}

store::MotionModel whole_model()
{
  store::MotionModel model = with_derived(sample_model({4, 3, true, true, true, true, 5, 2}));
  add_loads(model);
  for (Mesh* mesh : {&model.reference.contact.mesh, &model.moving.contact.mesh}) {
    mesh->offset_mm.assign(static_cast<std::size_t>(mesh->triangles.rows()), 0.5);
    mesh->overlap_mm.assign(static_cast<std::size_t>(mesh->triangles.rows()), 0.25);
  }
  add_follower(model);
  model.job.warnings = {"side: the first warning", "a second one, in °"};
  Scaling& scaling = model.job.scaling.emplace();
  // 3 and 4 mm of model, 3.3 and 4 mm of subject.
  scaling.factor.setConstant(1.036);
  scaling.keeps_steps = true;
  scaling.landmark = {"a", "b"};
  scaling.model_mm = {3, 4};
  scaling.subject_mm = {3.3, 4};
  scaling.residual_mm = {3.3 - 1.036 * 3, 4 - 1.036 * 4};
  scaling.residual_rms_mm = std::sqrt(0.0576 / 2);
  scaling.standard_error = 0.048;
  return model;
}

// Each status in turn; the first frame is the measured one.
store::RepairedFrames sample_repair(const store::MotionModel& model)
{
  const std::size_t n = model.flexion_deg.size();
  store::RepairedFrames repair;
  repair.is_converged = true;
  repair.X_measured = model.X_reference_moving;
  repair.rotation_shift.assign(3 * n, 0.0);
  repair.translation_shift.assign(3 * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    repair.status.push_back(static_cast<std::int8_t>(i % 4));
    repair.rotation_shift[3 * i] = 0.3 * static_cast<double>(i);
    repair.translation_shift[3 * i + 1] = -0.4 * static_cast<double>(i);
    repair.distance.push_back(0.5 * static_cast<double>(i));
    repair.gap_before_mm.push_back(i % 2 == 1 ? nan : 0.25);
    repair.gap_after_mm.push_back(0.125);
    repair.penetration_before_mm.push_back(i % 2 == 1 ? 1.5 : 0.0);
    repair.penetration_after_mm.push_back(0.0);
  }
  repair.noise_deg = {0.5, 1.0, 0.25};
  repair.noise_mm = {0.5, 0.0, 0.75};
  repair.rotation_period = {12.0, 2.0, 30.0};
  repair.translation_period = {8.0, 2.0, 10.0};
  repair.gap_limit_mm = {0.5, nan};
  return repair;
}

store::MotionModel frames_model()
{
  SampleOptions options{6, 1, true, true, false};
  options.has_frames = true;
  store::MotionModel model = sample_model(options);
  store::AuditSet audit = sample_audit("raw", model);
  for (std::size_t i = 0; i < audit.flexion_deg.size(); ++i)
    audit.frame_key.push_back(0.125 * static_cast<double>(i));
  model.audits = store::with_audit(model.audits, audit);
  model.repair = sample_repair(model);
  return model;
}

store::IndexTable sample_index()
{
  using Texts = std::vector<std::string>;
  store::IndexTable table;
  table.title = "Three cases (étude)";
  table.columns.push_back({"case", "", "name of the case", Texts{"a_rest", "a_search", "b_rest"}});
  table.columns.push_back(
      {"status", "", "how far it is", std::vector<std::int8_t>{0, 2, 3}, store::FlagSet::case_status});
  table.columns.push_back({"remark", "", "why", Texts{"", "a \"quoted\", longer\nremark", ""}});
  table.columns.push_back({"gap_mm", "mm", "a length", std::vector<double>{0.125, nan, -1e-5}});
  return table;
}

}  // namespace vrda::test
