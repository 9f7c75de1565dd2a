#include "groups/group_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>

#include "axes/quantity.hpp"
#include "driveline/runtime/config/finite_number.hpp"
#include "driveline/runtime/toml/suggestion.hpp"

namespace driveline::cli {
namespace {

using runtime::ClientGroupRequest;
using trajectory::PathMove;
using Verb = ClientGroupRequest::Verb;

/// A verb: the word after the name of a group.
struct Word {
  std::string_view name;
  Verb verb;
  bool relative = false;  ///< kMove: distances instead of positions
};

constexpr std::array kWords = {
    Word{"enable", Verb::kEnable},     Word{"disable", Verb::kDisable},    Word{"reset", Verb::kReset},
    Word{"move", Verb::kMove},         Word{"move-by", Verb::kMove, true}, Word{"arc", Verb::kMove},
    Word{"arc-by", Verb::kMove, true}, Word{"hold", Verb::kHold},          Word{"resume", Verb::kResume},
    Word{"reverse", Verb::kReverse},   Word{"forward", Verb::kForward},    Word{"override", Verb::kOverride},
    Word{"halt", Verb::kHalt},         Word{"stop", Verb::kStop},          Word{"release-stop", Verb::kReleaseStop},
};
constexpr std::array<std::string_view, 3> kOptions{"feed", "tolerance", "buffer"};
constexpr std::array<std::string_view, 3> kParts{"via", "center", "clockwise"};

std::string hint(std::string_view word, std::span<const std::string_view> known) {
  const auto meant = runtime::closest(word, known);
  return meant.empty() ? std::string{} : fmt::format("; did you mean {}?", meant);
}

/// Builds a request word by word.
class RequestReader {
 public:
  RequestReader(const NamedGroup& group, const Word& word) : group_(group), word_(word) {
    request_.verb = word.verb;
    request_.move.relative = word.relative;
    request_.move.path.tolerance = group.config.tolerance;
  }

  [[nodiscard]] Outcome<ClientGroupRequest> read(std::span<const std::string> words) {
    words_ = words;
    auto done = word_.verb == Verb::kOverride ? read_override() : is_arc() ? read_arc() : read_line();
    if (!done) return tl::unexpected(done.error());
    return request_;
  }

 private:
  [[nodiscard]] bool is_arc() const { return word_.name.starts_with("arc"); }

  [[nodiscard]] tl::unexpected<Failure> refuse(std::string_view what) const {
    return misused(fmt::format("group {}: {}: {}", group_.config.name, word_.name, what));
  }

  [[nodiscard]] Outcome<void> read_override() {
    constexpr double kPercent = 100.0;
    if (words_.size() != 1) return refuse("a factor such as 50% is expected");
    std::string_view word = words_[0];
    const bool percent = word.ends_with('%');
    if (percent) word.remove_suffix(1);
    const auto value = runtime::finite_number(word);
    if (!value) return misused(fmt::format("override \"{}\": a factor such as 50% or 0.5 is expected", words_[0]));
    request_.share = percent ? *value / kPercent : *value;
    return {};
  }

  /// Reads everything but an arc: a straight move, or a verb without operands.
  [[nodiscard]] Outcome<void> read_line() {
    if (word_.verb == Verb::kMove) {
      if (auto read = read_target(); !read) return read;
    }
    return read_options();
  }

  [[nodiscard]] Outcome<void> read_arc() {
    auto& path = request_.move.path;
    if (group_.config.axes.size() > trajectory::kMaxGroupAxes)
      return refuse(fmt::format("groups of more than {} axes support straight moves only", trajectory::kMaxGroupAxes));
    if (auto read = read_target(); !read) return read;
    if (words_.empty() || (words_[0] != "via" && words_[0] != "center")) {
      return refuse("via with a point of the arc, or center with the centre of its circle, is expected");
    }
    const bool via = words_[0] == "via";
    path.kind = via ? PathMove::Kind::kArcVia : PathMove::Kind::kArc;
    words_ = words_.subspan(1);
    const auto point = read_place(nullptr);
    if (!point) return tl::unexpected(point.error());
    std::copy(point->begin(), point->end(), (via ? path.via : path.center).begin());
    if (!via && !words_.empty() && words_[0] == "clockwise") {
      path.clockwise = true;
      words_ = words_.subspan(1);
    }
    return read_options();
  }

  [[nodiscard]] Outcome<void> read_target() {
    auto place = read_place(&request_.stays);
    if (!place) return tl::unexpected(place.error());
    if (place->size() > trajectory::kMaxGroupAxes) {
      request_.move.target = std::move(*place);
    } else {
      std::copy(place->begin(), place->end(), request_.move.path.target.begin());
    }
    return {};
  }

