#include "app/scenes.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>
#include <thread>

#include "job/job.hpp"
#include "support/meshes.hpp"

namespace vrda::test {
namespace {

std::string stl_bytes(const Mesh& mesh)
{
  std::string bytes(80, ' ');
  const auto n = static_cast<std::uint32_t>(mesh.triangles.rows());
  bytes.append(reinterpret_cast<const char*>(&n), 4);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<float, 12> numbers{};
    const auto corner = corners(mesh, t);
    for (std::size_t k = 0; k < 9; ++k) {
      numbers[3 + k] = static_cast<float>(corner[k / 3][static_cast<Eigen::Index>(k % 3)]);
    }
    bytes.append(reinterpret_cast<const char*>(numbers.data()), 48);
    bytes.append(2, '\0');
  }
  return bytes;
}

// A closed slab, 20 mm thick, with the given height of its lower face over (x, z).
template <typename Height>
Mesh ceiling(double size_mm, int n, const Height& height)
{
  Mesh under = sheet(size_mm, n);
  Mesh mesh = under;
  mesh.vertices_mm.col(1).setConstant(20.0);
  for (Eigen::Index v = 0; v < under.vertices_mm.rows(); ++v) {
    under.vertices_mm(v, 1) = height(under.vertices_mm(v, 0), under.vertices_mm(v, 2));
  }
  under.triangles.col(1).swap(under.triangles.col(2));
  const auto n_under = static_cast<std::int32_t>(under.vertices_mm.rows());
  append(mesh, under);
  // Walls along the rim, each between a top edge and the edge below.
  std::vector<std::int32_t> rim;
  for (int k = 0; k < n; ++k) rim.push_back(k);
  for (int i = 0; i < n; ++i) rim.push_back(i * (n + 1) + n);
  for (int k = n; k > 0; --k) rim.push_back(n * (n + 1) + k);
  for (int i = n; i > 0; --i) rim.push_back(i * (n + 1));
  const Eigen::Index first = mesh.triangles.rows();
  mesh.triangles.conservativeResize(first + 2 * static_cast<Eigen::Index>(rim.size()), 3);
  for (std::size_t s = 0; s < rim.size(); ++s) {
    const std::int32_t a = rim[s], b = rim[(s + 1) % rim.size()];
    const Eigen::Index row = first + 2 * static_cast<Eigen::Index>(s);
    mesh.triangles.row(row) << b, a, n_under + a;
    mesh.triangles.row(row + 1) << b, n_under + a, n_under + b;
  }
  return mesh;
}

Mesh shifted(const Mesh& mesh, const Eigen::Vector3d& by)
{
  Pose X = Pose::Identity();
  X.translation() = by;
  return transformed(mesh, X);
}

}  // namespace

const char* const laxity_tables = R"(
[laxity]
flexion_deg = [0, 30]
anterior_force_n = 100
load_steps = 2
[[laxity.cut]]
name = "ACL"
bundles = ["ACLam", "ACLpl"]
)";

const char* const fit_tables = R"(
[fit]
noise = { anterior_mm = 0.1 }
[[fit.parameter]]
quantity = "reference_strain"
bundle = "ACLpl"
sd = 0.03
from = -0.1
to = 0.1
[[fit.parameter]]
quantity = "load"
load = "varus_moment"
sd = 100
from = -200
to = 200
)";

const std::string coarse_knee_text = R"(
[reference]
[[reference.component]]
name = "femur"
generate = { shape = "knee", part = "femur", resolution = 0.5 }
[moving]
[[moving.component]]
name = "tibia"
generate = { shape = "knee", part = "tibia", resolution = 0.5 }
[ligaments]
generate = { shape = "knee" }
[grid]
flexion = { from = 0, to = 30, step = 10 }
varus = "free"
[smooth]
degrees = [1]
)";

const std::string prior_and_its_spread = R"(
[[prior]]
coordinate = "internal"
shape = "walker-1988"
stiffness = { at_least = 4126, times_own = 2.2 }
[[prior]]
coordinate = "centre_anterior"
shape = "walker-1988"
stiffness = { at_least = 4 }
[uncertainty]
samples = 12
[[uncertainty.parameter]]
quantity = "prior_shape"
coordinate = "internal"
distribution = "normal"
sd = 5
[[uncertainty.parameter]]
quantity = "prior_level"
coordinate = "internal"
distribution = "normal"
sd = 3
[[uncertainty.parameter]]
quantity = "thickness"
body = "reference"
distribution = "normal"
sd = 0.4
)";

