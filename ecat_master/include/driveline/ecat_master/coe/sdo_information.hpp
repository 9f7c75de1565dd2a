#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::ecat_master {

/// Object lists of the SDO information service (ETG.1000.6 Table 47).
enum class ObjectList : std::uint16_t { kAll = 1, kRxMappable = 2, kTxMappable = 3, kBackup = 4, kStartUp = 5 };

/// A slave's description of an object (ETG.1000.6 5.6.3.5).
struct ObjectDescription {
  std::uint16_t index = 0;        ///< index of the object
  std::uint16_t data_type = 0;    ///< index of the type in the dictionary, 0001h to 0FFFh
  std::uint8_t max_subindex = 0;  ///< highest sub-index
  std::uint8_t object_code = 0;   ///< 7 variable, 8 array, 9 record
  std::string name;               ///< name as reported by the slave
};

/// A slave's description of an entry (ETG.1000.6 5.6.3.6). Values are raw, little endian; empty: not reported.
struct EntryDescription {
  std::uint16_t index = 0;                              ///< index of the object
  std::uint8_t subindex = 0;                            ///< sub-index of the entry
  std::uint16_t data_type = 0;                          ///< index of the type in the dictionary
  std::uint16_t bit_length = 0;                         ///< length of the value in bits
  std::uint16_t access = 0;                             ///< wire::entry_access bits
  std::optional<std::uint32_t> unit;                    ///< ETG.1004 unit code
  std::optional<std::vector<std::byte>> default_value;  ///< default value; empty: not reported
  std::optional<std::vector<std::byte>> minimum;        ///< minimum; empty: not reported
  std::optional<std::vector<std::byte>> maximum;        ///< maximum; empty: not reported
  std::string name;                                     ///< name as reported by the slave
};

/// One query of the SDO information service and its answer, assembled from fragments. A slave that repeats or omits
/// fragments, or never ends, causes an error.
class SdoInformationQuery final : public MailboxDialogue {
 public:
  /// Largest total size of an answer's fragments, in bytes: a list of every possible index.
  static constexpr std::size_t kMaxAnswerBytes = 2 * 0x10000 + 2;

  /// Queries the indices in a list.
  [[nodiscard]] static std::shared_ptr<SdoInformationQuery> list(ObjectList list);
  /// Queries the description of an object.
  [[nodiscard]] static std::shared_ptr<SdoInformationQuery> object(std::uint16_t index);
  /// Queries everything about an entry, including unit, default, minimum and maximum.
  [[nodiscard]] static std::shared_ptr<SdoInformationQuery> entry(std::uint16_t index, std::uint8_t subindex);

  /// Used by the functions above.
  SdoInformationQuery(wire::SdoInfoOpCode question, std::uint16_t about, std::uint8_t subindex,
                      std::span<const std::byte> parameters);

  /// After done(): the data behind the SDO information headers of all fragments. Errors: SdoAbort with the slave's
  /// reason, Mailbox*, those of the bus.
  [[nodiscard]] const Result<std::vector<std::byte>>& result() const noexcept { return result_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return outgoing_; }
  /// The fragments of an answer would come twice.
  [[nodiscard]] bool repeatable() const noexcept override { return !fragments_left_; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override;

 private:
  [[nodiscard]] Reaction end(ErrorFacts facts);
  [[nodiscard]] facts::ObjectAddress object() const noexcept;
  [[nodiscard]] bool is_about_this(std::span<const std::byte> data) const;

  wire::SdoInfoOpCode question_;
  std::uint16_t about_;
  std::uint8_t subindex_;
  std::uint16_t position_ = Error::kNoSlave;
  std::vector<std::byte> outgoing_;
  std::vector<std::byte> data_;
  std::optional<std::uint16_t> fragments_left_;
  Result<std::vector<std::byte>> result_;
};

///
/// ame Decoding of the answers. Errors: MailboxMalformed when the data are too short.
/// @{

/// Decodes the indices behind the list type, in the order of the slave.
[[nodiscard]] Result<std::vector<std::uint16_t>> decode_object_list(std::span<const std::byte> answer);
/// Decodes an object description behind the header of the service.
[[nodiscard]] Result<ObjectDescription> decode_object_description(std::span<const std::byte> answer);
/// Decodes an entry description behind the header of the service, with unit, default, minimum and maximum if reported.
[[nodiscard]] Result<EntryDescription> decode_entry_description(std::span<const std::byte> answer);
/// @}

}  // namespace driveline::ecat_master
