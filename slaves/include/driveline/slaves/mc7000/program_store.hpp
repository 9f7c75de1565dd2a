#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/mc7000/program.hpp"
#include "driveline/slaves/mc7000/program_line.hpp"

namespace driveline::slaves::mc7000 {

/// How long `%SAV` takes (MC7000 manual, line 1618: approximately 100 ms).
inline constexpr std::chrono::milliseconds kSaveTime{100};

/// Programs of a drive in working memory and in flash, and the download of a program line by line (MC7000 manual, lines
/// 1604-1625). Does not know the mode: its owner passes lines on in manual mode only.
class ProgramStore {
 public:
  /// Executes a line that is written to parameter 551. A refused line changes nothing, and a download goes on with the
  /// next line. `%Pnn` drops a download that has had no END.
  tl::expected<void, LineError> execute(std::string_view line);
  /// Drops a download that has had no END: the program does not exist.
  void drop_download() noexcept { download_.reset(); }
  /// Counts the time of `%SAV`. Its end copies the programs into flash memory, outside the cycle of a real drive.
  void advance(std::chrono::nanoseconds elapsed) noexcept;
  /// Supply off and on: programs are those in flash memory. A saving that has not ended has saved nothing.
  void restart();

  /// Returns whether `%SAV` is at work. \rtsafe
  [[nodiscard]] bool saving() const noexcept { return saving_left_.count() > 0; }
  /// Returns whether a program has begun and has had no END. \rtsafe
  [[nodiscard]] bool downloading() const noexcept { return download_.has_value(); }
  /// Returns a program; null when it does not exist. Valid until it is deleted or the drive restarts. \rtsafe
  [[nodiscard]] const Program* program(std::uint8_t number) const noexcept;
  /// Returns the name of a program; empty when it has none or does not exist. \rtsafe
  [[nodiscard]] std::string_view name(std::uint8_t number) const noexcept;

 private:
  struct Stored {
    std::string name;
    Program program;
  };
  struct Download {
    std::uint8_t number = 0;
    Stored content;
  };
  using Programs = std::array<std::shared_ptr<const Stored>, kPrograms>;

  tl::expected<void, LineError> run(const OpenProgram& line);
  tl::expected<void, LineError> run(const DeleteProgram& line);
  tl::expected<void, LineError> run(const SavePrograms& line);
  tl::expected<void, LineError> run(const EndProgram& line);
  tl::expected<void, LineError> run(const Record& line);

  Programs programs_{};
  Programs flash_{};
  std::optional<Download> download_;
  std::chrono::nanoseconds saving_left_{};
};

}  // namespace driveline::slaves::mc7000
