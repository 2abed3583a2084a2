// `vrda prepare` with the generated knee, and a job whose frames are found (schemas/frames.md).
#include <gmock/gmock.h>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "app/scenes.hpp"
#include "geometry/shapes.hpp"
#include "job/case.hpp"
#include "job/case_picture.hpp"
#include "job/job.hpp"
#include "job/thesis_files.hpp"
#include "prepare/knee_landmarks.hpp"
#include "prepare/template_joint.hpp"
#include "store/motion_model.hpp"
#include "support/meshes.hpp"
#include "support/messages.hpp"
#include "support/real_knees.hpp"

namespace vrda::prepare_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Prepare : public testing::Test {
 protected:
  // The bones of a left knee in cm, turned and moved, in two files.
  Prepare()
  {
    const prepare::TemplateJoint joint = prepare::mirrored(prepare::generic_template());
    X_.linear() = Eigen::Quaterniond(1, 2, -1, 2).normalized().toRotationMatrix();
    X_.translation() = Eigen::Vector3d(120, -40, 300);
    femur_ = written("femur.stl", joined(joint.knee.surfaces.femur));
    tibia_ = written("tibia.stl", joined(joint.knee.surfaces.tibia));
    fibula_ = written("fibula.stl", joint.fibula);
  }

  std::string written(const std::string& name, Mesh mesh) const
  {
    mesh = transformed(mesh, X_);
    mesh.vertices_mm *= 0.1;
    return scratch_.write(name, job::stl_bytes(mesh, "")).string();
  }

  // Bare, of another femur.
  test::Ended prepared(const std::string& femur, const std::vector<std::string>& more = {}) const
  {
    test::Ended ended = test::run_vrda({"prepare", "--femur", femur, "--tibia", tibia_, "--no-ligaments",
                                        "--cartilage", "none", "-o", folder_.string(), "--replace"},
                                       more);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended;
  }

  nlohmann::json report() const { return nlohmann::json::parse(test::read_bytes(folder_ / "prepare.json")); }

  test::Scratch scratch_;
  fs::path folder_ = scratch_.path() / "knee";
  Pose X_ = Pose::Identity();
  std::string femur_, tibia_, fibula_;
};

// The scanned patella of a left knee, and the template's, follow the joint at every flexion.
TEST_F(Prepare, APatellaFollows)
{
  const prepare::TemplateJoint joint = prepare::mirrored(prepare::generic_template());
  const std::string patella = written("patella.stl", joined(prepare::surfaces_of(joint.patella->body)));
  for (const std::vector<std::string>& given :
       {std::vector<std::string>{"--patella", patella}, std::vector<std::string>{"--template-patella"}}) {
    std::vector<std::string> arguments{"prepare",  "--femur",        femur_,        "--tibia", tibia_,
                                       "--fibula", fibula_,          "--cartilage", "none",    "--no-prior",
                                       "-o",       folder_.string(), "--replace"};
    arguments.insert(arguments.end(), given.begin(), given.end());
    const test::Ended ended = test::run_vrda(arguments);
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    const nlohmann::json found = report().at("patella");
    EXPECT_EQ(found.at("is_template"), given.size() == 1);
    EXPECT_NEAR(found.at("scanned").at("flexion_deg").get<double>(), 0.0, 1.0);
    EXPECT_NEAR(found.at("scanned").at("lateral_mm").get<double>(), 0.0, 0.5);
    EXPECT_EQ(ended.err.find("illustrative") != std::string::npos, given.size() == 1) << ended.err;
    const store::MotionModel model = test::solved(folder_ / "knee.toml", {"grid.flexion.step=45"});
    ASSERT_EQ(model.followers.size(), 1U);
    const store::FollowerRows& follower = model.followers.front();
    EXPECT_EQ((follower.status == status_stable).count(), 3);
    EXPECT_GT(follower.coordinates[JointCoordinate::flexion](2, 0), 50.0);
    EXPECT_LT(follower.coordinates[JointCoordinate::flexion](2, 0), 80.0);
  }
}

