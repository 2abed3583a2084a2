#include "job/mesh_file.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "support/refusal.hpp"

namespace vrda::ply_file_test {

// Two triangles with other elements and properties, in any of the formats.
struct Ply {
  std::string format = "ascii";
  std::string text;

  Ply& header(const std::string& lines)
  {
    text += lines + "\n";
    return *this;
  }
  Ply& put(const std::string& type, double value)
  {
    const bool is_big = format == "binary_big_endian";
    const bool is_real = type == "double" || type == "float";
    if (format == "ascii") {
      text += (is_real ? std::to_string(value) : std::to_string(static_cast<int>(value))) + " ";
    } else if (type == "double") {
      append(std::bit_cast<std::uint64_t>(value), 8, is_big);
    } else if (type == "float") {
      append(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4, is_big);
    } else {
      append(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)), type == "uchar" ? 1 : 2, is_big);
    }
    return *this;
  }

 private:
  void append(std::uint64_t bits, int n_bytes, bool is_big)
  {
    for (int k = 0; k < n_bytes; ++k)
      text += static_cast<char>(bits >> (8 * (is_big ? n_bytes - 1 - k : k)) & 0xffU);
  }
};

std::string sheet(const std::string& format)
{
  Ply ply{format, ""};
  ply.header("ply\nformat " + format + " 1.0\ncomment two triangles\nobj_info none");
  ply.header("element camera 1\nproperty list uchar short view");
  ply.header("element vertex 4\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red");
  ply.header("property float nx\nproperty float ny\nproperty float nz");
  ply.header(
      "element face 3\nproperty list uchar float texcoord\nproperty list uchar short "
      "vertex_index\nend_header");
  ply.put("uchar", 2).put("short", -1).put("short", 9);
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 0.015625}) {
      ply.put("double", x).put("double", y).put("double", -2.5).put("uchar", 99);
      ply.put("float", 0).put("float", 0).put("float", 1);
    }
  }
  for (const auto& face : {std::array{0, 2, 1}, std::array{1, 2, 3}}) {
    ply.put("uchar", 2).put("float", 0).put("float", 1).put("uchar", 3);
    for (const int corner : face) ply.put("short", corner);
  }
  // An edge, which is not a face.
  ply.put("uchar", 0).put("uchar", 2).put("short", 0).put("short", 1);
  return ply.text;
}

TEST(PlyFile, every_format)
{
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    SCOPED_TRACE(format);
    const job::RawMesh mesh = job::read_ply("a.ply", sheet(format));
    Points wanted(4, 3);
    wanted << 0, 0, -2.5, 0, 0.015625, -2.5, 1, 0, -2.5, 1, 0.015625, -2.5;
    EXPECT_EQ(mesh.vertices, wanted);
    EXPECT_EQ(mesh.normals, Points(Eigen::RowVector3d(0, 0, 1).replicate(4, 1)));
    EXPECT_EQ(mesh.corner, (std::vector<std::int32_t>{0, 2, 1, 1, 2, 3}));
    EXPECT_EQ(mesh.size, (std::vector<std::int32_t>{3, 3}));
  }
}

// A strip turns every second triangle; a negative index begins another one.
TEST(PlyFile, strips)
{
  const std::string bytes =
      "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n2 2 0\n3 4 5 6\n9 0 1 2 3 -1 1 3 2 5\n";
  const job::RawMesh mesh = job::read_ply("a.ply", bytes);
  EXPECT_EQ(mesh.size, std::vector<std::int32_t>(5, 3));
  EXPECT_EQ(mesh.corner, (std::vector<std::int32_t>{4, 5, 6, 0, 1, 2, 2, 1, 3, 1, 3, 2, 2, 3, 5}));
}

TEST(PlyFile, elements_come_in_any_order)
{
  const std::string bytes =
      "ply\ncomment knee\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
      "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(job::read_ply("a.ply", bytes).corner, (std::vector<std::int32_t>{0, 1, 2}));
}

TEST(PlyFile, cut_anywhere)
{
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const std::string whole = sheet(format);
    const std::size_t all_but_the_end = whole.size() - (std::string(format) == "ascii" ? 2 : 0);
    for (std::size_t size = 0; size < all_but_the_end; ++size) {
      SCOPED_TRACE(size);
      EXPECT_EQ(test::input_error([&] { job::read_ply("a.ply", whole.substr(0, size)); }).file, "a.ply");
    }
  }
}

TEST(PlyFile, RefusesWhatItCannotMean)
{
  const std::string head = "ply\nformat ascii 1.0\n";
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string body = "end_header\n0 0 0 1 0 0 0 1 0\n";
  struct Row {
    std::string bytes, field, found;
  };
  const std::vector<Row> rows{
      {head + vertex + vertex + face, "line 7", "\"vertex\""},
      {head + vertex + "element face 1\nproperty list float int vertex_indices\n", "line 8",
       "list float int"},
      {head + vertex + "element face 1\nproperty list uchar float vertex_indices\n" + body, "header",
       "vertex_indices"},
      {head + vertex + face + body + "-1", "face 0", "damaged"},
      {head + vertex + face + body + "3 0 1 1.5", "face 0", "damaged"},
      {head + vertex + face + body + "3 0 1 99999999999", "face 0", "damaged"},
      {head + vertex + face + body + "4000000000 0 1 2", "face 0", "damaged"},
      {head + vertex + face + "element trifans 1\nproperty list uchar int vertex_index\n" + body +
           "3 0 1 2 3 0 1 2",
       "header", "\"trifans\""},
      {head + vertex + face + "property list uchar int vertex_index\n" + body + "3 0 1 2 3 0 1 2", "header",
       "two lists"},
      {head + vertex + face + body + "3 0 1 2\n3 2 1 0\n", "header", "8 bytes after"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.bytes);
    const InputError::Facts facts = test::input_error([&] { job::read_ply("a.ply", row.bytes); });
    EXPECT_THAT(facts, test::refuses({"a.ply", row.field, row.found}));
  }
}

TEST(PlyFile, empty_elements)
{
  // 1000 elements with 15,000,000 empty rows each: a loop over the rows would take a minute.
  std::string bytes = "ply\nformat ascii 1.0\n";
  for (int k = 0; k < 1000; ++k) bytes += "element e" + std::to_string(k) + " 15000000\n";
  bytes += "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n";
  bytes += "element face 0\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_EQ(job::read_ply("a.ply", bytes).vertices.rows(), 0);
}

}  // namespace vrda::ply_file_test
