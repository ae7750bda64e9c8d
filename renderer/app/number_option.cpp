#include "renderer/app/number_option.h"

#include <CLI/CLI.hpp>

#include "renderer/core/shortened.h"

namespace emberline {

CLI::Option* add_number_text(CLI::App* app, const std::string& name, const NumberRange& range,
                             const std::function<bool(const std::string& text)>& read,
                             const std::string& help) {
  return app
      ->add_option_function<std::string>(
          name,
          [name, range, read](const std::string& text) {
            if (!read(text)) {
              throw CLI::ValidationError(
                  name, fmt::format("'{}' is not a {} from {} to {}", shortened(text), range.kind,
                                    range.least, range.most));
            }
          },
          help)
      ->type_name(fmt::format("{}..{}", range.least, range.most));
}

}  // namespace emberline