TEST_F(Prepare, WritesAJobThatSolves)
{
  const test::Ended ended = test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia_, "--fibula",
                                            fibula_, "--cartilage", "none", "-o", folder_.string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("knee.toml"));
  const nlohmann::json found = report();
  EXPECT_EQ(found.at("side"), "left");
  EXPECT_EQ(found.at("unit"), "cm");
  EXPECT_EQ(found.at("solved_flexions"), nlohmann::json::parse("[10, 10]"));
  EXPECT_NEAR(found.at("scanned").at("flexion_deg").get<double>(), 0.0, 0.1);
  // The matrix takes the file's origin to where it is in the anatomical frame; STL has single precision.
  const Eigen::Vector3d origin_mm = X_.inverse() * Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(
        found.at("femur").at("anatomical_from_file").at(static_cast<std::size_t>(k)).at(3).get<double>(),
        origin_mm[k], 0.05);
    EXPECT_NEAR(found.at("femur").at("scale").at(static_cast<std::size_t>(k)).get<double>(), 1.0, 1e-3);
  }
  // [scan] takes that point back to the file's origin.
  const job::Job written = job::read_job((folder_ / "knee.toml").string());
  for (const std::vector<double>& row : core::rows_at(written.document.root, "scan.X_scan_reference")) {
    double p_mm = row.at(3);
    for (std::size_t k = 0; k < 3; ++k)
      p_mm += row.at(k) * found.at("femur").at("anatomical_from_file").at(k).at(3).get<double>();
    EXPECT_NEAR(p_mm, 0.0, 1e-9);  // rounding
  }
  for (const char* name : {"femur.stl", "tibia.stl", "fibula.stl", "ligaments.csv", "prepare.png"})
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  // Four views of 800 pixels: the width is in bytes 16 to 19 of a PNG.
  const std::string png = test::read_bytes(folder_ / "prepare.png");
  EXPECT_EQ(256 * static_cast<unsigned char>(png.at(18)) + static_cast<unsigned char>(png.at(19)), 3200);
  const job::Case job = job::load_case((folder_ / "knee.toml").string());
  EXPECT_EQ(job.frame.side, Side::left);
  EXPECT_EQ(job.ligaments.fibres.size(), 26U);
  EXPECT_EQ(job.grid.flexion_deg.size(), 19U);
  const test::Ended other_side =
      test::run_vrda({"check", (folder_ / "knee.toml").string(), "--set", "side=right"});
  EXPECT_THAT(other_side.out + other_side.err, test::warns("side", "left"));
  const test::Ended run =
      test::run_vrda({"run", (folder_ / "knee.toml").string(), "--set", "grid.flexion.step=30", "-o",
                      (folder_ / "knee.h5").string(), "--progress", "none"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

// In any order; of a left knee.
TEST_F(Prepare, PartsOfBothSidesAreNamedByTheirSide)
{
  std::map<std::string, std::string> file_of;
  const geometry::Shape knee = geometry::generate_shape({"knee", {}, {}});
  for (const geometry::ShapePart& part : knee.moving)
    if (part.material == "meniscus") file_of[part.name] = written(part.name + "-.stl", mirrored_z(part.mesh));
  ASSERT_EQ(file_of.size(), 2U);
  prepared(femur_, {"--meniscus", file_of.at("meniscus_lateral"), file_of.at("meniscus_medial")});
  for (const auto& [name, file] : file_of)
    EXPECT_EQ(fs::file_size(folder_ / (name + ".stl")), fs::file_size(file)) << name;
  const job::Case job = job::load_case((folder_ / "knee.toml").string());
  EXPECT_THAT(job.moving.components,
              testing::IsSupersetOf({testing::Field(&Component::name, "meniscus_medial"),
                                     testing::Field(&Component::name, "meniscus_lateral")}));
}

// A child's bones, the program's own shape without its shafts, a fibula far from the tibia's only surface.
TEST_F(Prepare, KneesThatAreRight)
{
  const prepare::TemplateJoint joint = prepare::mirrored(prepare::generic_template());
  const auto scaled = [&](const std::string& name, Mesh mesh, double factor) {
    mesh.vertices_mm *= factor;
    return written(name, std::move(mesh));
  };
  const auto child = [&](double factor) {
    const std::string size = shortest_decimal(factor);
    return std::vector<std::string>{
        "--femur",  scaled(size + "f.stl", joined(joint.knee.surfaces.femur), factor),
        "--tibia",  scaled(size + "t.stl", joined(joint.knee.surfaces.tibia), factor),
        "--fibula", scaled(size + "b.stl", joint.fibula, factor)};
  };
  const auto shape = [&](const std::string& name, const std::vector<std::string>& how) {
    const std::string folder = (scratch_.path() / name).string();
    EXPECT_EQ(test::run_vrda({"shape", "knee", "-o", folder, "-q"}, how).exit_code, 0);
    return std::vector<std::string>{"--femur", folder + "/femur.stl", "--tibia", folder + "/tibia.stl"};
  };
  struct Row {
    std::string name;
    std::vector<std::string> words;
    const char* side;
    double scale;
  };
  for (const Row& row : {Row{"child", child(0.45), "left", 0.45}, Row{"shape", shape("gk", {}), "right", 1.0},
                         Row{"left_shape", shape("gl", {"side=left", "resolution=2"}), "left", 1.0},
                         Row{"fibula_and_cartilage",
                             {"--femur", femur_, "--fibula", fibula_, "--tibia-cartilage",
                              written("cartilage.stl", joint.knee.surfaces.tibia.cartilage)},
                             "left",
                             1.0}}) {
    SCOPED_TRACE(row.name);
    std::vector<std::string> words = row.words;
    words.insert(words.end(), {"--no-ligaments", "--replace", "-o", folder_.string()});
    const test::Ended ended = test::run_vrda({"prepare"}, words);
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    const nlohmann::json found = report();
    EXPECT_EQ(found.at("side"), row.side);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(found.at("femur").at("scale").at(k).get<double>(), row.scale, 0.02 * row.scale);
    EXPECT_NEAR(found.at("scanned").at("flexion_deg").get<double>(), 0.0, 2.0);
    EXPECT_NEAR(found.at("scanned").at("internal_rotation_deg").get<double>(), 0.0, 2.0);
  }
}

TEST_F(Prepare, ThickensBonesWithoutCartilageAndLeavesLigamentsOut)
{
  const test::Ended ended =
      test::run_vrda({"prepare", "--femur", femur_, "--tibia-cartilage", tibia_, "--cartilage", "1.5",
                      "--side", "left", "--unit", "cm", "--no-ligaments", "--json", "-o", folder_.string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, testing::AllOf(test::warns("femur", "1.5 mm"), test::warns("tibia", "cartilage")));
  EXPECT_EQ(nlohmann::json::parse(ended.out), report());
  EXPECT_THAT(test::read_bytes(folder_ / "knee.toml"), HasSubstr("inset_mm = -1.5"));
  EXPECT_TRUE(job::load_case((folder_ / "knee.toml").string()).ligaments.fibres.empty());
}

std::map<std::string, std::string> contents(const fs::path& folder)
{
  std::map<std::string, std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    found[entry.path().filename().string()] = test::read_bytes(entry.path());
  return found;
}

TEST_F(Prepare, FilesOfAnEarlierPreparationStayUnlessAllAreReplaced)
{
  const auto prepared = [&](const std::string& femur, const std::string& tibia,
                            const std::vector<std::string>& more) {
    return test::run_vrda(
        {"prepare", "--femur", femur, "--tibia", tibia, "--no-ligaments", "-o", folder_.string()}, more);
  };
  ASSERT_EQ(prepared(femur_, tibia_, {}).exit_code, 0);
  const std::map<std::string, std::string> before = contents(folder_);
  EXPECT_THAT(prepared(femur_, tibia_, {}),
              test::refuses({(folder_ / "knee.toml").string(), "-o", "existing", "--replace"}));
  EXPECT_EQ(contents(folder_), before);
  ASSERT_EQ(prepared(tibia_, femur_, {"--replace"}).exit_code, 2);
  std::map<std::string, std::string> after = contents(folder_);
  EXPECT_EQ(after.erase("refused.png"), 1U);
  EXPECT_EQ(after, before);
  ASSERT_EQ(prepared(femur_, tibia_, {"--replace", "--cartilage", "none"}).exit_code, 0);
  EXPECT_NE(contents(folder_), before);
  EXPECT_FALSE(fs::exists(folder_ / "refused.png"));
}

// Half of the faces around one vertex are missing: its winding is known by its volume all the same.
TEST_F(Prepare, ABoneWithAHoleIsOrientedByItsVolume)
{
  Mesh tibia = joined(prepare::mirrored(prepare::generic_template()).knee.surfaces.tibia);
  tibia.triangles = tibia.triangles.topRows(tibia.triangles.rows() - 3).eval();
  tibia.triangles.col(1).swap(tibia.triangles.col(2));
  const std::string inward = written("inward.stl", tibia);
  EXPECT_EQ(test::run_vrda(
                {"prepare", "--femur", femur_, "--tibia", inward, "--no-ligaments", "-o", folder_.string()})
                .exit_code,
            0);
}

// Left-overs in the joint space, inner walls and copies of triangles: said, left out, and the rest is the
// same.
TEST_F(Prepare, WhatDoesNotBelongToASurfaceIsLeftOut)
{
  const Mesh femur = joined(prepare::mirrored(prepare::generic_template()).knee.surfaces.femur);
  Mesh speck = test::ball(1.0, 6, 8), with_all = femur;
  speck.vertices_mm.rowwise() += Eigen::RowVector3d(0, -25.5, 20);
  append(with_all, select_triangles(femur, {3, 200, 4000}));
  append(with_all, test::box({5, 10, 0}, {8, 12, 20}));
  append(with_all, speck);
  prepared(femur_);
  std::map<std::string, std::string> expected = contents(folder_);
  expected.erase("prepare.json");  // has the warnings
  expected.erase("prepare.png");
  const std::string changed = written("changed.stl", with_all);
  const test::Ended ended = prepared(changed);
  for (const char* said : {"2 mm across", "inside another", "3 copies of other triangles"})
    EXPECT_THAT(ended.err, test::warns("--femur: left out", said));
  std::map<std::string, std::string> found = contents(folder_);
  found.erase("prepare.json");
  found.erase("prepare.png");
  EXPECT_TRUE(found == expected);
  prepared(changed, {"--keep-specks"});
  EXPECT_NE(contents(folder_).at("femur.stl"), expected.at("femur.stl"));
  EXPECT_EQ(report().at("specks").at(0).at("left_out"), false);
}

// Noise is measured and smoothed away; clean surfaces keep their vertices bit for bit, and --no-smooth all.
TEST_F(Prepare, RoughSurfacesAreSmoothedCleanOnesStay)
{
  Mesh rough = joined(prepare::mirrored(prepare::generic_template()).knee.surfaces.femur);
  std::mt19937 random(1);
  std::normal_distribution<double> across_mm(0.0, 0.5);
  for (Eigen::Index v = 0; v < rough.vertices_mm.rows(); ++v)
    rough.vertices_mm.row(v) += across_mm(random) * rough.normals.row(v);
  const std::string rough_file = written("rough.stl", rough);

  EXPECT_THAT(prepared(femur_).err, Not(HasSubstr("smooth")));
  for (const nlohmann::json& row : report().at("noise")) EXPECT_EQ(row.at("smoothed"), false) << row;
  const std::map<std::string, std::string> clean = contents(folder_);
  prepared(femur_, {"--no-smooth"});
  EXPECT_TRUE(contents(folder_) == clean);

  const test::Ended smoothed = prepared(rough_file);
  EXPECT_THAT(smoothed.err, test::warns("--femur", "smoothed: vertices moved by"));
  EXPECT_THAT(smoothed.err, HasSubstr("noise of the surfaces: femur 0."));
  const nlohmann::json femur = report().at("noise").at(0), tibia = report().at("noise").at(1);
  EXPECT_EQ(femur.at("component"), "femur");
  EXPECT_EQ(femur.at("smoothed"), true);
  EXPECT_NEAR(femur.at("noise_mm").get<double>(), 0.5, 0.1);
  EXPECT_GT(femur.at("moved_rms_mm").get<double>(), 0.3);
  EXPECT_GT(femur.at("moved_largest_mm").get<double>(), femur.at("moved_rms_mm").get<double>());
  EXPECT_EQ(tibia.at("smoothed"), false);
  const std::map<std::string, std::string> after = contents(folder_);

  EXPECT_THAT(prepared(rough_file, {"--no-smooth"}).err, test::warns("--femur", "not smoothed"));
  EXPECT_EQ(report().at("noise").at(0).at("smoothed"), false);
  EXPECT_NE(contents(folder_).at("femur.stl"), after.at("femur.stl"));
  EXPECT_NE(contents(folder_).at("prepare.png"), after.at("prepare.png"));

  // Idempotent: a prepared knee is clean.
  for (const char* name : {"femur.stl", "tibia.stl"}) scratch_.write(name, after.at(name));
  const test::Ended again = test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia_, "--no-ligaments",
                                            "-o", (scratch_.path() / "again").string()});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, Not(HasSubstr("is rough")));
}

