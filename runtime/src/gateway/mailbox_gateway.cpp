#include "driveline/runtime/gateway/mailbox_gateway.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <thread>
#include <utility>

#include "driveline/ecat_master/mailbox/mail_exchange.hpp"
#include "driveline/port/descriptor_reserve.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/foe.hpp"
#include "gateway/gateway_access.hpp"
#include "gateway/gateway_frame.hpp"
#include "gateway/gateway_sockets.hpp"
#include "gateway/tcp_user.hpp"

namespace driveline::runtime {
namespace {

using wire::MailboxErrorCode;
using wire::MailboxType;

constexpr auto kIdle = std::chrono::milliseconds{100};
/// Pause when a client can neither be accepted nor turned away.
constexpr auto kDescriptorPause = std::chrono::milliseconds{10};
/// Time-out for each mailbox message of an answer.
constexpr auto kMessageTimeout = std::chrono::milliseconds{500};
constexpr std::size_t kMaxClients = 64;
constexpr std::size_t kMaxTcpClients = 16;
/// Most requests in progress, per client and in total. UDP clients are created at no cost, so the total is limited,
/// too.
constexpr std::size_t kMaxUnderWay = 4;
constexpr std::size_t kMaxRequests = 64;
/// Most changes that wait for take_writes(). Further ones are refused, so that none is missing among the events.
constexpr std::size_t kMaxWrites = 256;

bool is_sdo_abort(std::span<const std::byte> service) {
  constexpr std::byte kAbort{0x80};  // in the command byte, ETG.1000.6 Table 40
  const auto header = wire::CoeHeader::decode(service);
  return header && header->service == wire::CoeService::kSdoRequest && service.size() > wire::CoeHeader::kSize &&
         (service[wire::CoeHeader::kSize] & std::byte{0xE0}) == kAbort;
}

}  // namespace

class MailboxGateway::Service {
 public:
  Service(ecat_master::MailboxEngine& engine, std::vector<ecat_master::SlaveRef> slaves,
          const GatewaySettings& settings, GatewaySockets sockets)
      : engine_(engine), slaves_(std::move(slaves)), settings_(settings), sockets_(std::move(sockets)) {
    thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
  }

