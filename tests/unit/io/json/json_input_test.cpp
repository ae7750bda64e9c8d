// Tests the single entry point for JSON files: the accepted input, and the errors of all other
// input.
#include "io/json/input.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <ctime>
#include <functional>
#include <nlohmann/json.hpp>

#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "support/process_memory.h"
#include "support/temp_folder.h"

namespace emberline {
namespace {

std::string rejection_message(const std::string& text) {
  try {
    parse_json(text, "f.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(JsonInput, MatchesThePlainParser) {
  for (
      const char* text :
      {"0", "-0.0", "\"\"", "null", "[]", "{}", " [1, -2, 3.5e-7, true, false, null, \"x\"] ",
       R"({"a": {"b": [[], {}, [{"c": [1, [2, [3]]]}]], "": 18446744073709551615}, "b": "\u00e9"})",
       "[[1], [2, [3, {\"a\": [4], \"b\": 5}], 6], 7]", "\xEF\xBB\xBF{\"bom\": 1}", "1e-400"}) {
    EXPECT_EQ(parse_json(text, "f.json"), nlohmann::json::parse(text)) << text;
  }
  std::string deep = std::string(256, '[') + std::string(256, ']');
  EXPECT_EQ(parse_json(deep, "f.json"), nlohmann::json::parse(deep));
}

TEST(JsonInput, ErrorsNameThePlace) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "f.json: not valid JSON near byte "},
      {"{", "f.json: not valid JSON near byte "},
      {"{} {}", "f.json: not valid JSON near byte "},
      {"[1, 2,]", "f.json#/2: not valid JSON near byte "},
      {"[[], [1, x]]", "f.json#/1/1: not valid JSON near byte "},
      {"{\"a\": {\"b\": [1, 2, {\"c\": }]}}", "f.json#/a/b/2/c: not valid JSON near byte "},
      {"{\"a\": 1 \"b\": 2}", "f.json#/a: not valid JSON near byte "},
      {"{\"a\": [\"\xff\"]}", "f.json#/a/0: not valid JSON near byte "},
      {"{\"a\": \"\\ud800\"}", "f.json#/a: not valid JSON near byte "},
      {"{\"a\": \"\n\"}", "f.json#/a: not valid JSON near byte "},
      {"{\"a\": [0, 1e400]}", "f.json#/a/1: a number is too large to be finite"},
      {"-1e400", "f.json: a number is too large to be finite"},
      {"{\"a\": [0, NaN]}", "f.json#/a/1: not valid JSON near byte "},
      {"{\"a\": 1, \"b\": 2, \"a\": 3}", "f.json#/a: the member appears twice in one object"},
      {"[{\"x/y\": {\"~\": [], \"~\": 1}}]",
       "f.json#/0/x~1y/~0: the member appears twice in one object"},
      {std::string(257, '['), "JSON nested deeper than 256 levels"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string message = rejection_message(text);
    EXPECT_NE(message.find(expected), std::string::npos) << text << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 300u) << message;
  }
}

TEST(JsonInput, DepthIsRefusedBeforeItCostsAnything) {
  for (const char* brackets : {"[", "{\"a\":", "[{\"a\":"}) {
    std::string text;
    for (int i = 0; i < 1000000; ++i) text += brackets;
    EXPECT_NE(rejection_message(text).find("nested deeper than 256 levels"), std::string::npos)
        << brackets;
  }
}

// A scene may have a duplicate member, as a program that appends to the file may leave it.
TEST(JsonInput, LastOfDuplicateMembersWins) {
  const char* text = R"({"a": {"old": [1, 2]}, "b": 1, "a": {"new": 3}, "b": 2, "b": [3]})";
  EXPECT_EQ(parse_json(text, "twice.json", DuplicateMembers::kWarn), nlohmann::json::parse(text));
  EXPECT_EQ(warnings_so_far().back(),
            "twice.json#/a: the member appears twice in one object; the last one is used (and "
            "2 more like it)");
}

// The text has several megabytes of members, the last of which is a duplicate. Rejecting it
// must take less than 5 s.
TEST(JsonInput, ManyMembersAreFast) {
  std::string text = "{";
  for (int i = 0; i < 300000; ++i) text.append("\"").append(std::to_string(i)).append("\":0,");
  text += "\"7\":0}";
  const std::clock_t begin = std::clock();
  EXPECT_NE(rejection_message(text).find("f.json#/7: the member appears twice"), std::string::npos);
  EXPECT_LT(double(std::clock() - begin) / CLOCKS_PER_SEC, 5.0);
}

TEST(JsonInput, ReadsRegularFilesOnly) {
  const test::TempFolder folder;
  test::write_text(folder / "good.json", "[1]");
  EXPECT_EQ(read_json(folder / "good.json"), nlohmann::json::array({1}));
  ASSERT_EQ(mkfifo((folder / "pipe.json").c_str(), 0600), 0);
  for (const std::string& path : {folder / "pipe.json", folder / "none.json",
                                  folder.path().string(), std::string("/dev/zero")}) {
    EXPECT_THROW(read_json(path), InputError) << path;
  }
  test::write_text(folder / "huge.json", "[1]");
  std::filesystem::resize_file(folder / "huge.json", uintmax_t(1) << 40);  // sparse
  EXPECT_THROW(read_json(folder / "huge.json"), InputError);
}

// These texts expand as much as possible. The reservation covers the memory that they may need.
TEST(JsonInput, CountsTheDocumentsMemory) {
  for (const char* element : {"0,", "[],", "{},", "{\"\":0},", "\"0123456789abcdef\","}) {
    std::string text = "{\"extras\":[";
    for (int i = 0; i <= 1 << 19; ++i) text += element;  // the array has just doubled
    text += "0]}";
    LoadLimits limits;
    limits.memory = std::make_shared<MemoryBudget>(uint64_t(1) << 30);
    {
      const LoadProgress progress({}, {}, limits);
      MemoryReservation memory;
      test::reset_peak();
      const double before = test::ProcessMemory::now().resident;
      { const nlohmann::json json = parse_json(text, "f.json", {}, progress, &memory); }
      const double taken = test::peak_resident_bytes() - before;
      EXPECT_LE(memory.bytes(), 50 * text.size()) << element;
      if (!test::kSanitized) {
        EXPECT_LE(taken, 1.1 * double(memory.bytes())) << element;
        EXPECT_GE(taken, 0.4 * double(memory.bytes())) << element;
      }
    }
    EXPECT_EQ(limits.memory->reserved(), 0u) << "what a document took is given back";
    limits.memory = std::make_shared<MemoryBudget>(uint64_t(20) << 20);
    EXPECT_THROW(parse_json(text, "f.json", {}, LoadProgress({}, {}, limits)), InputError);
  }
}

TEST(JsonReader, ErrorsNameThePlaceAndTheExpectedValue) {
  const std::string file = "f.json";
  const nlohmann::json json = nlohmann::json::parse(
      R"({"number": 2.5, "whole": 7, "text": "t", "flag": true, "list": [1, "x"], "a/b": {}})");
  const JsonReader root(json, file);
  EXPECT_EQ(root["number"].number(0, 3), 2.5);
  EXPECT_EQ(root["whole"].whole_number(0, 7), 7u);
  EXPECT_EQ(root["text"].text(), "t");
  EXPECT_TRUE(root["flag"].boolean());
  EXPECT_EQ(root["list"].size(), 2u);
  EXPECT_EQ(root["a/b"].members().size(), 0u);
  const std::pair<std::function<void()>, const char*> cases[] = {
      {[&] { root["none"]; }, "f.json: the required member \"none\" is missing"},
      {[&] { root["list"]["x"]; }, "f.json#/list: expected an object, found [1,\"x\"]"},
      {[&] { root["a/b"].size(); }, "f.json#/a~1b: expected an array, found {}"},
      {[&] { root["number"].number(0, 2); }, "f.json#/number: expected a number from 0 to 2"},
      {[&] { root["list"][1].number(0, 2); }, "f.json#/list/1: expected a number from 0 to 2"},
      {[&] { root["number"].whole_number(0, 9); },
       "f.json#/number: expected a whole number from 0 to 9"},
      {[&] { root["whole"].whole_number(8, 9); },
       "f.json#/whole: expected a whole number from 8 to 9"},
      {[&] { root["whole"].text(); }, "f.json#/whole: expected a string, found 7"},
      {[&] { root["whole"].boolean(); }, "f.json#/whole: expected true or false, found 7"},
      {[&] { root["list"].vector(0, 1); }, "f.json#/list: expected an array of 3 numbers"},
      {[&] {
         root.object({"number", "whole", "text", "flag", "list"});
       },
       "f.json#/a~1b: unknown member 'a/b'; valid names are number, whole"},
  };
  for (const auto& [read, expected] : cases) {
    try {
      read();
      ADD_FAILURE() << "accepted, not: " << expected;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace emberline
