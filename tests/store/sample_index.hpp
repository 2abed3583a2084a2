/// An index of three cases: each kind of column, an answer that is not there, a text that wants quotes.
#pragma once

#include "store/index_table.hpp"

namespace vrda::test {

IndexTable sample_index();

}  // namespace vrda::test
