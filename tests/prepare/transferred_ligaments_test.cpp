#include "prepare/knee_landmarks.hpp"

#include <gmock/gmock.h>

namespace vrda::transferred_ligaments_test {

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

TEST(TemplateJoint, mirrored_twice)
{
  const TemplateJoint joint = prepare::generic_template(), twice = mirrored(mirrored(joint));
  EXPECT_EQ(joint.knee.surfaces.tibia.bone.vertices_mm, twice.knee.surfaces.tibia.bone.vertices_mm);
  EXPECT_EQ(joint.joint.ligaments.fibres[3].moving_mm, twice.joint.ligaments.fibres[3].moving_mm);
  EXPECT_EQ(mirrored(joint).joint.frame.side, Side::left);
  EXPECT_GT(joint.fibula.triangles.rows(), 0);
}

}  // namespace vrda::transferred_ligaments_test
