// [[follower]] of a job: parsing, and loading of meshes, fibres and wraps.
#include <algorithm>
#include <numeric>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/component_loader.hpp"
#include "job/job_parts.hpp"

namespace vrda::job {

std::size_t follower_named(const core::Document& document, const std::string& key, const std::string& name)
{
  std::vector<std::string> names;
  for (const core::DocumentValue& value : core::list_or_empty(document.root, "follower"))
    names.push_back(core::text_at(value, "name"));
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    document.refuse(key, '"' + name + '"',
                    names.empty()
                        ? "a job with [[follower]]"
                        : "a [[follower]] of the job; the nearest is \"" + nearest_word(name, names) + '"');
  return static_cast<std::size_t>(found - names.begin());
}

std::vector<double> given_strains(const std::vector<FibreJob>& fibres)
{
  std::vector<double> strains;
  for (const FibreJob& fibre : fibres) strains.push_back(fibre.reference_strain.value_or(nan));
  return strains;
}

BodyIndex attached_body(const Job& job, const std::string& name, const std::string& key)
{
  if (const std::optional<BodyIndex> found = body_named(name, names_before(job, job.followers.size())))
    return *found;
  job.document.refuse(key, name.empty() ? "nothing" : '"' + name + '"',
                      "\"reference\", \"moving\" or a follower");
}

BodyNames names_before(const Job& job, std::size_t row)
{
  BodyNames names{job.reference.name, job.moving.name};
  for (std::size_t k = 0; k < row; ++k) names.push_back(job.followers[k].body.name);
  return names;
}

namespace {

constexpr double shortest_direction = 1e-6;

std::string listed(const BodyNames& names)
{
  return std::accumulate(
      names.begin() + 1, names.end(), '"' + names.front() + '"',
      [](const std::string& sum, const std::string& name) { return sum + ", \"" + name + '"'; });
}

BodyIndex object_before(const Job& job, std::size_t row, const std::string& name, const std::string& key)
{
  const BodyNames names = names_before(job, row);
  const std::optional<BodyIndex> found = body_named(name, names);
  if (!found) job.document.refuse(key, '"' + name + '"', "an object before it: " + listed(names));
  return *found;
}

Eigen::Vector3d direction_at(const Job& job, const core::DocumentValue& value, const std::string& name,
                             const std::string& key)
{
  const Eigen::Vector3d direction = core::vector3_at(value, name);
  if (!(direction.norm() > shortest_direction))
    job.document.refuse(key + "." + name, core::numbers_text(direction), "a direction that is not zero");
  return direction.normalized();
}

void read_scan(const core::DocumentValue& value, const char* name,
               std::array<double, n_joint_coordinates>& coordinates)
{
  const std::vector<double> numbers = core::numbers_at(value, std::string("scan.") + name);
  std::copy(numbers.begin(), numbers.end(), coordinates.begin());
}

FollowerJob follower_of(const Job& job, const core::DocumentValue& value, BodyJob body,
                        const std::string& key)
{
  FollowerJob follower;
  follower.key = key;
  follower.body = std::move(body);
  follower.of = core::text_at(value, "of");
  follower.touches = core::texts_at(value, "touches");
  if (core::find_at(value, "centre_mm") != nullptr)
    follower.centre_native_mm = core::vector3_at(value, "centre_mm");
  follower.delta = direction_at(job, value, "push.delta", key);
  follower.push_n = core::number_at(value, "push.force_n");
  follower.fibres_file = core::text_or_empty(value, "fibres");
  follower.wraps_file = core::text_or_empty(value, "wraps");
  if (const core::DocumentValue* generate = core::find_at(value, "generate"))
    follower.generate = generate_of(*generate);
  if (follower.generate && !follower.wraps_file.empty())
    job.document.refuse(key, "both wraps and generate", "one of them");
  if (follower.fibres_file.empty() && !follower.generate)
    job.document.refuse(key, "neither fibres nor generate",
                        "fibres = \"fibres.csv\", or generate = { shape = \"knee\" }");
  follower.touches_visual = core::flag_at(value, "touches_visual");
  follower.transition_strain = core::number_at(value, "transition_strain");
  follower.tension_n = core::number_at(value, "tension_n");
  for (const core::DocumentValue& item : core::list_or_empty(value, "direction")) {
    const std::string at = key + ".direction." + std::to_string(follower.directions.size());
    follower.directions.push_back(
        {core::text_at(item, "bundle"), core::number_at(item, "stiffness_nmm_per_rad"),
         direction_at(job, item, "axis", at),
         item.contains("rest_deg") ? rad_from_deg(core::number_at(item, "rest_deg")) : 0.0});
  }
  read_scan(value, "joint", follower.scan_joint);
  read_scan(value, "follower", follower.scan_follower);
  follower.has_reaction = core::flag_at(value, "reaction");
  if (follower.has_reaction && job.method != SolverMethod::equilibrium)
    job.document.refuse(key + ".reaction", "true with solver.method = \"stability-search\"",
                        "false, or the method \"equilibrium\"");
  follower.n_restarts = static_cast<int>(core::integer_at(value, "restarts"));
  return follower;
}

JointCoordinates coordinates_of(const std::array<double, n_joint_coordinates>& numbers)
{
  JointCoordinates q;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    q(static_cast<Eigen::Index>(k)) = from_file(numbers[k], k);
  return q;
}

// Of stored vertices, by the six coordinates of the joint.
Pose joint_pose_at(const SolverFrame& frame, const JointCoordinates& q)
{
  SolverFrame proximal = frame;
  proximal.delta = Eigen::Vector3d::UnitY();
  return X_reference_moving(proximal, {q(0), q(1)}, {floating_translation_mm(q), q(2)});
}

// Of the bodies before the follower.
model::BodyPoses scan_poses(const Follower& follower, const std::vector<Follower>& followers,
                            std::size_t n_before)
{
  model::BodyPoses scan{Pose::Identity(), follower.X_reference_moving_scan};
  for (std::size_t k = 0; k < n_before; ++k)
    scan.push_back(scan.at(model::row_of(followers[k].of)) * followers[k].X_of_scan);
  return scan;
}

struct FollowerLoader {
  const Job& job;
  const std::string& data_directory;
  std::size_t row;
  const Case& loaded;
  const std::vector<Follower>& before;

