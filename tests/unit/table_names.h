#pragma once

#include <string>
#include <vector>

namespace emberline::test {

// The names of a table's rows (samplers, filters), for tests with one case per row.
template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& entry : table) names.emplace_back(entry.name);
  return names;
}

}  // namespace emberline::test
