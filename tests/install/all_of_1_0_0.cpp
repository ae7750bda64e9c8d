// Uses the whole interface of 1.0.0, with its sizes and signatures: all_of_1_0_0 SCENE MATERIAL
// FOLDER. Built against the header of 1.0.0, this program must run with every later 1.y. It must
// also compile against later headers.
#include <emberline/emberline.h>

#include <cstdio>
#include <string>

namespace em = emberline::api;

namespace {

int g_failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s: does not hold\n", what);
  ++g_failures;
}

template <typename Error, typename Work>
void expect_error(const Work& work, const char* what) {
  try {
    work();
    expect(false, what);
  } catch (const Error&) {
  }
}

void use_settings(const em::Settings& settings) {
  em::Settings copy(settings), other;
  other = copy;
  const em::Settings moved = std::move(copy);
  expect(moved.get("spp") == "4" && other.get("spp") == "4", "settings are copied and moved");
  bool driver = false;
  for (const em::Settings::Help& row : em::Settings::help()) {
    driver = driver || (row.name == "driver" && !row.type.empty() && !row.help.empty() &&
                        !row.values.empty() && !row.of_scene);
  }
  expect(driver, "the settings' help");
  expect_error<em::InputError>([&] { other.read("/no/file.json"); }, "a file of settings");
  expect_error<em::UsageError>([&] { other.set("spp", "none"); }, "a wrong setting");
}

em::Picture use_scene(const char* file, const std::string& material, const em::Settings& settings) {
  em::Resources resources;
  resources.threads = 1;
  resources.memory_bytes = uint64_t(1) << 30;
  resources.load_timeout_s = 60.0;
  em::Scene first(file, settings, resources, {});
  em::Scene scene = std::move(first);
  expect(!scene.materials().empty() && !scene.cameras().empty() && scene.lights().empty(), "names");
  scene.approximated();
  scene.ignored();
  scene.edit(R"({"emberline_edits": 1, "lights": [{"kind": "material", "name": ")" + material +
             R"(", "on": false}]})");
  const float sky[6] = {1, 1, 1, 1, 1, 1};
  scene.edit(R"({"emberline_edits": 1})", em::Scene::Environment{sky, 2, 1});
  scene.edit(R"({"emberline_edits": 1})");
  uint64_t seen = 0;
  std::stop_source stop, give_up;
  const em::Picture picture = em::render(
      scene, settings, resources, stop.get_token(),
      [&](const em::Progress& now) {
        seen = now.samples;
        expect(now.width == 16 && now.height == 8, "progress");
      },
      give_up.get_token());
  expect(em::render(scene, settings, {}).values == picture.values, "defaults are braces");
  expect(seen == picture.samples, "progress counts samples");
  return picture;
}

void use_pictures(const em::Picture& picture, const std::string& folder) {
  expect(picture.width == 16 && picture.height == 8 && picture.x == 0 && picture.y == 0 &&
             picture.frame_width == 16 && picture.frame_height == 8,
         "places");
  expect(picture.samples == 4 * 16 * 8 && picture.rays > picture.samples && picture.complete &&
             picture.non_finite_samples == 0 && !picture.error_estimate,
         "counts");
  em::write_picture(folder + "/a.exr", picture);
  em::write_picture(folder + "/a.png", picture, 1.0);
  const uint8_t bytes[3] = {1, 2, 3};
  em::write_picture(folder + "/b.png", bytes, 1, 1, 3);
  const em::Picture back = em::read_picture(folder + "/a.exr", {}, {});
  std::vector<float> rgb;
  for (int y = 0; y < back.height; ++y) {
    for (int x = 0; x < back.width; ++x) {
      for (int c = 0; c < 3; ++c) rgb.push_back(picture.pixel(x, y)[c]);
    }
  }
  const em::Comparison same = em::compare(rgb.data(), rgb.data(), 16, 8, 0.5);
  expect(same.mse == 0 && same.rmse == 0 && same.relmse == 0 && same.relmse_epsilon > 0 &&
             same.relmse_trimmed == 0 && same.signed_bias == 0 && same.psnr > 90 &&
             same.ssim == 1 && same.flip == 0 && same.max_abs == 0 && same.different_pixels == 0 &&
             same.non_finite == 0,
         "a picture is equal to itself");
  expect(em::flip(rgb.data(), rgb.data(), 16, 8).size() == 128, "flip");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  int messages = 0;
  em::set_log([&](em::Message kind, std::string_view text) {
    messages += kind == em::Message::kError || !text.empty();
  });
  try {
    em::Settings settings;
    settings.set("size", "16x8").set("spp", "4").set("driver", "bisection");
    use_settings(settings);
    use_pictures(use_scene(argv[1], argv[2], settings), argv[3]);
    expect_error<em::Error>([] { em::Scene("/no/scene.glb"); }, "a scene that is not there");
  } catch (const em::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
  em::set_log({});
  expect(em::version().starts_with("1."), "the version");
  std::printf("%d.%d with %s\n", EMBERLINE_VERSION_MAJOR, EMBERLINE_VERSION_MINOR,
              em::version().c_str());
  return g_failures > 0;
}
