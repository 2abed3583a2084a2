// The template's ligaments on a subject, frames, and the files of a prepared job.
#include <gmock/gmock.h>

#include <algorithm>

#include "core/units.hpp"
#include "job/case_warnings.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"
#include "prepare/bone_wraps.hpp"
#include "prepare/job_files.hpp"
#include "prepare/knee_landmarks.hpp"
#include "prepare/template_joint.hpp"
#include "prepare/transfer.hpp"
#include "support/meshes.hpp"

namespace vrda::template_joint_test {

using prepare::frame_warnings;

using prepare::SettledPose, prepare::settled_pose, prepare::SlackLengths;

TEST(SettledPose, displaced_knee)
{
  job::Case knee = prepare::generic_template().joint;
  const SettledPose own = settled_pose(knee);
  ASSERT_TRUE(own.has_contact);
  // Adducted by 3 degrees about the rotation centre and lowered by 4 mm.
  Pose X = Pose::Identity();
  X.linear() = rotation_x(rad_from_deg(-3.0));
  knee.moving.contact.mesh = transformed(knee.moving.contact.mesh, X);
  knee.moving.contact.mesh.vertices_mm.col(1).array() -= 4.0;
  const SettledPose settled = settled_pose(knee);
  ASSERT_TRUE(settled.has_contact);
  // The point of contact moves on the plateau as the tibia turns: some hundredths of a millimetre.
  EXPECT_NEAR(deg_from_rad(settled.attitude.varus_rad - own.attitude.varus_rad), 3.0, 0.3);
  EXPECT_NEAR(settled.pose.translation_mm.y() - own.pose.translation_mm.y(), 4.0, 0.2);
}

TEST(SettledPose, one_compartment)
{
  job::Case knee = prepare::generic_template().joint;
  knee.reference.contact.mesh.vertices_mm.col(2).array() += 200.0;
  EXPECT_FALSE(settled_pose(knee).has_contact);
}

TEST(SlackLengths, onto_itself)
{
  const job::Case knee = prepare::generic_template().joint;
  job::Case subject = knee;
  for (model::Fibre& fibre : subject.ligaments.fibres) fibre.slack_length_mm = 1.0;
  const prepare::SlackResult result = SlackLengths(subject, knee, 2).set();
  for (std::size_t i = 0; i < knee.ligaments.fibres.size(); ++i) {
    EXPECT_NEAR(subject.ligaments.fibres[i].slack_length_mm, knee.ligaments.fibres[i].slack_length_mm, 1e-9);
    EXPECT_NEAR(result.loads.largest_strain[i], result.template_strain[i], 1e-9);
  }
  EXPECT_EQ(result.loads.n_solved, result.loads.n_flexions);
  EXPECT_THAT(result.lengthenings, testing::ElementsAre(0));
}

TEST(SlackLengths, strained_fibre)
{
  job::Case knee = prepare::generic_template().joint;
  job::Case subject = knee;
  // Attached anterior of the flexion axis, it tightens in flexion.
  for (model::Fibre& fibre : subject.ligaments.fibres) {
    if (fibre.bundle == "MCLs") fibre.reference_mm.x() += 20.0;
  }
  const prepare::SlackResult result = SlackLengths(subject, knee, 2).set();
  ASSERT_GT(result.lengthenings.front(), 0);
  for (std::size_t i = 0; i < result.template_strain.size(); ++i)
    EXPECT_LT(result.loads.largest_strain[i], std::max(result.template_strain[i], 0.0) + 0.06);
}

// The superficial MCL of the template runs through its tibia.
TEST(BoneWraps, onto_itself)
{
  const job::Case knee = prepare::generic_template().joint;
  job::Case subject = knee;
  SlackLengths lengths(subject, knee, 2);
  prepare::SlackResult slack = lengths.set();
  const std::vector<prepare::BundleCrossing> bundles = wrap_over_bones(subject, lengths, slack);
  const auto mcl = std::ranges::find(bundles, "MCLs", &prepare::BundleCrossing::bundle);
  ASSERT_NE(mcl, bundles.end());
  EXPECT_GT(mcl->straight_mm, 3.0);
  EXPECT_GT(mcl->n_wrapped, 0);
  for (const prepare::BundleCrossing& bundle : bundles) EXPECT_LT(bundle.left_mm, 1.0) << bundle.bundle;
  // The template's strains, from the wrapped lengths.
  const std::vector<double> own_mm = fibre_lengths_mm(subject, slack.settled);
  const std::vector<double> template_mm = fibre_lengths_mm(knee, settled_pose(knee));
  for (std::size_t i = 0; i < own_mm.size() && slack.lengthenings.front() == 0; ++i)
    EXPECT_NEAR(own_mm[i] / subject.ligaments.fibres[i].slack_length_mm,
                template_mm[i] / knee.ligaments.fibres[i].slack_length_mm, 1e-9);
  // Through the file.
  model::Ligaments read = subject.ligaments;
  read.wraps = job::read_wraps("wraps.json", prepare::wraps_text(read), {"femur", "tibia"});
  subject.ligaments = read;
  const std::vector<double> read_mm = fibre_lengths_mm(subject, slack.settled);
  for (std::size_t i = 0; i < own_mm.size(); ++i) EXPECT_NEAR(read_mm[i], own_mm[i], 1e-9);
}

TEST(BoneWraps, warning_of_a_fibre_in_bone)
{
  job::Case knee = prepare::generic_template().joint;
  knee.ligaments.fibres.erase(knee.ligaments.fibres.begin(), knee.ligaments.fibres.end() - 1);
  model::Fibre& fibre = knee.ligaments.fibres.front();
  ASSERT_EQ(fibre.bundle, "LCL");
  EXPECT_THAT(job::bone_crossing_warnings(knee), testing::IsEmpty());
  fibre.moving_mm.z() -= 25.0;
  EXPECT_THAT(job::bone_crossing_warnings(knee),
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("\"" + fibre.name + "\""),
                                                  testing::HasSubstr("inside the bone of \"tibia\""))));
}

