// Mutates JSON for libFuzzer, alone or in a .glb. Most mutations change the tree of values, so that
// inputs reach the code behind the parser. Others change the bytes of the binary chunk, or
// occasionally of the whole file. A changed .glb gets a valid container.
#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "fuzz/fuzz.h"
#include "support/gltf_builder.h"

namespace emberline::fuzz {
namespace {

using Bytes = std::vector<uint8_t>;
using nlohmann::json;

// The string literals of the files that read JSON: members, extensions, names of types and modes.
constexpr const char* kWords[] = {
#include "json_words.inc"
};

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  size_t below(size_t count) { return random_() % count; }
  bool one_in(size_t count) { return below(count) == 0; }

  // Lets libFuzzer mutate the bytes, which grow by at most `room`.
  Bytes mutate_bytes(Bytes bytes, size_t room) {
    const size_t size = bytes.size();
    bytes.resize(size + room);
    bytes.resize(LLVMFuzzerMutate(bytes.data(), size, bytes.size()));
    return bytes;
  }

  void mutate_tree(json& root) {
    for (size_t changes = 1 + below(3); changes > 0; --changes) mutate_node(root);
  }

  // Replaces a random value of `root` by one of `other`.
  void splice(json& root, json& other) { any(root) = json(any(other)); }

 private:
  json& any(json& root) {
    std::vector<json*> nodes = {&root};
    for (size_t next = 0; next < nodes.size(); ++next) {
      if (!nodes[next]->is_structured()) continue;
      for (json& member : *nodes[next]) nodes.push_back(&member);
    }
    return *nodes[below(nodes.size())];
  }

  json extreme() {
    static const json kExtremes[] = {0,
                                     1,
                                     -1,
                                     2,
                                     3,
                                     4,
                                     127,
                                     255,
                                     256,
                                     65535,
                                     65536,
                                     1e30,
                                     -1e30,
                                     1e308,
                                     1e-308,
                                     2147483647,
                                     -2147483648ll,
                                     4294967295u,
                                     4294967296u,
                                     9007199254740992,
                                     9223372036854775807,
                                     18446744073709551615u,
                                     -0.0,
                                     0.5,
                                     3.4028234e38,
                                     1e19,
                                     5120,
                                     5121,
                                     5122,
                                     5123,
                                     5125,
                                     5126,
                                     nullptr,
                                     true,
                                     false,
                                     "",
                                     json::array(),
                                     json::object()};
    return kExtremes[below(std::size(kExtremes))];
  }

  std::string word() { return kWords[below(std::size(kWords))]; }

  void mutate_node(json& root) {
    json& node = any(root);
    switch (below(node.is_structured() ? 8 : 4)) {
      case 0:
        node = extreme();
        return;
      case 1:
        node = json(any(root));
        return;
      case 2:
      case 3:
        return mutate_value(node);
      case 4:
        if (!node.empty()) node.erase(std::next(node.begin(), std::ptrdiff_t(below(node.size()))));
        return;
      case 5: {  // duplicates an element once, or often
        if (!node.is_array() || node.empty()) return;
        const json element = node[below(node.size())];
        for (size_t n = one_in(8) ? 100 : 1; n > 0; --n) node.push_back(element);
        return;
      }
      default: {
        json value = one_in(2) ? extreme() : json(any(root));
        if (node.is_object()) {
          node[word()] = std::move(value);
        } else {
          node.push_back(std::move(value));
        }
        return;
      }
    }
  }

  void mutate_value(json& node) {
    if (node.is_string()) {
      if (one_in(2)) {
        node = word();
        return;
      }
      const std::string& text = node.get_ref<const std::string&>();
      const Bytes changed = mutate_bytes(Bytes(text.begin(), text.end()), 16);
      node = std::string(changed.begin(), changed.end());
    } else if (node.is_number_integer()) {
      // Takes a nearby value, or half of the value. The type is unsigned, so that the value may
      // wrap.
      const uint64_t value = node.get<uint64_t>();
      node = int64_t(one_in(4) ? value / 2 : value + below(5) - 2);
    } else if (node.is_number()) {
      node = node.get<double>() * (one_in(2) ? -1.5 : 1e-3);
    }
  }

  std::minstd_rand random_;
};

struct File {
  json root;  // discarded if not JSON
  Bytes chunk;
  bool is_glb = false;
};

uint32_t word_at(const uint8_t* bytes) {
  uint32_t word = 0;
  std::memcpy(&word, bytes, sizeof(word));
  return word;
}

File split(const uint8_t* data, size_t size) {
  File file;
  const uint8_t* end = data + size;
  file.is_glb = size >= 20 && std::memcmp(data, "glTF", 4) == 0;
  if (file.is_glb) {
    const size_t text_size = std::min<size_t>(word_at(data + 12), size - 20);
    const uint8_t* rest = data + 20 + text_size;
    if (end - rest >= 8) {
      file.chunk.assign(rest + 8,
                        rest + 8 + std::min<size_t>(word_at(rest), size_t(end - rest - 8)));
    }
    data += 20;
    end = data + text_size;
  }
  file.root = json::parse(data, end, nullptr, false);
  return file;
}

// Writes the file to `data` and returns its size, or 0 if it does not fit.
size_t join(const File& file, uint8_t* data, size_t max_size) {
  const std::string text = file.root.dump(-1, ' ', false, json::error_handler_t::replace);
  const Bytes bytes =
      file.is_glb ? test::GltfBuilder::glb(text, file.chunk) : Bytes(text.begin(), text.end());
  if (bytes.size() > max_size) return 0;
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}

}  // namespace
}  // namespace emberline::fuzz

using namespace emberline::fuzz;

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
  Mutator mutator(seed);
  File file = split(data, size);
  if (!file.root.is_discarded() && !mutator.one_in(16)) {
    if (!file.chunk.empty() && mutator.one_in(3)) {
      file.chunk = mutator.mutate_bytes(std::move(file.chunk), 64);
    } else {
      mutator.mutate_tree(file.root);
    }
    if (const size_t joined = join(file, data, max_size)) return joined;
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" size_t LLVMFuzzerCustomCrossOver(const uint8_t* data1, size_t size1,
                                            const uint8_t* data2, size_t size2, uint8_t* out,
                                            size_t max_out_size, unsigned seed) {
  Mutator mutator(seed);
  File file = split(data1, size1), other = split(data2, size2);
  if (file.root.is_discarded() || other.root.is_discarded()) return 0;
  mutator.splice(file.root, other.root);
  if (!other.chunk.empty() && mutator.one_in(2)) file.chunk = std::move(other.chunk);
  return join(file, out, max_out_size);
}