// Each triangle divided into 4^n.
Mesh divided(const Mesh& mesh, int n)
{
  if (n == 0) return mesh;
  Mesh finer;
  finer.vertices_mm.resize(6 * mesh.triangles.rows(), 3);
  finer.triangles.resize(4 * mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const auto v = static_cast<std::int32_t>(6 * t);
    finer.vertices_mm.middleRows<6>(6 * t) << a.transpose(), b.transpose(), c.transpose(),
        0.5 * (a + b).transpose(), 0.5 * (b + c).transpose(), 0.5 * (c + a).transpose();
    finer.triangles.middleRows<4>(4 * t) << v, v + 3, v + 5, v + 3, v + 1, v + 4, v + 5, v + 4, v + 2, v + 3,
        v + 4, v + 5;
  }
  finer.normals = vertex_normals(finer);
  return divided(finer, n - 1);
}

// A large mesh is registered by a simpler copy, which the job has only where that is wanted.
TEST_F(Prepare, ALargeMeshHasTheFramesOfItsSurface)
{
  const auto prepared = [&](const std::string& tibia, const std::string& flag) {
    const test::Ended ended =
        test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia, "--no-ligaments", "--cartilage",
                        "none", "-o", folder_.string(), "--replace", flag});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.err;
  };
  const auto n_written = [&] {
    constexpr std::uintmax_t header_bytes = 84, triangle_bytes = 50;
    return static_cast<Eigen::Index>((fs::file_size(folder_ / "tibia.stl") - header_bytes) / triangle_bytes);
  };
  EXPECT_THAT(prepared(tibia_, "--every-triangle"), Not(HasSubstr("copies of the surfaces")));
  const nlohmann::json before = report();
  const Mesh fine = divided(joined(prepare::mirrored(prepare::generic_template()).knee.surfaces.tibia), 3);
  ASSERT_GT(fine.triangles.rows(), 200'000);
  const std::string file = written("fine.stl", fine);
  EXPECT_THAT(prepared(file, "--every-triangle"), HasSubstr("works on copies of the surfaces with "));
  EXPECT_EQ(n_written(), fine.triangles.rows());
  EXPECT_THAT(prepared(file, "--no-smooth"), HasSubstr("works on and writes copies of the surfaces with "));
  EXPECT_LT(n_written(), report().at("copies").at("triangles").get<Eigen::Index>());  // both bones
  EXPECT_LT(report().at("copies").at("triangles"), report().at("copies").at("of"));
  constexpr double tolerance = 0.05;  // degrees and mm: that of the copies
  EXPECT_LE(report().at("copies").at("within_mm").get<double>(), tolerance);
  for (const char* key :
       {"flexion_deg", "varus_deg", "internal_rotation_deg", "anterior_mm", "proximal_mm", "lateral_mm"})
    EXPECT_NEAR(report().at("scanned").at(key).get<double>(), before.at("scanned").at(key).get<double>(),
                tolerance)
        << key;
}