TEST(ScannedGap, two_compartments)
{
  geometry::KneeFit fit;
  geometry::KneeSurfaces knee;
  knee.femur.bone = test::box({0, 10, 0}, {60, 10, 80});
  knee.tibia.bone = test::box({0, -10, -20}, {60, 26, 30});        // 2 mm below
  append(knee.tibia.bone, test::box({0, -11, 20}, {60, 24, 30}));  // 4 mm below
  EXPECT_NEAR(prepare::scanned_gap_mm(fit, knee), 3.0, 1e-9);
  knee.tibia.bone.vertices_mm.col(2).array() += 300.0;
  EXPECT_TRUE(std::isnan(prepare::scanned_gap_mm(fit, knee)));
  EXPECT_DOUBLE_EQ(prepare::cartilage_in_gap_mm(3.2), 3.2);
  EXPECT_DOUBLE_EQ(prepare::cartilage_in_gap_mm(0.4), 1.5);
  EXPECT_DOUBLE_EQ(prepare::cartilage_in_gap_mm(9.0), 5.0);
}

using geometry::BoneFit, geometry::KneeFit;
using prepare::TransferredLigaments, prepare::SubjectBones, prepare::TemplateJoint;

// The template at `factor` times its size as a subject, and the fit that finds it.
struct Copy {
  SubjectBones bones;
  KneeFit fit;
};

Copy copy_of(const TemplateJoint& joint, double factor)
{
  Copy copy{{joint.knee.surfaces, joint.fibula}, {}};
  for (Mesh* mesh : {&copy.bones.surfaces.femur.bone, &copy.bones.surfaces.tibia.bone, &copy.bones.fibula})
    mesh->vertices_mm *= factor;
  copy.fit.femur.scale.setConstant(factor);
  copy.fit.tibia.scale.setConstant(factor);
  return copy;
}

TEST(TransferredLigaments, onto_itself)
{
  const TemplateJoint joint = prepare::generic_template();
  const Copy copy = copy_of(joint, 1.0);
  const TransferredLigaments transferred = transferred_ligaments(joint, copy.fit, copy.bones);
  ASSERT_EQ(transferred.ligaments.fibres.size(), joint.joint.ligaments.fibres.size());
  for (std::size_t i = 0; i < transferred.moves.size(); ++i) {
    EXPECT_LT(transferred.moves[i].reference_mm, 1e-6) << transferred.ligaments.fibres[i].name;
    EXPECT_LT(transferred.moves[i].moving_mm, 1e-6) << transferred.ligaments.fibres[i].name;
    EXPECT_LT((transferred.ligaments.fibres[i].moving_mm - joint.joint.ligaments.fibres[i].moving_mm).norm(),
              1e-6);
  }
}

