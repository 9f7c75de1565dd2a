// Launch times as received by the kernel. No kernel of the test machines has `etf`, which would hold the frames back: a
// BPF program at the exit to the driver reads what a queueing discipline would see of a frame.
#include "driveline/port/launch_times.hpp"

#include <gmock/gmock.h>
#include <linux/bpf.h>
#include <net/if.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <thread>

#include "driveline/port/interface_port.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "driveline/rt/time_conversion.hpp"
#include "private_network.hpp"
#include "support/must.hpp"

namespace driveline::port {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kNoEtf =
    "Interface 'dlmaster' has no launch times: it has no queueing discipline `etf`; `tc qdisc replace dev dlmaster "
    "root "
    "etf clockid CLOCK_TAI delta 20000 offload` sets it up where the card has launch times.";

/// BPF_TCX_EGRESS of Linux 6.6, which the headers of Debian 12 do not have yet.
constexpr unsigned kTcxEgress = 47;

int bpf(int command, bpf_attr& attributes) {
  return static_cast<int>(syscall(SYS_bpf, command, &attributes, sizeof attributes));
}

constexpr bpf_insn instruction(unsigned code, unsigned to, unsigned from, std::int16_t offset, std::int32_t number) {
  return {static_cast<__u8>(code), static_cast<__u8>(to & 0x0F), static_cast<__u8>(from & 0x0F), offset, number};
}

/// Stores the delivery time of the last frame that left an interface.
class DeliveryTimes {
 public:
  explicit DeliveryTimes(const std::string& interface) {
    bpf_attr map{};
    map.map_type = BPF_MAP_TYPE_ARRAY;
    map.key_size = sizeof(std::uint32_t);
    map.value_size = sizeof(std::uint64_t);
    map.max_entries = 1;
    map_ = rt::FileDescriptor{bpf(BPF_MAP_CREATE, map)};
    const std::array program = {
        instruction(BPF_LDX | BPF_MEM | BPF_DW, 2, 1, offsetof(__sk_buff, tstamp), 0),
        instruction(BPF_STX | BPF_MEM | BPF_DW, 10, 2, -8, 0),
        instruction(BPF_ST | BPF_MEM | BPF_DW, 10, 0, -16, 0),
        instruction(BPF_LD | BPF_DW | BPF_IMM, 1, BPF_PSEUDO_MAP_FD, 0, map_.get()),
        instruction(0, 0, 0, 0, 0),
        instruction(BPF_ALU64 | BPF_MOV | BPF_X, 2, 10, 0, 0),
        instruction(BPF_ALU64 | BPF_ADD | BPF_K, 2, 0, 0, -16),
        instruction(BPF_ALU64 | BPF_MOV | BPF_X, 3, 10, 0, 0),
        instruction(BPF_ALU64 | BPF_ADD | BPF_K, 3, 0, 0, -8),
        instruction(BPF_ALU64 | BPF_MOV | BPF_K, 4, 0, 0, BPF_ANY),
        instruction(BPF_JMP | BPF_CALL, 0, 0, 0, BPF_FUNC_map_update_elem),
        instruction(BPF_ALU64 | BPF_MOV | BPF_K, 0, 0, 0, -1),  // continue with the next program, or send
        instruction(BPF_JMP | BPF_EXIT, 0, 0, 0, 0),
    };
    constexpr const char* kLicense = "MIT";
    bpf_attr load{};
    load.prog_type = BPF_PROG_TYPE_SCHED_CLS;
    load.insns = reinterpret_cast<std::uintptr_t>(program.data());
    load.insn_cnt = static_cast<__u32>(program.size());
    load.license = reinterpret_cast<std::uintptr_t>(kLicense);
    load.expected_attach_type = kTcxEgress;
    const rt::FileDescriptor loaded{bpf(BPF_PROG_LOAD, load)};
    bpf_attr link{};
    link.link_create.prog_fd = static_cast<__u32>(loaded.get());
    link.link_create.target_ifindex = if_nametoindex(interface.c_str());
    link.link_create.attach_type = kTcxEgress;
    link_ = rt::FileDescriptor{bpf(BPF_LINK_CREATE, link)};
  }
  [[nodiscard]] bool attached() const { return link_.valid(); }
  /// On the clock of the launch times; 0: none was set.
  [[nodiscard]] nanoseconds last() const {
    const std::uint32_t key = 0;
    std::uint64_t value = 0;
    bpf_attr look{};
    look.map_fd = static_cast<__u32>(map_.get());
    look.key = reinterpret_cast<std::uintptr_t>(&key);
    look.value = reinterpret_cast<std::uintptr_t>(&value);
    EXPECT_EQ(bpf(BPF_MAP_LOOKUP_ELEM, look), 0);
    return nanoseconds{static_cast<std::int64_t>(value)};
  }

