#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>
#include <utility>

#include "driveline/slaves/mailbox/file_store.hpp"
#include "driveline/slaves/msd/core/drive_core.hpp"

namespace driveline::slaves::msd {

/// Files of the drive for FoE (names and formats ours): in BOOT the firmware, any name that ends with ".efw", write
/// only; in PREOP and above the parameter set, writable in PREOP with the power stage off.
class DriveFiles final : public FileStore {
 public:
  static constexpr std::string_view kParameterSet = "parameters.txt";    ///< one parameter per line
  static constexpr std::string_view kFirmwareSuffix = ".efw";            ///< suffix of firmware names
  static constexpr std::size_t kMaxFirmware = std::size_t{8} << 20;      ///< bytes
  static constexpr std::size_t kMaxParameterSet = std::size_t{1} << 20;  ///< bytes

  /// `core` must outlive this. `password`: required for all files, 0: none; `flash_time`: until a firmware is stored.
  DriveFiles(DriveCore& core, std::uint32_t password, std::chrono::nanoseconds flash_time)
      : core_(&core), password_(password), flash_time_(flash_time) {}

  [[nodiscard]] FileAnswer<std::vector<std::byte>> read_file(const FileRequest& request) override;
  [[nodiscard]] FileAnswer<std::size_t> open_file(const FileRequest& request) override;
  [[nodiscard]] FileAnswer<void> write_file(const FileRequest& request, std::span<const std::byte> content) override;
  [[nodiscard]] std::optional<wire::FoeBusy> busy() const noexcept override;

 private:
  enum class Kind : std::uint8_t { kFirmware, kParameterSet };
  /// Returns the requested file, if state and password permit access.
  [[nodiscard]] FileAnswer<Kind> find(const FileRequest& request) const;
  [[nodiscard]] FileAnswer<void> write_firmware(std::span<const std::byte> content);
  [[nodiscard]] FileAnswer<void> write_parameters(std::span<const std::byte> content);

  DriveCore* core_;
  std::uint32_t password_;
  std::chrono::nanoseconds flash_time_;
  std::chrono::nanoseconds kept_at_{0};  ///< when the last firmware is stored, in running time of the drive
};

}  // namespace driveline::slaves::msd
