// Parses our HTML and SVG strictly: every element must be closed, every attribute must be quoted,
// and an ampersand must begin an entity. The parser is stricter than browsers, so that it detects
// text that is not escaped.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace emberline::test {

struct Element {
  std::string name;
  std::map<std::string, std::string> attributes;  // the values contain no entities
};

struct ParsedMarkup {
  std::string fault;  // empty if the markup is well formed
  std::vector<Element> elements;
  std::string text;  // the text between the tags, with entities replaced

  size_t count(std::string_view name) const {
    return size_t(std::ranges::count(elements, name, &Element::name));
  }
};

// Appends `from` to `to` and replaces its entities. Returns false if an ampersand does not begin an
// entity.
inline bool unescape(std::string_view from, std::string* to) {
  static const std::map<std::string_view, char> kEntities = {
      {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"#39", '\''}};
  for (size_t i = 0; i < from.size(); ++i) {
    if (from[i] != '&') {
      *to += from[i];
      continue;
    }
    const size_t end = from.find(';', i);
    if (end == std::string_view::npos) return false;
    const auto found = kEntities.find(from.substr(i + 1, end - i - 1));
    if (found == kEntities.end()) return false;
    *to += found->second;
    i = end;
  }
  return true;
}

// Parses a tag. `tag` is the text between < and >, without a final slash. Returns false if it is
// malformed.
inline bool read_element(std::string_view tag, Element* element) {
  const size_t name_end = std::min(tag.find_first_of(" \n"), tag.size());
  element->name = tag.substr(0, name_end);
  std::string_view remaining = tag.substr(name_end);
  while (!remaining.empty()) {
    const size_t begin = remaining.find_first_not_of(" \n");
    if (begin == std::string_view::npos) break;
    const size_t equals = remaining.find("=\"", begin);
    if (begin == 0 || equals == std::string_view::npos) return false;
    const size_t end = remaining.find('"', equals + 2);
    if (end == std::string_view::npos) return false;
    const std::string name(remaining.substr(begin, equals - begin));
    if (name.empty() || name.find_first_of(" <>'&") != std::string::npos) return false;
    std::string value;
    if (!unescape(remaining.substr(equals + 2, end - equals - 2), &value)) return false;
    if (!element->attributes.emplace(name, value).second) return false;
    remaining.remove_prefix(end + 1);
  }
  return !element->name.empty();
}

inline ParsedMarkup read_markup(std::string_view html) {
  ParsedMarkup read;
  std::vector<std::string> open;
  const auto fail = [&](const std::string& what, size_t at) {
    read.fault = what + " at \"" + std::string(html.substr(at, 80)) + "\"";
    return read;
  };
  size_t i = 0;
  while (i < html.size()) {
    if (html[i] != '<') {
      const size_t end = std::min(html.find('<', i), html.size());
      if (!unescape(html.substr(i, end - i), &read.text)) return fail("unknown entity", i);
      if (html.substr(i, end - i).find('>') != std::string_view::npos) return fail("stray >", i);
      i = end;
      continue;
    }
    const size_t end = html.find('>', i);
    if (end == std::string_view::npos) return fail("unterminated tag", i);
    std::string_view tag = html.substr(i + 1, end - i - 1);
    if (tag.find('<') != std::string_view::npos) return fail("< in a tag", i);
    if (tag.starts_with("!")) {
      i = end + 1;
      continue;
    }
    if (tag.starts_with("/")) {
      if (open.empty() || open.back() != tag.substr(1))
        return fail("closing tag without opening tag", i);
      open.pop_back();
      i = end + 1;
      continue;
    }
    const bool closed = tag.ends_with("/");
    if (closed) tag.remove_suffix(1);
    Element element;
    if (!read_element(tag, &element)) return fail("bad tag", i);
    read.elements.push_back(element);
    i = end + 1;
    if (closed || element.name == "img" || element.name == "meta") continue;
    open.push_back(element.name);
    if (element.name == "style") i = std::min(html.find("</style>", i), html.size());
  }
  if (!open.empty()) read.fault = "not closed: " + open.back();
  return read;
}

}  // namespace emberline::test
