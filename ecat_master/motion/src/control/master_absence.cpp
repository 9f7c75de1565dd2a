#include "driveline/motion/control/master_absence.hpp"

#include <fmt/format.h>

namespace driveline::motion {

std::string describe(const MasterAbsence& absence, std::chrono::nanoseconds begin, std::string_view limit) {
  using Milliseconds = std::chrono::duration<double, std::milli>;
  auto sentence = fmt::format("the master was away for {:.1f} ms at {:.3f} s", Milliseconds(absence.duration).count(),
                              std::chrono::duration<double>(absence.since - begin).count());
  if (absence.effect == AbsenceEffect::kStopped) {
    return sentence + fmt::format(", longer than {}: all axes stopped", limit);
  }
  if (absence.path_late.count() > 0) {
    sentence += fmt::format("; the path is {:.1f} ms late", Milliseconds(absence.path_late).count());
  }
  return sentence;
}

}  // namespace driveline::motion
