#include "store/solved_cells.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "core/files.hpp"
#include "store/h5_file.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::index_table_test {

using testing::ElementsAre;

template <typename Value>
std::vector<Value> read_back(const store::H5Reader& reader, const std::string& path, std::size_t n)
{
  std::vector<Value> values(n);
  reader.read(path, std::span<Value>(values));
  return values;
}

TEST(IndexTable, TheFileGivesBackEveryColumn)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "index.h5";
  const store::IndexTable table = test::sample_index();
  write_atomically(path, {store::index_bytes(path, table)});
  const store::H5Reader reader({path, test::read_bytes(path)});
  EXPECT_THAT(reader.rejected(), testing::IsEmpty());
  EXPECT_THAT(read_back<std::string>(reader, "/case", 3), ElementsAre("a_rest", "a_search", "b_rest"));
  EXPECT_THAT(read_back<std::string>(reader, "/remark", 3),
              ElementsAre("", "a \"quoted\", longer\nremark", ""));
  EXPECT_THAT(read_back<std::int8_t>(reader, "/status", 3), ElementsAre(0, 2, 3));
  const std::vector<double> gaps = read_back<double>(reader, "/gap_mm", 3);
  EXPECT_EQ(gaps[0], 0.125);
  EXPECT_TRUE(std::isnan(gaps[1]));
  EXPECT_EQ(reader.attribute("/gap_mm", "units")->texts, std::vector<std::string>{"mm"});
  EXPECT_EQ(reader.attribute("/status", "flag_meanings")->texts,
            std::vector<std::string>{"done partial failed missing"});
  EXPECT_EQ(reader.attribute("/", "format")->texts, std::vector<std::string>{store::index_format_name});
  EXPECT_EQ(reader.dataset_info("/case").scale_name, "case");
  for (const std::string column : {"/remark", "/status", "/gap_mm"})
    EXPECT_TRUE(reader.is_attached(column, 0, "/case")) << column;
}

TEST(IndexTable, EqualTablesGiveEqualBytes)
{
  EXPECT_EQ(store::index_bytes("a.h5", test::sample_index()),
            store::index_bytes("b.h5", test::sample_index()));
}

TEST(IndexTable, CsvHasWordsEmptyFieldsAndQuotes)
{
  EXPECT_EQ(store::index_csv(test::sample_index()),
            "case,status,remark,gap_mm\n"
            "a_rest,done,,0.125\n"
            "a_search,failed,\"a \"\"quoted\"\", longer\nremark\",\n"
            "b_rest,missing,,-1e-05\n");
}

}  // namespace vrda::index_table_test
