// Tests wrong command lines. The command must exit with 2, print one line that names the option and
// the valid values, and change no file.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "cli/command_test.h"
#include "renderer/engine/setting_table.h"

namespace emberline::test {
namespace {

class Usage : public CommandTest {};

struct WrongValue {
  const char* option;
  Words values;
  Words message_parts;  // what the message must contain in addition to the option's name
  Words with = {};      // other options that are needed for the value to be checked
};

// Has at least one row for each option of `render` that takes a value. If a new option has no row,
// EveryOptionHasARow below fails.
const std::vector<WrongValue>& wrong_values() {
  // None of these texts is a number. All of them are tested with one integer and one real option,
  // because the other options use the same parser.
  static const Words kNotANumber = {"", "abc", "nan", "inf", "4x", "0x10", "1e999", " 4", "+-4"};
  static const auto numbers = [](const Words& more) { return Words{"nan"} + more; };
  static const Words kAdaptive = {"--driver", "adaptive"};
  static const Words kHeatmap = {"--heatmap", "d.png"};
  static const std::vector<WrongValue> rows = {
      {"--output", {"foo", "foo.tif", "exr", "."}, {".exr, .png, .jpg, .jpeg"}},
      {"--across", numbers({"-1", "5", "1.5"}), {"0 to 4"}},
      {"--size",
       {"0x0", "-1", "1e9", "16", "16x", "x16", "-4x4", "16x16x1", "1.5x2", "65537x1", "nanx4",
        "99999999999x1", "16X16", "16x16 "},
       {"WxH", "1 to 65536"}},
      {"--crop", {"a", "1,2,3", "1,2,3,4,5", "0.5,0,1,1", "0,0,99999999999,4"}, {"X0,Y0,X1,Y1"}},
      {"--crop",
       {"0,0,0,0", "5,5,3,3", "0,0,17,16", "-1,0,4,4", "16,16,20,20"},
       {"inside", "0 <= X0 < X1 <= 16 and 0 <= Y0 < Y1 <= 16"}},
      {"--spp",
       kNotANumber + Words{"0", "-3", "1e12", "1.5", "16777217", "4294967297"},
       {"1 to 16777216"}},
      {"--time-limit", numbers({"0", "-1", "1e10"}), {"0.001 to 1000000000"}},
      {"--time-budget", numbers({"0", "-1", "1e10"}), {"0.001 to 1000000000"}},
      {"--memory-limit",
       {"abc", "nan", "inf", "0", "-1", "G", "4X", "GB", "4B", "4iB", "4GiBB", "0.5", "1e30", "8 G",
        "99999999T"},
       {"8G, 500MB or 4096"}},
      {"--texture-memory", {"abc", "0", "-1", "4X", "0.5", "1e30"}, {"8G, 500MB or 4096"}},
      {"--load-timeout", numbers({"0", "-1", "1e10"}), {"0.001 to 1000000000"}},
      {"--turntable-center", {"middle", "0,1,0"}, {"valid names are", "bounds, look-at"}},
      {"--bisection-axis", {"row", "Both"}, {"valid names are", "rows, columns, both"}},
      {"--reconstruction", {"cubic"}, {"valid names are", "duplicate, linear"}},
      {"--snapshot-at",
       {"1", "0%", "101%", "-1s", "nan%", "1%,", "1%,,2%", "0spp", "4 spp", "1e10s", "second"},
       {"'first'", "100%"},
       {"--driver", "bisection", "--snapshots", "shots"}},
      {"--snapshot-format",
       {"jpg"},
       {"valid names are", "png, exr"},
       {"--driver", "bisection", "--snapshots", "shots"}},
      {"--min-spp", numbers({"0", "-1", "16777217", "1.5"}), {"1 to 16777216"}, kAdaptive},
      {"--max-spp", numbers({"0", "-1", "16777217", "1.5"}), {"1 to 16777216"}, kAdaptive},
      {"--noise-threshold",
       kNotANumber + Words{"0", "-1", "2", "1.01", "1e-7", "%", "200%", "1e300%", "2 %", "2%%"},
       {"1e-06 to 1"},
       kAdaptive},
      {"--judge",
       {"", ",", "samples", "light", "A:", "A:-1", "RGB:inf", "RGB,A:1e7", "A,A", "RGBA"},
       {},
       kAdaptive},
      {"--estimator",
       {"two-streams", "Kajiya"},
       {"valid names are", "two-stream", "contrast", "painter-sloan", "chi-square", "kajiya",
        "dammertz"},
       kAdaptive},
      {"--allocation", {"l2", "MSE"}, {"valid names are", "display", "mse", "relmse"}, kAdaptive},
      {"--max-depth", numbers({"-1", "100001", "2.5"}), {"0 to 100000"}},
      {"--light-samples", numbers({"0", "17", "-1", "2.5"}), {"1 to 16"}},
      {"--light-samples",
       {"2"},
       {"normal", "--integrator path or direct"},
       {"--integrator", "normal"}},
      {"--clamp-indirect", numbers({"0", "-1", "inf", "1e10"}), {"1e-06 to 1000000000"}},
      {"--clamp-indirect",
       {"1"},
       {"normal", "--integrator path or direct"},
       {"--integrator", "normal"}},
      {"--seed", numbers({"-1", "4294967296", "0.5"}), {"0 to 4294967295"}},
      {"--streams", numbers({"0", "3", "-1"}), {"1 to 2"}},
      {"--bucket-size", numbers({"0", "-8", "4097", "1e9"}), {"1 to 4096"}},
      {"--threads", numbers({"0", "-1", "4097"}), {"1 to 4096"}},
      {"--filter-radius", numbers({"0", "-1", "33"}), {"0.01 to 32"}},
      {"--fov-y", numbers({"0", "-10", "180"}), {"0.05 to 179.9"}},
      {"--f-stop", numbers({"0", "-2.8", "1e10"}), {"1e-09 to 1000000000"}},
      {"--focus-distance", numbers({"0", "-1", "1e16"}), {"1e-15 to 1000000000000000"}},
      {"--exposure", numbers({"-65", "65"}), {"-64 to 64"}},
      {"--sun",
       {"45", "45,", "nan,0", "0,nan", "90.1,0", "-91,0", "0,361", "0,-1e9", "1,2,3", "inf,1"},
       {"ELEVATION,AZIMUTH", "-90 to 90"}},
      {"--sun", {"45,0"}, {"--env"}, {"--env", "sky.hdr"}},
      {"--env-strength", numbers({"-1", "1e10"}), {"0 to 1000000000"}, {"--env", "sky.hdr"}},
      {"--env-rotation", numbers({"36001"}), {"-36000 to 36000"}, {"--env", "sky.hdr"}},
      {"--look-from",
       {"1,2", "1,2,3,4", "a,b,c", "nan,0,0", "1,2,1e16"},
       {"X,Y,Z"},
       {"--look-at", "0,0,0"}},
      {"--look-at", {"1,2", "1,2,", ",,", "inf,0,0"}, {"X,Y,Z"}, {"--look-from", "0,0,0"}},
      {"--look-at", {"1,2,3"}, {"same point"}, {"--look-from", "1,2,3"}},
      {"--driver", {"bukket", "Bucket"}, {"valid names are", "bucket"}},
      {"--integrator", {"pth"}, {"valid names are", "path", "direct", "ambient_occlusion"}},
      {"--sampler",
       {"sobel", "blue-noise"},
       {"valid names are", "sobol", "blue_noise", "stratified", "poisson_disk", "hierarchical",
        "independent"}},
      {"--sampler",
       {"blue_noise", "stratified"},
       {"adaptive", "--sampler sobol, poisson_disk, hierarchical and independent"},
       {"--driver", "adaptive"}},
      {"--spp",
       {"3", "48", "16777215"},
       {"power of two", "blue_noise", "the nearest"},
       {"--sampler", "blue_noise"}},
      {"--filter",
       {"gauss"},
       {"valid names are", "box", "gaussian", "blackman-harris", "mitchell"}},
      {"--aov", {"foo", "albedo,foo", "albedo N"}, {"unknown channel", "did you mean"}},
      {"--cryptomatte",
       {"foo", "object,foo", "objects"},
       {"valid names are", "object", "material", "asset"}},
      {"--aov", {"shadow"}, {"--aov shadow requires --catcher"}},
      {"--cryptomatte-levels", numbers({"0", "65", "-1", "2.5"}), {"1 to 64"}},
      {"--half", {"foo", "id", "N,samples"}, {"unknown layer", "did you mean"}},
      {"--exr-compression", {"foo", "rle"}, {"valid names are", "none", "zip", "dwab"}},
      {"--isa", {"foo", "avx"}, {"valid names are"}},
      {"--exr-parts", {"foo", "2"}, {"valid names are", "one", "layers"}},
      {"--heatmap", {"foo", "foo.tif"}, {".exr, .png, .jpg, .jpeg"}},
      {"--heatmap-of",
       {"noise", "Samples"},
       {"valid names are", "samples", "error", "stop", "time", "non_finite"},
       kHeatmap},
      {"--colors",
       {"jet", "gray"},
       {"valid names are", "grey, viridis, inferno, magma, turbo"},
       kHeatmap},
      {"--range",
       {"1", "1,1", "2,1", "a,b", "1,2,3", "nan,1", "0,inf", "0,1e19", "1e17,1.0000000000000002e17",
        "0,1e-310", "-5e-324,5e-324", "1e-320,1e-319"},
       {"MIN,MAX"},
       kHeatmap},
      {"--bucket-order",
       {"hilber", "rows"},
       {"valid names are", "hilbert", "spiral", "scanline", "random"}},
      {"--env-sampling", {"guide", "Light"}, {"valid names are", "guided, light"}},
      {"--guiding", {"yes", "Off"}, {"valid names are", "auto, on, off"}},
      {"--working-space", {"aces", "ACEScg"}, {"valid names are", "rec709, acescg"}},
      {"--working-space",
       {"acescg"},
       {"--snapshots", "rec709"},
       {"--driver", "bisection", "--snapshots", "shots"}},
      {"--backfaces", {"maybe"}, {"valid names are", "cull", "show"}},
      {"--catcher", {"nope", "-1", "999999"}, {"no node"}},
      {"--catcher", {","}, {"needs a value"}},
      {"--catcher-plane", {"", "floor", "nan", "inf", "1e16", "0,0"}, {"bottom or a number"}},
      {"--catcher-plane", {"1e9", "-1e9"}, {"far away from the scene"}},
      {"--holdout", {"nope"}, {"no node"}},
      {"--holdout", {",,"}, {"needs a value"}},
      {"--camera", {"nope", "1", "-1", "0.0"}, {"no camera", "0 'main'"}},
      {"--variant", {"nope", "0", "-1"}, {"no variant", "the file has none"}},
      {"--animation", {"nope", "0", "-1", "all"}, {"no animation", "the file has none"}},
      {"--time", numbers({"1e7", "-1e7"}), {"-1000000 to 1000000"}},
      {"--time", {"1"}, {"--time excludes --frame"}, {"--frame", "24"}},
      {"--frame", numbers({"1e13", "-1e13"}), {"-1000000000000 to 1000000000000"}},
      {"--fps", numbers({"0", "-24", "1e7"}), {"0.001 to 1000000"}},
      {"--shutter",
       {"0.5", "0.5,0", "0,nan", "nan,1", "0,1e7", "-1e7,0", "0,0.5,1", ","},
       {"OPEN,CLOSE"}},
      {"--display", {"Rec.2020"}, {"valid names are", "sRGB"}, {"-o", "a.png"}},
      {"--display",
       {"tev:", "tev://", "tev://host:99999", "tev://host:0", "tev://host:", "tev://::1:1",
        "TEV:x"},
       {"tev://HOST:PORT", "1 to 65535"}},
      {"--view", {"filmic"}, {"valid names are", "sRGB, ACES, Raw"}, {"-o", "a.png"}},
      {"--look", {"warm"}, {"valid names are"}, {"-o", "a.png"}},
      {"--replay", {"1,1", "1,1,1,1", "a,b,c", "1.5,1,1", "1,1,nan", "1 1 1"}, {"X,Y,SAMPLE"}},
      {"--replay", {"16,0,0", "0,16,0", "-1,0,0", "99999999999,0,0"}, {"outside", "16 x 16"}},
      {"--replay", {"1,1,-1", "0,0,99999999999", "0,0,16777216"}, {"0 to 16777215"}},
      {"--explain", {"1", "a,b", "1,2,3", "-1,0", "1.5,2"}, {"X,Y"}, kAdaptive},
      {"--explain", {"16,0", "0,16"}, {"outside", "0 to 15"}, kAdaptive},
      {"--explain", {"1,1"}, {"--driver adaptive"}},
      {"--tree", {"tree.json"}, {"--driver adaptive"}},
      {"--checkpoint-interval", {"0", "-1", "nan", "1e10"}, {"0.1 to 1"}},
      {"--part", {"0/2", "3/2", "1", "1/2/3", "1/65537", "a/b"}, {"K/N"}},
      {"--part", {"1/2"}, {"--driver bucket"}, kAdaptive},
      {"--frames",
       {"a", "1-", "1,,2", "1-10x0", "1-1000001", "1..5", "1.5", "9999999999"},
       {"--frames"},
       {"-o", "a.#.exr"}},
      {"--frames", {"1-3"}, {"put ####", "out.####.exr"}},
      {"--frames", {"1"}, {"--frames excludes --frame"}, {"--frame", "1"}},
      {"--turntable",
       {"0", "-3", "a", "1.5", "1000001", "1/", "/3", "1/0", "1/2/3", "1/1000001"},
       {"N or K/N", "1 to 1000000"}},
      {"--turntable", {"3"}, {"put ####"}},
      {"--range-report", {"r.json"}, {"--frames"}},
      {"--sample-range", {"4-4", "5-4", "0-16777217", "4", "-1-4"}, {"A-B"}},
      {"--sample-range", {"0-4"}, {"--spp"}},
      {"--sample-range", {"0-4"}, {"--seed"}, kAdaptive},
      // These options accept any file name. It is checked after the options are parsed.
      {"--env", {}, {}},
      {"--edits", {}, {}},
      {"--plan", {}, {}},
      {"--settings", {}, {}},
      {"--save-settings", {}, {}},
      {"--resource-root", {}, {}},
      {"--report", {}, {}},
      {"--progress-file", {}, {}},
      {"--checkpoint", {}, {}},
      {"--snapshots", {}, {}},
      {"--reference", {}, {}},
  };
  return rows;
}

// Returns the name that messages use for the option.
std::string option_in_messages(const std::string& option) {
  return option == "--output" || option == "--difference" ? "-o" : option;
}

struct HelpedOption {
  std::string name;  // the long name
  bool has_value;
};

// Returns the options in the output of --help-all, where they are in lines such as
// "  -o, --output FILE". Lines with help texts are indented further.
std::vector<HelpedOption> options_in(const std::string& help) {
  std::vector<HelpedOption> options;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  -")) continue;
    const size_t at = line.find("--"), end = std::min(line.size(), line.find(' ', at));
    options.push_back({line.substr(at, end - at), end < line.size()});
  }
  return options;
}

size_t line_count(const std::string& text) { return size_t(std::ranges::count(text, '\n')); }

TEST_F(Usage, WrongValuesNameTheOptionAndTheValidOnes) {
  for (const WrongValue& row : wrong_values()) {
    for (const std::string& value : row.values) {
      expect_failure(render_words(row.with + Words{row.option, value}), 2,
                     Words{option_in_messages(row.option)} + row.message_parts);
    }
  }
}

TEST_F(Usage, EveryOptionHasARow) {
  const RunResult help = run({"render", "--help-all"});
  ASSERT_EQ(help.exit_code, 0);
  std::set<std::string> with_row = {
      "--help",         "--help-all",  "--transparent",   "--lenient",       "--unbiased",
      "--light-groups", "--quiet",     "--verbose",       "--log",           "--plain",
      "--resume",       "--resumable", "--skip-existing", "--stop-on-error", "--denoise",
      "--panorama",     "--strict",    "--static-noise"};
  for (const WrongValue& row : wrong_values()) with_row.insert(row.option);
  const std::vector<HelpedOption> options = options_in(help.out);
  EXPECT_GE(options.size(), 30u) << help.out;
  for (const HelpedOption& option : options) {
    EXPECT_TRUE(with_row.contains(option.name)) << option.name << " has no row in wrong_values()";
  }
}

// A script may pass --env "$UNSET", whose value is empty. This test checks every option of several
// commands.
TEST_F(Usage, EmptyValuesAreRefused) {
  write("a.exr", "");
  const Words commands[] = {render_words(),
                            {"view", scene()},
                            {"heatmap", path("a.exr"), "-o", path("b.png")},
                            {"compare", path("a.exr"), path("a.exr")},
                            {"show", path("a.exr"), "-o", path("b.png")},
                            {"study", scene(), "-o", path("s")}};
  for (const Words& words : commands) {
    size_t values = 0;
    for (const HelpedOption& option : options_in(run({words[0], "--help-all"}).out)) {
      if (!option.has_value) continue;
      ++values;
      expect_failure(words + Words{option.name, ""}, 2, {option_in_messages(option.name)});
    }
    EXPECT_GE(values, words[0] == "compare"                         ? 2u
                      : words[0] == "heatmap" || words[0] == "show" ? 4u
                                                                    : 20u)
        << words[0];
  }
}

TEST_F(Usage, NoNameMayBeEmpty) {
  for (const Words& words : {Words{"render", "", "-o", path("a.png")}, Words{"view", ""},
                             Words{"info", ""}, Words{"study", "", "-o", path("s")}}) {
    expect_failure(words, 2, {"scene needs a value"});
  }
  expect_failure({"heatmap", "", "-o", path("a.png")}, 2, {"image needs a value"});
  expect_failure({"compare", path("a.exr"), ""}, 2, {"reference needs a value"});
}

TEST_F(Usage, AnOptionWithoutItsValueSaysWhatItNeeds) {
  expect_failure(render_words({"--spp"}), 2, {"--spp needs a value", "1..16777216"});
  expect_failure(render_words({"-o"}), 2, {"needs a value", "FILE"});
  expect_failure(render_words({"--sampler"}), 2, {"--sampler needs a value"});
}

TEST_F(Usage, OptionsThatNeedEachOther) {
  expect_failure(render_words({"--look-from", "1,2,3"}), 2, {"--look-from requires --look-at"});
  expect_failure(render_words({"--look-at", "1,2,3"}), 2, {"--look-at requires --look-from"});
  expect_failure(render_words({"--env-strength", "2"}), 2, {"--env-strength requires --env"});
  expect_failure(render_words({"--env-rotation", "2"}), 2, {"--env-rotation requires --env"});
  expect_failure(render_words({"--f-stop", "2.8"}), 2, {"--f-stop", "--focus-distance"});
  for (const char* option : {"--fov-y", "--f-stop", "--focus-distance"}) {
    expect_failure(render_words({"--panorama", option, "2"}), 2, {option, "--panorama"});
  }
  expect_failure(render_words({"--quiet", "--verbose"}), 2, {"--quiet", "--verbose"});
  expect_failure({"render", scene()}, 2, {"-o"});
}

// The message may not list all options, because a long list would hide the suggestion.
TEST_F(Usage, UnknownOptionsNameOnlyTheNearest) {
  for (const char* command : {"render", "view", "compare", "study", "farm"}) {
    const std::string err = run({command, "--noise-treshold", "1"}).err;
    EXPECT_LE(line_count(err), 2u) << err;
    EXPECT_LE(std::ranges::count(err, '\''), 8) << err;  // quotes around the word and three names
  }
}

TEST_F(Usage, NoCommandShowsTheThreeThatMostPeopleWant) {
  const RunResult result = run({});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  for (const char* word :
       {"emberline render ", "emberline view ", "emberline info ", "emberline help"}) {
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
  }
  EXPECT_LE(line_count(result.err), 8u);
}

TEST_F(Usage, UnknownWordsListTheValidOnes) {
  expect_failure({"rendr", scene()}, 2,
                 {"unknown command 'rendr'", "render", "info", "heatmap", "compare"});
  expect_failure({"--vers"}, 2, {"unknown option '--vers'", "--version"});
  expect_failure(render_words({"--sppp", "3"}), 2,
                 {"unknown option '--sppp'", "did you mean '--spp', '--min-spp' or '--max-spp'",
                  "see emberline render --help-all"});
  expect_failure(render_words({"--sppp=3"}), 2, {"unknown option '--sppp'"});
  expect_failure(render_words({"--threshold=3"}), 2, {"did you mean '--noise-threshold'"});
  // Names from other renderers that resemble none of ours.
  expect_failure(render_words({"--width", "64"}), 2, {"did you mean '--size'?"});
  expect_failure(render_words({"--samples=3"}), 2, {"did you mean '--spp'?"});
  expect_failure(render_words({"-x"}), 2, {"unknown option '-x'", "--help-all"});
  expect_failure({"farm", "status", path("a.exr"), "--jsn"}, 2,
                 {"--json", "emberline farm status --help-all"});
  expect_failure(render_words({"second.glb"}), 2, {"unexpected argument 'second.glb'"});
  expect_failure({"info", scene(), "--spp", "3"}, 2,
                 {"unknown option '--spp'", "emberline info --help-all"});
  expect_failure({"compare", scene()}, 2, {"reference"});
  expect_failure({"render"}, 2, {"scene", "--help"});
  expect_failure({"info"}, 2, {"scene"});
}

TEST_F(Usage, RejectsConflictingPaths) {
  expect_failure(render_words({"-o", path("./out.exr")}), 2,
                 {"-o", "out.exr", "it is also written by"});
  expect_failure(render_words({"-o", path("a.png"), "--report", path("a.png")}), 2,
                 {"--report", "a.png"});
  expect_failure(render_words({"--report", scene()}), 2, {"--report", "scene"});
  write("sky.exr", "irreplaceable");
  expect_failure({"render", scene(), "-o", path("sky.exr"), "--env", path("sky.exr")}, 2,
                 {"-o", "--env"});
  write("shot.json", "hours of work");
  expect_failure(render_words({"--edits", path("shot.json"), "--report", path("shot.json")}), 2,
                 {"--report", "--edits"});
}

TEST_F(Usage, AJpegTooLargeForItsFormatIsRefusedBeforeTheRender) {
  expect_failure(render_words({"-o", path("a.jpg"), "--size", "65536x1"}), 2, {"65500"});
}

TEST_F(Usage, HelpAndVersion) {
  for (const Words& words : {Words{"--help"}, Words{"render", "--help"}, Words{"info", "-h"},
                             Words{"heatmap", "--help"}, Words{"compare", "--help"}}) {
    const RunResult result = run(words);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.err, "");
    EXPECT_NE(result.out.find("emberline"), std::string::npos) << result.out;
  }
  const RunResult version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  for (const char* library :
       {"emberline ", "embree ", "openexr ", "openimageio ", "opencolorio "}) {
    EXPECT_NE(version.out.find(library), std::string::npos) << version.out;
  }
}

