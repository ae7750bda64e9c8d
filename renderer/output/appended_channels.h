// Channels that a file has behind those of the film.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace emberline {

// Makes room for `added` values behind those of each of `count` interleaved pixels, and has
// put(pixel, values) write them; pixels are counted from the last down.
template <typename Put>
void append_channels(size_t count, size_t added, std::vector<float>& pixels, const Put& put) {
  const size_t before = pixels.size() / count, after = before + added;
  pixels.resize(after * count);
  // From the last pixel, so that none is written over before it has moved.
  for (size_t i = count; i-- > 0;) {
    std::copy_backward(&pixels[before * i], &pixels[before * i] + before,
                       &pixels[after * i] + before);
    put(i, &pixels[after * i] + before);
  }
}

}  // namespace emberline