 private:
  rt::FileDescriptor map_;
  rt::FileDescriptor link_;
};

class LaunchTimesOnVeth : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string& obstacle = enter_private_network(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    if (!run_quietly("ip link add name dlmaster type veth peer name dlslave"))
      GTEST_SKIP() << "no veth pair: the kernel lacks the driver or `ip` is not installed";
    ASSERT_TRUE(run_quietly("ip link set dev dlmaster up && ip link set dev dlslave up"));
  }
  void TearDown() override { run_quietly("ip link delete dlmaster"); }

  static Bytes frame() {
    Bytes bytes(60, std::byte{0x11});
    wire::EthernetHeader{wire::kBroadcastMac, {}, wire::kEtherTypeEtherCat}.encode(std::span{bytes}.first<14>());
    return bytes;
  }
  static nanoseconds read(clockid_t id) {
    timespec time{};
    clock_gettime(id, &time);
    return rt::from_timespec(time);
  }

  rt::MonotonicClock clock;
};

TEST_F(LaunchTimesOnVeth, OfEachFrameGetToTheKernelOnItsClock) {
  for (const clockid_t id : {CLOCK_TAI, CLOCK_MONOTONIC}) {
    auto port = RawSocketPort::open({.interface = "dlmaster", .launch_times = LaunchTimes{id, 50us, false}}, clock);
    if (!port && port.error().code == PortErrorCode::kNoPermission) GTEST_SKIP() << port.error().message;
    ASSERT_TRUE(port) << port.error().message;
    EXPECT_THAT((*port)->access_method(), HasSubstr("launch times"));
    const DeliveryTimes delivery("dlmaster");
    if (!delivery.attached()) GTEST_SKIP() << "this kernel attaches no BPF program where frames leave";

    // Held back, however long it takes until the frame is sent.
    const auto instant = clock.now() + 60s;
    (*port)->hold_until(instant);
    ASSERT_EQ((*port)->send(frame()), SendStatus::kSent);
    EXPECT_EQ((*port)->last_send_time(), instant);
    // Determine the lead of that clock over the port's clock between two readings of the latter.
    const auto earlier = clock.now();
    const auto there = read(id);
    const auto later = clock.now();
    EXPECT_GE(delivery.last() - instant, there - later - 10us);
    EXPECT_LE(delivery.last() - instant, there - earlier + 10us);

    // An instant in the past: sent at once, but late enough for the discipline to accept it.
    (*port)->hold_until(clock.now() - 1ms);
    const auto before = read(id);
    ASSERT_EQ((*port)->send(frame()), SendStatus::kSent);
    EXPECT_GE(delivery.last(), before + 49us);
    EXPECT_LE(delivery.last(), read(id) + 51us);
  }
}

TEST_F(LaunchTimesOnVeth, AreNotGivenByAPortWithoutThem) {
  auto port = must(RawSocketPort::open({.interface = "dlmaster"}, clock));
  const DeliveryTimes delivery("dlmaster");
  if (!delivery.attached()) GTEST_SKIP() << "this kernel attaches no BPF program where frames leave";
  (*port)->hold_until(clock.now() + 60s);
  const auto before = clock.now();
  ASSERT_EQ((*port)->send(frame()), SendStatus::kSent);
  EXPECT_EQ(delivery.last(), 0ns);
  EXPECT_GE((*port)->last_send_time(), before);
  EXPECT_LE((*port)->last_send_time(), clock.now());
}

TEST_F(LaunchTimesOnVeth, WithoutEtfAreRefusedOrDoneWithout) {
  const auto found = find_launch_times("dlmaster", 30us);
  if (found) GTEST_SKIP() << "this kernel has etf by default";
  EXPECT_EQ(found.error().code, PortErrorCode::kUnsupported);
  EXPECT_EQ(found.error().message, kNoEtf);
  const auto refused = open_launching_interface("dlmaster", 30us, false, clock);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, kNoEtf);
  const auto fallen = must(open_launching_interface("dlmaster", 30us, true, clock));
  EXPECT_FALSE(fallen->launches);
  EXPECT_THAT(fallen->steps_down, ElementsAre(kNoEtf));
  EXPECT_EQ(fallen->port->access_method(), "packet socket with a receive ring");
  EXPECT_EQ(find_launch_times("nothere", 30us).error().code, PortErrorCode::kNoSuchInterface);
}

TEST_F(LaunchTimesOnVeth, NeedACapability) {
  PortError error;
  std::thread{[&] {
    keep_only_net_raw();  // of this thread only
    const auto port =
        RawSocketPort::open({.interface = "dlmaster", .launch_times = LaunchTimes{CLOCK_TAI, 50us, false}}, clock);
    if (!port) error = port.error();
  }}.join();
  EXPECT_EQ(error.code, PortErrorCode::kNoPermission);
  EXPECT_EQ(error.message,
            "Launch times on interface 'dlmaster' need the capability CAP_NET_ADMIN; run as root or grant it.");
}

}  // namespace
}  // namespace driveline::port
