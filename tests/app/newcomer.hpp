/// A job of a generated knee in files, which tests spoil in one way each.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <map>
#include <sstream>

#include "app/scenes.hpp"
#include "core/text.hpp"
#include "support/messages.hpp"

namespace vrda::newcomer_test {

namespace fs = std::filesystem;

inline constexpr const char* sound_job = R"(title = "My knee"
joint = "knee"
side = "right"
[frame]
unit = "mm"
origin = [0, 0, 0]
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
[[moving.component]]
name = "meniscus_medial"
file = "meniscus_medial.stl"
[[moving.component]]
name = "meniscus_lateral"
file = "meniscus_lateral.stl"
[push]
delta = [0, 1, 0]
[ligaments]
fibres = "ligaments.csv"
[grid]
flexion = { from = 0, to = 90, step = 10 }
varus = { from = -9, to = 9, step = 3 }
[smooth]
degrees = [3]
)";

// The files of a generated knee in the folder of the job.
struct Folder {
  test::Scratch scratch;
  fs::path job = scratch.write("my-knee.toml", sound_job);

  Folder()
  {
    EXPECT_EQ(test::run_vrda({"shape", "knee", "--ligaments", "-o", scratch.path().string()}).exit_code, 0);
  }
  fs::path file(const std::string& name) const { return scratch.path() / name; }
  void set(const std::string& from, const std::string& to) const { test::edit(job, from, to); }

  void scale_mesh(const std::string& name, float factor) const
  {
    std::string bytes = test::read_bytes(file(name));
    for (std::size_t at = 84; at < bytes.size(); at += 50) {
      for (std::size_t k = 3; k < 12; ++k) {
        float value = 0;
        std::memcpy(&value, bytes.data() + at + 4 * k, 4);
        value *= factor;
        std::memcpy(bytes.data() + at + 4 * k, &value, 4);
      }
    }
    scratch.write(name, bytes);
  }
  void scale_meshes(float factor) const
  {
    for (const char* name : {"femur.stl", "tibia.stl", "meniscus_medial.stl", "meniscus_lateral.stl"})
      scale_mesh(name, factor);
  }
  // Edits the numbers of the mesh's corners, each axis in turn; a number of a shared corner only once.
  void change_mesh(const std::string& name, const std::function<float(float, int)>& changed) const
  {
    std::string bytes = test::read_bytes(file(name));
    std::map<std::array<float, 3>, std::array<float, 3>> known;
    for (std::size_t at = 84; at < bytes.size(); at += 50) {
      for (std::size_t corner = 1; corner < 4; ++corner) {
        std::array<float, 3> p{};
        std::memcpy(p.data(), bytes.data() + at + 12 * corner, 12);
        const auto [found, is_new] = known.emplace(p, p);
        for (int axis = 0; is_new && axis < 3; ++axis)
          found->second.at(static_cast<std::size_t>(axis)) =
              changed(p.at(static_cast<std::size_t>(axis)), axis);
        std::memcpy(bytes.data() + at + 12 * corner, found->second.data(), 12);
      }
    }
    scratch.write(name, bytes);
  }
  // Edits columns of the fibres whose name begins with `prefix`; a row that becomes empty is removed.
  using Row = std::map<std::string, std::string>;
  void change_fibres(const std::string& prefix, const std::function<void(Row&)>& change) const
  {
    std::istringstream lines(test::text_of(file("ligaments.csv")));
    std::vector<std::string> columns;
    std::string text;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("#")) continue;
      std::vector<std::string> fields;
      std::istringstream row(line);
      for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
      if (columns.empty()) columns = fields;
      Row values;
      for (std::size_t k = 0; k < columns.size(); ++k)
        values[columns[k]] = k < fields.size() ? fields[k] : "";
      if (fields != columns && values["name"].starts_with(prefix)) change(values);
      if (values.empty()) continue;
      for (const std::string& column : columns)
        text += values[column] + (column == columns.back() ? "\n" : ",");
    }
    scratch.write("ligaments.csv", text);
  }
  // Multiplies a column of fibres.
  void scale_fibres(const std::string& prefix, const std::string& column, double factor) const
  {
    change_fibres(prefix, [&](Row& row) { row[column] = shortest_decimal(factor * std::stod(row[column])); });
  }
  // Replaces the table by one fibre.
  void one_fibre(const std::string& values) const
  {
    scratch.write(
        "ligaments.csv",
        "name,bundle,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,moving_y_mm,moving_z_mm,"
        "stiffness_n," +
            values);
  }
};

struct Mistake {
  const char* name;
  std::function<void(const Folder&)> make;
  int exit_code;
  const char* key;      // where the message has a key of its own
  test::Values values;  // of what was found, and of the remedy
};

/// `vrda check` must end with the exit code, and a single line must name all values.
inline void expect_answer(const Mistake& mistake)
{
  const Folder folder;
  mistake.make(folder);
  const test::Ended ended = test::run_vrda({"check", folder.job.string()});
  EXPECT_EQ(ended.exit_code, mistake.exit_code) << ended.err;
  EXPECT_THAT(ended.out + ended.err,
              test::has_line(test::Message{mistake.key, mistake.values, ended.exit_code == 0}));
}

}  // namespace vrda::newcomer_test
