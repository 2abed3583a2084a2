/// The tables of the pages in schemas/, made from the registries.
#pragma once

#include <string>

#include "store/motion_model.hpp"

namespace vrda::test {

/// `page` with each table that follows a line `<!-- table GROUP -->` made of the rows of the motion model's
/// registry below GROUP, or the trace's where `is_trace`.
std::string with_tables(const std::string& page, bool is_trace);

}  // namespace vrda::test