TEST_F(Prepare, CartilageOfOneCompartmentAndAFibulaThatIsNotLateralAreWarnedOf)
{
  // Of a left knee: its lateral half.
  const Mesh femur = joined(prepare::mirrored(prepare::generic_template()).knee.surfaces.femur);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index t = 0; t < femur.triangles.rows(); ++t) {
    const Eigen::Vector3d p = corners(femur, t)[0];
    if (p.z() < -5.0 && p.y() < 5.0) kept.push_back(t);
  }
  Mesh half = select_triangles(femur, kept);
  half.vertices_mm += 2.0 * half.normals;
  const test::Ended ended =
      test::run_vrda({"prepare", "--femur", femur_, "--femur-cartilage", written("half.stl", half), "--tibia",
                      tibia_, "--fibula", written("medial.stl", prepare::generic_template().fibula),
                      "--no-ligaments", "-o", folder_.string()});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, test::warns("--femur-cartilage", "one compartment only"));
  EXPECT_THAT(ended.err, test::warns("--fibula", "lateral"));
}

TEST_F(Prepare, LandmarksAreUsedAndReported)
{
  const prepare::TemplateJoint left = prepare::mirrored(prepare::generic_template());
  const auto in_file = [&](const Eigen::Vector3d& p_mm) {
    const Eigen::Vector3d p = 0.1 * (X_ * p_mm);
    return "[" + std::to_string(p.x()) + ", " + std::to_string(p.y()) + ", " + std::to_string(p.z()) + "]\n";
  };
  const auto prepared = [&](const Eigen::Vector3d& epicondyle_mm) {
    const std::vector<model::Fibre>& fibres = left.joint.ligaments.fibres;
    const std::string marks =
        scratch_
            .write("marks.toml", "[landmarks]\nmedial_epicondyle = " + in_file(epicondyle_mm) +
                                     "[[fibre]]\nname = \"" + fibres[0].name +
                                     "\"\nfemur = " + in_file(fibres[2].reference_mm))
            .string();
    return test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia_, "--cartilage", "none",
                           "--landmarks", marks, "-o", folder_.string(), "--replace"});
  };
  const Eigen::Vector3d epicondyle_mm = *landmark_mm(left, "medial_epicondyle");
  const test::Ended ended = prepared(epicondyle_mm);
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const nlohmann::json marks = report().at("landmarks");
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks.at(0).at("name"), "medial_epicondyle");
  EXPECT_LT(marks.at(0).at("residual_mm").get<double>(), 0.1);
  // The first fibre of the bundle is attached where the user says: where the third one is.
  const std::vector<model::Fibre> fibres = job::load_case((folder_ / "knee.toml").string()).ligaments.fibres;
  EXPECT_LT((fibres[0].reference_mm - fibres[2].reference_mm).norm(), 0.5);
  EXPECT_GT((fibres[1].reference_mm - fibres[2].reference_mm).norm(), 1.0);
  EXPECT_THAT(prepared(epicondyle_mm + Eigen::Vector3d(0, 0, 60)),
              test::refuses({"marks.toml", "line 2, landmarks.medial_epicondyle"}));
}

