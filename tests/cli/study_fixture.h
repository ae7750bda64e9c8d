// A fixture for tests of `study`. It runs a small study and reads its table.
#pragma once

#include <map>
#include <sstream>

#include "cli/command_test.h"

namespace emberline::test {

using Row = std::map<std::string, std::string>;

// Splits one line of CSV (RFC 4180).
inline std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> list = {""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      list.emplace_back();
    } else {
      list.back() += c;
    }
  }
  return list;
}

class Study : public CommandTest {
 protected:
  Words study_words(const std::string& folder, const Words& more = {}) {
    return Words{"study", scene(),  "-o",      path(folder), "--size",    "16x16",
                 "--spp", "1,4,16", "--seeds", "2",          "--threads", "1"} +
           more;
  }
  RunResult study(const Words& words) {
    const RunResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    return result;
  }
  std::vector<Row> rows(const std::string& folder) const {
    std::istringstream text(read_text(path(folder + "/study.csv")));
    std::string line;
    std::getline(text, line);
    const std::vector<std::string> names = cells(line);
    std::vector<Row> list;
    while (std::getline(text, line)) {
      const std::vector<std::string> values = cells(line);
      EXPECT_EQ(values.size(), names.size()) << line;
      Row& row = list.emplace_back();
      for (size_t i = 0; i < std::min(names.size(), values.size()); ++i) row[names[i]] = values[i];
    }
    return list;
  }
  // Returns the rows of the table without the times, which differ between runs.
  std::vector<Row> contents(const std::string& folder) const {
    std::vector<Row> list = rows(folder);
    for (Row& row : list) {
      row.erase("wall_s");
      row.erase("cpu_s");
      row.erase("filter_cpu_s");
    }
    return list;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
};

}  // namespace emberline::test
