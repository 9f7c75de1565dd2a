#include "stream/stream_server.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "stream/stream_peer.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::steady_clock;
using stream::EndReason;

constexpr std::size_t kMaxVisitors = 8;
/// Time-out for the Hello of a connected client.
constexpr auto kHelloTimeout = std::chrono::seconds{1};
/// Time-out for the confirmation that a client has mapped its memory. Until then it has no axis.
constexpr auto kMappedTimeout = std::chrono::seconds{5};
/// Interval between two events about refused clients.
constexpr auto kRefusalInterval = std::chrono::seconds{1};

/// Returns the text of a client with only printable ASCII: it reaches terminals and files.
std::string printable(std::string_view text) {
  std::string result(text.empty() ? "?" : text);
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~' || c == '"'; }, '?');
  return result;
}

}  // namespace

Result<std::unique_ptr<StreamServer>> StreamServer::open(const StreamConfig& config, std::vector<StreamAxis> axes,
                                                         StreamHub& hub, AxisAuthority& authority,
                                                         std::chrono::nanoseconds period) {
  const bool others = !config.allowed.users.empty() || config.allowed.group.has_value();
  auto socket = StreamSocket::listen(config.socket, others);
  if (!socket) return tl::unexpected(socket.error());
  return std::unique_ptr<StreamServer>(
      new StreamServer(config, std::move(axes), hub, authority, period, std::move(*socket)));
}

StreamServer::StreamServer(const StreamConfig& config, std::vector<StreamAxis> axes, StreamHub& hub,
                           AxisAuthority& authority, std::chrono::nanoseconds period, StreamSocket socket)
    : config_(config),
      axes_(std::move(axes)),
      hub_(hub),
      authority_(authority),
      period_(period),
      socket_(std::move(socket)) {}

StreamServer::~StreamServer() = default;

events::StreamUp StreamServer::offer() const {
  events::StreamUp up{config_.socket.string(), {}};
  for (const auto& axis : axes_) up.axes.push_back(axis.name);
  return up;
}

std::vector<Event> StreamServer::poll() {
  if (socket_) let_in();
  hear_newcomers();
  hear_visitors();
  look_after_clients();
  return std::exchange(events_, {});
}

void StreamServer::close() {
  socket_.reset();
  visitors_.clear();
  newcomers_.clear();
  for (auto& client : clients_) client->session->request_end(EndReason::kLine);
}

void StreamServer::note(EventFacts facts, Severity severity) {
  events_.push_back({std::move(facts), severity, {}});
}

void StreamServer::let_in() {
  for (std::size_t i = 0; i < kMaxVisitors; ++i) {
    auto socket = socket_->accept();
    if (!socket.valid()) return;
    auto peer = peer_of(socket.get());
    if (!peer) continue;
    peer->name = "?";
    Visitor visitor{std::move(socket), std::move(*peer), steady_clock::now()};
    if (!may_stream(visitor.socket.get(), visitor.peer, config_.allowed)) {
      refuse(visitor, fmt::format("user {} may not stream to this line", visitor.peer.user));
    } else if (visitors_.size() + newcomers_.size() >= kMaxVisitors) {
      refuse(visitor, "too many clients connect at the same time");
    } else {
      visitors_.push_back(std::move(visitor));
    }
  }
}

void StreamServer::hear_visitors() {
  std::erase_if(visitors_, [this](Visitor& visitor) { return hear(visitor); });
}

/// Processes the message of a visitor. Returns true if no further message is expected.
bool StreamServer::hear(Visitor& visitor) {
  const auto message = receive_message(visitor.socket.get());
  if (message.closed) return true;
  if (message.bytes.empty()) {
    if (steady_clock::now() - visitor.since < kHelloTimeout) return false;
    refuse(visitor, "it sent no Hello in time");
    return true;
  }
  const auto hello = stream::from_bytes<stream::Hello>(message.bytes);
  if (!hello) {
    refuse(visitor, fmt::format("its first message is not a Hello of version {}", stream::kVersion));
  } else {
    visitor.peer.name = printable(hello->name.text());
    greet(visitor, *hello);
  }
  return true;
}

