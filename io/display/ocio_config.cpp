#include "io/display/ocio_config.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/readable.h"

namespace emberline {
namespace {

namespace ocio = OCIO_NAMESPACE;

// The limit is a hundred times the number of transforms that a real config expands to.
constexpr double kMaxTransforms = 1e5;
// Limits the recursion.
constexpr int kMaxDepth = 200;
// Studio tables have about ten megabytes.
constexpr uint64_t kMaxTableBytes = uint64_t(64) << 20;
// Each YAML alias can triple the size of the parsed config. Studio configs have none.
constexpr int kMaxAliases = 16;

class ConfigChecker {
 public:
  ConfigChecker(const ocio::ConstConfigRcPtr& config, const std::string& place)
      : config_(config), place_(place) {}

  std::vector<std::string> files() {
    constexpr auto kSpaces = ocio::SEARCH_REFERENCE_SPACE_ALL;
    const int spaces = config_->getNumColorSpaces(kSpaces, ocio::COLORSPACE_ALL);
    for (int i = 0; i < spaces; ++i) {
      space(config_->getColorSpaceNameByIndex(kSpaces, ocio::COLORSPACE_ALL, i));
    }
    for (int i = 0; i < config_->getNumLooks(); ++i) look(config_->getLookNameByIndex(i));
    for (int i = 0; i < config_->getNumViewTransforms(); ++i) {
      view_transform(config_->getViewTransformNameByIndex(i));
    }
    for (int i = 0; i < config_->getNumNamedTransforms(ocio::NAMEDTRANSFORM_ALL); ++i) {
      named_transform(config_->getNamedTransformNameByIndex(ocio::NAMEDTRANSFORM_ALL, i));
    }
    return std::move(files_);
  }

 private:
  // Returns the number of transforms that `name` expands to. Calls `count` only once per name.
  double count_once(const std::string& name, const std::function<double()>& count) {
    const auto [entry, is_new] = counts_.try_emplace(name, -1.0);
    if (!is_new && entry->second < 0) throw InputError(place_, name + " refers back to itself");
    if (!is_new) return entry->second;
    if (++depth_ > kMaxDepth) {
      throw InputError(place_, "{} is nested more than {} levels deep", name, kMaxDepth);
    }
    const double total = count();
    --depth_;
    if (total > kMaxTransforms) {
      throw InputError(place_, "{} expands to more than {} transforms", name, int(kMaxTransforms));
    }
    return counts_[name] = total;
  }

  // Counts the transforms of both directions.
  template <typename Thing, typename Direction>
  double count_both_directions(const std::string& name, const Thing& thing, Direction there,
                               Direction back) {
    return count_once(name, [&] {
      return transform(thing.getTransform(there)) + transform(thing.getTransform(back));
    });
  }

  double space(const std::string& name) {
    const ocio::ConstColorSpaceRcPtr found = config_->getColorSpace(name.c_str());
    if (!found) return named_transform(name);
    return count_both_directions("the colour space \"" + std::string(found->getName()) + "\"",
                                 *found, ocio::COLORSPACE_DIR_TO_REFERENCE,
                                 ocio::COLORSPACE_DIR_FROM_REFERENCE);
  }

  double named_transform(const std::string& name) {
    const ocio::ConstNamedTransformRcPtr found = config_->getNamedTransform(name.c_str());
    if (!found) return 0;
    return count_both_directions("the named transform \"" + std::string(found->getName()) + "\"",
                                 *found, ocio::TRANSFORM_DIR_FORWARD, ocio::TRANSFORM_DIR_INVERSE);
  }

  double look(const std::string& name) {
    const ocio::ConstLookRcPtr found = config_->getLook(name.c_str());
    if (!found) return 0;
    return count_once("the look \"" + name + "\"", [&] {
      return transform(found->getTransform()) + transform(found->getInverseTransform()) +
             space(found->getProcessSpace());
    });
  }

  // Counts the transforms of a list of looks such as "a, +b | -c". Signs are directions; `|`
  // separates alternatives.
  double looks(const char* text) {
    double total = 0;
    std::string name;
    for (const char* c = text ? text : "";; ++c) {
      if (*c && !std::strchr(",:|+- \t", *c)) {
        name += *c;
        continue;
      }
      if (!name.empty()) total += look(name);
      name.clear();
      if (!*c) return total;
    }
  }

  double view_transform(const std::string& name) {
    const ocio::ConstViewTransformRcPtr found = config_->getViewTransform(name.c_str());
    if (!found) return 0;
    return count_both_directions("the view transform \"" + name + "\"", *found,
                                 ocio::VIEWTRANSFORM_DIR_TO_REFERENCE,
                                 ocio::VIEWTRANSFORM_DIR_FROM_REFERENCE);
  }

  double view(const char* display, const char* name) {
    return count_once("the view \"" + std::string(display) + " / " + name + "\"", [&] {
      const auto text = [](const char* c) { return std::string(c ? c : ""); };
      const std::string shown = text(config_->getDisplayViewColorSpaceName(display, name));
      return space(shown == "<USE_DISPLAY_NAME>" ? display : shown) +
             view_transform(text(config_->getDisplayViewTransformName(display, name))) +
             looks(config_->getDisplayViewLooks(display, name));
    });
  }

