// The settings of the pixel filter. Does not include the filters.
#pragma once

#include <string_view>

namespace emberline {

inline constexpr std::string_view kDefaultFilter = "blackman-harris";  // of filter_table()

}  // namespace emberline
