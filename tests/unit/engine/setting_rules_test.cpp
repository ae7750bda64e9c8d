#include "renderer/engine/setting_rules.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/option_rules.h"
#include "unit/setting_values.h"

namespace emberline {
namespace {

// Makes conditions true that are not settings or that are special values of a setting.
const std::map<std::string, void (*)(RenderOptions&)> kOptions = {
    {"output FILE.exr", [](RenderOptions& o) { o.outputs = {"a.exr"}; }},
    {"report FILE.html", [](RenderOptions& o) { o.reports = {"a.html"}; }},
    {"snapshots", [](RenderOptions& o) { o.snapshots = "shots"; }},
    {"tree", [](RenderOptions& o) { o.trees = {"a.json"}; }},
    {"explain", [](RenderOptions& o) { o.explained = Vec2i(0); }},
    {"replay", [](RenderOptions& o) { o.replay = "0,0,0"; }},
    {"display tev", [](RenderOptions& o) { o.viewer.emplace(); }},
    {"skip-existing", [](RenderOptions& o) { o.skip_existing = true; }},
    {"stop-on-error", [](RenderOptions& o) { o.stop_on_error = true; }},
    {"range-report", [](RenderOptions& o) { o.range_report = "a.json"; }},
    {"frames", [](RenderOptions& o) { o.frames = {7}; }},
    {"frames A-B",
     [](RenderOptions& o) {
       o.frames = {7, 8};
     }},
    {"turntable N",
     [](RenderOptions& o) {
       o.turntable = Turntable{std::nullopt, 1};
     }},
    {"turntable 2 or more",
     [](RenderOptions& o) {
       o.turntable = Turntable{std::nullopt, 2};
     }},
    {"turntable K/N",
     [](RenderOptions& o) {
       o.turntable = Turntable{1, 2};
     }},
};

std::string key(const SettingCondition& condition) {
  return condition.value.empty() ? std::string(condition.name)
                                 : fmt::format("{} {}", condition.name, condition.value);
}

std::vector<std::string> values_of(const Setting& setting) {
  std::vector<std::string> values;
  for (const SettingChoice& choice : setting.choices) values.push_back(choice.name);
  return values;
}

// The settings and options that are given. Everything else has its default.
struct Given {
  std::map<std::string, std::string> settings;
  std::set<std::string> options;

  void set(const SettingCondition& condition) {
    if (kOptions.contains(key(condition))) {
      options.insert(key(condition));
      return;
    }
    const std::string name(condition.name);
    std::string& text = settings[name];
    const bool list =
        find_setting(name)->type == "LIST" && !condition.value.empty() && !text.empty();
    text = condition.value.empty() ? test::non_default_values().at(name)
                                   : (list ? text + "," : "") + std::string(condition.value);
    if (!condition.with.empty()) set({condition.with});
    if (!condition.without.empty()) settings.erase(std::string(condition.without));
  }
  void remove(const SettingCondition& condition) {
    options.erase(key(condition));
    settings.erase(std::string(condition.name));
  }
  RenderOptions make() const {
    RenderOptions made;
    for (const auto& [name, text] : settings) find_setting(name)->read(made, text);
    for (const std::string& option : options) kOptions.at(option)(made);
    return made;
  }
};

std::vector<SettingRule> all_rules() {
  std::vector<SettingRule> all(setting_rules().begin(), setting_rules().end());
  all.insert(all.end(), option_rules().begin(), option_rules().end());
  return all;
}

// Searches for options for which `about` holds and which break only `wanted`, or no rule if
// `wanted` is null.
class Search {
 public:
  Search(const std::vector<SettingRule>& rules, const SettingRule* wanted,
         const SettingCondition& about)
      : rules_(rules), wanted_(wanted), about_(about) {}

  std::optional<Given> from(const Given& given, int steps = 4) const {
    const RenderOptions options = given.make();
    const auto holds = [&](const SettingCondition& condition) {
      return option_holds(options, condition);
    };
    if (!holds(about_)) return std::nullopt;
    const SettingRule* other = nullptr;
    bool found = !wanted_;
    for (const SettingRule& rule : rules_) {
      if (find_violation(rule, options, holds).empty()) continue;
      &rule == wanted_ ? void(found = true) : void(other = &rule);
    }
    if (found && !other) return given;
    if (steps == 0) return std::nullopt;
    for (const Given& next : found ? satisfy(given, *other) : violate(given)) {
      if (const auto end = from(next, steps - 1)) return end;
    }
    return std::nullopt;
  }