void StreamServer::greet(Visitor& visitor, const stream::Hello& hello) {
  if (hello.version != stream::kVersion) {
    refuse(visitor, fmt::format("it uses version {} of the stream protocol, the line uses version {}", hello.version,
                                stream::kVersion));
    return;
  }
  auto members = choose(hello);
  if (!members) {
    refuse(visitor, members.error().reason);
    return;
  }
  LeaseTerms terms;
  terms.owner = describe(visitor.peer);
  terms.take_over = hello.take_over == 1;
  if (auto free = check(*members, terms); !free) {
    refuse(visitor, free.error().reason);
    return;
  }
  auto session = StreamSession::make(std::move(*members), hello.power == 1, config_.settings, period_, authority_,
                                     rt::SharedSealing::kSizeOnly);
  if (!session) {
    refuse(visitor, session.error().reason);
    return;
  }
  const std::array descriptors{(*session)->setpoints().descriptor(), (*session)->status().descriptor()};
  // If the client has disconnected, its closed connection shows that later.
  static_cast<void>(send_answer(visitor.socket.get(), acceptance(**session), descriptors));
  visitor.since = steady_clock::now();
  newcomers_.push_back({std::move(visitor), std::move(*session), std::move(terms)});
}

void StreamServer::hear_newcomers() {
  std::erase_if(newcomers_, [this](Newcomer& newcomer) { return hear(newcomer); });
}

/// Processes the message of a newcomer. Returns true if no further message is expected.
bool StreamServer::hear(Newcomer& newcomer) {
  auto& visitor = newcomer.visitor;
  const auto message = receive_message(visitor.socket.get());
  if (message.closed) return true;
  if (message.bytes.empty() && steady_clock::now() - visitor.since < kMappedTimeout) return false;
  if (stream::from_bytes<stream::Mapped>(message.bytes)) {
    begin(newcomer);
  } else {
    refuse(visitor, "it has not confirmed that it has mapped its memory");
  }
  return true;
}

/// Gives a client its axes, and its session to the cycle.
void StreamServer::begin(Newcomer& newcomer) {
  auto& [visitor, session, terms] = newcomer;
  if (auto admitted = admit(*session, terms); !admitted) {
    for (std::size_t i = 0; i < session->members().size(); ++i) {
      release(visitor.peer, session->members()[i].axis, session->lease(i));
    }
    refuse(visitor, admitted.error().reason);
    return;
  }
  static_cast<void>(send_answer(visitor.socket.get(), acceptance(*session), {}));
  std::vector<StreamAxis> axes;
  for (const auto& member : session->members()) axes.push_back(offered(member.axis));
  SessionWatch watch(visitor.peer, std::move(axes), *session);
  watch.tell_begin(note_);
  clients_.push_back(std::make_unique<Client>(Client{std::move(visitor.socket), std::move(session), std::move(watch)}));
}

Result<std::vector<StreamSession::Member>> StreamServer::choose(const stream::Hello& hello) const {
  const auto no = [](std::string reason) { return fail(ErrorKind::kSetting, std::move(reason)); };
  if (hello.axis_count == 0 || hello.axis_count > stream::kMaxAxes) {
    return no(fmt::format("a client has 1 to {} axes, not {}", stream::kMaxAxes, hello.axis_count));
  }
  std::vector<StreamSession::Member> members;
  for (std::size_t i = 0; i < hello.axis_count; ++i) {
    const auto name = hello.axes[i].text();
    const auto found = std::find_if(axes_.begin(), axes_.end(), [&](const auto& axis) { return axis.name == name; });
    if (found == axes_.end()) {
      return no(fmt::format("there is no axis \"{}\" for streams, there are {}", printable(name),
                            fmt::join(offer().axes, ", ")));
    }
    const auto same = [&](const auto& member) { return member.axis == found->axis; };
    if (std::any_of(members.begin(), members.end(), same)) {
      return no(fmt::format("axis {} is named twice", found->name));
    }
    members.push_back({found->axis, found->bounds});
  }
  return members;
}

/// Takes a lease for each axis of the session, and adds the session to the cycle. Takes no axis over before it is clear
/// that the session can begin. After an error, the session has the leases that were taken.
Result<void> StreamServer::admit(StreamSession& session, const LeaseTerms& terms) {
  if (auto free = check(session.members(), terms); !free) return free;
  if (auto closed = session.close_to_writers(); !closed) return closed;
  for (std::size_t i = 0; i < session.members().size(); ++i) {
    const auto& member = session.members()[i];
    const bool moved = !authority_.owner_of(member.axis).empty();
    const auto taken = authority_.take(member.axis, terms);
    if (!taken) return tl::unexpected(refusal_of(member, taken.error()));
    session.give(i, *taken);
    if (moved) session.halt_first(i);
  }
  if (!hub_.add(session)) return fail(ErrorKind::kMachine, "the maximum number of stream clients is reached");
  return {};
}

