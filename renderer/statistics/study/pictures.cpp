#include "renderer/statistics/study/pictures.h"

#include "io/files/input_file.h"
#include "renderer/output/flip_picture.h"
#include "renderer/output/rgb_file.h"

namespace emberline {

StudyPictures::StudyPictures(const StudyFolder& folder, const RenderOptions& frame,
                             const Rect& crop)
    : folder_(folder),
      frame_(frame),
      crop_(crop),
      transform_(std::make_shared<DisplayTransform>(frame.display)) {}

StudyMethod::Pictures StudyPictures::names(const std::string& id) {
  StudyMethod::Pictures pictures;
  pictures.exr = "pictures/" + id + ".exr";
  pictures.png = "pictures/" + id + ".png";
  pictures.flip_png = "pictures/" + id + "_flip.png";
  return pictures;
}

bool StudyPictures::exist(const std::string& id) const {
  const StudyMethod::Pictures pictures = names(id);
  for (const std::string& name : {pictures.exr, pictures.png, pictures.flip_png}) {
    if (!file_identity(folder_.path(name))) return false;
  }
  return true;
}

ExrHeader StudyPictures::header() const {
  ExrHeader header;
  header.width = frame_.width;
  header.height = frame_.height;
  header.data_window = crop_;
  header.attributes = {{"emberline:command", frame_.command_line}};
  return header;
}

void StudyPictures::write_png(const std::string& name, std::vector<float> rgba) const {
  write_display_image(folder_.path(name), crop_, transform_, frame_.transparent, rgba);
}

void StudyPictures::write(const std::string& id, const StudyPicture& picture,
                          const ReferencePicture& reference) const {
  const StudyMethod::Pictures files = names(id);
  ExrHeader exr = header();
  for (const char* name : {"R", "G", "B", "A"}) exr.channels.push_back({name});
  exr.channels.push_back({"samples", ChannelType::kUint});
  write_exr_file(folder_.path(files.exr), exr, picture.values);
  std::vector<float> rgba;
  rgba.reserve(picture.values.size() / kStudyPictureChannels * 4);
  for (size_t i = 0; i < picture.values.size(); i += kStudyPictureChannels) {
    rgba.insert(rgba.end(), &picture.values[i], &picture.values[i] + 4);
  }
  write_png(files.png, std::move(rgba));
  const RgbImage rgb = to_rgb_image(picture.values, kStudyPictureChannels, crop_);
  write_flip_picture(folder_.path(files.flip_png), rgb, reference.flip(rgb),
                     non_finite_pixels(rgb, reference.mean()));
}

void StudyPictures::write_reference(const ReferencePicture& reference, StudyReference* out) const {
  out->exr = kReferenceExr;
  out->png = kReferencePng;
  ExrHeader exr = header();
  for (const char* name : {"R", "G", "B"}) exr.channels.push_back({name});
  write_exr_file(folder_.path(out->exr), exr, reference.mean().rgb);
  std::vector<float> rgba;
  for (size_t i = 0; i < reference.mean().rgb.size(); i += 3) {
    rgba.insert(rgba.end(), &reference.mean().rgb[i], &reference.mean().rgb[i] + 3);
    rgba.push_back(1);
  }
  write_png(out->png, std::move(rgba));
}

}  // namespace emberline
