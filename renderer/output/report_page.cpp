#include "renderer/output/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "renderer/core/file_suffix.h"
#include "renderer/core/readable.h"
#include "renderer/core/setting_names.h"
#include "renderer/engine/process_usage.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/svg_chart.h"

namespace emberline {
namespace {

using Row = std::vector<PageCell>;

// Returns a table of names and values, without a header.
PageTable pair_table(std::vector<Row> rows) { return {"", {{""}, {"", true}}, std::move(rows)}; }

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

std::string summary(const RenderOptions& o, const RenderReport& r) {
  const double pixels = double(r.crop.area());
  return fmt::format("{} x {} pixels, {} samples per pixel, {} in {}. {}", r.crop.width(),
                     r.crop.height(), readable_number(double(r.counters.samples) / pixels, 4),
                     o.driver, readable_seconds(r.times.render_s), readable_local_time());
}

PageFigure encoded_figure(const ByteImage& image, const char* format, const std::string& text,
                          const std::string& caption) {
  const std::string media_type = fmt::format("image/{}", format);
  return {picture_markup(encode_image(image, format, "the report's picture"), media_type,
                         image.width, image.height, text),
          caption};
}

std::string scale_note(const ReportPictures& pictures, const char* how) {
  if (pictures.factor() == 1) return "";
  return fmt::format(" Each pixel here is {} of {} x {} pixels of the frame.", how,
                     pictures.factor(), pictures.factor());
}

void add_stop(HtmlPage& page, const RenderReport& r) {
  if (!r.counters.stopped) return;
  page.warning(
      fmt::format("The {} stopped the render before it was finished; the page shows the picture "
                  "that was written. Pixels have {} to {} samples.",
                  r.stop_cause == PixelStop::kTimeLimit ? "time limit" : "user",
                  readable_count(r.counters.min_samples), readable_count(r.counters.max_samples)));
}

void add_picture(HtmlPage& page, const RenderOptions& o, const RenderReport& r,
                 const ReportPictures& pictures) {
  std::string caption = fmt::format("{} seen by camera \"{}\".", file_name(o.scene), r.camera);
  if (o.crop) {
    caption += fmt::format(" Crop {},{} to {},{} of {} x {}.", r.crop.x0, r.crop.y0, r.crop.x1,
                           r.crop.y1, o.width, o.height);
  }
  if (r.denoise) caption += " Shown before denoising.";
  caption += scale_note(pictures, "the mean");
  page.figures(std::vector{encoded_figure(pictures.picture(), "jpeg", "the picture", caption)});
}

std::string estimate_text(const RenderReport& r) {
  if (!r.error_estimate) return "none, because sampling was uniform";
  return fmt::format("{} ({})", readable_number(*r.error_estimate), r.estimator);
}

std::string denoising_text(const DenoiseReport& denoise) {
  return fmt::format("{} (before: {}); {} of the pixels are unchanged",
                     readable_number(denoise.error_after), readable_number(denoise.error_before),
                     readable_percent(denoise.unchanged_fraction));
}

void add_numbers(HtmlPage& page, const RenderReport& r) {
  const RenderCounters& c = r.counters;
  const double per_second = r.times.render_s > 0 ? 1e-6 / r.times.render_s : 0;
  std::vector<Row> rows = {
      {"Samples", readable_count(c.samples)},
      {"Samples per pixel: minimum, mean, maximum",
       fmt::format("{}, {}, {}", readable_count(c.min_samples),
                   readable_number(double(c.samples) / double(r.crop.area()), 5),
                   readable_count(c.max_samples))},
      {"Wall time: total, rendering",
       fmt::format("{}, {}", readable_seconds(r.times.wall_s), readable_seconds(r.times.render_s))},
      {"Processor time", readable_seconds(r.times.cpu_s)},
      {"Millions of samples and rays per second",
       fmt::format("{}, {}", readable_number(double(c.samples) * per_second),
                   readable_number(double(c.rays.total()) * per_second))},
      {"Peak memory", readable_bytes(peak_rss_bytes())},
      {"Estimated error (RMS of the displayed picture, 0 to 1)", estimate_text(r)},
  };
  if (r.denoise) {
    rows.push_back({"Estimated error of the denoised picture", denoising_text(*r.denoise)});
  }
  page.table(pair_table(std::move(rows)));
}

// Returns the borders of the bars of a histogram. The bars have about the same width or, if
// `logarithmic`, about the same ratio of right to left border. Borders are whole numbers, so that
// every bar covers the counts that it appears to cover.
std::vector<double> bar_borders(uint32_t min, uint32_t max, bool logarithmic) {
  constexpr int kBars = 40;
  std::vector<double> borders = {double(min)};
  const double end = double(max) + 1;
  for (int i = 1; i <= kBars; ++i) {
    const double t = double(i) / kBars;
    const double border =
        std::round(logarithmic ? min * std::pow(end / min, t) : min + (end - min) * t);
    if (border > borders.back()) borders.push_back(border);
  }
  return borders;
}

Markup samples_histogram(const std::map<uint32_t, uint64_t>& pixels) {
  const uint32_t min = std::max(1u, pixels.upper_bound(0)->first), max = pixels.rbegin()->first;
  const bool logarithmic = max > 8 * min;
  Histogram chart;
  chart.title = "Pixels by number of samples";
  chart.x = {"samples per pixel", logarithmic ? AxisScale::kLog : AxisScale::kLinear};
  chart.y = {"pixels"};
  const std::vector<double> borders = bar_borders(min, max, logarithmic);
  auto next = pixels.upper_bound(0);
  for (size_t i = 0; i + 1 < borders.size(); ++i) {
    uint64_t count = 0;
    for (; next != pixels.end() && double(next->first) < borders[i + 1]; ++next) {
      count += next->second;
    }
    chart.bars.push_back({borders[i], borders[i + 1], double(count)});
  }
  return histogram_chart(chart);
}

// Repeats the numbers of the legend as text, because text is more readable on a phone.
std::string map_caption(const ReportPictures::Map& map) {
  const PlaneStatistics s = plane_statistics(map.plane);
  std::string text(map.quantity->summary);
  if (map.quantity->categories || s.values == 0) return text + ".";
  const DisplayUnit unit = display_unit(std::string(map.quantity->unit), s.mean);
  const auto format_value = [&](double value) { return readable_number(unit.factor * value); };
  return fmt::format("{}{}{}: {} to {}, mean {}{}.", text, unit.name.empty() ? "" : ", in ",
                     unit.name, format_value(s.minimum), format_value(s.maximum),
                     format_value(s.mean),
                     map.quantity->rms ? ", root mean square " + format_value(s.rms) : "");
}

void add_samples(HtmlPage& page, const ReportPictures& pictures) {
  page.section("Where the samples went");
  std::vector<PageFigure> figures;
  for (const ReportPictures::Map& map : pictures.maps()) {
    HeatmapStyle style;
    style.judged = pictures.judged();
    if (map.quantity->name != "samples") style.colours = ColourMap::kViridis;
    figures.push_back(encoded_figure(
        draw_quantity(*map.quantity, map.plane, style), "png", std::string(map.quantity->title),
        map_caption(map) + scale_note(pictures, map.quantity->categories ? "one" : "the mean")));
  }
  const std::map<uint32_t, uint64_t> pixels = pictures.pixels_by_samples();
  const uint64_t none = pixels.contains(0) ? pixels.at(0) : 0;
  const size_t kinds = pixels.size() - (none > 0 ? 1 : 0);
  if (kinds > 1) {
    figures.push_back({samples_histogram(pixels),
                       none > 0
                           ? readable_count(none) + " pixels have no samples and are not shown."
                           : "Every pixel is counted."});
  }
  page.figures(figures);
  if (kinds == 0) page.paragraph("No pixel has samples.");
  if (kinds == 1) {
    page.paragraph(
        fmt::format("Every sampled pixel has {} samples.{}", readable_count(pixels.rbegin()->first),
                    none > 0 ? fmt::format(" {} pixels have none.", readable_count(none)) : ""));
  }
  if (figures.size() < 3) {
    page.paragraph(spell_setting_names(
        "Add `aov` variance,time,stop to see error, cost and stop reasons as well."));
  }
}

void add_error_chart(HtmlPage& page, const RenderOptions& o, const RenderReport& r) {
  LineChart chart;
  chart.title = "RMS error of the displayed picture";
  chart.x = {"seconds of rendering", AxisScale::kLog};
  chart.y = {"RMS error (0 to 1)", AxisScale::kLog};
  ChartSeries estimated{"estimated"}, measured{"measured against the reference"};
  for (const PassReport& pass : r.passes) {
    if (pass.error_estimate) estimated.points.push_back({pass.elapsed_s, *pass.error_estimate});
  }
  for (const SnapshotReport& snapshot : r.snapshots) {
    if (snapshot.rmse) measured.points.push_back({snapshot.elapsed_s, *snapshot.rmse});
  }
  if (estimated.points.empty() && measured.points.empty()) {
    page.paragraph(spell_setting_names(
        "The error is unknown: uniform sampling does not estimate it, and there was no "
        "reference. The adaptive driver estimates it after every pass; `snapshots` with "
        "`reference` measures the error of each snapshot."));
    return;
  }
  double first = INFINITY, last = 0;
  for (ChartSeries* series : {&estimated, &measured}) {
    series->style = series == &estimated ? 0 : 1;
    if (series->points.empty()) continue;
    first = std::min(first, series->points.front().x);
    last = std::max(last, series->points.back().x);
    chart.series.push_back(*series);
  }
  if (o.noise_threshold) {
    const double y = double(*o.noise_threshold);
    ChartSeries threshold{
        spell_setting_names("`noise-threshold` per pixel"), {{first, y}, {last, y}}, 4};
    threshold.markers = false;
    chart.series.push_back(threshold);
  }
  page.figures(std::vector<PageFigure>{{line_chart(chart),
                                        "Both scales are logarithmic: an error that falls as 1 / "
                                        "sqrt(time) is a line of slope -1/2."}});
}

// From a longer table, only this many rows are kept. They are evenly spaced and include the last
// row.
constexpr size_t kMaxRows = 24;

template <typename Entry>
std::vector<Entry> subsample_rows(const std::vector<Entry>& all) {
  if (all.size() <= kMaxRows) return all;
  std::vector<Entry> some;
  for (size_t i = 1; i <= kMaxRows; ++i) some.push_back(all[i * all.size() / kMaxRows - 1]);
  return some;
}

std::string number_or_none(const std::optional<double>& value) {
  return value ? readable_number(*value) : "";
}

void add_error(HtmlPage& page, const RenderOptions& o, const RenderReport& r) {
  page.section("Error against time");
  add_error_chart(page, o, r);
  if (r.passes.size() > 1) {
    PageTable table{r.passes.size() > kMaxRows
                        ? fmt::format("{} of {} passes", kMaxRows, r.passes.size())
                        : std::string("Passes"),
                    {{"after"}, {"samples per pixel", true}, {"estimated error", true}},
                    {}};
    for (const PassReport& pass : subsample_rows(r.passes)) {
      table.rows.push_back({readable_seconds(pass.elapsed_s),
                            readable_number(double(pass.samples) / double(r.crop.area()), 4),
                            number_or_none(pass.error_estimate)});
    }
    page.table(table);
  }
  if (r.snapshots.empty()) return;
  PageTable table{"Snapshots",
                  {{"after"},
                   {"file"},
                   {"first pass done", true},
                   {"samples per pixel", true},
                   {"RMSE (displayed)", true},
                   {"MSE", true},
                   {"relMSE", true}},
                  {}};
  for (const SnapshotReport& s : r.snapshots) {
    table.rows.push_back({readable_seconds(s.elapsed_s), s.file, readable_percent(s.completion),
                          readable_number(double(s.samples) / double(r.crop.area()), 4),
                          number_or_none(s.rmse), number_or_none(s.mse),
                          number_or_none(s.rel_mse)});
  }
  page.table(table);
}

void add_times(HtmlPage& page, const RenderTimes& t) {
  page.section("Time");
  PageTable table{"", {{"part"}, {"wall time", true}, {"share", true}}, {}};
  double sum = 0;
  const auto add = [&](const char* part, double seconds) {
    table.rows.push_back({part, readable_seconds(seconds),
                          t.wall_s > 0 ? readable_percent(seconds / t.wall_s) : ""});
  };
  const auto add_part = [&](const char* part, double seconds) {
    add(part, seconds);
    sum += seconds;
  };
  add_part("setup: options, reference, opening the outputs", t.setup_s);
  add_part("loading the scene", t.load_s);
  add_part("building the scene", t.build_s);
  add_part("rendering", t.render_s);
  add_part("writing the remaining output", t.write_s);
  if (t.snapshots_s > 0) add_part("snapshots: copying, writing, measuring", t.snapshots_s);
  add("other", std::max(0.0, t.wall_s - sum));
  add("total", t.wall_s);
  page.table(table);
  std::vector<Row> rows = {
      {"Processor time of the process", readable_seconds(t.cpu_s)},
      {"Processor time of rendering",
       fmt::format("{} ({} threads busy on average)", readable_seconds(t.render_cpu_s),
                   readable_number(t.render_s > 0 ? t.render_cpu_s / t.render_s : 0))}};
  if (t.start_s)
    rows.push_back({"Loading the program (before the times above)", readable_seconds(*t.start_s)});
  if (t.first_sample_s) {
    rows.push_back({"Process start to first samples", readable_seconds(*t.first_sample_s)});
  }
  page.table(pair_table(std::move(rows)));
}

void add_rays(HtmlPage& page, const RenderReport& r) {
  page.section("Rays");
  PageTable table{"", {{""}, {"rays", true}, {"per sample", true}, {"per second", true}}, {}};
  const auto add = [&](const char* kind, uint64_t rays) {
    const auto ratio = [&](double divisor) {
      return divisor > 0 ? readable_number(double(rays) / divisor) : std::string();
    };
    const double per_second = r.times.render_s > 0 ? double(rays) / r.times.render_s : 0;
    table.rows.push_back({kind, readable_count(rays), ratio(double(r.counters.samples)),
                          readable_number(1e-6 * per_second) + " M"});
  };
  add("camera", r.counters.rays.camera);
  add("scattered", r.counters.rays.scatter);
  add("shadow", r.counters.rays.shadow);
  add("total", r.counters.rays.total());
  page.table(table);
}

void add_memory(HtmlPage& page, const RenderReport& r) {
  page.section("Memory");
  page.table(
      pair_table({{"Peak resident memory of the process", readable_bytes(peak_rss_bytes())},
                  {"Geometry", readable_bytes(r.memory.geometry_bytes)},
                  {"Bounding volume hierarchies", readable_bytes(r.memory.bvh_bytes)},
                  {"Textures", readable_bytes(r.memory.texture_bytes)},
                  {"Textures in a temporary file", readable_bytes(r.memory.texture_file_bytes)},
                  {"Film, pictures and the maps on this page", readable_bytes(r.film_bytes)}}));
}

void add_scene(HtmlPage& page, const RenderReport& r) {
  page.section("Scene features");
  page.list(r.features);
  page.section("glTF coverage");
  const auto add = [&](const char* heading, const std::vector<std::string>& entries) {
    page.heading(heading);
    if (entries.empty()) page.paragraph("none");
    page.list(entries);
  };
  add("Extensions honoured", r.coverage.used);
  add("Approximated", r.coverage.approximated);
  add("Ignored", r.coverage.ignored);
}

void add_warnings(HtmlPage& page, const RenderOptions& o, const RenderReport& r) {
  page.section("Warnings and repairs");
  for (const std::string& text : r.warnings) page.warning(text);
  std::vector<Row> rows;
  const auto add = [&rows](const std::string& what, uint64_t count) {
    if (count > 0) rows.push_back({what, {readable_count(count), PageCell::Tone::kBad}});
  };
  add("Degenerate triangles left out", r.repairs.degenerate_triangles);
  add("Triangles with NaN or infinite vertices left out", r.repairs.non_finite_triangles);
  add("Vertices with a NaN or infinite colour, normal, tangent or texture coordinate",
      r.repairs.non_finite_attributes);
  add("Texels that were NaN, infinite or negative", r.repairs.non_finite_texels);
  add("Instances left out because their transform has no inverse", r.repairs.singular_instances);
  add(spell_setting_names("Images replaced by a neutral colour (`lenient`)"),
      r.repairs.replaced_images);
  add("Samples that were NaN or infinite and count as black", r.counters.non_finite_samples);
  add("Rays stopped after too many panes in a row", r.counters.optics.rays_ended_at_panes);
  add("Paths that ignored a solid, because they were inside too many solids at once",
      r.counters.optics.dropped_solids);
  if (const OpticsCounters& optics = r.counters.optics; optics.blocked_by_glass > 0) {
    rows.push_back({"Light samples of lamps and suns blocked by smooth solid glass",
                    fmt::format("{:.3g} %", 100.0 * optics.blocked_fraction())});
  }
  if (const ClampedLight& clamped = r.counters.clamped; clamped.clamps()) {
    rows.push_back({spell_setting_names(
                        fmt::format("Light removed by `clamp-indirect` {:g}", clamped.limit())),
                    fmt::format("{:.3g} %", 100.0 * clamped.fraction())});
  }
  if (rows.empty() && r.warnings.empty()) page.paragraph("none");
  if (!rows.empty()) page.table(pair_table(std::move(rows)));
  if (r.counters.located.empty()) return;
  page.paragraph("Each of these commands replays one such sample:");
  std::string commands;
  for (const NonFiniteSample& sample : r.counters.located) {
    commands += fmt::format("{}{} {} {}", commands.empty() ? "" : "\n", o.command_line,
                            spell_setting_names("`replay`"), replay_arguments(sample, o));
  }
  page.code(commands);
}

void add_settings(HtmlPage& page, const RenderOptions& o, const RenderReport& r) {
  page.section("How to render this frame again");
  page.code(o.command_line);
  std::error_code error;
  const std::string folder = std::filesystem::current_path(error).string();
  if (!error) page.paragraph("Run it in the folder " + folder);
  constexpr std::string_view kPrefix = "emberline:", kVersion = "emberline:version:";
  PageTable settings{"", {{"setting"}, {"value"}}, {}};
  PageTable versions{"", {{"library"}, {"version"}}, {}};
  for (const auto& [key, value] : settings_attributes(o)) {
    if (key == "emberline:command") continue;
    if (key.starts_with(kVersion)) {
      versions.rows.push_back({key.substr(kVersion.size()), value});
    } else {
      settings.rows.push_back({key.substr(kPrefix.size()), value.empty() ? "none" : value});
    }
  }
  settings.rows.push_back({"camera", r.camera});
  settings.rows.push_back({"threads", std::to_string(r.threads)});
  if (!r.display.empty()) settings.rows.push_back({"display", r.display});
  page.heading("Settings");
  page.table(settings);
  page.heading("Versions");
  page.table(versions);
}

}  // namespace

bool is_page(std::string_view path) {
  const std::string suffix = lower_suffix(path);
  return suffix == ".html" || suffix == ".htm";
}

std::string report_page(const RenderOptions& options, const RenderReport& report,
                        const ReportPictures& pictures) {
  HtmlPage page(file_name(options.scene), summary(options, report));
  add_stop(page, report);
  add_picture(page, options, report, pictures);
  add_numbers(page, report);
  add_samples(page, pictures);
  add_error(page, options, report);
  add_times(page, report.times);
  add_rays(page, report);
  add_memory(page, report);
  add_scene(page, report);
  add_warnings(page, options, report);
  add_settings(page, options, report);
  return page.finish();
}

}  // namespace emberline
