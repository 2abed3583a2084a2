#include "guide/dials.hpp"

#include <gtest/gtest.h>

namespace vrda::dials_test {

Task task_of(TaskKind kind, std::size_t n_dials)
{
  Task task;
  task.kind = kind;
  for (std::size_t k = 0; k < n_dials; ++k) task.dials.push_back({"d", "px", 10.0, 0.0, 1000.0, 0.25});
  return task;
}

std::vector<double> after(const Task& task, std::initializer_list<KeyPress> presses)
{
  Dials dials(task);
  for (const KeyPress& press : presses) dials.press(press);
  return {dials.values().begin(), dials.values().end()};
}

TEST(GuideDials, KeysChangeTheFirstAndTheSecond)
{
  const Task two = task_of(TaskKind::sides, 2), cross = task_of(TaskKind::point, 2);
  const Task one = task_of(TaskKind::number, 1);
  using Values = std::vector<double>;
  EXPECT_EQ(after(two, {{Key::right}}), (Values{10.25, 10.0}));
  EXPECT_EQ(after(two, {{Key::left}, {Key::left}}), (Values{9.5, 10.0}));
  EXPECT_EQ(after(two, {{Key::up}}), (Values{10.0, 10.25}));
  EXPECT_EQ(after(two, {{Key::down, true}}), (Values{10.0, 7.5}));
  // A cross moves up when y decreases.
  EXPECT_EQ(after(cross, {{Key::up}}), (Values{10.0, 9.75}));
  EXPECT_EQ(after(cross, {{Key::down}}), (Values{10.0, 10.25}));
  EXPECT_EQ(after(one, {{Key::right, false, true}, {Key::up}, {Key::down}}), Values{35.0});
  EXPECT_EQ(after(one, {{Key::left, false, true}}), Values{0.0});
  EXPECT_EQ(after(task_of(TaskKind::look, 0), {{Key::left}, {Key::up}}), Values{});
}

TEST(GuideDials, OfManyUpAndDownSelect)
{
  Dials dials(task_of(TaskKind::grid, 8));
  EXPECT_EQ(dials.selected(), 0u);
  dials.press({Key::down});
  dials.press({Key::right, true});
  EXPECT_EQ(dials.selected(), 1u);
  EXPECT_EQ(dials.values()[1], 12.5);
  dials.press({Key::up});
  dials.press({Key::up});
  EXPECT_EQ(dials.selected(), 7u);
  dials.press({Key::down});
  EXPECT_EQ(dials.selected(), 0u);
}

TEST(GuideDials, ManyStepsLeaveNoDust)
{
  Dials dials(task_of(TaskKind::number, 1));
  for (int k = 0; k < 1000; ++k) dials.press({Key::right});
  for (int k = 0; k < 1000; ++k) dials.press({Key::left});
  EXPECT_EQ(dials.values()[0], 10.0);
}

TEST(GuideDials, ATurnOfThePotentiometerIsTwoHundredSteps)
{
  Dials dials(task_of(TaskKind::number, 1));
  double time_s = 0.0;
  const auto hold = [&](int count) {
    for (int k = 0; k < 500; ++k) dials.turn(count, time_s += 0.01);
  };
  // The initial position has no effect.
  hold(200);
  EXPECT_EQ(dials.values()[0], 10.0);
  hold(200 + 1023 / 2);
  EXPECT_EQ(dials.values()[0], 10.0 + 100 * 0.25);
  // The potentiometer continues from the value set by a key.
  dials.press({Key::right});
  hold(200 + 1023 / 2);
  EXPECT_EQ(dials.values()[0], 35.25);
  hold(200);
  EXPECT_EQ(dials.values()[0], 10.25);
}

}  // namespace vrda::dials_test
