#pragma once

#include "driveline/canopen_client/sdo_transfer.hpp"

namespace driveline::canopen {

/// Expedited or segmented upload (CiA 301 7.2.4.3.5, .6).
class SegmentedUpload final : public SdoTransfer {
 public:
  SegmentedUpload(std::uint8_t node, SdoObject object, const SdoOptions& options);

 private:
  void answered(const SdoBytes& in) override;
  void begin(const SdoMessage& message);
  void take(const SdoBytes& in);
  void ask_for_segment();

  std::vector<std::byte> data_;
  std::optional<std::size_t> announced_;
  bool toggle_ = false;
};

/// Expedited or segmented download (CiA 301 7.2.4.3.3, .4).
class SegmentedDownload final : public SdoTransfer {
 public:
  SegmentedDownload(std::uint8_t node, SdoObject object, std::span<const std::byte> data, const SdoOptions& options);

 private:
  static constexpr std::size_t kExpedited = 4;  ///< bytes that an initiate message carries

  [[nodiscard]] bool expedited() const noexcept { return !data_.empty() && data_.size() <= kExpedited; }
  void answered(const SdoBytes& in) override;
  void send_segment();

  std::vector<std::byte> data_;
  std::size_t position_ = 0;  ///< bytes that have been sent
  bool complete_ = false;     ///< the last segment has been sent
  bool toggle_ = false;       ///< of the segment under way
};

/// Block upload (CiA 301 7.2.4.3.12 to .15).
class BlockUpload final : public SdoTransfer {
 public:
  BlockUpload(std::uint8_t node, SdoObject object, const SdoOptions& options);

 private:
  enum class Phase : std::uint8_t { kInitiate, kSegments, kEnd };

  void answered(const SdoBytes& in) override;
  [[nodiscard]] bool repeated() override;
  void begin(const SdoMessage& message);
  void take(const SdoBytes& in);
  void confirm();
  void end(const SdoBytes& in);

  std::vector<std::byte> data_;
  std::optional<std::size_t> announced_;
  Phase phase_ = Phase::kInitiate;
  std::uint8_t last_good_ = 0;  ///< sequence number within the sub-block
  unsigned fruitless_ = 0;      ///< sub-blocks in a row without a good segment
  bool any_segment_ = false;    ///< the node has begun to send
  bool complete_ = false;       ///< the last segment is here
  bool crc_ = false;            ///< both sides compute it
};

/// Block download (CiA 301 7.2.4.3.8 to .11).
class BlockDownload final : public SdoTransfer {
 public:
  BlockDownload(std::uint8_t node, SdoObject object, std::span<const std::byte> data, const SdoOptions& options);

 private:
  enum class Phase : std::uint8_t { kInitiate, kSegments, kEnd };

  void answered(const SdoBytes& in) override;
  void continue_sending() override;
  void begin(const SdoMessage& message);
  void confirmed(const SdoBytes& in);
  void queue_segment();
  void queue_end();

  std::vector<std::byte> data_;
  Phase phase_ = Phase::kInitiate;
  std::size_t segments_done_ = 0;    ///< that the node has confirmed
  std::uint8_t sequence_ = 0;        ///< last one that was queued in this sub-block
  std::uint8_t block_segments_ = 0;  ///< most of a sub-block
  unsigned fruitless_ = 0;           ///< sub-blocks in a row without a confirmed segment
  bool crc_ = false;                 ///< both sides compute it
};

}  // namespace driveline::canopen
