#include "renderer/statistics/study/pictures.h"

#include <algorithm>

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
  const std::string begin = "pictures/" + id;
  return {.exr = begin + ".exr", .png = begin + ".png", .flip_png = begin + "_flip.png"};
}

bool StudyPictures::exist(const std::string& id) const {
  const StudyMethod::Pictures pictures = names(id);
  const std::string files[] = {pictures.exr, pictures.png, pictures.flip_png};
  return std::ranges::all_of(files, [&](const std::string& name) {
    return file_identity(folder_.path(name)).has_value();
  });
}

ExrHeader StudyPictures::header(std::vector<PictureChannel> channels) const {
  return {.width = frame_.width,
          .height = frame_.height,
          .data_window = crop_,
          .channels = std::move(channels),
          .attributes = {{"emberline:command", frame_.command_line}}};
}

void StudyPictures::write_png(const std::string& name, std::vector<float> rgba) const {
  write_display_image(folder_.path(name), crop_, transform_, frame_.transparent, rgba);
}

void StudyPictures::write(const std::string& id, const StudyPicture& picture,
                          const ReferencePicture& reference) const {
  const StudyMethod::Pictures files = names(id);
  const ExrHeader exr = header({{"R"}, {"G"}, {"B"}, {"A"}, {"samples", ChannelType::kUint}});
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

void StudyPictures::write_reference(const ReferencePicture& reference,
                                    const std::optional<std::vector<float>>& motion,
                                    StudyReference* out) const {
  out->exr = kReferenceExr;
  out->png = kReferencePng;
  std::vector<PictureChannel> channels = {{"R"}, {"G"}, {"B"}};
  if (motion) channels.insert(channels.end(), {{"velocity.X"}, {"velocity.Y"}});
  std::vector<float> values, rgba;
  for (size_t i = 0; i < reference.mean().rgb.size() / 3; ++i) {
    const float* rgb = &reference.mean().rgb[3 * i];
    values.insert(values.end(), rgb, rgb + 3);
    if (motion) values.insert(values.end(), {(*motion)[2 * i], (*motion)[2 * i + 1]});
    rgba.insert(rgba.end(), rgb, rgb + 3);
    rgba.push_back(1);
  }
  write_exr_file(folder_.path(out->exr), header(std::move(channels)), values);
  write_png(out->png, std::move(rgba));
}

}  // namespace emberline
