#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/line.hpp"
#include "line/drive_source.hpp"

namespace driveline::cli {

/// Answers a question of RunDrives about a running line, on the thread that owns the line; `words` follow "drive ":
///
///     slaves                    alias addresses of all slaves, by position
///     3 0x6041:0 0x6064:0 ...   state, link and these objects of slave 3, at most kDriveObjectsAtOnce
///     3 acknowledge             acknowledges a fault
///
/// One line of JSON, or "error: " and a sentence.
[[nodiscard]] std::string answer_about_drives(runtime::Line& line, std::string_view words);

/// Most objects in one question, so that the thread of the line is not kept for long.
inline constexpr std::size_t kDriveObjectsAtOnce = 8;

/// The drives of a running line, asked through its control socket: the master of the run reads the objects.
class RunDrives final : public DriveSource {
 public:
  /// `control`: socket of the run. Failure: the run does not answer, or is not in operation.
  [[nodiscard]] static Outcome<std::unique_ptr<RunDrives>> open(std::string control);

  [[nodiscard]] std::size_t size() const noexcept override { return aliases_.size(); }
  [[nodiscard]] std::vector<std::uint16_t> aliases() const override { return aliases_; }
  [[nodiscard]] Outcome<void> read(std::size_t position, DriveView& view) override;
  [[nodiscard]] Outcome<void> acknowledge(std::size_t position) override;

 private:
  explicit RunDrives(std::string control) : control_(std::move(control)) {}
  [[nodiscard]] Outcome<void> read_objects(std::size_t position, DriveView& view);

  std::string control_;
  std::vector<std::uint16_t> aliases_;
  /// Objects that a slave does not have, by position; they are not read again.
  std::map<std::size_t, std::vector<DriveObject>> missing_;
};

}  // namespace driveline::cli
