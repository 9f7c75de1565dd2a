#include "driveline/port/launch_times.hpp"

#include <linux/pkt_sched.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "network_interface.hpp"

namespace driveline::port {

namespace {

using Bytes = std::span<const std::byte>;

constexpr std::string_view kEtf = "etf";
/// Most bytes that the kernel returns per read.
constexpr std::size_t kAnswerBytes = 32768;

template <typename T>
std::optional<T> take(Bytes bytes) noexcept {
  if (bytes.size() < sizeof(T)) return std::nullopt;
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

constexpr std::size_t aligned(std::size_t length) noexcept {
  return (length + NLMSG_ALIGNTO - 1) & ~std::size_t{NLMSG_ALIGNTO - 1};
}

/// The content of the first attribute of this type.
std::optional<Bytes> find_attribute(Bytes attributes, unsigned type) noexcept {
  while (const auto header = take<rtattr>(attributes)) {
    if (header->rta_len < sizeof(rtattr) || header->rta_len > attributes.size()) break;
    if ((header->rta_type & NLA_TYPE_MASK) == type)
      return attributes.subspan(sizeof(rtattr), header->rta_len - sizeof(rtattr));
    attributes = attributes.subspan(std::min(aligned(header->rta_len), attributes.size()));
  }
  return std::nullopt;
}

bool is_etf(Bytes kind) noexcept {
  return kind.size() == kEtf.size() + 1 && std::memcmp(kind.data(), kEtf.data(), kEtf.size()) == 0;
}

/// Reads the launch times from one message about a queueing discipline.
std::optional<LaunchTimes> read_discipline(Bytes message, int interface_index) noexcept {
  const auto about = take<tcmsg>(message);
  if (!about || about->tcm_ifindex != interface_index) return std::nullopt;
  const auto attributes = message.subspan(std::min(aligned(sizeof(tcmsg)), message.size()));
  const auto kind = find_attribute(attributes, TCA_KIND);
  const auto options = find_attribute(attributes, TCA_OPTIONS);
  if (!kind || !is_etf(*kind) || !options) return std::nullopt;
  const auto values = find_attribute(*options, TCA_ETF_PARMS);
  const auto etf = values ? take<tc_etf_qopt>(*values) : std::nullopt;
  if (!etf) return std::nullopt;
  return LaunchTimes{etf->clockid, std::chrono::nanoseconds{etf->delta}, (etf->flags & TC_ETF_OFFLOAD_ON) != 0};
}

struct Question {
  nlmsghdr header{};
  tcmsg about{};
};

/// All answers of the kernel to a query for the queueing disciplines of an interface, concatenated.
tl::expected<std::vector<std::byte>, int> ask_for_disciplines(int interface_index) {
  const rt::FileDescriptor socket{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
  if (!socket.valid()) return tl::unexpected(errno);
  Question question;
  question.header.nlmsg_len = sizeof question;
  question.header.nlmsg_type = RTM_GETQDISC;
  question.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
  question.about.tcm_ifindex = interface_index;
  if (send(socket.get(), &question, sizeof question, 0) < 0) return tl::unexpected(errno);
  std::vector<std::byte> answers;
  std::vector<std::byte> part(kAnswerBytes);
  for (;;) {
    const ssize_t size = recv(socket.get(), part.data(), part.size(), 0);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return tl::unexpected(errno);
    const auto first = take<nlmsghdr>(Bytes(part).first(static_cast<std::size_t>(size)));
    // A separate message marks the end of the answers.
    if (!first || first->nlmsg_type == NLMSG_DONE || first->nlmsg_type == NLMSG_ERROR) return answers;
    answers.insert(answers.end(), part.begin(), part.begin() + size);
  }
}

std::string set_up_with(const std::string& interface) {
  return "`tc qdisc replace dev " + interface +
         " root etf clockid CLOCK_TAI delta 20000 offload` sets it up where the card has launch times";
}

}  // namespace

std::optional<LaunchTimes> etf_in(Bytes messages, int interface_index) noexcept {
  while (const auto header = take<nlmsghdr>(messages)) {
    if (header->nlmsg_len < sizeof(nlmsghdr) || header->nlmsg_len > messages.size()) break;
    if (header->nlmsg_type == RTM_NEWQDISC) {
      const auto found =
          read_discipline(messages.subspan(sizeof(nlmsghdr), header->nlmsg_len - sizeof(nlmsghdr)), interface_index);
      if (found) return found;
    }
    messages = messages.subspan(std::min(aligned(header->nlmsg_len), messages.size()));
  }
  return std::nullopt;
}

tl::expected<LaunchTimes, PortError> usable_launch_times(const std::optional<LaunchTimes>& etf,
                                                         const std::string& interface, std::chrono::nanoseconds early) {
  if (!etf) {
    return failure(PortErrorCode::kUnsupported, "Interface " + quoted(interface) +
                                                    " has no launch times: it has no queueing discipline `etf`; " +
                                                    set_up_with(interface) + ".");
  }
  const std::string discipline = "The queueing discipline `etf` of interface " + quoted(interface);
  if (etf->clock != CLOCK_TAI && etf->clock != CLOCK_MONOTONIC) {
    return failure(PortErrorCode::kUnsupported, discipline + " has clock " + std::to_string(etf->clock) +
                                                    ", CLOCK_TAI is expected; " + set_up_with(interface) + ".");
  }
  if (etf->ahead > early) {
    return failure(PortErrorCode::kUnsupported, discipline + " takes frames " + std::to_string(etf->ahead.count()) +
                                                    " ns before they leave (delta), and they are handed over " +
                                                    std::to_string(early.count()) + " ns before.");
  }
  return *etf;
}

tl::expected<LaunchTimes, PortError> find_launch_times(const std::string& interface, std::chrono::nanoseconds early) {
  const auto found = find_interface(interface);
  if (!found) return tl::unexpected(found.error());
  const auto answers = ask_for_disciplines(found->index);
  if (!answers)
    return system_failure("Cannot ask for the queueing disciplines of interface " + quoted(interface), answers.error());
  return usable_launch_times(etf_in(*answers, found->index), interface, early);
}

}  // namespace driveline::port