// Also checks the length of lines, because a terminal wraps long lines.
TEST_F(Usage, HelpFitsOnAScreen) {
  for (const char* command : {"render", "view", "session", "info", "show", "heatmap", "explain",
                              "compare", "denoise", "extend", "merge", "farm", "study", "help"}) {
    const RunResult help = run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_LE(line_count(help.out), 45u) << help.out;
    std::istringstream lines(help.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
    EXPECT_EQ(run({"help", command}).out, help.out);
  }
  const std::string help = run({"render", "--help"}).out;
  for (const char* section :
       {"Output:", "Samples:", "View:", "Light:", "Scene:", "Limits:", "Examples:"}) {
    EXPECT_NE(help.find(std::string("\n") + section), std::string::npos) << help;
  }
  EXPECT_GE(options_in(help).size(), 20u) << help;
}

TEST_F(Usage, FullHelpHasEverySettingAndItsNames) {
  const std::string help = run({"render", "--help-all"}).out;
  for (const Setting& setting : setting_table()) {
    EXPECT_NE(help.find("\n  --" + setting.name + (setting.type.empty() ? "\n" : " ")),
              std::string::npos)
        << setting.name;
    for (const SettingChoice& choice : setting.choices) {
      EXPECT_NE(help.find("\n        " + choice.name + ": "), std::string::npos) << choice.name;
    }
  }
}

TEST_F(Usage, HelpExplainsEveryOption) {
  for (const HelpedOption& option : options_in(run({"render", "--help-all"}).out)) {
    const RunResult page = run({"help", "render", option.name.substr(2)});
    EXPECT_EQ(page.exit_code, 0) << option.name;
    EXPECT_NE(page.out.find(option.name), std::string::npos) << page.out;
  }
  EXPECT_EQ(run({"help", "render", "--spp"}).out, run({"help", "render", "spp"}).out);
  EXPECT_EQ(run({"help", "farm", "status", "json"}).exit_code, 0);
  const std::string threshold = run({"help", "render", "noise-threshold"}).out;
  for (const char* part : {"--noise-threshold 1e-06..1", "Default: ", "Example: "}) {
    EXPECT_NE(threshold.find(part), std::string::npos) << threshold;
  }
  EXPECT_EQ(run({"help"}).out, run({"--help"}).out);
  expect_failure({"help", "rendr"}, 2, {"unknown command 'rendr'", "did you mean 'render'"});
  expect_failure({"help", "render", "noise-treshold"}, 2,
                 {"unknown option '--noise-treshold'", "'--noise-threshold'"});
}

// The manual includes these pages.
TEST_F(Usage, GeneratedPagesHaveEveryOptionAndChannel) {
  ASSERT_EQ(run({"--write-documents", path("share")}).exit_code, 0);
  const std::string options = read_text(path("share/doc/options.md"));
  for (const std::string command : {"render", "view", "study", "farm", "farm status"}) {
    const size_t section = options.find("# emberline " + command + "\n");
    ASSERT_NE(section, std::string::npos) << command;
    Words words;
    std::istringstream parts(command);
    for (std::string word; parts >> word;) words.push_back(word);
    for (const HelpedOption& option : options_in(run(words + Words{"--help-all"}).out)) {
      EXPECT_NE(options.find(option.name + (option.has_value ? " " : "`"), section),
                std::string::npos)
          << command << " " << option.name;
    }
  }
  const std::string channels = read_text(path("share/doc/channels.md"));
  const auto rows = nlohmann::json::parse(run({"info", "--channels", "--json"}).out);
  EXPECT_GE(rows.size(), 30u);
  for (const auto& row : rows) {
    EXPECT_NE(channels.find("| `" + row["name"].get<std::string>() + "` |"), std::string::npos)
        << row;
  }
}

TEST_F(Usage, LastOfARepeatedOptionWins) {
  render(render_words({"--quiet", "--spp", "3", "--size", "8x4"}));
  const ExrPicture picture = read_exr(path("out.exr"));
  EXPECT_EQ(picture.display, (Rect{0, 0, 8, 4}));
  EXPECT_EQ(picture.at("samples", 0, 0), 3.0f);
}

}  // namespace
}  // namespace emberline::test