const std::string stiffness_and_strain = R"(
[uncertainty]
samples = 48
[[uncertainty.parameter]]
quantity = "stiffness"
distribution = "lognormal"
sd = 0.3
[[uncertainty.parameter]]
quantity = "reference_strain"
shared_by = "fibre"
correlation = 0.5
distribution = "normal"
sd = 0.01
)";

const std::string uncertain_sesamoid = R"(
[uncertainty]
samples = 10
sequence = "latin-hypercube"
[[uncertainty.parameter]]
quantity = "load"
follower = "bead"
load = "tension"
distribution = "uniform"
from = -8
to = 8
[[uncertainty.parameter]]
quantity = "stiffness"
follower = "bead"
bundle = "tendon"
distribution = "uniform"
from = 0.5
to = 2
[[uncertainty.parameter]]
quantity = "attachment"
follower = "bead"
bundle = "tendon"
body = "tibia"
distribution = "uniform"
to = 2
[[uncertainty.parameter]]
quantity = "direction"
follower = "bead"
bundle = "tendon"
distribution = "normal"
sd = 10
)";

bool runs_full_set()
{
  return std::getenv("VRDA_FAULTS_ALL") != nullptr;
}

Command vrda(std::vector<std::string> words, const std::vector<std::string>& more)
{
  words.insert(words.end(), more.begin(), more.end());
  return {VRDA_PROGRAM, words, {}, {}};
}
Ended run_vrda(const std::vector<std::string>& words, const std::vector<std::string>& more)
{
  return run(vrda(words, more));
}

nlohmann::json json_of(const std::vector<std::string>& words, int exit_code)
{
  const Ended ended = run_vrda(words, {"--json"});
  EXPECT_EQ(ended.exit_code, exit_code) << testing::PrintToString(words) << ended.err;
  return nlohmann::json::parse(ended.out);
}

store::MotionModel solved(const std::filesystem::path& job, const std::vector<std::string>& settings,
                          int exit_code)
{
  const Scratch scratch;
  const std::string file = (scratch.path() / "solved.h5").string();
  std::vector<std::string> words{"run", job.string(), "-o", file, "--quiet"};
  for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
  const Ended ended = run_vrda(words);
  EXPECT_EQ(ended.exit_code, exit_code) << ended.err;
  EXPECT_THAT(store::validate_hdf5(file), testing::IsEmpty());
  return store::read_motion_model(file);
}

std::filesystem::path small_job(const Scratch& scratch)
{
  scratch.write("dish.stl",
                stl_bytes(ceiling(60, 12, [](double x, double z) { return -(x * x + z * z) / 80.0; })));
  scratch.write("ball.stl", stl_bytes(ball(6, 8, 12)));
  return scratch.write("small.toml", R"(title = "Ball in a dish"
joint = "other"
side = "right"
[reference]
name = "dish"
[[reference.component]]
name = "dish"
file = "dish.stl"
material = "bone"
[moving]
name = "ball"
initial = { translation_mm = [3, -40, 2], theta_deg = 0 }
[[moving.component]]
name = "ball"
file = "ball.stl"
material = "bone"
[solver]
method = "stability-search"
[grid]
flexion = { from = 0, to = 4, step = 2 }
varus = { from = -4, to = 4, step = 2 }
[smooth]
degrees = [1]
)");
}

std::filesystem::path small_knee_job(const Scratch& scratch, const std::string& side, const BallEdges& edges)
{
  // Two dents 40 mm apart, the lateral one shallower; below them two balls of different radii.
  const Mesh plate = ceiling(90, 18, [](double x, double z) {
    const double s = z < 0.0 ? z + 20.0 : z - 20.0;
    return -(x * x + s * s) / (z < 0.0 ? 50.0 : 90.0);
  });
  Mesh moving = shifted(ball(8, edges.n_rings, edges.n_sectors), {0, -10, -20});
  append(moving, shifted(ball(7, edges.n_rings, edges.n_sectors), {0, -9, 20}));
  const bool is_left = side == "left";
  const std::string reference_name = "plate_" + side + ".stl", moving_name = "balls_" + side + ".stl";
  scratch.write(reference_name, stl_bytes(is_left ? mirrored_z(plate) : plate));
  scratch.write(moving_name, stl_bytes(is_left ? mirrored_z(moving) : moving));
  return scratch.write(
      "knee_" + side + ".toml", "title = \"Two balls\"\njoint = \"knee\"\nside = \"" + side + R"("
[reference]
name = "femur"
[[reference.component]]
name = "femur"
file = ")" + reference_name + R"("
[moving]
name = "tibia"
initial = { translation_mm = [1, -20, 0], theta_deg = 0 }
[[moving.component]]
name = "tibia"
file = ")" + moving_name + R"("
[solver]
method = "stability-search"
[grid]
flexion = { from = 0, to = 12, step = 2 }
varus = { from = -2, to = 2, step = 1 }
[smooth]
degrees = [2]
)");
}

