#include "xdp_program.hpp"

#include <arpa/inet.h>
#include <linux/bpf.h>
#include <linux/if_link.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <thread>

#include "driveline/wire/ethernet.hpp"

namespace driveline::port {

namespace {

constexpr std::uint16_t kVlanTag = 0x8100;      // 802.1Q
constexpr std::uint16_t kProviderTag = 0x88A8;  // 802.1ad
constexpr std::int16_t kTypeOffset = 12;        // offset of the EtherType in an untagged frame
constexpr std::int16_t kTaggedTypeOffset = 16;  // offset of the EtherType behind a tag

int bpf(int command, bpf_attr& attributes) noexcept {
  return static_cast<int>(syscall(SYS_bpf, command, &attributes, sizeof attributes));
}

rt::FileDescriptor make_socket_map() noexcept {
  bpf_attr attributes{};
  attributes.map_type = BPF_MAP_TYPE_XSKMAP;
  attributes.key_size = sizeof(std::uint32_t);
  attributes.value_size = sizeof(std::uint32_t);
  attributes.max_entries = 1;
  return rt::FileDescriptor{bpf(BPF_MAP_CREATE, attributes)};
}

bool put_socket(int map, int socket) noexcept {
  const std::uint32_t queue = 0;
  const auto value = static_cast<std::uint32_t>(socket);
  bpf_attr attributes{};
  attributes.map_fd = static_cast<std::uint32_t>(map);
  attributes.key = reinterpret_cast<std::uintptr_t>(&queue);
  attributes.value = reinterpret_cast<std::uintptr_t>(&value);
  return bpf(BPF_MAP_UPDATE_ELEM, attributes) == 0;
}

// The BPF instructions (RFC 9669) that the program needs.

bpf_insn instruction(unsigned code, unsigned to, unsigned from, std::int16_t offset, std::int32_t number) {
  bpf_insn result{};
  result.code = static_cast<__u8>(code);
  result.dst_reg = to & 0x0F;
  result.src_reg = from & 0x0F;
  result.off = offset;
  result.imm = number;
  return result;
}
bpf_insn move(unsigned to, unsigned from) {
  return instruction(BPF_ALU64 | BPF_MOV | BPF_X, to, from, 0, 0);
}
bpf_insn move_number(unsigned to, std::int32_t number) {
  return instruction(BPF_ALU64 | BPF_MOV | BPF_K, to, 0, 0, number);
}
bpf_insn add_number(unsigned to, std::int32_t number) {
  return instruction(BPF_ALU64 | BPF_ADD | BPF_K, to, 0, 0, number);
}
bpf_insn load_word(unsigned to, unsigned address, std::int16_t offset) {
  return instruction(BPF_LDX | BPF_MEM | BPF_W, to, address, offset, 0);
}
bpf_insn load_half(unsigned to, unsigned address, std::int16_t offset) {
  return instruction(BPF_LDX | BPF_MEM | BPF_H, to, address, offset, 0);
}
bpf_insn jump_if_above(unsigned left, unsigned right, std::int16_t skip) {
  return instruction(BPF_JMP | BPF_JGT | BPF_X, left, right, skip, 0);
}
/// Compares with an EtherType in network byte order.
bpf_insn jump_if_type(unsigned value, std::uint16_t type, std::int16_t skip) {
  return instruction(BPF_JMP | BPF_JEQ | BPF_K, value, 0, skip, htons(type));
}
bpf_insn jump_unless_type(unsigned value, std::uint16_t type, std::int16_t skip) {
  return instruction(BPF_JMP | BPF_JNE | BPF_K, value, 0, skip, htons(type));
}

rt::FileDescriptor load_program(int map) noexcept {
  // A call takes its arguments from registers 1 to 3; registers from 6 on keep their values.
  constexpr unsigned kResult = BPF_REG_0;
  constexpr unsigned kFirst = BPF_REG_1;
  constexpr unsigned kSecond = BPF_REG_2;
  constexpr unsigned kThird = BPF_REG_3;
  constexpr unsigned kLimit = BPF_REG_4;
  constexpr unsigned kType = BPF_REG_5;
  constexpr unsigned kContext = BPF_REG_6;
  const std::array program{
      move(kContext, kFirst),
      load_word(kSecond, kContext, offsetof(xdp_md, data)),
      load_word(kThird, kContext, offsetof(xdp_md, data_end)),
      // Short frames go to the kernel: the verifier demands a bounds check before each access.
      move(kLimit, kSecond),
      add_number(kLimit, kTypeOffset + 2),
      jump_if_above(kLimit, kThird, 14),  // 5: to 20
      load_half(kType, kSecond, kTypeOffset),
      jump_if_type(kType, wire::kEtherTypeEtherCat, 6),  // 7: to 14
      jump_if_type(kType, kVlanTag, 1),                  // 8: to 10
      jump_unless_type(kType, kProviderTag, 10),         // 9: to 20
      add_number(kLimit, kTaggedTypeOffset - kTypeOffset),
      jump_if_above(kLimit, kThird, 8),  // 11: to 20
      load_half(kType, kSecond, kTaggedTypeOffset),
      jump_unless_type(kType, wire::kEtherTypeEtherCat, 6),  // 13: to 20
      // 14: redirect to the socket of this queue; if there is none, pass to the kernel.
      load_word(kSecond, kContext, offsetof(xdp_md, rx_queue_index)),
      instruction(BPF_LD | BPF_DW | BPF_IMM, kFirst, BPF_PSEUDO_MAP_FD, 0, map),
      bpf_insn{},  // the upper half of the address
      move_number(kThird, XDP_PASS),
      instruction(BPF_JMP | BPF_CALL, 0, 0, 0, BPF_FUNC_redirect_map),
      instruction(BPF_JMP | BPF_EXIT, 0, 0, 0, 0),
      // 20
      move_number(kResult, XDP_PASS),
      instruction(BPF_JMP | BPF_EXIT, 0, 0, 0, 0),
  };
  constexpr std::string_view kName = "driveline";
  bpf_attr attributes{};
  attributes.prog_type = BPF_PROG_TYPE_XDP;
  attributes.insn_cnt = program.size();
  attributes.insns = reinterpret_cast<std::uintptr_t>(program.data());
  attributes.license = reinterpret_cast<std::uintptr_t>("");
  kName.copy(attributes.prog_name, sizeof attributes.prog_name - 1);
  return rt::FileDescriptor{bpf(BPF_PROG_LOAD, attributes)};
}

/// Retries for three seconds: the kernel detaches the program of a closed port later, when its work queues get to it.
rt::FileDescriptor link_program(int program, int interface_index, bool generic) noexcept {
  bpf_attr attributes{};
  attributes.link_create.prog_fd = static_cast<std::uint32_t>(program);
  attributes.link_create.target_ifindex = static_cast<std::uint32_t>(interface_index);
  attributes.link_create.attach_type = BPF_XDP;
  attributes.link_create.flags = generic ? XDP_FLAGS_SKB_MODE : XDP_FLAGS_DRV_MODE;
  for (int attempt = 0;; ++attempt) {
    rt::FileDescriptor link{bpf(BPF_LINK_CREATE, attributes)};
    if (link.valid() || errno != EBUSY || attempt == 300) return link;
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
}

}  // namespace

int XdpProgram::try_load() {
  const auto map = make_socket_map();
  if (!map.valid()) return errno;
  return load_program(map.get()).valid() ? 0 : errno;
}

tl::expected<XdpProgram, XdpRefusal> XdpProgram::attach(int interface_index, int socket, bool generic) {
  const auto refused = [](XdpRefusal::Step step) { return tl::unexpected(XdpRefusal{step, errno}); };
  auto map = make_socket_map();
  if (!map.valid() || !put_socket(map.get(), socket)) return refused(XdpRefusal::Step::kProgram);
  auto program = load_program(map.get());
  if (!program.valid()) return refused(XdpRefusal::Step::kProgram);
  auto link = link_program(program.get(), interface_index, generic);
  if (!link.valid()) return refused(XdpRefusal::Step::kAttach);
  return XdpProgram{std::move(map), std::move(program), std::move(link)};
}

}  // namespace driveline::port
