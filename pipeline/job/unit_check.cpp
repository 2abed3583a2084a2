#include "job/unit_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda::job {
namespace {

// From mice to whales; a wrong unit gives a factor of 10 to 1000.
SizeRange possible_sizes(const Job& job)
{
  return {job.joint == "knee" ? 3.0 : 1.0, 3000.0};
}

bool is_within(double size_mm, const SizeRange& sizes)
{
  return size_mm >= sizes.least_mm && size_mm <= sizes.most_mm;
}

std::string three_decimals(double value)
{
  return shortest_decimal(std::round(value * 1000.0) / 1000.0);
}

// The largest mesh file of one object; null if all components are generated.
const ComponentSurvey* largest_file(const BodyJob& body, const ComponentSurvey* survey)
{
  const ComponentSurvey* largest = nullptr;
  for (std::size_t c = 0; c < body.components.size(); ++c) {
    if (body.components[c].generate) continue;
    if (largest == nullptr || diagonal_mm(survey[c].box) > diagonal_mm(largest->box)) largest = &survey[c];
  }
  return largest;
}

}  // namespace

double diagonal_mm(const Box& box)
{
  return (box.max_mm - box.min_mm).norm();
}

SizeRange usual_size_range(const Job& job)
{
  // Menisci are 40 mm long, a whole tibia 450 mm; other joints range from fingers to hips.
  return job.joint == "knee" ? SizeRange{12.0, 800.0} : SizeRange{3.0, 2000.0};
}

std::string suggested_unit(const std::string& given, double size_mm, const SizeRange& sizes)
{
  for (const char* unit : {"mm", "cm", "m"}) {
    if (is_within(size_mm / mm_per_unit(given) * mm_per_unit(unit), sizes)) return unit;
  }
  return "";
}

void check_unit(const Job& job, const std::vector<ComponentSurvey>& survey)
{
  const std::array files{largest_file(job.reference, survey.data()),
                         largest_file(job.moving, survey.data() + job.reference.components.size())};
  for (std::size_t b = 0; b < files.size(); ++b) {
    const ComponentSurvey* file = files.at(b);
    const ComponentSurvey* other = files.at(1 - b);
    if (file == nullptr) continue;
    const FrameJob& frame = frame_of(job, b == 0 ? job.reference : job.moving);
    const std::string key = frame.key + ".unit";
    const double size_mm = diagonal_mm(file->box);
    if (is_within(size_mm, possible_sizes(job))) continue;
    const std::string unit = suggested_unit(frame.unit, size_mm, usual_size_range(job));
    const std::string found = "\"" + frame.unit + "\", in which \"" + file->name + "\" (" + file->source +
                              ") measures " + three_decimals(size_mm) + " mm across";
    std::string wanted = "meshes of a joint in mm, cm or m";
    if (other != nullptr && is_within(diagonal_mm(other->box), usual_size_range(job))) {
      wanted = "all mesh files in one unit: \"" + other->name + "\" measures " +
               three_decimals(diagonal_mm(other->box)) + " mm; convert \"" + file->source + "\" to " +
               frame.unit + (unit.empty() ? "" : ", its size suggests " + unit);
    } else if (!unit.empty()) {
      wanted = key + " = \"" + unit + "\", in which it measures " +
               three_decimals(size_mm / mm_per_unit(frame.unit) * mm_per_unit(unit)) + " mm";
    }
    throw InputError({job.document.source_of(key), key, found, wanted});
  }
}

}  // namespace vrda::job