TEST(TransferredLigaments, scaled)
{
  TemplateJoint joint = prepare::generic_template();
  model::Wrap wrap{"w", model::WrapShape::ellipsoid, BodyIndex::moving};
  wrap.radii_mm = {10, 20, 45};
  wrap.X_body_wrap.translation() = Eigen::Vector3d(1, 2, 3);
  joint.joint.ligaments.wraps = {wrap};
  const Copy copy = copy_of(joint, 1.1);
  const TransferredLigaments transferred = transferred_ligaments(joint, copy.fit, copy.bones);
  for (std::size_t i = 0; i < transferred.moves.size(); ++i) {
    // An attachment keeps the template's own distance from the bone, which is a facet's.
    EXPECT_LT(
        (transferred.ligaments.fibres[i].reference_mm - 1.1 * joint.joint.ligaments.fibres[i].reference_mm)
            .norm(),
        0.2);
  }
  EXPECT_TRUE(
      transferred.ligaments.wraps[0].X_body_wrap.translation().isApprox(Eigen::Vector3d(1.1, 2.2, 3.3)));
  EXPECT_NEAR(transferred.ligaments.wraps[0].radii_mm.z(), 1.1 * 45, 1e-12);
}

TEST(TransferredLigaments, attached_to_bone)
{
  TemplateJoint joint = prepare::generic_template();
  model::Wrap wrap{"w", model::WrapShape::ellipsoid, BodyIndex::reference};
  wrap.radii_mm = {10, 20, 48};
  joint.joint.ligaments.wraps = {wrap};
  Copy copy = copy_of(joint, 1.0);
  copy.fit.femur.scale = {1.0, 1.0, 1.02};
  // The subject's surface is 2 mm outside, so attachments move by up to that; contact part and shaft overlap.
  copy.bones.surfaces.femur.bone.vertices_mm += 2.0 * vertex_normals(copy.bones.surfaces.femur.bone);
  const TransferredLigaments transferred = transferred_ligaments(joint, copy.fit, copy.bones);
  const Eigen::Vector3d radii_mm = transferred.ligaments.wraps[0].radii_mm;
  EXPECT_NEAR(radii_mm.z(), 1.02 * 48, 1e-12);
  EXPECT_LT(radii_mm.maxCoeff() / radii_mm.minCoeff(), 5.0);
  double largest_mm = 0.0;
  const geometry::NearestSurface bone(copy.bones.surfaces.femur.bone);
  for (std::size_t i = 0; i < transferred.moves.size(); ++i) {
    if (std::isnan(transferred.moves[i].reference_mm)) continue;
    EXPECT_LT(bone.nearest(transferred.ligaments.fibres[i].reference_mm).distance_mm, 0.2);
    largest_mm = std::max(largest_mm, transferred.moves[i].reference_mm);
  }
  EXPECT_NEAR(largest_mm, 2.0, 0.5);
}

TEST(TransferredLigaments, without_bone)
{
  const TemplateJoint joint = prepare::generic_template();
  Copy copy = copy_of(joint, 1.0);
  copy.bones.surfaces.femur.bone = {};
  copy.bones.fibula = {};
  const TransferredLigaments transferred = transferred_ligaments(joint, copy.fit, copy.bones);
  for (std::size_t i = 0; i < transferred.moves.size(); ++i) {
    EXPECT_TRUE(std::isnan(transferred.moves[i].reference_mm));
    EXPECT_EQ(std::isnan(transferred.moves[i].moving_mm), transferred.ligaments.fibres[i].bundle == "LCL");
  }
}

