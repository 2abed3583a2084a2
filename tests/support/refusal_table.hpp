/// Refusals of a program as rows of a data file. Each row spoils one input; the program must end with exit
/// code 2 and one message that names file, field, found and wanted as its last line, write nothing on
/// standard output, and change no file.
///
/// The file is a list of groups. A group has "name", "rows", and any key of a row as the rows' default:
///   scene    name of a function of the test that makes input files which a text cannot hold
///   files    {name: content} of the group; content is a text, or a list of texts, {"u8", "u32" or "f32":
///            numbers} (little-endian) and {"repeat": text, "times": number}, with a number from 0 for its #
///   write    the same of the row; a file that is there is replaced
///   file     the file that the message names, or its end, or an option; default: the target
///   target   the file that `text`, `edit`, `cut` and `append` change; default: `file`
///   text     content of the target
///   edit     [from, to], or a list of such pairs: replaces the first occurrence of each text, which must
///   exist cut      number of bytes of the target that remain; from its end if negative append   text after
///   the target remove   a file that is absent command  words of the command line, run in the folder of the
///   files; "{file}" is `target` add      words after those of `command` field    of the message, with its
///   line ("line 3, name") or without found    values in the message, one or a list wanted   the same writes
///   files that the program may create; default: none name     of the row; default: its number and `field`
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// A row with the defaults of its group filled in.
struct RefusalRow {
  std::string name;                                        ///< letters, digits and _: the name of a test
  std::string scene;                                       ///< empty: none
  std::vector<std::pair<std::string, std::string>> files;  ///< name and bytes, after those of the scene
  std::string target;
  std::vector<std::pair<std::string, std::string>> edits;  ///< from and to, in order
  long cut_bytes = 0;                                      ///< 0: not cut
  std::string appended;
  std::string removed;
  std::vector<std::string> words;  ///< arguments of the program
  std::vector<std::string> writes;
  Refusal refusal;
  int exit_code = 0;
  Values names;
};

/// The rows of a data file. Throws std::exception for a row with an unknown key or without a command.
std::vector<RefusalRow> read_refusals(const std::filesystem::path& file);

/// Functions that write the files of a scene into a folder, by name.
using Scenes = std::map<std::string, std::function<void(const Scratch&)>>;

/// Makes the input of the row in a folder of its own, runs the program and expects the refusal.
void expect_row_refused(const RefusalRow& row, const std::filesystem::path& program, const Scenes& scenes);

/// The same, and expects the exit code and the line that names the values.
void expect_row_answered(const RefusalRow& row, const std::filesystem::path& program, const Scenes& scenes);

/// The name of a row, for INSTANTIATE_TEST_SUITE_P.
inline std::string name_of_row(const testing::TestParamInfo<RefusalRow>& row)
{
  return row.param.name;
}

inline void PrintTo(const RefusalRow& row, std::ostream* out)
{
  *out << row.name;
}

}  // namespace vrda::test