  const FollowerJob& own() const { return job.followers[row]; }
  BodyIndex index() const { return model::follower_index(row); }

  // Of points of files; generated ones are canonical.
  AxisMap map_of(BodyIndex body, bool is_generated) const
  {
    if (is_generated) return {};
    if (body == BodyIndex::reference) return body_map(job, job.reference);
    if (body == BodyIndex::moving) return body_map(job, job.moving);
    return body_map(job, job.followers.at(model::row_of(body) - 2).body);
  }

  BodyIndex end_of(const FibreJob& fibre, const std::string& name, BodyIndex otherwise, const char* key) const
  {
    if (name.empty()) return otherwise;
    const BodyNames names = names_before(job, row + 1);
    if (const std::optional<BodyIndex> found = body_named(name, names)) return *found;
    throw InputError({fibre.source, fibre_key(fibre, key), '"' + name + '"', "one of " + listed(names)});
  }

  void add_fibre(const FibreJob& fibre, BodyIndex of, LoadedLigaments& out) const
  {
    model::Fibre made;
    made.name = fibre.name;
    made.bundle = fibre.bundle.empty() ? default_bundle(fibre.name) : fibre.bundle;
    made.from = end_of(fibre, fibre.from_body, of, "from_body");
    made.to = end_of(fibre, fibre.to_body, index(), "to_body");
    if ((made.from == index()) == (made.to == index()))
      throw InputError({fibre.source, fibre_key(fibre, "to_body"),
                        "a fibre without one end on " + own().body.name,
                        "one end on it, the other on an object before it"});
    const bool is_generated = own().fibres_file.empty();
    made.reference_mm = map_of(made.from, is_generated).X_canonical_native * fibre.reference_native_mm;
    made.moving_mm = map_of(made.to, is_generated).X_canonical_native * fibre.moving_native_mm;
    made.stiffness_n = fibre.stiffness_n;
    made.slack_length_mm = fibre.slack_length_mm.value_or(1.0);
    made.tension_n = fibre.tension_share.value_or(0.0);
    made.wrap = wrap_named(fibre, out.ligaments.wraps, own().wraps_file, own().key + ".wraps");
    const auto is_end = [&](BodyIndex body) { return body == made.from || body == made.to; };
    if (made.wrap >= 0 && !is_end(out.ligaments.wraps[static_cast<std::size_t>(made.wrap)].body))
      throw InputError({fibre.source, fibre_key(fibre, "wrap"), "a wrap of a third object",
                        "one that is fixed to an object of the fibre's ends"});
    // The follower's end is the second.
    if (made.from == index()) {
      std::swap(made.from, made.to);
      std::swap(made.reference_mm, made.moving_mm);
    }
    out.ligaments.fibres.push_back(std::move(made));
  }

