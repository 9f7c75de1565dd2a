#pragma once

#include <random>
#include <string_view>
#include <vector>

#include "bytes.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/datagram.hpp"
#include "driveline/wire/dl.hpp"
#include "driveline/wire/eoe.hpp"
#include "driveline/wire/ethernet.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/foe.hpp"
#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/soe.hpp"
#include "driveline/wire/sync_manager.hpp"

/// Test data of each wire type: bytes from other sources than the encoder under test, their source and meaning, and
/// random values. Captures: "soem" is from a master that scans an AKD drive, "twincat" from a master that takes it to
/// OP (both from the public ethercrab repository).
namespace driveline::wire::test {

template <typename T>
struct Golden {
  std::string_view provenance;
  std::string_view hex;
  T value;
};

template <typename T>
T any(std::mt19937& random) {
  return static_cast<T>(random());
}
inline bool coin(std::mt19937& random) {
  return (random() & 1U) != 0;
}

inline MacAddress mac(const std::array<int, 6>& octets) {
  MacAddress address{};
  for (std::size_t i = 0; i < octets.size(); ++i) address[i] = static_cast<std::byte>(octets[i]);
  return address;
}

/// A specialisation for each type with encode() and decode(): `name`, `golden()`, `random()`.
template <typename T>
struct Sample;

/// A specialisation for each type made from the raw value of a register: `name`, `Raw`, `kMeaning` (bits that are not
/// reserved), `golden()`.
template <typename T>
struct RegisterSample;

// --- Frames ----------------------------------------------------------------------------------------------------

template <>
struct Sample<EthernetHeader> {
  static constexpr std::string_view kName = "EthernetHeader";
  static std::vector<Golden<EthernetHeader>> golden() {
    return {{"twincat packet 1",
             "01 01 05 01 00 00  72 85 c2 8d d3 c4  88 a4",
             {{std::byte{1}, std::byte{1}, std::byte{5}, std::byte{1}, std::byte{0}, std::byte{0}},
              {std::byte{0x72}, std::byte{0x85}, std::byte{0xC2}, std::byte{0x8D}, std::byte{0xD3}, std::byte{0xC4}},
              0x88A4}}};
  }
  static EthernetHeader random(std::mt19937& random) {
    EthernetHeader header;
    for (auto& b : header.destination) b = any<std::byte>(random);
    for (auto& b : header.source) b = any<std::byte>(random);
    header.ether_type = any<std::uint16_t>(random);
    return header;
  }
};

template <>
struct Sample<EtherCatHeader> {
  static constexpr std::string_view kName = "EtherCatHeader";
  static std::vector<Golden<EtherCatHeader>> golden() {
    return {{"soem packet 7", "0e 10", {14, 1}},
            {"soem packet 281", "0c 14", {1036, 1}},
            {"ETG.1000.4 5.3.3, all bits of the length, type 5 (mailbox gateway)", "ff 57", {2047, 5}}};
  }
  static EtherCatHeader random(std::mt19937& random) {
    return {static_cast<std::uint16_t>(random() & 0x7FFU), static_cast<std::uint8_t>(random() & 0xFU)};
  }
};

template <>
struct Sample<DatagramHeader> {
  static constexpr std::string_view kName = "DatagramHeader";
  static std::vector<Golden<DatagramHeader>> golden() {
    return {
        {"soem packet 281, write of a mailbox",
         "05 0d 01 10 00 18 00 04 00 00",
         {Command::kFpwr, 0x0D, DatagramAddress::physical(0x1001, 0x1800), 1024, false, false, 0}},
        {"twincat packet 18, first datagram",
         "08 83 01 00 00 03 08 80 00 00",
         {Command::kBwr, 0x83, DatagramAddress::physical(1, 0x0300), 8, false, true, 0}},
        {"twincat packet 408, drift compensation",
         "0d c2 01 00 10 09 04 00 00 00",
         {Command::kArmw, 0xC2, DatagramAddress::physical(1, 0x0910), 4, false, false, 0}},
        {"ETG.1000.4 5.4.1.2, circulating, interrupt, logical address, command out of the standard",
         "ff 01 78 56 34 12 ff 47 fe ca",
         {static_cast<Command>(0xFF), 1, DatagramAddress::logical(0x12345678), 2047, true, false, 0xCAFE}},
    };
  }
  static DatagramHeader random(std::mt19937& random) {
    return {any<Command>(random),
            any<std::uint8_t>(random),
            {any<std::uint32_t>(random)},
            static_cast<std::uint16_t>(random() & 0x7FFU),
            coin(random),
            coin(random),
            any<std::uint16_t>(random)};
  }
};

// --- Registers with structure ----------------------------------------------------------------------------------

template <>
struct Sample<SyncManagerChannel> {
  static constexpr std::string_view kName = "SyncManagerChannel";
  static std::vector<Golden<SyncManagerChannel>> golden() {
    return {{"soem packet 264, SM0", "00 18 00 04 26 00 01 00", {0x1800, 0x0400, 0x26, 0, 1, 0}},
            {"soem packet 264, SM1", "00 1c 00 04 22 00 01 00", {0x1C00, 0x0400, 0x22, 0, 1, 0}},
            {"soem packet 736, SM2", "00 11 11 00 24 00 01 00", {0x1100, 0x0011, 0x24, 0, 1, 0}},
            {"ETG.1000.4 Table 59, a value in each byte", "01 02 03 04 05 06 07 08", {0x0201, 0x0403, 5, 6, 7, 8}}};
  }
  static SyncManagerChannel random(std::mt19937& random) {
    return {any<std::uint16_t>(random), any<std::uint16_t>(random), any<std::uint8_t>(random),
            any<std::uint8_t>(random),  any<std::uint8_t>(random),  any<std::uint8_t>(random)};
  }
};

template <>
struct Sample<FmmuEntity> {
  static constexpr std::string_view kName = "FmmuEntity";
  static std::vector<Golden<FmmuEntity>> golden() {
    return {{"soem packet 740, outputs",
             "00 00 00 00 11 00 00 07 00 11 00 02 01 00 00 00",
             {0, 17, 0, 7, 0x1100, 0, FmmuEntity::kTypeWrite, true}},
            {"soem packet 742, inputs",
             "11 00 00 00 11 00 00 07 40 11 00 01 01 00 00 00",
             {17, 17, 0, 7, 0x1140, 0, FmmuEntity::kTypeRead, true}},
            {"ETG.1000.4 Table 56, a value in each field",
             "78 56 34 12 bc 0a 03 05 ef 0d 06 03 00 00 00 00",
             {0x12345678, 0x0ABC, 3, 5, 0x0DEF, 6, 3, false}}};
  }
  static FmmuEntity random(std::mt19937& random) {
    return {any<std::uint32_t>(random),
            any<std::uint16_t>(random),
            static_cast<std::uint8_t>(random() & 7U),
            static_cast<std::uint8_t>(random() & 7U),
            any<std::uint16_t>(random),
            static_cast<std::uint8_t>(random() & 7U),
            static_cast<std::uint8_t>(random() & 3U),
            coin(random)};
  }
};

// --- Mailbox and CoE -------------------------------------------------------------------------------------------

template <>
struct Sample<MailboxHeader> {
  static constexpr std::string_view kName = "MailboxHeader";
  static std::vector<Golden<MailboxHeader>> golden() {
    return {{"soem packet 281, CoE request", "0a 00 00 00 00 13", {10, 0, 0, 0, MailboxType::kCoe, 1}},
            {"soem packet 352, CoE response", "0a 00 00 00 00 63", {10, 0, 0, 0, MailboxType::kCoe, 6}},
            {"twincat packet 207, EoE without counter", "3e 00 00 00 00 02", {62, 0, 0, 0, MailboxType::kEoe, 0}},
            {"ETG.1000.4 Table 29, a value in each field",
             "02 01 e9 03 bf 7f",
             {0x0102, 1001, 0x3F, 2, MailboxType::kVoe, 7}}};
  }
  static MailboxHeader random(std::mt19937& random) {
    return {static_cast<std::uint16_t>(random() % 1500), any<std::uint16_t>(random),
            static_cast<std::uint8_t>(random() & 0x3FU), static_cast<std::uint8_t>(random() & 3U),
            static_cast<MailboxType>(random() & 0xFU),   static_cast<std::uint8_t>(random() & 7U)};
  }
};

template <>
struct Sample<EoeHeader> {
  static constexpr std::string_view kName = "EoeHeader";
  static std::vector<Golden<EoeHeader>> golden() {
    return {{"fields as Wireshark names them: FragNo 1, Offset 64, FrameNo 3, last, time stamp appended",
             "00 03 81 30",
             {EoeType::kFragment, 0, true, true, false, EoeFragment{1, 2, 3}.value()}},
            {"Wireshark: Init Res, no IP support",
             "03 01 01 02",
             {EoeType::kSetIpResponse, 0, true, false, false, 0x0201}}};
  }
  static EoeHeader random(std::mt19937& random) {
    return {static_cast<EoeType>(random() & 0x0FU),
            static_cast<std::uint8_t>(random() & 0x0FU),
            coin(random),
            coin(random),
            coin(random),
            any<std::uint16_t>(random)};
  }
};

template <>
struct Sample<EoeIpParameters> {
  static constexpr std::string_view kName = "EoeIpParameters";
  static EoeIpParameters::Name name(std::string_view text) {
    EoeIpParameters::Name name{};
    std::copy(text.begin(), text.end(), name.begin());
    return name;
  }
  static std::vector<Golden<EoeIpParameters>> golden() {
    return {{"written by hand; Wireshark shows these addresses and this name",
             "3f 00 00 00  02 01 02 03 04 05  05 26 a8 c0  00 ff ff ff  01 26 a8 c0  02 26 a8 c0  "
             "64 72 69 76 65 35 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00",
             {mac({2, 1, 2, 3, 4, 5}), IpV4Address{192, 168, 38, 5}, IpV4Address{255, 255, 255, 0},
              IpV4Address{192, 168, 38, 1}, IpV4Address{192, 168, 38, 2}, name("drive5")}}};
  }
  static EoeIpParameters random(std::mt19937& random) {
    EoeIpParameters parameters;
    const auto fill = [&random](auto& place) {
      if (!coin(random)) return;
      for (auto& octet : place.emplace()) octet = any<std::remove_reference_t<decltype(octet)>>(random);
    };
    fill(parameters.mac);
    fill(parameters.ip);
    fill(parameters.subnet_mask);
    fill(parameters.gateway);
    fill(parameters.dns_server);
    fill(parameters.dns_name);
    return parameters;
  }
};

template <>
struct Sample<EoeAddressFilter> {
  static constexpr std::string_view kName = "EoeAddressFilter";
  static std::vector<Golden<EoeAddressFilter>> golden() {
    static const std::string kHex = [] {
      std::string hex = "92 00  01 02 03 04 05 06  07 08 09 0a 0b 0c ";
      for (int i = 0; i < 14 * 6; ++i) hex += " 00";
      hex += "  ff ff ff 00 00 00";
      for (int i = 0; i < 3 * 6; ++i) hex += " 00";
      return hex;
    }();
    EoeAddressFilter filter;
    filter.address_count = 2;
    filter.mask_count = 1;
    filter.no_broadcasts = true;
    filter.addresses[0] = mac({1, 2, 3, 4, 5, 6});
    filter.addresses[1] = mac({7, 8, 9, 10, 11, 12});
    filter.masks[0] = mac({255, 255, 255, 0, 0, 0});
    return {
        {"written by hand; Wireshark shows these addresses as Filter 0 and 1 and this one as Mask 0", kHex, filter}};
  }
  static EoeAddressFilter random(std::mt19937& random) {
    EoeAddressFilter filter;
    filter.address_count = static_cast<std::uint8_t>(random() & 0x0FU);
    filter.mask_count = static_cast<std::uint8_t>(random() & 3U);
    filter.no_broadcasts = coin(random);
    for (auto& mac : filter.addresses) {
      for (auto& octet : mac) octet = any<std::byte>(random);
    }
    for (auto& mac : filter.masks) {
      for (auto& octet : mac) octet = any<std::byte>(random);
    }
    return filter;
  }
};

template <>
struct Sample<FoeHeader> {
  static constexpr std::string_view kName = "FoeHeader";
  /// Read by Wireshark's dissector in tests/replay/wire (OwnFrames.FoeMailsMadeByHand).
  static std::vector<Golden<FoeHeader>> golden() {
    return {{"ETG.1000.6 5.8, read request with password", "01 00 78 56 34 12", {FoeOpCode::kReadRequest, 0x12345678}},
            {"ETG.1000.6 5.8, packet 70000", "03 00 70 11 01 00", {FoeOpCode::kData, 70000}},
            {"ETG.1000.6 Table 92, not found", "05 00 01 80 00 00", {FoeOpCode::kError, 0x8001}},
            {"an operation of tomorrow", "09 00 00 00 00 00", {static_cast<FoeOpCode>(9), 0}}};
  }
  static FoeHeader random(std::mt19937& random) { return {any<FoeOpCode>(random), any<std::uint32_t>(random)}; }
};

template <>
struct Sample<SoeHeader> {
  static constexpr std::string_view kName = "SoeHeader";
  /// Read by Wireshark's dissector in tests/replay/wire (OwnFrames.SoeMailsMadeByHand).
  static std::vector<Golden<SoeHeader>> golden() {
    return {{"Wireshark: RRQ (S-0-0017, 'V')",
             "01 40 11 00",
             {SoeOpCode::kReadRequest, false, false, 0, SoeElement::kValue, 17}},
            {"Wireshark: WRQ (P-0-0047, 'IV'), drive 2",
             "43 50 2f 80",
             {SoeOpCode::kWriteRequest, false, false, 2, SoeElement::kMin | SoeElement::kValue, 0x802F}},
            {"Wireshark: FragmentsLeft 2",
             "0a 40 02 00",
             {SoeOpCode::kReadResponse, true, false, 0, SoeElement::kValue, 2}},
            {"Wireshark: Error, drive 1",
             "32 40 12 00",
             {SoeOpCode::kReadResponse, false, true, 1, SoeElement::kValue, 18}},
            {"Wireshark: all elements, drive 7, an operation of tomorrow",
             "e7 ff ff ff",
             {static_cast<SoeOpCode>(7), false, false, 7, SoeElementSet::of(0xFF), 0xFFFF}}};
  }
  static SoeHeader random(std::mt19937& random) {
    return {static_cast<SoeOpCode>(random() & 7U),
            coin(random),
            coin(random),
            static_cast<std::uint8_t>(random() & 7U),
            SoeElementSet::of(any<std::uint8_t>(random)),
            any<std::uint16_t>(random)};
  }
};

template <>
struct Sample<SoeListHeader> {
  static constexpr std::string_view kName = "SoeListHeader";
  static std::vector<Golden<SoeListHeader>> golden() {
    return {{"IEC 61800-7-204, lists: eight bytes of at most 0x0102", "08 00 02 01", {8, 0x0102}}};
  }
  static SoeListHeader random(std::mt19937& random) { return {any<std::uint16_t>(random), any<std::uint16_t>(random)}; }
};

template <>
struct Sample<SoeAttribute> {
  static constexpr std::string_view kName = "SoeAttribute";
  static std::vector<Golden<SoeAttribute>> golden() {
    return {{"IEC 61800-7-204, element 3: an unsigned number of two bytes",
             "01 00 11 00",
             {1, 1, false, false, SoeDisplay::kUnsigned, 0, false, false, false}},
            {"IEC 61800-7-204, element 3: a list of IDNs that is protected in every phase",
             "01 00 55 70",
             {1, 1, true, false, SoeDisplay::kIdn, 0, true, true, true}},
            {"IEC 61800-7-204, element 3: a procedure command, protected in phase 4",
             "01 00 09 40",
             {1, 1, false, true, SoeDisplay::kBinary, 0, false, false, true}},
            {"IEC 61800-7-204, element 3: signed, eight bytes, factor 1000, three decimals, protected in phase 3",
             "e8 03 23 23",
             {1000, 3, false, false, SoeDisplay::kSigned, 3, false, true, false}}};
  }
  static SoeAttribute random(std::mt19937& random) {
    return {any<std::uint16_t>(random),
            static_cast<std::uint8_t>(random() & 3U),
            coin(random),
            coin(random),
            static_cast<SoeDisplay>(random() & 7U),
            static_cast<std::uint8_t>(random() & 15U),
            coin(random),
            coin(random),
            coin(random)};
  }
};

template <>
struct Sample<MailboxErrorReply> {
  static constexpr std::string_view kName = "MailboxErrorReply";
  static std::vector<Golden<MailboxErrorReply>> golden() {
    return {{"ETG.1000.4 Table 30", "01 00 02 00", {MailboxErrorCode::kUnsupportedProtocol}},
            {"ETG.1000.4 Table 30, a code of tomorrow", "01 00 fe ca", {static_cast<MailboxErrorCode>(0xCAFE)}}};
  }
  static MailboxErrorReply random(std::mt19937& random) { return {any<MailboxErrorCode>(random)}; }
};

template <>
struct Sample<CoeHeader> {
  static constexpr std::string_view kName = "CoeHeader";
  static std::vector<Golden<CoeHeader>> golden() {
    return {{"soem packet 281", "00 20", {0, CoeService::kSdoRequest}},
            {"soem packet 290", "00 30", {0, CoeService::kSdoResponse}},
            {"ETG.1000.6 Table 29, all bits of the number", "ff 81", {0x1FF, CoeService::kSdoInformation}}};
  }
  static CoeHeader random(std::mt19937& random) {
    return {static_cast<std::uint16_t>(random() & 0x1FFU), static_cast<CoeService>(random() & 0xFU)};
  }
};

template <>
struct Sample<SdoHeader> {
  static constexpr std::string_view kName = "SdoHeader";
  static std::vector<Golden<SdoHeader>> golden() {
    return {{"soem packet 281, upload of 1C00h:0", "40 00 1c 00 00 00 00 00", {0x40, 0x1C00, 0, {}}},
            {"soem packet 290, its answer, one byte", "4f 00 1c 00 04 00 00 00", {0x4F, 0x1C00, 0, {std::byte{4}}}},
            {"soem packet 352, four bytes of 1600h:1",
             "43 00 16 01 10 00 40 60",
             {0x43, 0x1600, 1, {std::byte{0x10}, std::byte{0x00}, std::byte{0x40}, std::byte{0x60}}}}};
  }
  static SdoHeader random(std::mt19937& random) {
    SdoHeader header{any<std::uint8_t>(random), any<std::uint16_t>(random), any<std::uint8_t>(random), {}};
    for (auto& b : header.data) b = any<std::byte>(random);
    return header;
  }
};

template <>
struct Sample<Emergency> {
  static constexpr std::string_view kName = "Emergency";
  static std::vector<Golden<Emergency>> golden() {
    return {{"CiA 301 7.2.7, heartbeat error with five bytes of the manufacturer",
             "30 81 11 01 02 03 04 05",
             {0x8130, 0x11, {std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}}}}};
  }
  static Emergency random(std::mt19937& random) {
    Emergency emergency{any<std::uint16_t>(random), any<std::uint8_t>(random), {}};
    for (auto& b : emergency.data) b = any<std::byte>(random);
    return emergency;
  }
};