  /// Reads a number for each axis; "-" leaves an axis at its position.
  [[nodiscard]] Outcome<std::vector<double>> read_place(std::vector<bool>* stays) {
    std::vector<double> place(group_.config.axes.size());
    if (stays != nullptr) stays->resize(place.size());
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (words_.empty() || words_[0].find('=') != std::string::npos || is_part(words_[0])) return refuse(expected());
      if (stays != nullptr && words_[0] == "-") {
        (*stays)[i] = true;
      } else {
        const auto value = parse_quantity(group_.coordinate(i), Quantity::kPosition, words_[0],
                                          word_.relative ? "distance" : "position");
        if (!value) return tl::unexpected(value.error());
        place[i] = *value;
      }
      words_ = words_.subspan(1);
    }
    return place;
  }

  [[nodiscard]] static bool is_part(std::string_view word) {
    return std::find(kParts.begin(), kParts.end(), word) != kParts.end();
  }

  /// The message "2 positions are expected, of x, y".
  [[nodiscard]] std::string expected() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < group_.config.axes.size(); ++i) names.push_back(group_.coordinate(i).name);
    return fmt::format("{} positions are expected, of {}; - leaves an axis where it is", names.size(),
                       fmt::join(names, ", "));
  }

  [[nodiscard]] Outcome<void> read_options() {
    for (const std::string_view word : words_) {
      const auto equals = word.find('=');
      if (equals == std::string_view::npos) return refuse(fmt::format("\"{}\" was not expected", word));
      const auto name = word.substr(0, equals);
      const bool known = std::find(kOptions.begin(), kOptions.end(), name) != kOptions.end();
      if (!known || word_.verb != Verb::kMove) {
        return refuse(fmt::format("\"{}=\" does not belong there{}", name, known ? "" : hint(name, kOptions)));
      }
      auto read = name == "buffer" ? read_buffer(word.substr(equals + 1)) : read_figure(name, word.substr(equals + 1));
      if (!read) return read;
    }
    return {};
  }

  [[nodiscard]] Outcome<void> read_figure(std::string_view name, std::string_view text) {
    const bool feed = name == "feed";
    const auto value =
        parse_quantity(group_.coordinate(0), feed ? Quantity::kVelocity : Quantity::kPosition, text, name);
    if (!value) return tl::unexpected(value.error());
    if (feed && !(*value > 0.0)) return refuse("a feed above 0 is expected");
    if (!feed && *value < 0.0) return refuse("a tolerance of 0 or more is expected");
    auto& path = request_.move.path;
    (feed ? path.feed : path.tolerance) = *value;
    return {};
  }

  [[nodiscard]] Outcome<void> read_buffer(std::string_view text) {
    using motion::GroupBuffer;
    std::vector<std::string_view> names;
    for (const auto buffer : {GroupBuffer::kAborting, GroupBuffer::kBuffered, GroupBuffer::kBlending}) {
      names.push_back(to_text(buffer));
      if (names.back() != text) continue;
      request_.move.buffer = buffer;
      return {};
    }
    return misused(fmt::format("buffer \"{}\": {} are possible{}", text, fmt::join(names, ", "), hint(text, names)));
  }

  const NamedGroup& group_;
  const Word& word_;
  std::span<const std::string> words_;
  ClientGroupRequest request_;
};

}  // namespace

motion::AxisConfig NamedGroup::coordinate(std::size_t number) const {
  auto made = axes[config.axes[number]];
  if (!config.machine || number >= config.machine->kinematics().coordinates().size()) return made;
  const auto& tool = config.machine->kinematics().coordinates()[number];
  made.name = tool.name;
  made.kind = tool.kind;
  made.unit = &config.machine->unit_of(tool);
  return made;
}

std::span<const std::string_view> group_verbs() {
  static const auto kNames = [] {
    std::vector<std::string_view> names;
    for (const auto& word : kWords) names.push_back(word.name);
    return names;
  }();
  return kNames;
}

Outcome<ClientGroupRequest> parse_group_request(const NamedGroup& group, std::span<const std::string> words) {
  const auto& name = group.config.name;
  if (words.empty()) {
    return misused(
        fmt::format("group {}: a request is missing; {} are possible", name, fmt::join(group_verbs(), ", ")));
  }
  const auto* const word =
      std::find_if(kWords.begin(), kWords.end(), [&](const Word& one) { return one.name == words[0]; });
  if (word != kWords.end()) return RequestReader(group, *word).read(words.subspan(1));
  const auto meant = hint(words[0], group_verbs());
  return misused(fmt::format("group {}: unknown request \"{}\"{}", name, words[0],
                             meant.empty() ? fmt::format("; {} are possible", fmt::join(group_verbs(), ", ")) : meant));
}

Outcome<std::size_t> find_group(std::span<const runtime::AxisGroupConfig> groups, std::string_view name) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    names.emplace_back(groups[i].name);
    if (groups[i].name == name) return i;
  }
  if (groups.empty()) return misused("the line has no groups of axes ([[axis_group]])");
  return misused(
      fmt::format("there is no group \"{}\"; the line has {}{}", name, fmt::join(names, ", "), hint(name, names)));
}

}  // namespace driveline::cli
