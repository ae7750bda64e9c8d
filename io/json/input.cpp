#include "io/json/input.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

// glTF itself nests about ten levels deep; extras may go deeper.
constexpr size_t kMaxJsonDepth = 256;

constexpr size_t kMaxSidecarBytes = size_t(16) << 20;

constexpr const char* kDuplicateMessage = "the member appears twice in one object";

// Upper bounds on a document's memory with libstdc++ and a 64-bit malloc. While an array grows, its
// old storage and a new one of twice the size exist together. Later, nlohmann's destructor moves
// the elements to a list that grows in the same way.
constexpr uint64_t kElementBytes = 5 * sizeof(json);
constexpr uint64_t kContainerBytes = 64;
constexpr uint64_t kMemberBytes = 112;  // a map node: name and value
constexpr uint64_t kStringBytes = 48;   // plus the text

// Whenever this many bytes have been added, memory is reserved and cancellation is checked. Adding
// them takes a few milliseconds.
constexpr uint64_t kBytesBetweenChecks = uint64_t(1) << 20;

// Builds the document from the parser's events. Tracks the JSON pointer for messages, since the
// parser reports only byte offsets.
class DocumentBuilder final : public json::json_sax_t {
 public:
  DocumentBuilder(const std::string& file, DuplicateMembers duplicates,
                  const LoadProgress& progress)
      : file_(file),
        duplicates_(duplicates),
        progress_(progress),
        memory_(progress.budget(), MemoryPart::kFile) {}

  bool null() override { return add_leaf(nullptr); }
  bool boolean(bool value) override { return add_leaf(value); }
  bool number_integer(json::number_integer_t value) override { return add_leaf(value); }
  bool number_unsigned(json::number_unsigned_t value) override { return add_leaf(value); }
  bool number_float(json::number_float_t value, const std::string&) override {
    return add_leaf(value);
  }
  bool string(std::string& value) override {
    count(kStringBytes + value.size());
    return add_leaf(value);
  }
  bool binary(json::binary_t&) override { return false; }  // never in JSON
  bool start_object(std::size_t) override { return open(json::object()); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(json::array()); }
  bool end_array() override { return close(); }
  bool key(std::string& name) override {
    count(kMemberBytes + name.size());
    Level& level = levels_.back();
    const auto [member, is_new] = level.value->emplace(name, nullptr);
    level.name = &member.key();
    level.member = &*member;
    return is_new || duplicate();
  }
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception& error) override {
    // Error 406 means that a number overflows double. The parser's message for it would repeat the
    // number's text, which may be long.
    throw InputError(place(), error.id == 406
                                  ? "a number is too large to be finite"
                                  : "not valid JSON near byte " + std::to_string(position) +
                                        syntax_detail(error.what()));
  }

  json take() {
    if (duplicates_found_ > 0) {
      const size_t others = duplicates_found_ - 1;
      log_warning(first_duplicate_ + ": " + kDuplicateMessage + "; the last one is used" +
                  (others ? " (and " + std::to_string(others) + " more like it)" : ""));
    }
    return std::move(root_);
  }
  MemoryReservation take_memory() {
    memory_.add(unreserved_bytes_, file_);
    return std::move(memory_);
  }

 private:
  // An array or object that has not been closed yet. The pointers stay valid, since nothing is
  // appended to an array while one of its elements is open.
  struct Level {
    json* value;
    const std::string* name = nullptr;  // name of the latest member
    json* member = nullptr;
  };

  // "[json.exception...] parse error at line 1, column 2: syntax error while ... - X" -> ": X"
  static std::string syntax_detail(const std::string& what) {
    const size_t dash = what.find(" - ");
    const size_t end = what.find(';', dash);
    if (dash == std::string::npos) return "";
    std::string detail = ": ";
    for (const char c : what.substr(dash + 3, end - dash - 3)) {
      detail += uint8_t(c) < 0x20 || uint8_t(c) > 0x7e ? '?' : c;
    }
    return shortened(detail);
  }

  // Returns "file#/json/pointer" of the current value.
  std::string place() const {
    json::json_pointer pointer;
    for (const Level& level : levels_) {
      if (level.value->is_array()) {
        // The fault is in the element that would come next in the innermost array. In each outer
        // array, it is in the last element, which is still open.
        pointer.push_back(std::to_string(level.value->size() - (&level != &levels_.back())));
      } else if (level.name) {
        pointer.push_back(*level.name);
      }
    }
    return pointer.empty() ? file_ : file_ + "#" + shortened(pointer.to_string());
  }

  bool duplicate() {
    if (duplicates_ == DuplicateMembers::kReject) {
      throw InputError(place(), kDuplicateMessage);
    }
    if (++duplicates_found_ == 1) first_duplicate_ = place();
    return true;
  }

  void count(uint64_t bytes) {
    unreserved_bytes_ += bytes;
    if (unreserved_bytes_ < kBytesBetweenChecks) return;
    progress_.check();
    memory_.add(unreserved_bytes_, file_);
    unreserved_bytes_ = 0;
  }
  json* put(json&& value) {
    count(kElementBytes);
    if (levels_.empty()) return &(root_ = std::move(value));
    const Level& level = levels_.back();
    if (!level.value->is_array()) return &(*level.member = std::move(value));
    level.value->push_back(std::move(value));
    return &level.value->back();
  }
  bool add_leaf(json&& value) {
    put(std::move(value));
    return true;
  }
  bool open(json&& value) {
    if (levels_.size() >= kMaxJsonDepth) {
      throw InputError(place(), "JSON nested deeper than {} levels", kMaxJsonDepth);
    }
    count(kContainerBytes);
    levels_.push_back({put(std::move(value))});
    return true;
  }
  bool close() {
    levels_.pop_back();
    return true;
  }

  const std::string& file_;
  const DuplicateMembers duplicates_;
  const LoadProgress& progress_;
  MemoryReservation memory_;
  uint64_t unreserved_bytes_ = 0;  // bytes counted, but not reserved yet
  json root_;
  std::vector<Level> levels_;
  size_t duplicates_found_ = 0;
  std::string first_duplicate_;
};

}  // namespace

json parse_json(std::string_view text, const std::string& file, DuplicateMembers duplicates,
                const LoadProgress& progress, MemoryReservation* memory) {
  DocumentBuilder builder(file, duplicates, progress);
  json::sax_parse(text.begin(), text.end(), &builder);  // the builder throws all errors
  if (memory) *memory = builder.take_memory();
  return builder.take();
}

json read_json(const std::string& path, const LoadProgress& progress) {
  const InputFile file(path);
  if (file.size() > kMaxSidecarBytes) {
    throw InputError(path, "the file is larger than {} MiB", kMaxSidecarBytes >> 20);
  }
  return parse_json(file.read_text(), path, DuplicateMembers::kReject, progress);
}

}  // namespace emberline