TEST_F(Prepare, LandmarksAloneScaleTheTemplate)
{
  const std::string marks =
      scratch_
          .write("marks.toml",
                 "[[distance]]\nfrom = \"medial_epicondyle\"\nto = \"lateral_epicondyle\"\nmm = 87\n")
          .string();
  const std::vector<std::string> words{"prepare",        "--landmarks", marks, "-o",
                                       folder_.string(), "--side",      "left"};
  const test::Ended ended = test::run_vrda(words);
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, AllOf(HasSubstr("no meshes given"), HasSubstr("tibia: no distance")));
  const nlohmann::json found = report();
  EXPECT_EQ(found.at("solved_flexions"), nlohmann::json::parse("[10, 10]"));
  const prepare::TemplateJoint joint = prepare::mirrored(prepare::generic_template());
  const double factor =
      87.0 / (*landmark_mm(joint, "medial_epicondyle") - *landmark_mm(joint, "lateral_epicondyle")).norm();
  const job::Case job = job::load_case((folder_ / "knee.toml").string());
  EXPECT_EQ(job.frame.side, Side::left);
  EXPECT_EQ(job.ligaments.fibres.size(), joint.joint.ligaments.fibres.size());
  for (const auto& [body, own] :
       {std::pair(&job.reference, &joint.joint.reference), std::pair(&job.moving, &joint.joint.moving)}) {
    const Box box = bounding_box(body->contact.mesh), own_box = bounding_box(own->contact.mesh);
    EXPECT_LT((box.max_mm - factor * own_box.max_mm).norm(), 1e-3);
  }
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(found.at("femur").at("scale").at(k).get<double>(), factor, 1e-6);
}

