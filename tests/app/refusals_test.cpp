// What `vrda` refuses: the rows of refusals.json, on the inputs made here.
#include "app/scenes.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/shapes.hpp"
#include "job/mesh_text.hpp"
#include "job/thesis_files.hpp"
#include "prepare/template_joint.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/meshes.hpp"
#include "support/refusal_table.hpp"

namespace vrda::refusals_test {

namespace fs = std::filesystem;
using test::Scratch;

void run_in(const Scratch& scratch, const std::vector<std::string>& words)
{
  const test::Ended ended = test::run({VRDA_PROGRAM, words, {}, scratch.path()});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
}

void copy_job(const Scratch& scratch, const std::string& name)
{
  fs::copy_file(fs::path(VRDA_SOURCE_DIR "/jobs") / name, scratch.path() / name);
}

void two_boxes(const Scratch& scratch)
{
  scratch.write("reference.stl", test::binary_stl(test::box({0, 40, 0}, {60, 20, 80})));
  scratch.write("moving.stl", test::binary_stl(test::box({0, 0, 0}, {50, 20, 70})));
  scratch.write("job.toml", test::small_job("joint = \"other\"\n"));
}

/// A block of femur above a block of tibia with a sheet of cartilage 5 mm below the femur, and the tibia
/// again.
void blocks(const Scratch& scratch)
{
  const Mesh tibia = test::box({0, -60, 0}, {50, 30, 70});
  scratch.write("reference.stl", test::binary_stl(test::box({0, 0, 0}, {50, 40, 70})));
  scratch.write("moving.stl", test::binary_stl(tibia));
  scratch.write("cover.stl", test::binary_stl(test::box({0, -43, 0}, {40, 4, 60})));
  Mesh copy = tibia;
  copy.triangles = copy.triangles.colwise().reverse().eval();
  scratch.write("copy.stl", test::binary_stl(copy));
}

/// The bones of a right knee in one pose, in mm and in cm; the tibia 80 mm below.
void scanned_knee(const Scratch& scratch)
{
  const geometry::Shape knee = geometry::right_template_knee();
  const auto write = [&](const std::string& name, Mesh mesh, double scale, double lift_mm = 0.0) {
    mesh.vertices_mm.col(1).array() += lift_mm;
    mesh.vertices_mm *= scale;
    scratch.write(name, test::binary_stl(mesh));
  };
  const Mesh &femur = knee.reference.front().mesh, &tibia = knee.moving.front().mesh;
  write("reference.stl", femur, 1.0);
  write("moving.stl", tibia, 1.0);
  write("reference_cm.stl", femur, 0.1);
  write("moving_cm.stl", tibia, 0.1);
  write("apart.stl", tibia, 1.0, -80.0);
}

/// A box of coordinates that floats hold exactly, in every format.
void box_files(const Scratch& scratch)
{
  const Mesh box = test::box({0.5, -2.25, 3}, {2, 4, 8});
  scratch.write("box.stl", test::binary_stl(box));
  scratch.write("ascii.stl", test::ascii_stl(box));
  scratch.write("box.ply", test::binary_ply(box));
  scratch.write("ascii.ply", test::ascii_ply(box));
}

/// The generic knee, without and with laxity tests and unknowns to fit.
void laxity_knee(const Scratch& scratch)
{
  const std::string knee = test::text_of(VRDA_SOURCE_DIR "/jobs/knee-generic.toml");
  scratch.write("plain.toml", knee);
  scratch.write("knee.toml", knee + test::laxity_tables + test::fit_tables);
}

/// Models of two-ball knees of both sides, of a ball in a dish with its trace, of frames; one without a pose,
/// one of objects that never met, one truncated, one with a changed byte; a table of the right knee's motion.
void models(const Scratch& scratch)
{
  test::small_knee_job(scratch, "right");
  test::small_knee_job(scratch, "left");
  test::small_job(scratch);
  run_in(scratch, {"run", "knee_right.toml", "-o", "right.h5"});
  run_in(scratch, {"run", "knee_left.toml", "-o", "left.h5"});
  run_in(scratch, {"run", "small.toml", "-o", "ball.h5", "--trace"});
  run_in(scratch, {"run", "knee_right.toml", "-o", "apart.h5", "--set", "limits.unsolved_fraction=1", "--set",
                   "moving.initial.translation_mm=[500, -40, 0]"});
  run_in(scratch, {"export", "right.h5", "--to", "csv", "-o", "motion.csv", "--set", "raw", "--varus", "1"});
  run_in(scratch, {"import", "knee_right.toml", "--motion", "motion.csv", "-o", "frames.h5"});
  const std::string model = (scratch.path() / "right.h5").string();
  store::write_motion_model((scratch.path() / "pending.h5").string(),
                            store::with_pending_cells(store::read_motion_model(model)));
  std::string bytes = test::read_bytes(model);
  scratch.write("cut.h5", bytes.substr(0, bytes.size() / 2));
  bytes[bytes.size() / 2] ^= 1;
  scratch.write("changed.h5", bytes);
}

/// A finished submission.
void submitted(const Scratch& scratch)
{
  test::small_job(scratch);
  run_in(scratch, {"submit", "small.toml", "--shards", "2", "--local", "-o", "sub"});
}

void sample_model(const Scratch& scratch)
{
  const auto path = [&](const char* name) { return (scratch.path() / name).string(); };
  store::write_motion_model(path("knee.h5"), test::sample_model({}));
  store::write_motion_model(path("pending.h5"), store::with_pending_cells(test::sample_model({})));
}

/// The bones of a left knee in cm, turned and moved; other files that are not its bones.
void knee_bones(const Scratch& scratch)
{
  const prepare::TemplateJoint joint = prepare::mirrored(prepare::generic_template());
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(1, 2, -1, 2).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(120, -40, 300);
  const auto write = [&](const std::string& name, const Mesh& mesh, double scale = 0.1) {
    Mesh placed = transformed(mesh, X);
    placed.vertices_mm *= scale;
    scratch.write(name, job::stl_bytes(placed, ""));
  };
  const Mesh femur = joined(joint.knee.surfaces.femur), tibia = joined(joint.knee.surfaces.tibia);
  write("femur.stl", femur);
  write("copy.stl", femur);
  write("tibia.stl", tibia);
  write("tibia_mm.stl", tibia, 1.0);
  write("fibula.stl", joint.fibula);
  write("large.stl", joint.fibula, 1.0);
  write("patella_mm.stl", joined(prepare::surfaces_of(joint.patella->body)), 1.0);
  write("newt_femur.stl", femur, 0.3);  // in mm
  write("newt_tibia.stl", tibia, 0.3);
  const geometry::Shape hip = geometry::generate_shape({"hip", {}, {}});
  write("head.stl", hip.moving.front().mesh);
  write("socket.stl", hip.reference.front().mesh);
  X.translation() += Eigen::Vector3d(150, 0, 0);
  write("elsewhere.stl", tibia);
  test::small_job(scratch);
}

/// Makes the files once and copies them for each row.
template <void (*make)(const Scratch&)>
void copied(const Scratch& scratch)
{
  static const auto made = [] {
    auto folder = std::make_unique<Scratch>();
    make(*folder);
    return folder;
  }();
  fs::copy(made->path(), scratch.path(), fs::copy_options::recursive);
}

const test::Scenes scenes{
    {"ball_in_dish", [](const Scratch& scratch) { test::small_job(scratch); }},
    {"blocks", blocks},
    {"box_files", box_files},
    {"hip", [](const Scratch& scratch) { copy_job(scratch, "hip-generic.toml"); }},
    {"knee", [](const Scratch& scratch) { test::small_knee_job(scratch, "right"); }},
    {"knee_bones", copied<knee_bones>},
    {"laxity_knee", laxity_knee},
    {"models", copied<models>},
    {"sample_model", copied<sample_model>},
    {"scanned_knee", copied<scanned_knee>},
    {"submitted", copied<submitted>},
    {"two_boxes", two_boxes},
};

class Refusals : public testing::TestWithParam<test::RefusalRow> {};

TEST_P(Refusals, AreNamed)
{
  expect_row_refused(GetParam(), VRDA_PROGRAM, scenes);
}

INSTANTIATE_TEST_SUITE_P(Vrda, Refusals,
                         testing::ValuesIn(test::read_refusals(VRDA_SOURCE_DIR "/tests/app/refusals.json")),
                         test::name_of_row);

}  // namespace vrda::refusals_test
