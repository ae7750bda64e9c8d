#include "numerics/closed_form.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

namespace emberline::test {

void record(const CaseName& name, const Comparison& c, const std::string& reason) {
  const char* file = std::getenv("EMBERLINE_NUMERICS_TABLE");
  if (file == nullptr || *file == '\0') return;
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const nlohmann::json row = {{"case", name.number},
                              {"what", name.what},
                              {"exact", c.exact},
                              {"measured", c.measured},
                              {"standard_error", c.standard_error},
                              {"tolerance", c.tolerance},
                              {"passes", c.passes()},
                              {"reason", reason},
                              {"test", std::string(info->test_suite_name()) + "." + info->name()}};
  std::FILE* out = std::fopen(file, "a");
  ASSERT_NE(out, nullptr) << "cannot append to " << file;
  std::fprintf(out, "%s\n", row.dump().c_str());
  std::fclose(out);
}

}  // namespace emberline::test
