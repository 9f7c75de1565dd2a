#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/mailbox/mailbox_server.hpp"
#include "driveline/slaves/mailbox/soe_parameters.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::slaves {

/// Servo drive profile over EtherCAT server of a device (ETG.1000.6 5.9): elements of operation data of up to eight
/// drives, fragmented if necessary, notifications and emergencies.
///
/// The fragments of a write are answered once, after the last one. Masters count the remaining fragments differently,
/// but the count must decrease by one with each fragment, or the write is refused.
class SoeServer final : public MailboxProtocol {
 public:
  /// Maximum size of an element in bytes: the longest list with its header.
  static constexpr std::size_t kLargest = 0xFFFF + wire::SoeListHeader::kSize;

  /// `parameters` must outlive this.
  explicit SoeServer(SoeParameters& parameters) noexcept : parameters_(&parameters) {}

  /// SoE, type 5.
  [[nodiscard]] wire::MailboxType type() const noexcept override { return wire::MailboxType::kSoe; }
  [[nodiscard]] tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                          std::span<std::byte> out) override;
  [[nodiscard]] std::size_t unsolicited(std::span<std::byte> out) override;
  void stop() noexcept override;

 private:
  /// A write that is not complete yet.
  struct Write {
    std::uint8_t drive = 0;
    wire::SoeElementSet elements;
    std::uint16_t left = 0;  ///< remaining fragments according to the last one
    std::vector<std::byte> data{};
    std::optional<wire::SoeError> refusal{};  ///< sent with the answer after the last fragment
  };
  /// An answer that is not sent completely yet.
  struct Reading {
    wire::SoeHeader header;  ///< header of its last mailbox message
    std::vector<std::byte> data{};
    std::size_t sent = 0;
  };

  [[nodiscard]] std::size_t read(const wire::SoeHeader& request, wire::AlState state, std::span<std::byte> out);
  void collect(const wire::SoeHeader& request, std::span<const std::byte> data);
  [[nodiscard]] std::size_t write(const wire::SoeHeader& request, std::span<const std::byte> data, wire::AlState state,
                                  std::span<std::byte> out);
  [[nodiscard]] SoeAnswer<void> write_whole(const wire::SoeHeader& request, std::span<const std::byte> data,
                                            wire::AlState state);
  [[nodiscard]] std::size_t send_part(std::span<std::byte> out);
  [[nodiscard]] static std::size_t refuse(const wire::SoeHeader& request, wire::SoeError code,
                                          std::span<std::byte> out);

  SoeParameters* parameters_;
  std::optional<Write> write_;
  std::optional<Reading> reading_;
};

}  // namespace driveline::slaves
