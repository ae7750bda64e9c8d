// Measures a session behind a window: the latency from an edit to its first complete picture, also
// while dragging; the latency from a change of exposure to the next picture; how long the owner's
// thread waits; and how much of the driver's speed remains. This is not a test. tests/bench/results
// has the figures.
//
//   view_bench SCENE [--env FILE] [--look-from X,Y,Z --look-at X,Y,Z] [--size WxH] [--edits N]
//       [--driver NAME] [--idle SECONDS] [--repetitions N]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "bench/bench_frame.h"
#include "bench/frame_benches.h"
#include "renderer/core/errors.h"
#include "renderer/engine/render_sink.h"
#include "renderer/film/film.h"
#include "support/edits.h"
#include "support/session_owner.h"

namespace emberline::bench {
namespace {

struct Options {
  RenderOptions frame;
  int edits = 40;
  double idle_s = 6.0;
  int repetitions = 3;
};

void line(const std::string& name, std::vector<double> values, const char* unit = "ms",
          double scale = 1e3) {
  if (values.empty()) return;
  std::ranges::sort(values);
  const double p95 = values[size_t(0.95 * double(values.size() - 1) + 0.5)];
  fmt::print("{:<46}{:>8.2f} {}   95 %: {:.2f}, {:.2f} to {:.2f}, {} times\n", name,
             scale * spread(values).median, unit, scale * p95, scale * values.front(),
             scale * values.back(), values.size());
}

using test::SessionOwner;

using MakeEdit = std::function<void(SceneEdits&, int)>;

struct EditKind {
  const char* name;
  MakeEdit make;
};

std::vector<EditKind> edit_kinds(const ListedScene& scene) {
  std::vector<EditKind> kinds;
  kinds.push_back({"camera", [&scene](SceneEdits& edits, int i) {
                     const Mat44d& m = scene.camera.to_world;
                     const Vec3d from(m[3][0] + 1e-3 * scene.radius * i, m[3][1], m[3][2]);
                     edits.camera.look_from = from;
                     edits.camera.look_at = scene.center;
                   }});
  if (scene.outline.environment) {
    kinds.push_back({"environment, intensity", [](SceneEdits& edits, int i) {
                       edits.lights.clear();
                       test::light(edits, EditedLight::kEnvironment, -1).intensity =
                           1.0f + 0.01f * float(i % 50);
                     }});
    kinds.push_back({"environment, rotation", [](SceneEdits& edits, int i) {
                       edits.environment.rotation_degrees = float(i % 360);
                     }});
  }
  if (!scene.outline.materials.empty()) {
    kinds.push_back({"material, roughness", [](SceneEdits& edits, int i) {
                       edits.materials.clear();
                       test::material(edits, 0).roughness = 0.2f + 0.01f * float(i % 50);
                     }});
  }
  return kinds;
}

// Measures single edits, at moments that do not depend on the frame's progress.
void measure_edits(const Options& options, SessionOwner& owner) {
  RenderSession& session = owner.session;
  std::vector<double> all, all_waits, all_coverage;
  const auto scene = session.scene();
  for (const EditKind& kind : edit_kinds(*scene)) {
    std::vector<double> seconds;
    for (int i = 0; i < options.edits; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100 + 137 * i % 500));
      SceneEdits edits = session.edits();
      kind.make(edits, i + 1);
      const double start = wall_clock();
      session.set_edits(edits);
      all_waits.push_back(wall_clock() - start);
      owner.wait(10, [&] { return owner.shows(session.edit()); });
      seconds.push_back(wall_clock() - start);
      all_coverage.push_back(session.picture()->progress.completion);
    }
    line(std::string("first picture: ") + kind.name, seconds);
    all.insert(all.end(), seconds.begin(), seconds.end());
  }
  line("first picture: all edits", all);
  line("  pixels that have a sample by then", all_coverage, "%", 100);
  line("  set_edits(), on the owner's thread", all_waits);
}

