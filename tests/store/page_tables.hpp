/// The tables of the pages in schemas/, generated from the registries.
#pragma once

#include <string>

#include "store/motion_model.hpp"

namespace vrda::test {

/// `page` with each table after a line `<!-- table GROUP -->` generated from the registry's rows below GROUP,
/// of the motion model or (`is_trace`) the trace.
std::string with_tables(const std::string& page, bool is_trace);

}  // namespace vrda::test
