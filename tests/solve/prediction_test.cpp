#include "solve/prediction.hpp"

#include <gtest/gtest.h>

namespace vrda {
namespace {

Contact contact(const Eigen::Vector3d& point, const Eigen::Vector3d& direction)
{
  return {point, point, direction.normalized(), 0.0, {}};
}

TEST(PredictRotation, ACoupleTurnsAboutItsMiddle)
{
  // Reactions along +X at z = +1 and along -X at z = -1: torque about +Y.
  const RotationPrediction r =
      predict_rotation({contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {-1, -1, 0})});
  EXPECT_EQ(r.sign, 1);
  EXPECT_EQ(r.centre_mm, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(predict_rotation({contact({0, 0, 1}, {-1, -1, 0}), contact({0, 0, -1}, {1, -1, 0})}).sign, -1);
}

TEST(PredictRotation, FewerThanTwoContactsAndParallelPushesNeverTurn)
{
  EXPECT_EQ(predict_rotation({}).sign, 0);
  EXPECT_EQ(predict_rotation({contact({0, 0, 1}, {1, -1, 0})}).sign, 0);
  // Both push along +X: every point qualifies, their mean does not pass the verification.
  EXPECT_EQ(predict_rotation({contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {1, -1, 0})}).sign, 0);
}

TEST(PredictRotation, QualifyingPointsBecomeTheCentre)
{
  // Three pushes of which only the first and the last point see the others turn one way (thesis figure 7).
  const std::vector<Contact> contacts = {contact({0, 0, 0}, {1, -1, 0}), contact({0, 0, 3}, {1, -1, 0}),
                                         contact({1, 0, 0}, {0, -1, -1})};
  const RotationPrediction r = predict_rotation(contacts);
  EXPECT_EQ(r.sign, 1);
  EXPECT_EQ(r.centre_mm, Eigen::Vector3d(0.5, 0, 0));
}

TEST(PredictRotation, NormalsThroughOneAxisNeverTurn)
{
  std::vector<Contact> contacts;
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(1, 0, 0.3), Eigen::Vector3d(-0.4, 0.2, 1),
                                   Eigen::Vector3d(0.1, 0, -1), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
    contacts.push_back(contact(p, Eigen::Vector3d(0, -2, 0) - p));
  }
  EXPECT_EQ(predict_rotation(contacts).sign, 0);
}

TEST(PredictRotation, ReactionsActWhereTheirNormalsWereTaken)
{
  // On the reference the points would see a couple; where the reactions act they pass through one axis.
  std::vector<Contact> contacts = {contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {-1, -1, 0})};
  for (Contact& c : contacts) c.application_mm = Eigen::Vector3d::Zero();
  EXPECT_EQ(predict_rotation(contacts).sign, 0);
  EXPECT_EQ(mean_point(contacts), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictTranslation, MeansOverTheFourHalfAxesRemoveDuplicates)
{
  // Thesis figure 9: duplicates of one direction do not make the result longer.
  const Contact push_x = contact({0, 0, 0}, {1, -1, 0});
  const Contact push_z = contact({0, 0, 0}, {0, -1, 1});
  EXPECT_EQ(predict_translation({push_x}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(predict_translation({push_x, push_x, push_x}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(predict_translation({push_x, push_z}), Eigen::Vector3d(1, 0, 1));
  EXPECT_EQ(predict_translation({push_x, contact({1, 1, 1}, {-3, -1, 0})}), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictTranslation, SlopesDoNotMatterAndNormalsAlongDeltaContributeNone)
{
  EXPECT_EQ(predict_translation({contact({0, 0, 0}, {0.01, -1, 0})}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(predict_translation({contact({0, 0, 0}, {0, -1, 0})}), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(predict_translation({}), Eigen::Vector3d(0, 0, 0));
}

}  // namespace
}  // namespace vrda
