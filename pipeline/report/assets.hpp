/// Files that travel inside the program: page/ of this room and plotly.js.
#pragma once

#include <string_view>

namespace vrda {

std::string_view page_template();   ///< HTML with the places {{title}}, {{style}}, {{plotly_licence}},
                                    ///< {{plotly}}, {{code}}, {{data}}
std::string_view page_style();      ///< CSS
std::string_view page_code();       ///< JavaScript, in one piece
std::string_view plotly_licence();  ///< as a comment of JavaScript
std::string_view plotly_library();  ///< JavaScript, minified

}  // namespace vrda