  double transform(const ocio::ConstTransformRcPtr& one) {
    if (!one) return 0;
    if (const auto group = ocio::DynamicPtrCast<const ocio::GroupTransform>(one)) {
      double total = 1;
      for (int i = 0; i < group->getNumTransforms(); ++i)
        total += transform(group->getTransform(i));
      return total;
    }
    if (const auto conversion = ocio::DynamicPtrCast<const ocio::ColorSpaceTransform>(one)) {
      return 1 + space(conversion->getSrc()) + space(conversion->getDst());
    }
    if (const auto look = ocio::DynamicPtrCast<const ocio::LookTransform>(one)) {
      return 1 + space(look->getSrc()) + space(look->getDst()) + looks(look->getLooks());
    }
    if (const auto shown = ocio::DynamicPtrCast<const ocio::DisplayViewTransform>(one)) {
      return 1 + space(shown->getSrc()) + view(shown->getDisplay(), shown->getView());
    }
    if (const auto file = ocio::DynamicPtrCast<const ocio::FileTransform>(one)) {
      check_file(file->getSrc());
    }
    return 1;
  }

  // Ignores a missing file. OpenColorIO reports the file if it is needed.
  void check_file(const char* name) {
    std::string path;
    try {
      path = config_->getCurrentContext()->resolveFileLocation(name);
    } catch (const ocio::Exception&) {
      return;
    }
    if (std::ranges::find(files_, path) != files_.end()) return;
    const InputFile file(path, "the OpenColorIO config " + place_);
    if (file.size() > kMaxTableBytes) {
      throw InputError(place_, "{} is too large for a colour lookup table: {}", path,
                       readable_bytes(file.size()));
    }
    check_references(file, path);
    files_.push_back(path);
  }

  // Rejects XML tables (CTF, CLF) that refer to further files. OpenColorIO would open these files
  // without any check, even if they are devices or pipes or refer to each other in a cycle. Configs
  // can use a GroupTransform instead. DOCTYPE is rejected too, since XML entities could hide such a
  // reference.
  void check_references(const InputFile& file, const std::string& path) {
    std::array<char, 64> begin;
    const int64_t read = file.try_read(0, begin.size(), begin.data());
    const std::string_view head(begin.data(), size_t(std::max<int64_t>(0, read)));
    const size_t first =
        head.find_first_not_of(std::string_view("\0\xef\xbb\xbf\xff\xfe \t\r\n", 10));
    if (first == std::string_view::npos || head[first] != '<') return;
    std::string text = file.read_text();
    std::erase(text, '\0');  // in case the text is UTF-16
    for (const char* unsupported : {"<Reference", "<!DOCTYPE"}) {
      if (text.find(unsupported) == std::string::npos) continue;
      throw InputError(place_, "{}: \"{}\" is not supported; name the lookup tables in the config",
                       path, unsupported);
    }
  }

  const ocio::ConstConfigRcPtr& config_;
  const std::string& place_;
  std::map<std::string, double> counts_;  // negative: not finished yet
  int depth_ = 0;
  std::vector<std::string> files_;
};

// Removes comments. Keeps comments that contain a quote, because they may be part of a string.
std::string strip_comments(const std::string& text) {
  std::string result;
  for (size_t i = 0; i < text.size();) {
    const size_t end = std::min(text.find_first_of("\r\n", i), text.size());
    const bool begins = i == 0 || std::strchr(" \t\r\n", text[i - 1]);
    const std::string_view rest = std::string_view(text).substr(i, end - i);
    if (text[i] == '#' && begins && rest.find_first_of("\"'") == std::string_view::npos) {
      i = end;
    } else {
      result += text[i++];
    }
  }
  return result;
}

// Returns the names that follow `indicator`: '&' for anchors, '*' for aliases. Plain text may have
// such names too, so the caller counts only aliases that have an anchor. Treats all non-ASCII
// characters as the same one, since the YAML parser replaces every damaged character by the same.
std::vector<std::string> yaml_names(const std::string& text, char indicator) {
  std::vector<std::string> names;
  for (size_t i = text.find(indicator); i != std::string::npos; i = text.find(indicator, i + 1)) {
    const size_t end = std::min(text.find_first_of("[]{}, \t\r\n", i), text.size());
    std::string name;
    for (size_t c = i + 1; c < end; ++c) {
      const bool is_ascii = uint8_t(text[c]) < 0x80;
      if (is_ascii || name.empty() || name.back() != '\x7f') name += is_ascii ? text[c] : '\x7f';
    }
    if (!name.empty()) names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

std::vector<std::string> check_ocio_config(const ocio::ConstConfigRcPtr& config,
                                           const std::string& place) {
  return ConfigChecker(config, place).files();
}

void check_ocio_aliases(const std::string& text, const std::string& place) {
  const bool is_archive = text.starts_with("PK");  // .ocioz
  if (!is_archive && text.find('\0') != std::string::npos) {
    throw InputError(place, "the OpenColorIO config is not UTF-8 text");
  }
  const std::string yaml = strip_comments(text);
  const std::vector<std::string> anchors = yaml_names(yaml, '&'), aliases = yaml_names(yaml, '*');
  const std::set<std::string> known(anchors.begin(), anchors.end());
  const auto is_alias = [&](const std::string& name) { return known.contains(name); };
  if (std::ranges::count_if(aliases, is_alias) > kMaxAliases) {
    throw InputError(place, "has more than {} YAML aliases (*name); replace them with their values",
                     kMaxAliases);
  }
}

}  // namespace emberline