  [[nodiscard]] std::uint16_t port() const noexcept { return sockets_.port; }
  [[nodiscard]] std::vector<GatewayClient> clients() const {
    const std::scoped_lock lock(mutex_);
    std::vector<GatewayClient> all;
    for (const auto& client : clients_) all.push_back(client->figures);
    return all;
  }
  void stop() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] std::vector<GatewayWrite> take_writes() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(writes_, {});
  }

 private:
  using SteadyClock = std::chrono::steady_clock;
  struct Client {
    GatewayClient figures;
    sockaddr_in address{};
    rt::FileDescriptor socket;        ///< for a TCP client
    bool tcp = false;                 ///< stays true when its socket is closed
    bool may_write = false;           ///< may change parameters and files of slaves
    SteadyClock::time_point heard{};  ///< last message, answer, or start of an incomplete message
    GatewayStream received;           ///< for a TCP client
    std::vector<std::byte> waiting;   ///< for a TCP client: answers that it has not read yet
    /// Station addresses of the slaves that have sent the client the last packet of a file.
    std::set<std::uint16_t> files_read;
  };
  struct Request {
    std::shared_ptr<Client> client;
    wire::MailboxHeader header;
    std::shared_ptr<ecat_master::MailExchange> exchange;
  };

  void serve(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      wait_for_clients();
      drop_incomplete();
      if (requests_.empty()) continue;
      engine_.drive();
      hand_out_answers();
    }
  }

  void wait_for_clients() {
    std::vector<pollfd> watched = {{sockets_.udp.get(), POLLIN, 0}, {sockets_.tcp.get(), POLLIN, 0}};
    std::vector<std::shared_ptr<Client>> connected;
    for (const auto& client : clients_) {
      if (!client->socket.valid()) continue;
      connected.push_back(client);
      const auto events = static_cast<short>(client->waiting.empty() ? POLLIN : POLLIN | POLLOUT);
      watched.push_back({client->socket.get(), events, 0});
    }
    const auto timeout = requests_.empty() ? static_cast<int>(kIdle.count()) : 0;
    if (::poll(watched.data(), watched.size(), timeout) <= 0) return;
    const std::scoped_lock lock(mutex_);
    if (watched[0].revents != 0) receive_datagrams();
    if (watched[1].revents != 0) accept_client();
    for (std::size_t i = 0; i < connected.size(); ++i) {
      if (!connected[i]->socket.valid()) continue;  // dropped for the new client
      if ((watched[i + 2].revents & POLLOUT) != 0) send_waiting(*connected[i]);
      if ((watched[i + 2].revents & ~POLLOUT) != 0) receive_stream(connected[i]);
    }
  }

  void receive_datagrams() {
    std::array<std::byte, 2 * kLongestGatewayMail> buffer{};
    for (int i = 0; i < 32; ++i) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const auto length = ::recvfrom(sockets_.udp.get(), buffer.data(), buffer.size(), MSG_TRUNC,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (length < 0) return;
      const auto client = udp_client(from);
      const auto whole = std::span(buffer).first(std::min(static_cast<std::size_t>(length), buffer.size()));
      const auto bytes = gateway_mail_length(whole);
      const bool fits = bytes && kGatewayHeader + *bytes == static_cast<std::size_t>(length);
      auto mail = fits ? decode_gateway_mail(whole.subspan(kGatewayHeader)) : std::nullopt;
      if (mail) {
        take(client, std::move(*mail));
      } else {
        ++client->figures.malformed;
      }
    }
  }

  std::shared_ptr<Client> udp_client(const sockaddr_in& from) {
    const auto known = std::find_if(clients_.begin(), clients_.end(), [&](const auto& client) {
      return !client->tcp && client->address.sin_port == from.sin_port &&
             client->address.sin_addr.s_addr == from.sin_addr.s_addr;
    });
    return known != clients_.end() ? *known : add_client(from, {});
  }

  std::shared_ptr<Client> add_client(const sockaddr_in& from, rt::FileDescriptor socket) {
    auto client = std::make_shared<Client>();
    client->tcp = socket.valid();
    client->figures.name = fmt::format("{} {}", client->tcp ? "tcp" : "udp", to_text(from));
    client->address = from;
    client->heard = SteadyClock::now();
    // Reading the table of all connections is worth it only when users may write.
    const bool ask_user = client->tcp && !settings_.write_users.empty();
    client->may_write =
        may_write(from, ask_user ? user_of_connection(socket.get()) : std::optional<uid_t>{}, settings_);
    client->socket = std::move(socket);
    // Drop the oldest client without a connection; there is one, because there are fewer connections than clients.
    if (clients_.size() == kMaxClients) {
      clients_.erase(
          std::find_if(clients_.begin(), clients_.end(), [](const auto& one) { return !one->socket.valid(); }));
    }
    clients_.push_back(client);
    return client;
  }

  void accept_client() {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    rt::FileDescriptor socket{
        ::accept4(sockets_.tcp.get(), reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC)};
    if (!socket.valid()) {
      if (!reserve_.turn_away(sockets_.tcp.get())) std::this_thread::sleep_for(kDescriptorPause);
      return;
    }
    const auto connected =
        std::count_if(clients_.begin(), clients_.end(), [](const auto& one) { return one->socket.valid(); });
    if (static_cast<std::size_t>(connected) < kMaxTcpClients || drop_silent_client())
      static_cast<void>(add_client(from, std::move(socket)));
  }

  /// Disconnects the TCP client that has been silent for the longest time, and at least as long as the settings say.
  /// Precondition: there is a TCP client. Returns false if all of them are active.
  bool drop_silent_client() {
    const auto silent = std::min_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
      return a->socket.valid() != b->socket.valid() ? a->socket.valid() : a->heard < b->heard;
    });
    if (SteadyClock::now() - (*silent)->heard < settings_.silence) return false;
    disconnect(**silent);
    return true;
  }

  /// Disconnects the TCP clients that do not complete a message.
  void drop_incomplete() {
    const std::scoped_lock lock(mutex_);
    const auto now = SteadyClock::now();
    for (const auto& client : clients_) {
      if (!client->socket.valid() || client->received.empty() || now - client->heard < settings_.silence) continue;
      ++client->figures.malformed;
      disconnect(*client);
    }
  }

  static void disconnect(Client& client) {
    client.socket = {};
    client.waiting.clear();
  }

  void receive_stream(const std::shared_ptr<Client>& client) {
    std::array<std::byte, 4096> buffer{};
    const auto length = ::recv(client->socket.get(), buffer.data(), buffer.size(), 0);
    if (length < 0 && errno == EAGAIN) return;
    if (length <= 0) {
      client->socket = {};
      return;
    }
    if (client->received.empty()) client->heard = SteadyClock::now();
    client->received.push(std::span(buffer).first(static_cast<std::size_t>(length)));
    while (auto mail = client->received.next()) take(client, std::move(*mail));
    if (!client->received.broken()) return;
    ++client->figures.malformed;
    client->socket = {};
  }

  void take(const std::shared_ptr<Client>& client, GatewayMail mail) {
    ++client->figures.requests;
    client->heard = SteadyClock::now();
    const auto& header = mail.header;
    const auto allowed = std::find(settings_.protocols.begin(), settings_.protocols.end(), header.type);
    if (allowed == settings_.protocols.end()) {
      refuse(client, header, MailboxErrorCode::kUnsupportedProtocol);
      return;
    }
    const auto slave =
        std::find_if(slaves_.begin(), slaves_.end(), [&](const auto& one) { return one.station == header.address; });
    if (slave == slaves_.end()) {
      refuse(client, header, MailboxErrorCode::kInvalidHeader);
      return;
    }
    if (!admit_change(client, mail, slave->position)) return;
    const auto under_way = std::count_if(requests_.begin(), requests_.end(),
                                         [&](const auto& request) { return request.client == client; });
    if (static_cast<std::size_t>(under_way) >= kMaxUnderWay || requests_.size() >= kMaxRequests) {
      refuse(client, header, MailboxErrorCode::kServiceInWork);
      return;
    }
    std::optional<std::chrono::nanoseconds> timeout = kMessageTimeout;
    if (is_last_word(*client, mail)) timeout.reset();
    auto exchange = std::make_shared<ecat_master::MailExchange>(header.type, std::move(mail.service), timeout);
    engine_.submit(slave->position, exchange);
    requests_.push_back({client, header, std::move(exchange)});
  }

  /// Whether the message may pass: it changes nothing, or its client may change slaves.
  bool admit_change(const std::shared_ptr<Client>& client, const GatewayMail& mail, std::uint16_t slave) {
    auto change = change_of(mail);
    if (!change) return true;
    if (!client->may_write) {
      ++client->figures.refused;
      send(*client, refusal_of(mail));
      // One event is enough: any local process could fill the list of events otherwise.
      if (!std::exchange(refusal_told_, true)) {
        writes_.push_back({client->figures.name, slave, std::move(change->what), true});
      }
      return false;
    }
    if (change->continued) return true;
    if (writes_.size() >= kMaxWrites) {
      refuse(client, mail.header, MailboxErrorCode::kServiceInWork);
      return false;
    }
    writes_.push_back({client->figures.name, slave, std::move(change->what), false});
    return true;
  }

  /// Whether the slave does not answer the message: waiting for an answer would block its mailbox for other clients.
  static bool is_last_word(Client& client, const GatewayMail& mail) {
    const std::span<const std::byte> service(mail.service);
    if (mail.header.type == MailboxType::kCoe) return is_sdo_abort(service);
    const auto foe = wire::FoeHeader::decode(service);
    if (mail.header.type != MailboxType::kFoe || !foe) return false;
    if (foe->op_code == wire::FoeOpCode::kError) return true;
    const bool end_of_file = client.files_read.erase(mail.header.address) != 0;
    return end_of_file && foe->op_code == wire::FoeOpCode::kAck;
  }

  /// A packet below the maximum length is the last one of a file; the client acknowledges it.
  static void note_end_of_file(const Request& request, std::span<const std::byte> service) {
    const auto foe = wire::FoeHeader::decode(service);
    const bool data = request.header.type == MailboxType::kFoe && foe && foe->op_code == wire::FoeOpCode::kData;
    if (data && service.size() < request.exchange->answer_room())
      request.client->files_read.insert(request.header.address);
  }

  void hand_out_answers() {
    const std::scoped_lock lock(mutex_);
    for (auto request = requests_.begin(); request != requests_.end();) {
      if (!request->exchange->done()) {
        ++request;
        continue;
      }
      answer(*request);
      request = requests_.erase(request);
    }
  }

  void answer(const Request& request) {
    const auto& answers = request.exchange->answers();
    if (!answers) {
      no_answer(request, answers.error());
      return;
    }
    for (const auto& service : *answers) {
      ++request.client->figures.answers;
      note_end_of_file(request, service);
      send(*request.client, {request.header, service});
    }
  }

  /// Passes the slave's own refusal on to the client. If the slave is silent, the client relies on its own time-out.
  void no_answer(const Request& request, const ecat_master::Error& error) {
    if (const auto* told = std::get_if<ecat_master::facts::MailboxError>(&error.facts)) {
      refuse(request.client, request.header, static_cast<MailboxErrorCode>(told->code));
    } else if (std::holds_alternative<ecat_master::facts::ProcessDataSize>(error.facts)) {
      refuse(request.client, request.header, MailboxErrorCode::kInvalidSize);
    } else {
      ++request.client->figures.refused;
    }
  }

  void refuse(const std::shared_ptr<Client>& client, const wire::MailboxHeader& header, MailboxErrorCode code) {
    ++client->figures.refused;
    send(*client, mailbox_error(header, code));
  }

  void send(Client& client, const GatewayMail& mail) {
    const auto bytes = encode_gateway_mail(mail);
    client.heard = SteadyClock::now();
    if (client.tcp) {
      client.waiting.insert(client.waiting.end(), bytes.begin(), bytes.end());
      send_waiting(client);
      return;
    }
    static_cast<void>(::sendto(sockets_.udp.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL,
                               reinterpret_cast<const sockaddr*>(&client.address), sizeof client.address));
  }

  /// Disconnects a client that does not read its answers, before they fill the memory.
  static void send_waiting(Client& client) {
    constexpr std::size_t kMaxWaiting = 256 * 1024;
    const auto sent = ::send(client.socket.get(), client.waiting.data(), client.waiting.size(), MSG_NOSIGNAL);
    if (sent > 0) client.waiting.erase(client.waiting.begin(), client.waiting.begin() + sent);
    if ((sent < 0 && errno != EAGAIN) || client.waiting.size() > kMaxWaiting) client.socket = {};
    if (!client.socket.valid()) client.waiting.clear();
  }

  ecat_master::MailboxEngine& engine_;
  std::vector<ecat_master::SlaveRef> slaves_;
  GatewaySettings settings_;
  GatewaySockets sockets_;
  port::DescriptorReserve reserve_;
  std::vector<Request> requests_;  ///< used only by the thread
  mutable std::mutex mutex_;       ///< protects the clients' figures, the list of clients and the changes
  std::vector<std::shared_ptr<Client>> clients_;
  std::vector<GatewayWrite> writes_;  ///< for take_writes()
  bool refusal_told_ = false;         ///< take_writes() has the first refused change
  std::jthread thread_;               ///< last member, so that it ends before the others are destroyed
};

Result<std::unique_ptr<MailboxGateway>> MailboxGateway::open(ecat_master::MailboxEngine& engine,
                                                             std::vector<ecat_master::SlaveRef> slaves,
                                                             const GatewaySettings& settings) {
  auto sockets = open_gateway_sockets(settings.address, settings.port);
  if (!sockets) return tl::unexpected(sockets.error());
  auto service = std::make_unique<Service>(engine, std::move(slaves), settings, std::move(*sockets));
  return std::unique_ptr<MailboxGateway>(new MailboxGateway(std::move(service)));
}

MailboxGateway::MailboxGateway(std::unique_ptr<Service> service) : service_(std::move(service)) {}

MailboxGateway::~MailboxGateway() = default;

std::uint16_t MailboxGateway::port() const noexcept {
  return service_->port();
}

std::vector<GatewayClient> MailboxGateway::clients() const {
  return service_->clients();
}

void MailboxGateway::stop() {
  service_->stop();
}

std::vector<GatewayWrite> MailboxGateway::take_writes() {
  return service_->take_writes();
}

}  // namespace driveline::runtime