TEST(TransferredLigaments, known_end)
{
  const TemplateJoint joint = prepare::generic_template();
  Copy copy = copy_of(joint, 1.0);
  const model::Fibre& first = joint.joint.ligaments.fibres.front();
  const geometry::NearestSurface bone(copy.bones.surfaces.femur.bone);
  const auto transferred_end = [&](const Eigen::Vector3d& p_mm) {
    copy.bones.known_ends = {{first.name, p_mm, {}}};
    return transferred_ligaments(joint, copy.fit, copy.bones).ligaments.fibres.front().reference_mm;
  };
  const geometry::SurfacePoint own = bone.nearest(first.reference_mm);
  // 8 mm along the surface from the fit's, on it, 1.5 mm and 6 mm outside.
  const geometry::SurfacePoint on = bone.nearest(own.p_mm + 8.0 * bone.normal(own.triangle).unitOrthogonal());
  const Eigen::Vector3d outward = bone.normal(on.triangle);
  ASSERT_GT((on.p_mm - first.reference_mm).norm(), 4.0);
  EXPECT_EQ(transferred_end(on.p_mm), on.p_mm);
  EXPECT_EQ(transferred_end(on.p_mm + 1.5 * outward), on.p_mm + 1.5 * outward);
  const Eigen::Vector3d outside_mm = on.p_mm + 6.0 * outward, placed_mm = transferred_end(outside_mm);
  EXPECT_NEAR(bone.nearest(placed_mm).distance_mm, own.distance_mm, 0.2);
  EXPECT_LT((placed_mm - on.p_mm).norm(), 4.0);
  copy.bones.surfaces.femur.bone = {};
  EXPECT_EQ(transferred_end(outside_mm), outside_mm);
}

geometry::BoneSurfaces patella_at(const TemplateJoint& joint, const JointCoordinates& q, double factor)
{
  geometry::BoneSurfaces patella = prepare::surfaces_of(joint.patella->body);
  patella.bone.vertices_mm *= factor;
  patella.bone =
      transformed(patella.bone, follower_pose(q, joint.joint.frame.side, factor * joint.patella->centre_mm));
  return patella;
}

// Known pose and size of the template's own patella, of both sides.
TEST(Kneecap, registered)
{
  JointCoordinates q;
  q << rad_from_deg(25.0), 0.0, rad_from_deg(4.0), -3.0, -12.0, 1.0;
  const TemplateJoint right = prepare::generic_template();
  for (const TemplateJoint& joint : {right, prepare::mirrored(right)}) {
    const Copy copy = copy_of(joint, 1.1);
    const prepare::Kneecap cap =
        registered_kneecap(joint, copy.fit, copy.bones, patella_at(joint, q, 1.1), "patella.stl");
    for (Eigen::Index k = 0; k < 3; ++k) {
      EXPECT_NEAR(deg_from_rad(cap.scanned(k)), deg_from_rad(q(k)), 1.0) << k;
      EXPECT_NEAR(cap.scanned(k + 3), q(k + 3), 0.5) << k;
    }
    EXPECT_LT((cap.scale - Eigen::Vector3d::Constant(1.1)).norm(), 0.03);
    EXPECT_LT(cap.residual_mm, 0.3);
    const std::vector<model::Fibre>& own = joint.patella->ligaments.fibres;
    ASSERT_EQ(cap.ligaments.fibres.size(), own.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
      EXPECT_LT((cap.ligaments.fibres[i].reference_mm - 1.1 * own[i].reference_mm).norm(), 0.5);
      EXPECT_LT((cap.ligaments.fibres[i].moving_mm - 1.1 * own[i].moving_mm).norm(), 1.0);
    }
  }
}

// What is no patella: a bone, a patella of another size or behind the knee.
TEST(Kneecap, refused)
{
  const TemplateJoint joint = prepare::generic_template();
  const Copy copy = copy_of(joint, 1.0);
  const auto registered = [&](const geometry::BoneSurfaces& patella) {
    return registered_kneecap(joint, copy.fit, copy.bones, patella, "patella.stl");
  };
  JointCoordinates behind = JointCoordinates::Zero();
  behind(3) = -80.0;
  EXPECT_THROW(registered({joint.fibula, {}}), InputError);
  EXPECT_THROW(registered(patella_at(joint, JointCoordinates::Zero(), 2.5)), InputError);
  EXPECT_THROW(registered(patella_at(joint, behind, 1.0)), InputError);
}