std::filesystem::path longer_knee_job(const Scratch& scratch)
{
  const std::filesystem::path job = small_knee_job(scratch, "right");
  edit(job, "to = 12, step = 2", "to = 12, step = 0.25");
  return job;
}

std::filesystem::path sesamoid_job(const Scratch& scratch, const std::filesystem::path& job)
{
  scratch.write("bead.stl", stl_bytes(shifted(ball(5), {32, -20, 20})));
  scratch.write("bead.csv",
                "name,bundle,from_body,from_x_mm,from_y_mm,from_z_mm,to_body,to_x_mm,to_y_mm,to_z_mm,"
                "stiffness_n_per_strain,reference_strain,tension_share\n"
                "line1,line,femur,70,20,30,bead,34,-18,23,,,2\n"
                "line2,line,femur,70,20,10,bead,34,-18,17,,,2\n"
                "line3,line,femur,20,40,20,bead,29,-18,20,,,1\n"
                "tendon1,tendon,tibia,5,-12,18,bead,29,-22,18,500,0.02,\n"
                "tendon2,tendon,tibia,5,-12,22,bead,29,-22,22,500,0.02,\n");
  return scratch.write(job.filename().string(), read_bytes(job) + R"(
[[follower]]
name = "bead"
push = { delta = [0, 1, 0], force_n = 2 }
tension_n = 20
fibres = "bead.csv"
[[follower.direction]]
bundle = "tendon"
stiffness_nmm_per_rad = 300
[[follower.component]]
name = "bead"
file = "bead.stl"
)");
}

void wait_for_bytes(Process& process, const std::filesystem::path& file, std::uintmax_t n)
{
  std::error_code ignored;
  while (process.is_running() &&
         (!std::filesystem::exists(file) || std::filesystem::file_size(file, ignored) < n)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

Ended expect_refused(const std::vector<std::string>& words, const Refusal& refusal)
{
  SCOPED_TRACE(testing::PrintToString(words));
  const Ended ended = run_vrda(words);
  EXPECT_THAT(ended, refuses(refusal));
  EXPECT_EQ(n_lines(ended.err), 1) << ended.err;
  EXPECT_EQ(ended.out, "");
  return ended;
}

void expect_run_refused(const std::filesystem::path& job, const std::filesystem::path& output,
                        const Refusal& refusal)
{
  expect_refused({"run", job.string(), "-o", output.string(), "--progress", "none"}, refusal);
  EXPECT_FALSE(std::filesystem::exists(output));
}

Ended CommandTest::succeed(const std::vector<std::string>& words, const std::vector<std::string>& more)
{
  Ended ended = run_vrda(words, more);
  EXPECT_EQ(ended.exit_code, 0) << testing::PrintToString(words) << ended.err;
  return ended;
}

std::string CommandTest::solved_knee(const std::string& side) const
{
  // Solved once in a program.
  static std::map<std::string, std::string> models;
  const std::string job = small_knee_job(scratch_, side).string(), file = path(side + ".h5");
  if (models.count(side) == 0) {
    succeed({"run", job, "-o", file, "--progress", "none", "--replace"});
    models[side] = read_bytes(file);
  }
  scratch_.write(side + ".h5", models[side]);
  return file;
}

std::ptrdiff_t n_lines(const std::string& text)
{
  return std::count(text.begin(), text.end(), '\n');
}

std::string text_of(const std::filesystem::path& file)
{
  return read_bytes(file);
}

void edit(const std::filesystem::path& file, const std::string& from, const std::string& to)
{
  std::string text = read_bytes(file);
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("not in " + file.string() + ": " + from);
  text.replace(at, from.size(), to);
  std::FILE* out = std::fopen(file.c_str(), "wb");
  std::fwrite(text.data(), 1, text.size(), out);
  std::fclose(out);
}

std::string sha256_of_file(const std::filesystem::path& file)
{
  return job::sha256_of(read_bytes(file));
}

}  // namespace vrda::test