  // Of generated fibres, which are canonical, as if they were files.
  std::pair<InputFile, InputFile> generated(std::vector<LoadedInput>& inputs) const
  {
    const GenerateJob& generate = *own().generate;
    const std::string key = own().key + ".generate", request = shape_request_text(generate);
    return with_job_key(job, key, generate, [&] {
      const geometry::FollowerTexts texts =
          geometry::follower_texts({generate.shape, generate.numbers, generate.words});
      inputs.push_back({request + " follower", sha256_of(texts.fibres + texts.wraps)});
      return std::pair<InputFile, InputFile>{{request + " fibres", texts.fibres},
                                             {request + " wraps", texts.wraps}};
    });
  }

  // A table replaces generated fibres, not their wraps.
  std::pair<InputFile, InputFile> files(std::vector<LoadedInput>& inputs) const
  {
    std::pair<InputFile, InputFile> read;
    if (own().generate) read = generated(inputs);
    const auto read_file = [&](InputFile& file, const char* name, const std::string& path, const char* kind) {
      if (path.empty()) return;
      file = input_file(job, data_directory, {own().key + name, path, kind});
      inputs.push_back({path, sha256_of(file.bytes)});
    };
    read_file(read.first, ".fibres", own().fibres_file, "a CSV file");
    read_file(read.second, ".wraps", own().wraps_file, "a JSON file");
    return read;
  }

  LoadedLigaments ligaments(BodyIndex of, std::vector<LoadedInput>& inputs) const
  {
    LoadedLigaments out;
    out.ligaments.transition_strain = own().transition_strain;
    const auto [fibres, wraps] = files(inputs);
    if (!wraps.bytes.empty()) {
      out.ligaments.wraps = read_wraps(wraps.path, wraps.bytes, names_before(job, row + 1));
      for (model::Wrap& wrap : out.ligaments.wraps)
        wrap.X_body_wrap = canonical(wrap.X_body_wrap, map_of(wrap.body, own().wraps_file.empty()));
    }
    out.jobs = read_ligament_table(fibres.path, fibres.bytes);
    check_names(out.jobs);
    for (const FibreJob& fibre : out.jobs) add_fibre(fibre, of, out);
    share_tension(out);
    return out;
  }

  // Shares become the tensions of the lines.
  void share_tension(LoadedLigaments& all) const
  {
    std::vector<model::Fibre>& fibres = all.ligaments.fibres;
    double sum = 0.0;
    for (const model::Fibre& fibre : fibres) sum += fibre.tension_n;
    for (model::Fibre& fibre : fibres) {
      if (sum > 0.0) fibre.tension_n *= own().tension_n / sum;
    }
    // Without tension a line does nothing.
    const auto is_idle = [](const model::Fibre& f) { return !(f.stiffness_n > 0.0) && !(f.tension_n > 0.0); };
    std::size_t k = 0;
    std::erase_if(all.jobs, [&](const FibreJob&) { return is_idle(fibres[k++]); });
    std::erase_if(fibres, is_idle);
  }

  // Slack lengths where the scan found the objects.
  void set_slack_lengths_at_scan(LoadedLigaments& fibres, const Follower& follower) const
  {
    const model::BodyPoses scan = scan_poses(follower, before, before.size());
    for (std::size_t k = 0; k < fibres.jobs.size(); ++k) {
      if (!fibres.jobs[k].reference_strain) continue;
      LoadedLigaments one;
      one.ligaments = ligaments_between({{fibres.ligaments.fibres[k]}, fibres.ligaments.wraps}, follower.of,
                                        index(), scan);
      one.jobs = {fibres.jobs[k]};
      set_slack_lengths(one, follower.X_of_scan);
      fibres.ligaments.fibres[k].slack_length_mm = one.ligaments.fibres.front().slack_length_mm;
    }
  }

  void check_directions(const Follower& follower) const
  {
    std::vector<std::string> bundles;
    for (const model::Fibre& fibre : follower.ligaments.fibres) bundles.push_back(fibre.bundle);
    for (std::size_t k = 0; k < follower.directions.size(); ++k) {
      const std::string& name = follower.directions[k].bundle;
      if (std::find(bundles.begin(), bundles.end(), name) != bundles.end()) continue;
      job.document.refuse(own().key + ".direction." + std::to_string(k) + ".bundle", '"' + name + '"',
                          "a bundle of its fibres; the nearest is \"" + nearest_word(name, bundles) + '"');
    }
  }