// Makes sixty edits per second, as a mouse drag does.
void measure_drag(const Options& options, SessionOwner& owner) {
  RenderSession& session = owner.session;
  const auto scene = session.scene();
  const EditKind camera = edit_kinds(*scene).front();
  std::vector<double> posted, latency, coverage;
  uint64_t first_edit = 0, seen = 0, serial = 0;
  const auto look = [&] {
    const auto picture = session.picture();
    if (picture->serial == serial || picture->edit < first_edit || !picture->filled) return;
    serial = picture->serial;
    if (picture->edit <= seen) return;
    coverage.push_back(picture->progress.completion);
    for (uint64_t edit = std::max(seen + 1, first_edit); edit <= picture->edit; ++edit) {
      latency.push_back(wall_clock() - posted[edit - first_edit]);
    }
    seen = picture->edit;
  };
  const int steps = 4 * options.edits;
  const double start = wall_clock();
  for (int i = 0; i < steps; ++i) {
    SceneEdits edits = session.edits();
    camera.make(edits, i + 1);
    session.set_edits(edits);
    if (i == 0) first_edit = session.edit();
    posted.push_back(wall_clock());
    const double next = start + (i + 1) / 60.0;
    owner.wait(next - wall_clock(), [&] {
      look();
      return wall_clock() >= next;
    });
  }
  const double dragged_s = wall_clock() - start;
  const size_t pictures = coverage.size();
  owner.wait(10, [&] {
    look();
    return seen >= session.edit();
  });
  line("drag: picture of each step or a later one", latency);
  line("  pixels that have a sample by then", coverage, "%", 100);
  fmt::print("{:<46}{:>8.1f} a second\n", "  pictures", double(pictures) / dragged_s);
}

void measure_display(const Options& options, SessionOwner& owner) {
  RenderSession& session = owner.session;
  std::vector<double> seconds, waits;
  for (int i = 0; i < options.edits; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ViewSettings settings = session.settings();
    settings.display.exposure = 0.1f * float(i % 10 + 1);
    const uint64_t serial = session.picture()->serial;
    const double start = wall_clock();
    session.set_settings(settings);
    waits.push_back(wall_clock() - start);
    owner.wait(10, [&] { return session.picture()->serial > serial; });
    seconds.push_back(wall_clock() - start);
  }
  line("exposure: next picture", seconds);
  line("  set_settings(), on the owner's thread", waits);
}

// Changes a light's intensity during a frame with light groups: first thirty times per second, then
// occasionally, while no picture is pending.
void measure_lights(const Options& options) {
  ViewSettings settings;
  settings.render = options.frame;
  settings.light_groups = true;
  SessionOwner owner(settings);
  owner.open(options.frame.scene);
  RenderSession& session = owner.session;
  if (!session.scene()->outline.environment) return;
  owner.wait(3, [] { return false; });
  size_t anew = 0;
  float intensity = 1.0f;
  const auto edit = [&] {
    SceneEdits edits;
    test::light(edits, EditedLight::kEnvironment, -1).intensity = intensity += 0.01f;
    const uint64_t samples = session.picture()->samples;
    const double start = wall_clock();
    session.set_edits(edits);
    owner.wait(10, [&] { return owner.shows(session.edit()); });
    const double seconds = wall_clock() - start;
    if (session.picture()->samples < samples) ++anew;
    return seconds;
  };
  std::vector<double> dragged, single;
  for (int i = 0; i < options.edits; ++i) {
    dragged.push_back(edit());
    owner.wait(1.0 / 30 - dragged.back(), [] { return false; });
  }
  for (int i = 0; i < options.edits; ++i) {
    owner.wait(0.25 + 1e-3 * (137 * i % 500), [] { return false; });
    single.push_back(edit());
  }
  line("light groups: intensity, next picture", dragged);
  line("  … the first one after a while", single);
  fmt::print("  of these, rendered again: {}\n", anew);
}

// Measures how late a sleeping thread wakes up while other threads render.
void measure_wakes(const Options& /*options*/, SessionOwner& /*owner*/) {
  std::vector<double> late;
  for (int i = 0; i < 400; ++i) {
    const double due = wall_clock() + 0.005;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    late.push_back(wall_clock() - due);
  }
  line("a sleeping thread wakes up too late by", late);
}

class NullSink final : public RenderSink {
  void tile_finished(const FilmTile& /*tile*/) override {}
};