 private:
  static std::vector<Given> satisfy(const Given& given, const SettingRule& rule) {
    std::vector<Given> next;
    for (const SettingCondition& needed : rule.needs) next.emplace_back(given).set(needed);
    for (const SettingCondition& excluded : rule.excludes)
      next.emplace_back(given).remove(excluded);
    return next;
  }
  std::vector<Given> violate(const Given& given) const {
    std::vector<Given> next;
    for (const SettingCondition& excluded : wanted_->excludes)
      next.emplace_back(given).set(excluded);
    for (const SettingCondition& needed : wanted_->needs) {
      const Setting* const setting = find_setting(needed.name);
      if (!setting) continue;
      for (const std::string& value : values_of(*setting)) {
        next.emplace_back(given).settings[setting->name] = value;
      }
      if (!needed.without.empty()) next.emplace_back(given).set({needed.without});
    }
    return next;
  }

  const std::vector<SettingRule>& rules_;
  const SettingRule* const wanted_;
  const SettingCondition about_;
};

std::string message_of(const RenderOptions& options) {
  try {
    check_options(options);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(SettingRules, EveryRuleCanBeBrokenAloneAndObeyed) {
  const std::vector<SettingRule> rules = all_rules();
  ASSERT_GT(rules.size(), 40u);
  for (const SettingRule& rule : rules) {
    if (rule.violation) continue;  // tested below
    ASSERT_TRUE(!rule.needs.empty() || !rule.excludes.empty()) << rule.reason;
    for (const SettingCondition& about : rule.about) {
      Given given;
      given.set(about);
      const auto broken = Search(rules, &rule, about).from(given);
      ASSERT_TRUE(broken) << key(about) << ": " << rule.reason;
      const std::string message = message_of(broken->make());
      EXPECT_TRUE(message.starts_with(about.name)) << key(about) << ": " << message;
      EXPECT_TRUE(message.find(rule.needs.empty() ? " excludes " : " requires ") !=
                  std::string::npos)
          << message;
      EXPECT_EQ(message.find_first_of("{}\n`"), std::string::npos) << message;
      const auto obeyed = Search(rules, nullptr, about).from(given);
      ASSERT_TRUE(obeyed) << key(about) << ": " << rule.reason;
      EXPECT_EQ(message_of(obeyed->make()), "");
    }
  }
}

// Every exclusion is needed: none of them follows from another rule.
TEST(SettingRules, EachExclusionIsRefusedByItsOwnRule) {
  const std::vector<SettingRule> rules = all_rules();
  for (size_t i = 0; i < rules.size(); ++i) {
    for (const SettingCondition& excluded : rules[i].excludes) {
      std::vector<SettingRule> narrowed = rules;
      narrowed[i].excludes = {excluded};
      const bool found = std::ranges::any_of(rules[i].about, [&](const SettingCondition& about) {
        Given given;
        given.set(about);
        return Search(narrowed, &narrowed[i], about).from(given).has_value();
      });
      EXPECT_TRUE(found) << key(excluded) << ": " << rules[i].reason;
    }
  }
}

TEST(SettingRules, DefaultsObeyThem) {
  EXPECT_EQ(message_of({}), "");
  EXPECT_NO_THROW(RenderPlan{FrameSettings()});
}

TEST(SettingRules, NumbersAreCompared) {
  FrameSettings s;
  const auto message = [&] {
    try {
      check_rules(s);
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  s.crop = Rect{0, 0, s.width + 1, 1};
  EXPECT_EQ(message(),
            "crop: 0,0,1281,1 is not inside the frame; valid is 0 <= X0 < X1 <= 1280 and 0 <= Y0 < "
            "Y1 <= 720");
  for (const Rect& crop : {Rect{4, 4, 4, 5}, Rect{-1, 0, 1, 1}}) {
    s.crop = crop;
    EXPECT_TRUE(message().starts_with("crop: "));
  }
  s.crop = Rect{0, 0, s.width, s.height};
  EXPECT_EQ(message(), "");
  s = {};
  s.driver = "adaptive";
  s.min_spp = s.max_spp = s.spp = 8;
  EXPECT_EQ(message(), "");
  s.min_spp = 9;
  EXPECT_EQ(message(), "min-spp 9 is above max-spp 8; valid is 1 to 8");
  s.max_spp.reset();
  EXPECT_EQ(message(), "min-spp 9 is above the average of spp 8; valid is 1 to 8");

  RenderOptions options;
  options.driver = "adaptive";
  options.crop = Rect{2, 3, 10, 11};
  options.explained = Vec2i(9, 10);
  EXPECT_EQ(message_of(options), "");
  options.explained = Vec2i(10, 10);
  EXPECT_EQ(message_of(options),
            "explain: pixel 10,10 is outside the rendered pixels; valid is 2 to 9 and 3 to 10");
}

TEST(SettingRules, EveryNameIsASettingOrAnOption) {
  const auto check = [](std::span<const SettingRule> rules, bool options) {
    for (const SettingRule& rule : rules) {
      ASSERT_FALSE(rule.about.empty());
      for (const AnyCondition& list : {rule.about, rule.needs, rule.excludes, rule.unless}) {
        for (const SettingCondition& condition : list) {
          const Setting* const setting = find_setting(condition.name);
          EXPECT_TRUE(setting || options) << condition.name;
          if (options && kOptions.contains(key(condition))) continue;
          ASSERT_TRUE(setting) << condition.name;
          const std::vector<std::string> values = values_of(*setting);
          if (!condition.value.empty() && !values.empty()) {
            EXPECT_NE(std::ranges::find(values, condition.value), values.end())
                << condition.name << " " << condition.value;
          }
          for (const std::string_view name : {condition.with, condition.without}) {
            EXPECT_TRUE(name.empty() || find_setting(name)) << name;
          }
        }
      }
    }
  };
  check(setting_rules(), false);
  check(option_rules(), true);
  for (const auto& [name, set] : kOptions) {
    const size_t space = name.find(' ');
    const SettingCondition condition{
        std::string_view(name).substr(0, space),
        space == std::string::npos ? "" : std::string_view(name).substr(space + 1)};
    RenderOptions options;
    EXPECT_FALSE(option_holds(options, condition)) << name;
    set(options);
    EXPECT_TRUE(option_holds(options, condition)) << name;
  }
}

bool same(const SettingCondition& a, const SettingCondition& b) {
  return a.name == b.name && (a.value == b.value || b.value.empty());
}

bool contains(const AnyCondition& list, const SettingCondition& condition) {
  return std::ranges::any_of(
      list, [&](const SettingCondition& of_list) { return same(condition, of_list); });
}

// Searches for two rules of which one needs what the other excludes. Returns their reasons, or an
// empty string.
std::string contradiction(std::span<const SettingRule> rules) {
  for (const SettingRule& one : rules) {
    for (const SettingRule& other : rules) {
      for (const SettingCondition& about : one.about) {
        const auto excluded = [&](const SettingCondition& needed) {
          return (contains(other.about, about) && contains(other.excludes, needed)) ||
                 (contains(other.about, needed) && contains(other.excludes, about));
        };
        if (one.needs.empty() || !std::ranges::all_of(one.needs, excluded)) continue;
        return fmt::format("{}: {} / {}", key(about), one.reason, other.reason);
      }
    }
  }
  return "";
}

TEST(SettingRules, NoTwoContradict) {
  EXPECT_EQ(contradiction(all_rules()), "");
  std::vector<SettingRule> rules = {
      {.about = {{"sun"}}, .needs = {{"env-strength"}}, .reason = "needs it"},
      {.about = {{"env-strength"}}, .excludes = {{"env"}, {"sun"}}, .reason = "excludes it"}};
  EXPECT_EQ(contradiction(rules), "sun: needs it / excludes it");
  rules[0].needs.push_back({"spp"});
  EXPECT_EQ(contradiction(rules), "");
}

TEST(SettingRules, HelpTellsThem) {
  const auto help = [](std::string_view name) { return rules_of(*find_setting(name)); };
  EXPECT_EQ(help("env-strength").rules, "; requires `env` or `sun`");
  EXPECT_EQ(help("env").rules, "; excludes `sun`");
  EXPECT_EQ(help("max-spp").rules,
            "; requires `driver` adaptive or bucket with `noise-threshold`; excludes `unbiased`");
  EXPECT_EQ(help("part").rules, "; requires `driver` bucket or `plan`; excludes `time-budget`");
  EXPECT_EQ(help("fps").rules, "");
  EXPECT_NE(help("aov").values.find("undoes the clamping; requires `clamp-indirect`\n"),
            std::string::npos);
  EXPECT_NE(help("filter").values.find("\n  gaussian: "), std::string::npos);
  EXPECT_EQ(as_sentences(help("max-spp").rules),
            " Requires `driver` adaptive or bucket with `noise-threshold`. Cannot be combined with "
            "`unbiased`.");
  EXPECT_EQ(as_sentences(""), "");
  EXPECT_EQ(rules_of(option_rules(), "snapshots"),
            "; requires `driver` bisection or adaptive; excludes `plan`, `part`, `sample-range`, "
            "`working-space`");
}

TEST(SettingRules, TellWhetherASettingIsAllowedWithTheOthers) {
  FrameSettings settings;
  const auto allowed = [&](std::string_view driver, std::string_view name) {
    settings.driver = driver;
    return setting_is_allowed(settings, name);
  };
  EXPECT_TRUE(allowed("adaptive", "estimator"));
  EXPECT_TRUE(allowed("adaptive", "noise-threshold"));
  EXPECT_TRUE(allowed("bucket", "noise-threshold"));
  EXPECT_FALSE(allowed("bucket", "estimator")) << "only with a threshold";
  EXPECT_FALSE(allowed("bisection", "noise-threshold"));
  EXPECT_FALSE(allowed("bisection", "estimator"));
  settings.noise_threshold = 0.01f;
  EXPECT_TRUE(allowed("bucket", "estimator"));
}

}  // namespace
}  // namespace emberline
