// Defaults of the pixel filter's settings, without the filters themselves.
#pragma once

#include <string_view>

namespace emberline {

inline constexpr std::string_view kDefaultFilter = "blackman-harris";  // a name in filter_table()

}  // namespace emberline