// Runs an idle session and the driver alone in turn, for `idle_s` seconds each, and compares their
// samples per second.
void measure_pace(const Options& options, const std::string& driver) {
  RenderOptions frame = options.frame;
  frame.driver = driver;
  const BenchFrame bench(frame);
  const int threads = int(std::max(1u, std::thread::hardware_concurrency()));
  FrameSampling sampling;
  sampling.driver = driver;
  sampling.spp = kViewSamples;
  sampling.adaptive.budget = kViewSamples;
  if (driver == "adaptive") sampling.streams = find_estimator(sampling.adaptive.estimator).streams;
  std::vector<double> ratios;
  for (int i = 0; i < options.repetitions; ++i) {
    double paces[2] = {};
    for (int turn = 0; turn < 2; ++turn) {
      if ((i + turn) % 2 == 0) {
        std::stop_source stop;
        std::thread timer([&] {
          std::this_thread::sleep_for(std::chrono::duration<double>(options.idle_s));
          stop.request_stop();
        });
        NullSink null_sink;
        const FrameRun run = bench.run(threads, sampling, null_sink, stop.get_token());
        timer.join();
        paces[0] = double(run.counters.samples) / run.wall_s;
      } else {
        ViewSettings settings;
        settings.render = frame;
        SessionOwner owner(settings);
        owner.open(frame.scene);
        owner.wait(2 * options.idle_s,
                   [&] { return owner.session.picture()->rendering_s >= options.idle_s; });
        const auto picture = owner.session.picture();
        paces[1] = double(picture->samples) / picture->rendering_s;
      }
    }
    ratios.push_back(paces[1] / paces[0]);
  }
  line("pace of " + driver + " against the driver alone", ratios, "%", 100);
}

// Measures how much longer a bucket frame takes in a session, including the first picture, than
// alone.
void measure_buckets(const Options& options) {
  RenderOptions frame = options.frame;
  frame.driver = "bucket";
  frame.spp = 64;
  const BenchFrame bench(frame);
  const int threads = int(std::max(1u, std::thread::hardware_concurrency()));
  FrameSampling sampling;
  sampling.driver = frame.driver;
  sampling.spp = *frame.spp;
  std::vector<double> ratios;
  for (int i = 0; i < options.repetitions; ++i) {
    double seconds[2] = {};
    for (int turn = 0; turn < 2; ++turn) {
      if ((i + turn) % 2 == 0) {
        NullSink null_sink;
        seconds[0] = bench.run(threads, sampling, null_sink).wall_s;
      } else {
        ViewSettings settings;
        settings.render = frame;
        SessionOwner owner(settings);
        owner.open(frame.scene);
        owner.wait(600, [&] { return owner.finished(); });
        seconds[1] = owner.session.picture()->rendering_s;
      }
    }
    ratios.push_back(seconds[1] / seconds[0]);
  }
  line("a frame of buckets, time against the driver's", ratios, "%", 100);
}

}  // namespace

int run_view_bench(int argc, char** argv) {
  CLI::App app("Times a session behind a window", "view_bench");
  Options options;
  options.frame.driver = kLiveDriver;
  add_frame_options(&app, options.frame);
  app.add_option("--edits", options.edits, "number of edits of each kind")
      ->check(CLI::Range(1, 100000));
  app.add_option("--idle", options.idle_s, "seconds of undisturbed rendering")
      ->check(CLI::Range(0.1, 3600.0));
  app.add_option("--repetitions", options.repetitions, "repetitions of the undisturbed rendering")
      ->check(CLI::Range(0, 1000));
  CLI11_PARSE(app, argc, argv);
  fmt::print("{}  {}x{}\n", options.frame.scene, options.frame.width, options.frame.height);
  {
    ViewSettings settings;
    settings.render = options.frame;
    SessionOwner owner(settings);
    owner.open(options.frame.scene);
    measure_edits(options, owner);
    measure_drag(options, owner);
    measure_display(options, owner);
    measure_wakes(options, owner);
  }
  measure_lights(options);
  if (options.repetitions > 0) {
    for (const char* driver : {"bisection", "adaptive"}) measure_pace(options, driver);
    measure_buckets(options);
  }
  return 0;
}

}  // namespace emberline::bench
