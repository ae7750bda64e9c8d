// The filter of a study's denoised methods.
#pragma once

#include "renderer/core/rect.h"
#include "renderer/statistics/study/renderer.h"

namespace emberline {

// Of a whole frame with the channels of `denoising`: leaves R G B A samples of the denoised
// picture, and the error that the filter expects of it; adds the filter's time. On the calling
// thread's arena.
void denoise_picture(const Rect& crop, StudyPicture* picture);

}  // namespace emberline
