/// An index of three cases: each kind of column, a missing value, a text that needs quotes.
#pragma once

#include "store/index_table.hpp"

namespace vrda::test {

store::IndexTable sample_index();

}  // namespace vrda::test
