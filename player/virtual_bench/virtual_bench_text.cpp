#include "virtual_bench/truth.hpp"

namespace vrda {
namespace {

constexpr const char* beginning =
    R"(# A bench in numbers, to try and to train the calibration on.
title = "Virtual"
leg = "rigid"
)";

constexpr const char* on_a_stage = R"(head = "stage"

[board]
port = "/tmp/vrda-virtual-board"

[body.leg]
tool = "leg"
)";

constexpr const char* on_the_display = R"(head = "tracker"

[body.leg]
tool = "leg"

[body.head]
tool = "head"
)";

// Fiducials all around the knee, on both bones; the targets between them.
constexpr const char* rest = R"(
[display]
width = 1280
height = 1024
layout = "quarters"
refresh_hz = 60

[tracker]
host = "127.0.0.1"
port = 18944

[calibration]
rectangles = [[250, 0], [300, 150], [350, 300], [400, 450]]  # mm: width, depth

[[calibration.landmarks]]
name = "epicondyles"
model_mm = 82.0

[[calibration.landmarks]]
name = "plateau, across"
model_mm = 76.0

[[calibration.landmarks]]
name = "patella to tuberosity"
model_mm = 68.0

[[calibration.landmarks]]
name = "fibula's head to lateral epicondyle"
model_mm = 64.0

[[calibration.landmarks]]
name = "adductor tubercle to joint line"
model_mm = 52.0

[[calibration.landmarks]]
name = "patella to lateral epicondyle"
model_mm = 71.0
)";

struct Point {
  const char* name;
  const char* mm;
  bool is_target;
};

constexpr Point points[] = {
    {"patella, upper pole", "[44, 34, 2]", false},  {"patella, lower pole", "[46, -8, 4]", false},
    {"medial epicondyle", "[2, 12, -44]", false},   {"lateral epicondyle", "[-2, 10, 42]", false},
    {"tibial tuberosity", "[40, -52, 6]", false},   {"fibula's head", "[-30, -38, 46]", false},
    {"medial plateau", "[14, -26, -42]", false},    {"lateral plateau", "[16, -28, 40]", false},
    {"adductor tubercle", "[-18, 30, -42]", false}, {"thigh, front", "[38, 74, 0]", false},
    {"thigh, back", "[-56, 66, -6]", false},        {"calf, back", "[-58, -64, 4]", false},
    {"thigh, inside", "[0, 60, -40]", true},        {"thigh, outside", "[4, 52, 42]", true},
    {"shin, inside", "[20, -66, -30]", true},       {"hollow of the knee", "[-44, -2, 2]", true}};

std::string made_text(HeadKind head)
{
  std::string text = std::string(beginning) + (head == HeadKind::stage ? on_a_stage : on_the_display) + rest;
  for (const Point& point : points) {
    text += std::string("\n[[calibration.point]]\nname = \"") + point.name + "\"\nmm = " + point.mm +
            (point.is_target ? "\ntarget = true\n" : "\n");
  }
  return text;
}

}  // namespace

const std::string& virtual_bench_text(HeadKind head)
{
  static const std::string stage = made_text(HeadKind::stage), tracker = made_text(HeadKind::tracker);
  return head == HeadKind::stage ? stage : tracker;
}

}  // namespace vrda
