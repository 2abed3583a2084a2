/// Sorts many items by a row first: in linear time where few share one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace vrda::inline core {

/// Orders `items` by `row_of(item)`, in [0, n_rows), then by `less`.
template <typename Item, typename RowOf, typename Less>
void sort_by_row(std::vector<Item>& items, std::size_t n_rows, const RowOf& row_of, const Less& less)
{
  std::vector<std::size_t> end(n_rows + 1, 0);
  for (const Item& item : items) ++end[static_cast<std::size_t>(row_of(item)) + 1];
  for (std::size_t row = 1; row <= n_rows; ++row) end[row] += end[row - 1];
  std::vector<Item> sorted(items.size());
  for (const Item& item : items) sorted[end[static_cast<std::size_t>(row_of(item))]++] = item;
  items = std::move(sorted);
  std::size_t begin = 0;
  for (std::size_t row = 0; row < n_rows; ++row) {
    std::sort(items.begin() + static_cast<std::ptrdiff_t>(begin),
              items.begin() + static_cast<std::ptrdiff_t>(end[row]), less);
    begin = end[row];
  }
}

}  // namespace vrda::inline core
