#include "renderer/app/node_tree.h"

#include <fmt/format.h>

#include "renderer/core/readable.h"
#include "renderer/core/shortened.h"
#include "renderer/core/utf8.h"

namespace emberline {
namespace {

constexpr size_t kMaxListed = 200, kMaxLevels = 24;

class NodeTree {
 public:
  explicit NodeTree(const std::vector<NodeDescription>& nodes)
      : nodes_(nodes),
        children_(nodes.size() + 1),
        level_(nodes.size(), 0),
        more_(nodes.size(), 0) {
    for (size_t i = 0; i < nodes.size(); ++i) children_[parent_of(i)].push_back(i);
    list_nodes();
    count_others();
  }

  std::string text() const;

 private:
  // Treats the roots as children of an extra node, whose index is nodes_.size().
  size_t parent_of(size_t node) const {
    return nodes_[node].parent < 0 ? nodes_.size() : size_t(nodes_[node].parent);
  }
  void list_nodes();
  void count_others();
  std::string line(size_t node) const;

  const std::vector<NodeDescription>& nodes_;
  std::vector<std::vector<size_t>> children_;
  std::vector<size_t> level_;  // from 1; 0: not listed
  std::vector<size_t> more_;   // number of unlisted nodes below each node
  size_t more_roots_ = 0;
};

// Chooses the nodes to list, breadth first, so that a large branch leaves room for the others.
void NodeTree::list_nodes() {
  std::vector<size_t> listed = {nodes_.size()};
  for (size_t next = 0; next < listed.size(); ++next) {
    const size_t level = listed[next] < nodes_.size() ? level_[listed[next]] + 1 : 1;
    if (level > kMaxLevels) return;
    for (const size_t child : children_[listed[next]]) {
      if (listed.size() > kMaxListed) return;
      level_[child] = level;
      listed.push_back(child);
    }
  }
}

// For each unlisted node, increases the count of its nearest listed ancestor in `more_`.
void NodeTree::count_others() {
  std::vector<size_t> order = {nodes_.size()}, sizes(nodes_.size(), 1);
  for (size_t next = 0; next < order.size(); ++next) {
    order.insert(order.end(), children_[order[next]].begin(), children_[order[next]].end());
  }
  for (size_t i = order.size() - 1; i > 0; --i) {
    const size_t node = order[i], parent = parent_of(node);
    if (level_[node] > 0) continue;
    if (parent == nodes_.size()) {
      more_roots_ += sizes[node];
    } else {
      (level_[parent] > 0 ? more_ : sizes)[parent] += sizes[node];
    }
  }
}

std::string NodeTree::line(size_t index) const {
  const NodeDescription& node = nodes_[index];
  std::string text =
      fmt::format("{:{}}{} '{}'", "", 2 * level_[index], index, printable(shortened(node.name)));
  const char* separator = "  ";
  const auto add = [&](bool applies, const std::string& what) {
    if (!applies) return;
    text += separator + what;
    separator = ", ";
  };
  add(node.has_mesh, "mesh");
  add(node.has_camera, "camera");
  add(node.has_light, "light");
  add(!node.in_scene, "not in the scene");
  add(more_[index] > 0, readable_count(more_[index]) + " more below");
  return text + "\n";
}

std::string NodeTree::text() const {
  std::string text;
  std::vector<size_t> stack = {nodes_.size()};
  while (!stack.empty()) {
    const size_t node = stack.back();
    stack.pop_back();
    if (node < nodes_.size()) {
      if (level_[node] == 0) continue;
      text += line(node);
    }
    stack.insert(stack.end(), children_[node].rbegin(), children_[node].rend());
  }
  if (more_roots_ > 0) text += fmt::format("  and {} more\n", readable_count(more_roots_));
  return text;
}

}  // namespace

std::string node_tree(const std::vector<NodeDescription>& nodes) { return NodeTree(nodes).text(); }

}  // namespace emberline