// Moved until it touches a trochlea that is 3 mm nearer.
TEST(Kneecap, fitted_to_the_femur)
{
  const TemplateJoint joint = prepare::generic_template();
  Copy copy = copy_of(joint, 1.0);
  const prepare::Kneecap own = fitted_kneecap(joint, copy.fit, copy.bones);
  for (Mesh* mesh : {&copy.bones.surfaces.femur.bone, &copy.bones.surfaces.femur.cartilage})
    mesh->vertices_mm.col(0).array() -= 3.0;
  const prepare::Kneecap moved = fitted_kneecap(joint, copy.fit, copy.bones);
  EXPECT_NEAR(own.gap_mm, 0.2, 0.1);
  EXPECT_NEAR(moved.gap_mm, 0.2, 0.1);
  EXPECT_NEAR(own.centre_mm.x() - moved.centre_mm.x(), 3.0, 0.2);
  EXPECT_TRUE(std::isnan(own.residual_mm));
}

// On the generic knee the nearest line of the quadriceps ends 31 mm from the axis at 90 degrees.
TEST(Kneecap, lines_end_outside_their_cylinders)
{
  TemplateJoint joint = prepare::generic_template();
  const Copy copy = copy_of(joint, 1.0);
  const auto radius_mm = [&](double given_mm) {
    for (model::Wrap& wrap : joint.patella->ligaments.wraps) wrap.radii_mm.head<2>().setConstant(given_mm);
    return fitted_kneecap(joint, copy.fit, copy.bones).ligaments.wraps.front().radii_mm.x();
  };
  EXPECT_GT(radius_mm(40), 24.0);
  EXPECT_LT(radius_mm(40), 31.0);
  EXPECT_EQ(radius_mm(24), 24.0);
}

TEST(TemplateJoint, mirrored_twice)
{
  const TemplateJoint joint = prepare::generic_template(), twice = mirrored(mirrored(joint));
  EXPECT_EQ(joint.knee.surfaces.tibia.bone.vertices_mm, twice.knee.surfaces.tibia.bone.vertices_mm);
  EXPECT_EQ(joint.joint.ligaments.fibres[3].moving_mm, twice.joint.ligaments.fibres[3].moving_mm);
  EXPECT_EQ(mirrored(joint).joint.frame.side, Side::left);
  EXPECT_GT(joint.fibula.triangles.rows(), 0);
}

using testing::ElementsAre, testing::HasSubstr, testing::IsEmpty, testing::StartsWith;

job::Case moved(const Pose& X, double factor = 1.0)
{
  job::Case knee = prepare::generic_template().joint;
  for (Body* body : {&knee.reference, &knee.moving}) {
    for (Part* part : {&body->contact, &body->visual}) {
      part->mesh = transformed(part->mesh, X);
      part->mesh.vertices_mm *= factor;
    }
  }
  return knee;
}

Pose turned(const Eigen::Matrix3d& R)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  return X;
}

TEST(FrameWarnings, ARightFrameHasNone)
{
  EXPECT_THAT(frame_warnings(moved(turned(rotation_y(rad_from_deg(15.0))))), IsEmpty());
}

TEST(FrameWarnings, wrong_frames)
{
  EXPECT_THAT(frame_warnings(moved(Pose::Identity(), 0.1)),
              ElementsAre(HasSubstr("frame.unit: the bones have the size of a knee in cm")));
  EXPECT_THAT(frame_warnings(moved(turned(rotation_y(rad_from_deg(90.0))))),
              ElementsAre(HasSubstr("frame: the bones are turned by")));
  Pose X = Pose::Identity();
  X.translation().x() = 40.0;
  EXPECT_THAT(frame_warnings(moved(X)), ElementsAre(HasSubstr("frame.origin: 40 mm")));
  job::Case left = moved(Pose::Identity());
  left.frame.side = Side::left;
  EXPECT_THAT(frame_warnings(left), ElementsAre(HasSubstr("side: the bones are those of a right knee")));
}

TEST(FrameWarnings, no_knee)
{
  job::Case other = moved(turned(rotation_y(rad_from_deg(90.0))));
  other.joint = "other";
  EXPECT_THAT(frame_warnings(other), IsEmpty());
  job::Case half = moved(turned(rotation_y(rad_from_deg(90.0))));
  half.moving.contact.mesh = {};
  half.moving.contact.component.clear();
  EXPECT_THAT(frame_warnings(half), IsEmpty());
}

