#include "driveline/ecat_master/discovery/device_identification.hpp"

#include <gtest/gtest.h>

#include "driveline/wire/al.hpp"

namespace driveline::ecat_master {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::uint16_t kId = 0x1234;

/// A slave in PREOP that shows its device identification (ETG.1000.6) some reads of AL status after the request.
class Slave final : public DatagramExchange {
 public:
  int reads_until_loaded = 0;
  bool asked = false;
  /// The machine suspends the master for this long in each of the first rounds.
  nanoseconds away{0};
  int away_rounds = 0;

  Result<void> exchange(std::span<Request> requests) override {
    now_ += std::chrono::microseconds{10};
    if (away_rounds-- > 0) now_ += away;
    for (auto& request : requests) {
      request.answered = true;
      request.working_counter = 1;
      if (request.command == wire::Command::kFpwr) {
        asked = (bytes::load_le<std::uint16_t>(request.data) & 0x0020) != 0;
        continue;
      }
      const bool loaded = asked && reads_until_loaded-- <= 0;
      bytes::store_le<std::uint16_t>(request.data, loaded ? 0x0022 : 0x0002);
      bytes::store_le<std::uint16_t>(request.data.subspan(4), loaded ? kId : std::uint16_t{0});
    }
    return {};
  }
  void pause(nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] nanoseconds now() const noexcept override { return now_; }

 private:
  nanoseconds now_{0};
};

std::optional<std::uint16_t> id_of(Slave& slave) {
  Bus bus(slave);
  const SlaveRef ref{0, 0x1001};
  const auto ids = read_device_ids(bus, {&ref, 1}, milliseconds{100});
  EXPECT_TRUE(ids);
  return ids ? ids->at(0) : std::nullopt;
}

TEST(DeviceIdentification, IsWaitedFor) {
  Slave slave;
  slave.reads_until_loaded = 50;
  EXPECT_EQ(id_of(slave), kId);
  EXPECT_FALSE(slave.asked) << "the request is taken back";
}

TEST(DeviceIdentification, ASlaveWithoutOneIsGivenUpAfterItsTime) {
  Slave slave;
  slave.reads_until_loaded = 1'000'000;
  EXPECT_EQ(id_of(slave), std::nullopt);
  EXPECT_FALSE(slave.asked);
  EXPECT_GE(slave.now(), milliseconds{100});
  EXPECT_LT(slave.now(), milliseconds{102});
}

TEST(DeviceIdentification, AMachineThatSuspendsTheMasterTakesNoneAway) {
  Slave slave;
  slave.reads_until_loaded = 3;
  slave.away = milliseconds{300};
  slave.away_rounds = 10;
  EXPECT_EQ(id_of(slave), kId);
}

}  // namespace
}  // namespace driveline::ecat_master
