#include "renderer/app/number_option.h"

#include <CLI/CLI.hpp>

#include "renderer/core/shortened.h"

namespace emberline {

CLI::Option* add_parsed(CLI::App* app, const std::string& name, const std::string& type,
                        const std::string& help, const std::string& what,
                        const std::function<bool(const std::string& text)>& read) {
  const auto check = [name, what, read](const std::string& text) {
    if (read(text)) return;
    throw CLI::ValidationError(name, fmt::format("'{}' is not {}", shortened(text), what));
  };
  return app->add_option_function<std::string>(name, check, help)->type_name(type);
}

}  // namespace emberline
