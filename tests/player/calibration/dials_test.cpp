#include "calibration/dials.hpp"

#include <gtest/gtest.h>

#include "player/calibration/trial.hpp"

namespace vrda::calibration::dials_test {

const test::PlainKind plain({.name = "plain"}), cross({.name = "cross", .is_cross = true});

Task task_of(std::size_t n_dials, const TaskKind& kind = plain)
{
  Task task;
  task.kind = &kind;
  for (std::size_t k = 0; k < n_dials; ++k) task.dials.push_back({"d", "px", 10.0, 0.0, 1000.0, 0.25});
  return task;
}

std::vector<double> after(const Task& task, std::initializer_list<view::KeyPress> presses)
{
  Dials dials(task);
  for (const view::KeyPress& press : presses) dials.press(press);
  return {dials.values().begin(), dials.values().end()};
}

TEST(CalibrationDials, KeysChangeTheFirstAndTheSecond)
{
  const Task one = task_of(1), two = task_of(2), at = task_of(2, cross);
  using Values = std::vector<double>;
  EXPECT_EQ(after(two, {{view::Key::right}}), (Values{10.25, 10.0}));
  EXPECT_EQ(after(two, {{view::Key::left}, {view::Key::left}}), (Values{9.5, 10.0}));
  EXPECT_EQ(after(two, {{view::Key::up}}), (Values{10.0, 10.25}));
  EXPECT_EQ(after(two, {{view::Key::down, true}}), (Values{10.0, 7.5}));
  // A cross moves up when y decreases.
  EXPECT_EQ(after(at, {{view::Key::up}}), (Values{10.0, 9.75}));
  EXPECT_EQ(after(at, {{view::Key::down}}), (Values{10.0, 10.25}));
  EXPECT_EQ(after(one, {{view::Key::right, false, true}, {view::Key::up}, {view::Key::down}}), Values{35.0});
  EXPECT_EQ(after(one, {{view::Key::left, false, true}}), Values{0.0});
  EXPECT_EQ(after(task_of(0), {{view::Key::left}, {view::Key::up}}), Values{});
}

TEST(CalibrationDials, OfManyUpAndDownSelect)
{
  Dials dials(task_of(8));
  EXPECT_EQ(dials.selected(), 0u);
  dials.press({view::Key::down});
  dials.press({view::Key::right, true});
  EXPECT_EQ(dials.selected(), 1u);
  EXPECT_EQ(dials.values()[1], 12.5);
  dials.press({view::Key::up});
  dials.press({view::Key::up});
  EXPECT_EQ(dials.selected(), 7u);
  dials.press({view::Key::down});
  EXPECT_EQ(dials.selected(), 0u);
}

TEST(CalibrationDials, ManyStepsAccumulateNoRoundingError)
{
  Dials dials(task_of(1));
  for (int k = 0; k < 1000; ++k) dials.press({view::Key::right});
  for (int k = 0; k < 1000; ++k) dials.press({view::Key::left});
  EXPECT_EQ(dials.values()[0], 10.0);
}

TEST(CalibrationDials, ATurnOfThePotentiometerIsTwoHundredSteps)
{
  Dials dials(task_of(1));
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
  dials.press({view::Key::right});
  hold(200 + 1023 / 2);
  EXPECT_EQ(dials.values()[0], 35.25);
  hold(200);
  EXPECT_EQ(dials.values()[0], 10.25);
}

TEST(CalibrationDials, FollowThePointer)
{
  using Values = std::vector<double>;
  const auto dragged = [](const Task& task, const DialDrag& drag) {
    Dials dials(task);
    dials.drag(drag);  // without a press
    dials.begin_drag();
    dials.drag({{500.0, 500.0}, drag.is_second});
    dials.drag(drag);  // counts from the press
    return Values(dials.values().begin(), dials.values().end());
  };
  EXPECT_EQ(dragged(task_of(2, cross), {{3.1, -4.0}}), (Values{13.0, 6.0})) << "steps of a quarter";
  EXPECT_EQ(dragged(task_of(2, cross), {{10.0, 20.0}, false, true}), (Values{11.0, 12.0})) << "a tenth";
  Task line = task_of(1);
  EXPECT_EQ(dragged(line, {{7.0, 3.0}}), Values{17.0});
  line.is_row = true;
  EXPECT_EQ(dragged(line, {{7.0, 3.0}}), Values{13.0}) << "a row moves vertically";
  EXPECT_EQ(dragged(task_of(2), {{7.0, 3.0}}), (Values{17.0, 10.0}));
  EXPECT_EQ(dragged(task_of(2), {{7.0, 3.0}, true}), (Values{10.0, 17.0}));
  EXPECT_EQ(dragged(task_of(2, cross), {{0.0, 0.0}}), (Values{10.0, 10.0})) << "back at the press";
  Task size = task_of(1);
  size.dials[0].unit = "mm";
  EXPECT_EQ(dragged(size, {{8.0, 0.0}}), Values{12.0}) << "a step a pixel";
}

}  // namespace vrda::calibration::dials_test
