/// The rows of an index by several processes: the HDF5 library takes one thread a process.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cluster/index.hpp"

namespace vrda {

/// A row as text, and back: the same row to the bit.
std::string text_of_row(const IndexRow& row);
IndexRow row_of_text(const std::string& text);

/// row_of(k) for k from 0 to n_rows - 1, in that order, by at most `n_processes` copies of this process,
/// which must have no other thread. Throws InternalError when one of them does not end as it should.
std::vector<IndexRow> rows_by_processes(std::size_t n_rows,
                                        const std::function<IndexRow(std::size_t)>& row_of, int n_processes);

}  // namespace vrda