  Follower follower(ComponentLoader& source, Case& all) const
  {
    Follower out;
    out.name = own().body.name;
    out.of = object_before(job, row, own().of, own().key + ".of");
    for (std::size_t k = 0; k < own().touches.size(); ++k)
      out.touches.push_back(
          object_before(job, row, own().touches[k], own().key + ".touches." + std::to_string(k)));
    if (out.touches.empty()) out.touches = {out.of};
    std::vector<std::vector<Eigen::Index>> small_shells;
    out.body = loaded_body(job, own().body, source, all, small_shells);
    const Box box = box_of(out.body);
    out.centre_mm = own().centre_native_mm ? map_of(index(), own().generate.has_value()).X_canonical_native *
                                                 *own().centre_native_mm
                                           : Eigen::Vector3d(0.5 * (box.min_mm + box.max_mm));
    out.delta = own().delta;
    out.push_n = own().push_n;
    out.touches_visual = own().touches_visual;
    out.directions = own().directions;
    out.has_reaction = own().has_reaction;
    out.n_restarts = own().n_restarts;
    out.X_of_scan = follower_pose(coordinates_of(own().scan_follower), job.side, out.centre_mm);
    out.X_reference_moving_scan = joint_pose_at(all.frame, coordinates_of(own().scan_joint));
    LoadedLigaments fibres = ligaments(out.of, all.inputs);
    std::vector<const Body*> bodies{&all.reference, &all.moving};
    for (const Follower& other : before) bodies.push_back(&other.body);
    bodies.push_back(&out.body);
    check_attachments(fibres, bodies);
    set_slack_lengths_at_scan(fibres, out);
    out.reference_strain = given_strains(fibres.jobs);
    out.ligaments = std::move(fibres.ligaments);
    check_directions(out);
    return out;
  }
};

}  // namespace

std::vector<FollowerJob> followers_of(
    const Job& job, const std::function<BodyJob(const std::string& key, const std::string& name)>& bodies)
{
  std::vector<FollowerJob> followers;
  BodyNames names{job.reference.name, job.moving.name, "reference", "moving", "world"};
  for (const core::DocumentValue& value : core::list_or_empty(job.document.root, "follower")) {
    const std::string key = "follower." + std::to_string(followers.size());
    const std::string& name = core::text_at(value, "name");
    if (std::find(names.begin(), names.end(), name) != names.end())
      job.document.refuse(key + ".name", '"' + name + "\" a second time", "a name that no other object has");
    names.push_back(name);
    FollowerJob follower = follower_of(job, value, bodies(key, name), key);
    if (follower.body.frame && (follower.body.frame->is_origin_auto || follower.body.frame->is_align_auto))
      job.document.refuse(key + ".frame", "\"auto\"", "numbers, or the frame of the job");
    followers.push_back(std::move(follower));
  }
  return followers;
}

std::vector<double> scan_strains(const std::vector<Follower>& followers, std::size_t row,
                                 const model::Ligaments& ligaments)
{
  const Follower& follower = followers.at(row);
  const model::Ligaments between = ligaments_between(ligaments, follower.of, model::follower_index(row),
                                                     scan_poses(follower, followers, row));
  const model::JointPlacement placement{Eigen::Matrix3d::Identity(), follower.X_of_scan.linear(),
                                        follower.X_of_scan.translation()};
  std::vector<double> strains;
  for (const model::Fibre& fibre : between.fibres)
    strains.push_back(model::fibre_path(fibre, between.wraps, placement).length_mm / fibre.slack_length_mm -
                      1.0);
  return strains;
}

double tension_n(const Follower& follower)
{
  double sum_n = 0.0;
  for (const model::Fibre& fibre : follower.ligaments.fibres) sum_n += fibre.tension_n;
  return sum_n;
}

double load_n(const Follower& follower, InputLoad load)
{
  return load == InputLoad::push ? follower.push_n : tension_n(follower);
}

void set_load(Follower& follower, InputLoad load, double force_n)
{
  if (load == InputLoad::push) {
    follower.push_n = force_n;
    return;
  }
  const double before_n = tension_n(follower);
  if (!(before_n > 0.0)) return;
  const double factor = force_n / before_n;
  for (model::Fibre& fibre : follower.ligaments.fibres) fibre.tension_n *= factor;
}

std::vector<Follower> load_followers(const Job& job, const std::string& data_directory,
                                     ComponentLoader& source, Case& loaded)
{
  std::vector<Follower> followers;
  for (std::size_t row = 0; row < job.followers.size(); ++row)
    followers.push_back(FollowerLoader{job, data_directory, row, loaded, followers}.follower(source, loaded));
  return followers;
}

}  // namespace vrda::job