struct Scan {
  test::Scratch scratch;

  fs::path job(const Pose& X_femur, const Pose& X_tibia, const std::string& frames) const
  {
    const prepare::TemplateJoint joint = prepare::generic_template();
    const auto write = [&](const std::string& name, const Mesh& mesh, const Pose& X) {
      scratch.write(name, job::stl_bytes(transformed(mesh, X), ""));
    };
    write("femur.stl", joint.joint.reference.contact.mesh, X_femur);
    write("tibia.stl", joint.joint.moving.contact.mesh, X_tibia);
    return scratch.write("knee.toml", R"(
[reference]
name = "femur"
[[reference.component]]
name = "femur"
file = "femur.stl"
[moving]
name = "tibia"
[[moving.component]]
name = "tibia"
file = "tibia.stl"
[ligaments]
generate = { shape = "knee-template" }
[grid]
flexion = { from = 0, to = 90, step = 30 }
varus = "free"
)" + frames);
  }
};

TEST(BodyFramesRun, ATurnedKneeWithAutoHasThePosesOfTheKneeItself)
{
  const Scan scan;
  const store::MotionModel own = test::solved(scan.job(Pose::Identity(), Pose::Identity(), ""));
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(1, 2, -1, 2).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(120, -40, 300);
  Pose X_femur = X;
  X_femur.linear() = X.linear() * rotation_z(0.4);
  const fs::path job = scan.job(X_femur, X,
                                "[reference.frame]\norigin = \"auto\"\nalign = \"auto\"\n"
                                "[moving.frame]\norigin = \"auto\"\nalign = \"auto\"\n");
  const store::MotionModel found = test::solved(job);
  ASSERT_EQ(found.theta_deg.rows(), own.theta_deg.rows());
  // A fit ends within some thousandths of a degree; single precision of the files.
  EXPECT_LT((found.theta_deg - own.theta_deg).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((found.varus_solved_deg - own.varus_solved_deg).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((found.ty_mm - own.ty_mm).cwiseAbs().maxCoeff(), 0.05);
  const nlohmann::json origin =
      test::json_of({"check", job.string()}).at("found_frames").at("moving").at("origin");
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(origin.at(k).get<double>(), X.translation()[static_cast<Eigen::Index>(k)], 0.05);
}

}  // namespace vrda::prepare_test
