#include "driveline/ecat_master/dc/time_source.hpp"

#include <ctime>

#include "driveline/rt/time_conversion.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

/// 1970-01-01 to 2000-01-01: 30 years, 7 of them leap years.
constexpr nanoseconds kUnixTo2000 = std::chrono::seconds{946'684'800};

}  // namespace

nanoseconds SystemTimeSource::now() const noexcept {
  timespec time{};
  static_cast<void>(clock_gettime(scale_ == Scale::kTai ? CLOCK_TAI : CLOCK_REALTIME, &time));
  return rt::from_timespec(time) - kUnixTo2000;
}

}  // namespace driveline::ecat_master::dc