Result<void> StreamServer::check(std::span<const StreamSession::Member> members, const LeaseTerms& terms) const {
  for (const auto& member : members) {
    const auto owner = authority_.owner_of(member.axis);
    // One process may have several clients of the same name; they must not share an axis.
    if (owner == terms.owner) return tl::unexpected(refusal_of(member, {owner}));
    if (const auto free = authority_.check(member.axis, terms); !free)
      return tl::unexpected(refusal_of(member, free.error()));
  }
  if (hub_.full()) return fail(ErrorKind::kMachine, "the maximum number of stream clients is reached");
  return {};
}

Error StreamServer::refusal_of(const StreamSession::Member& member, const LeaseRefusal& owned) const {
  AxisRefusal refusal;
  refusal.why = owned.firm ? AxisRefusal::Why::kMovedTogether : AxisRefusal::Why::kOwned;
  refusal.owner = owned.owner;
  return fail(ErrorKind::kSetting, describe(events::EventAxis{offered(member.axis).name, {}, 1.0}, refusal)).value();
}

const StreamAxis& StreamServer::offered(std::size_t axis) const {
  return *std::find_if(axes_.begin(), axes_.end(), [&](const auto& one) { return one.axis == axis; });
}

stream::Answer StreamServer::acceptance(const StreamSession& session) const {
  stream::Answer answer;
  answer.accepted = 1;
  answer.period_ns = period_.count();
  answer.keep_alive_ns = config_.settings.keep_alive.count();
  answer.longest_ahead_ns = std::chrono::nanoseconds{StreamSession::kLongestAhead}.count();
  answer.records_per_cycle = StreamSession::kRecordsPerCycle;
  for (std::size_t i = 0; i < session.members().size(); ++i) answer.bounds[i] = session.members()[i].bounds;
  return answer;
}

void StreamServer::refuse(Visitor& visitor, const std::string& reason) {
  stream::Answer answer;
  answer.refusal.set(reason);
  static_cast<void>(send_answer(visitor.socket.get(), answer, {}));
  const auto now = steady_clock::now();
  if (last_refusal_ != Instant{} && now - last_refusal_ < kRefusalInterval) {
    ++unreported_;
    return;
  }
  last_refusal_ = now;
  note(events::StreamClientRefused{visitor.peer, reason, std::exchange(unreported_, 0)}, Severity::kNotice);
}

void StreamServer::look_after_clients() {
  for (auto& client : clients_) {
    if (receive_message(client->socket.get()).closed) client->session->request_end(EndReason::kGone);
    client->watch.poll(note_);
    lease_again(*client);
    if (hub_.holds(*client->session)) continue;
    client->watch.poll(note_);
    for (std::size_t i = 0; i < client->session->members().size(); ++i) {
      release(client->watch.peer(), client->session->members()[i].axis, client->session->lease(i));
    }
    client->watch.tell_end(note_);
    client.reset();
  }
  std::erase(clients_, nullptr);
}

/// Takes axes without an owner that the client requests back.
void StreamServer::lease_again(Client& client) {
  LeaseTerms terms;
  terms.owner = describe(client.watch.peer());
  for (std::size_t i = 0; i < client.session->members().size(); ++i) {
    const auto axis = client.session->members()[i].axis;
    if (!client.session->asks_for(i) || !authority_.owner_of(axis).empty()) continue;
    const auto taken = authority_.take(axis, terms);
    if (!taken) continue;
    client.session->give(i, *taken);
    note(events::StreamClientCame{client.watch.peer(), {client.watch.axes()[i].name}}, Severity::kProgress);
  }
}

/// Releases an axis unless another client has taken it over.
void StreamServer::release(const StreamPeer& peer, std::size_t axis, std::uint64_t lease) {
  if (authority_.goes_on(axis, lease)) authority_.release(axis, describe(peer));
}

}  // namespace driveline::runtime
