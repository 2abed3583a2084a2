// The template's own knee, deformed, as a subject whose attachments are known.
#include <gmock/gmock.h>

#include <random>

#include "core/units.hpp"
#include "prepare/carried_ligaments.hpp"
#include "prepare/slack_lengths.hpp"

namespace vrda::deformed_knee_test {

// A scale an axis within 12 %, and waves of 1 mm.
struct Deformation {
  explicit Deformation(unsigned seed)
  {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    for (Eigen::Index k = 0; k < 3; ++k) {
      scale[k] = uniform(0.88, 1.12);
      for (Eigen::Index i = 0; i < 3; ++i) wave_per_mm(k, i) = uniform(-0.1, 0.1);
      phase[k] = uniform(0.0, 2.0 * pi);
    }
  }

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_mm) const
  {
    constexpr double amplitude_mm = 1.0;
    return scale.cwiseProduct(p_mm) +
           amplitude_mm * ((wave_per_mm * p_mm + phase).array().sin() / std::sqrt(3.0)).matrix();
  }

  Mesh operator()(Mesh mesh) const
  {
    for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v)
      mesh.vertices_mm.row(v) = (*this)(Eigen::Vector3d(mesh.vertices_mm.row(v))).transpose();
    mesh.normals = vertex_normals(mesh);
    return mesh;
  }

  Eigen::Vector3d scale, phase;
  Eigen::Matrix3d wave_per_mm;
};

registration::BoneSurfaces deformed(const registration::BoneSurfaces& bone, const Deformation& deform)
{
  return {deform(bone.bone), deform(bone.cartilage)};
}

registration::BoneSurfaces in_frame(const registration::BoneSurfaces& bone, const Pose& X_scan_bone)
{
  const Pose X = X_scan_bone.inverse();
  return {transformed(bone.bone, X), transformed(bone.cartilage, X)};
}

// Attachments come back within 2 mm on average, and the knee moves.
TEST(DeformedKnee, ItsAttachmentsAreFoundAndItMoves)
{
  const prepare::TemplateJoint joint = prepare::generic_template();
  for (const unsigned seed : {1U}) {
    SCOPED_TRACE(seed);
    const Deformation deform(seed);
    const registration::KneeSurfaces scan{deformed(joint.knee.surfaces.femur, deform),
                                          deformed(joint.knee.surfaces.tibia, deform)};
    const registration::KneeFit fit = fit_knee(scan, joint.knee);
    ASSERT_EQ(fit.side, Side::right);
    const prepare::SubjectBones bones{
        {in_frame(scan.femur, fit.X_scan_femur), in_frame(scan.tibia, fit.X_scan_tibia)},
        transformed(deform(joint.fibula), fit.X_scan_tibia.inverse())};
    const prepare::CarriedLigaments carried = carried_ligaments(joint, fit, bones);
    double sum_mm = 0.0;
    const std::vector<ligament::Fibre>& own = joint.joint.ligaments.fibres;
    for (std::size_t i = 0; i < own.size(); ++i) {
      const ligament::Fibre& fibre = carried.ligaments.fibres[i];
      sum_mm += (fit.X_scan_femur * fibre.reference_mm - deform(own[i].reference_mm)).norm();
      sum_mm += (fit.X_scan_tibia * fibre.moving_mm - deform(own[i].moving_mm)).norm();
    }
    const double mean_mm = sum_mm / (2.0 * static_cast<double>(own.size()));
    EXPECT_LT(mean_mm, 2.0);
    load::Case subject = joint.joint;
    subject.reference.contact.mesh =
        transformed(deform(subject.reference.contact.mesh), fit.X_scan_femur.inverse());
    subject.moving.contact.mesh =
        transformed(deform(subject.moving.contact.mesh), fit.X_scan_tibia.inverse());
    subject.ligaments = carried.ligaments;
    const prepare::SlackResult slack = prepare::set_slack_lengths(subject, joint.joint, 2);
    EXPECT_EQ(slack.loads.n_solved, slack.loads.n_flexions);
    RecordProperty("mean_mm_" + std::to_string(seed), std::to_string(mean_mm));
  }
}

}  // namespace vrda::deformed_knee_test
