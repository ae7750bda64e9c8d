#pragma once
#include <string>
namespace emberline {
struct CompareOptions { std::string image, reference, difference; bool json=false; float exposure=0; };
inline int run_compare(const CompareOptions&) { return 0; }
}