template <>
struct Sample<SdoInfoHeader> {
  static constexpr std::string_view kName = "SdoInfoHeader";
  static std::vector<Golden<SdoInfoHeader>> golden() {
    return {
        {"ETG.1000.6 5.6.3, request of the object list", "01 00 00 00", {SdoInfoOpCode::kListRequest, false, 0}},
        {"ETG.1000.6 5.6.3, part of the list, 258 to come", "82 00 02 01", {SdoInfoOpCode::kListResponse, true, 258}}};
  }
  static SdoInfoHeader random(std::mt19937& random) {
    return {static_cast<SdoInfoOpCode>(random() & 0x7FU), coin(random), any<std::uint16_t>(random)};
  }
};

// --- Types made from raw register values -----------------------------------------------------------------------

template <>
struct RegisterSample<AlControl> {
  static constexpr std::string_view kName = "AlControl";
  using Raw = std::uint16_t;
  static constexpr Raw kMeaning = 0x003F;
  static std::vector<Golden<AlControl>> golden() {
    return {{"twincat packet 149, INIT with acknowledge", "11 00", {AlState::kInit, true, false}},
            {"ETG.1000.6 Table 9, OP", "08 00", {AlState::kOp, false, false}},
            {"ETG.1000.6 Table 9, PREOP with request of the identification", "22 00", {AlState::kPreOp, false, true}}};
  }
};

