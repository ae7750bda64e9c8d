// Writes the pictures of a study, for comparison by eye.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/display/display.h"
#include "io/exr/writer.h"
#include "renderer/statistics/reference_error.h"
#include "renderer/statistics/study/folder.h"
#include "renderer/statistics/study/renderer.h"

namespace emberline {

class StudyPictures {
 public:
  // The width and height in `frame` must be those of the rendered frame.
  StudyPictures(const StudyFolder& folder, const RenderOptions& frame, const Rect& crop);

  static constexpr const char* kReferenceExr = "pictures/reference.exr";
  static constexpr const char* kReferencePng = "pictures/reference.png";
  // Returns the file names of the pictures of the method with this id. The files need not exist.
  static StudyMethod::Pictures names(const std::string& id);
  bool exist(const std::string& id) const;

  // Writes the EXR (channels R, G, B, A and samples), the PNG and the FLIP picture. Throws
  // RenderError.
  void write(const std::string& id, const StudyPicture& picture,
             const ReferencePicture& reference) const;
  // Writes the mean of the halves and sets the file names in `out`. The EXR has a layer `velocity`
  // if `motion` is given (StudyRenderer::render_motion()).
  void write_reference(const ReferencePicture& reference,
                       const std::optional<std::vector<float>>& motion, StudyReference* out) const;

 private:
  void write_png(const std::string& name, std::vector<float> rgba) const;
  ExrHeader header(std::vector<PictureChannel> channels) const;

  const StudyFolder& folder_;
  RenderOptions frame_;
  Rect crop_;
  std::shared_ptr<const DisplayTransform> transform_;
};

}  // namespace emberline