TEST(JobText, IsAJobWithItsComponents)
{
  prepare::JobDescription description;
  description.title = "Anna \"A\"";
  description.side = Side::left;
  description.reference = {{"femur", "bone", true, -1.25}};
  description.moving = {{"tibia", "bone"}, {"meniscus_1", "meniscus", false}};
  description.has_wraps = true;
  description.scanned = ClinicalCoordinates{};
  description.scanned->flexion_rad = rad_from_deg(19.04);
  EXPECT_THAT(job_text(description), testing::HasSubstr("# In the scan: flexion 19, varus 0,"));
  const job::Job job = job::parse_job("knee.toml", job_text(description));
  EXPECT_EQ(job.title, "Anna \"A\"");
  EXPECT_EQ(job.side, Side::left);
  EXPECT_EQ(job.reference.components[0].file, "femur.stl");
  EXPECT_DOUBLE_EQ(job.reference.components[0].inset_mm, -1.25);
  EXPECT_FALSE(job.moving.components[1].has_contact);
  EXPECT_TRUE(job.is_varus_free);
  EXPECT_EQ(job.grid.flexion_deg.size(), 19U);
  EXPECT_EQ(job.ligaments->wraps_file, "wraps.json");
  description.X_scan_reference = Pose(Eigen::Translation3d(1, 2, 3.5));
  description.scan_space = "RAS";
  const job::Job in_scan = job::parse_job("knee.toml", job_text(description));
  EXPECT_EQ(core::rows_at(in_scan.document.root, "scan.X_scan_reference"),
            (std::vector<std::vector<double>>{{1, 0, 0, 1}, {0, 1, 0, 2}, {0, 0, 1, 3.5}}));
  EXPECT_EQ(core::text_at(in_scan.document.root, "scan.space"), "RAS");
  description.has_ligaments = false;
  EXPECT_FALSE(job::parse_job("knee.toml", job_text(description)).ligaments.has_value());
}

TEST(LigamentFiles, AreReadBackAsTheyWere)
{
  model::Ligaments ligaments;
  model::Wrap ellipsoid{"e", model::WrapShape::ellipsoid, BodyIndex::moving};
  ellipsoid.radii_mm = {30, 18, 12};
  ellipsoid.X_body_wrap.linear() = rotation_x(0.3) * rotation_y(-0.7) * rotation_z(2.0);
  ellipsoid.X_body_wrap.translation() = Eigen::Vector3d(1, -34.6, 5);
  model::Wrap cylinder{"c", model::WrapShape::cylinder, BodyIndex::reference};
  cylinder.radii_mm = {18, 18, 250};
  ligaments.wraps = {ellipsoid, cylinder};
  ligaments.fibres = {{"MCL1", "MCL", {1, 2, 3}, {4, 5, 6}, 500, 30.75, 0},
                      {"A", "ACL", {-1, 0.1, 3}, {4, 5, -6}, 1640, 31, -1}};
  const std::vector<job::FibreJob> fibres =
      job::read_ligament_table("l.csv", prepare::ligament_table(ligaments, "a comment"));
  ASSERT_EQ(fibres.size(), 2U);
  EXPECT_EQ(fibres[1].moving_native_mm, ligaments.fibres[1].moving_mm);
  EXPECT_EQ(fibres[0].bundle, "MCL");
  EXPECT_EQ(fibres[0].wrap, "e");
  EXPECT_EQ(fibres[1].wrap, "");
  EXPECT_DOUBLE_EQ(*fibres[0].slack_length_mm, 30.75);
  const std::vector<model::Wrap> wraps =
      job::read_wraps("w.json", prepare::wraps_text(ligaments), {"femur", "tibia"});
  ASSERT_EQ(wraps.size(), 2U);
  EXPECT_TRUE(wraps[0].X_body_wrap.isApprox(ellipsoid.X_body_wrap, 1e-12));
  EXPECT_EQ(wraps[0].body, BodyIndex::moving);
  EXPECT_TRUE(wraps[0].radii_mm.isApprox(ellipsoid.radii_mm));
  EXPECT_TRUE(wraps[1].radii_mm.isApprox(cylinder.radii_mm));
}

}  // namespace vrda::template_joint_test