template <>
struct RegisterSample<AlStatus> {
  static constexpr std::string_view kName = "AlStatus";
  using Raw = std::uint16_t;
  static constexpr Raw kMeaning = 0x003F;
  static std::vector<Golden<AlStatus>> golden() {
    return {{"twincat packet 151", "01 00", {AlState::kInit, false, false}},
            {"ETG.1000.6 Table 10, SAFEOP with error", "14 00", {AlState::kSafeOp, true, false}},
            {"ETG.1000.6 Table 10, BOOT with identification", "23 00", {AlState::kBootstrap, false, true}}};
  }
};

template <>
struct RegisterSample<DlStatus> {
  static constexpr std::string_view kName = "DlStatus";
  using Raw = std::uint16_t;
  static constexpr Raw kMeaning = 0xFFF7;
  static std::vector<Golden<DlStatus>> golden() {
    // Port 0 is linked, open and communicating, the others are closed.
    DlStatus end_of_line;
    end_of_line.pdi_operational = true;
    end_of_line.pdi_watchdog_ok = true;
    end_of_line.ports[0] = {true, false, true};
    return {{"soem packet 94", "13 56", end_of_line}};
  }
};

template <>
struct RegisterSample<SyncManagerControl> {
  static constexpr std::string_view kName = "SyncManagerControl";
  using Raw = std::uint8_t;
  static constexpr Raw kMeaning = 0x7F;
  static std::vector<Golden<SyncManagerControl>> golden() {
    using M = SyncManagerMode;
    using D = SyncManagerDirection;
    return {{"soem packet 264, SM0", "26", {M::kMailbox, D::kWrite, false, true, false}},
            {"soem packet 264, SM1", "22", {M::kMailbox, D::kRead, false, true, false}},
            {"soem packet 736, SM2", "24", {M::kThreeBuffer, D::kWrite, false, true, false}},
            {"SII of an EL2004 terminal, SM0", "44", {M::kThreeBuffer, D::kWrite, false, false, true}},
            {"ETG.1000.4 Table 59, interrupt to the master", "10", {M::kThreeBuffer, D::kRead, true, false, false}}};
  }
};

template <>
struct RegisterSample<SdoSegmentHeader> {
  static constexpr std::string_view kName = "SdoSegmentHeader";
  using Raw = std::uint8_t;
  static constexpr Raw kMeaning = 0xFF;
  static std::vector<Golden<SdoSegmentHeader>> golden() {
    return {{"CiA 301 7.2.4.3.6, upload segment request, toggled", "70", {3, true, 0, false}},
            {"CiA 301 7.2.4.3.6, last segment, one byte of data", "0d", {0, false, 6, true}},
            {"CiA 301 7.2.4.3.4, download segment response, toggled", "30", {1, true, 0, false}}};
  }
};

}  // namespace driveline::wire::test
