// Three-buffer and mailbox mode, opening and closing of buffers, status bits, events, locking (ETG.1000.4 6.6).
#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

constexpr std::uint16_t kArea = 0x1400;

/// Sync managers without a state machine: the test plays the application.
class SyncManagerTest : public BenchSlave {
 protected:
  SyncManagerUnit& unit() { return esc().sync_managers(); }
  /// Enables a channel and releases it for the master, as the firmware does in its transitions.
  void enable(unsigned n, std::uint16_t start, std::uint16_t length, std::uint8_t control) {
    set_sync_manager(n, {start, length, control, 0, 1, 0});
    unit().set_deactivated(n, false);
  }
  bool publish(unsigned n, const std::vector<std::byte>& data) {
    const auto buffer = unit().begin_publish(n);
    if (buffer.empty()) return false;
    std::copy(data.begin(), data.end(), buffer.begin());
    unit().end_publish(n);
    return true;
  }
  std::vector<std::byte> take(unsigned n) {
    const auto data = unit().take(n);
    return {data.begin(), data.end()};
  }
};

TEST_F(SyncManagerTest, MailboxTheMasterWritesIsLockedWhileFull) {
  enable(0, kArea, 4, 0x26);
  EXPECT_EQ(write(kArea, bytes({1, 2, 3, 4})), 1);
  EXPECT_EQ(sync_manager_status(0), 0x09) << "full, interrupt write";
  EXPECT_EQ(write(kArea, bytes({5, 6, 7, 8})), 0);
  EXPECT_EQ(take(0), bytes({1, 2, 3, 4}));
  EXPECT_EQ(sync_manager_status(0), 0x02) << "empty, interrupt read";
  EXPECT_TRUE(take(0).empty());
  EXPECT_EQ(write(kArea, bytes({5, 6, 7, 8})), 1);
  EXPECT_EQ(take(0), bytes({5, 6, 7, 8}));
}

TEST_F(SyncManagerTest, MailboxTheMasterReadsIsLockedWhileEmpty) {
  enable(1, kArea, 4, 0x22);
  EXPECT_EQ(sync_manager_status(1), 0x00);
  const auto empty = read(kArea, 4);
  EXPECT_EQ(empty.working_counter, 0);
  EXPECT_EQ(empty.data, bytes({0xEE, 0xEE, 0xEE, 0xEE})) << "data untouched";
  EXPECT_TRUE(publish(1, bytes({1, 2, 3, 4})));
  EXPECT_EQ(sync_manager_status(1), 0x09);
  EXPECT_FALSE(publish(1, bytes({9, 9, 9, 9}))) << "the application is locked out meanwhile";
  const auto full = read(kArea, 4);
  EXPECT_EQ(full.working_counter, 1);
  EXPECT_EQ(full.data, bytes({1, 2, 3, 4}));
  EXPECT_EQ(sync_manager_status(1), 0x02);
  EXPECT_EQ(read(kArea, 4).working_counter, 0);
}

TEST_F(SyncManagerTest, MailboxInTwoPieces) {
  // Like a master that learns the length only from the header: first bytes, again, then the last one.
  enable(1, kArea, 8, 0x22);
  publish(1, bytes({1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(read(kArea, 2).data, bytes({1, 2}));
  EXPECT_EQ(sync_manager_status(1), 0x48) << "full, read buffer open, interrupt write cleared by the first byte";
  EXPECT_EQ(read(kArea, 4).data, bytes({1, 2, 3, 4}));
  EXPECT_EQ(read(kArea + 5, 2).data, bytes({6, 7}));
  EXPECT_EQ(read(kArea + 7, 1).data, bytes({8}));
  EXPECT_EQ(sync_manager_status(1), 0x02);

  enable(0, 0x1480, 8, 0x26);
  EXPECT_EQ(write(0x1480, bytes({1, 2, 3})), 1);
  EXPECT_EQ(sync_manager_status(0), 0x80) << "write buffer open";
  EXPECT_TRUE(take(0).empty());
  EXPECT_EQ(write(0x1487, bytes({8})), 1);
  EXPECT_EQ(sync_manager_status(0), 0x09);
  EXPECT_EQ(take(0), bytes({1, 2, 3, 0, 0, 0, 0, 8}));
}

TEST_F(SyncManagerTest, BytesInTheMiddleAreLockedUntilTheFirstOneOpensTheBuffer) {
  enable(0, kArea, 4, 0x26);
  EXPECT_EQ(write(kArea + 1, bytes({2, 3, 4})), 0);
  EXPECT_EQ(write(kArea + 3, bytes({4})), 0);
  EXPECT_TRUE(take(0).empty());
  enable(1, 0x1480, 4, 0x22);
  publish(1, bytes({1, 2, 3, 4}));
  EXPECT_EQ(read(0x1481, 3).working_counter, 0);
  EXPECT_EQ(read(0x1483, 1).working_counter, 0);
  EXPECT_EQ(read(0x1480, 4).data, bytes({1, 2, 3, 4})) << "still there";

  enable(2, 0x1500, 4, 0x24);
  EXPECT_EQ(write(0x1503, bytes({4})), 0);
  enable(3, 0x1600, 4, 0x20);
  publish(3, bytes({1, 2, 3, 4}));
  EXPECT_EQ(read(0x1602, 2).working_counter, 0);
}

TEST_F(SyncManagerTest, AccessInTheWrongDirectionIsLocked) {
  enable(0, kArea, 4, 0x26);
  enable(2, 0x1500, 4, 0x24);
  write(kArea, bytes({1, 2, 3, 4}));
  write(0x1500, bytes({1, 2, 3, 4}));
  EXPECT_EQ(read(kArea, 4).working_counter, 0);
  EXPECT_EQ(read(0x1500, 4).working_counter, 0);
  enable(3, 0x1600, 4, 0x20);
  EXPECT_EQ(write(0x1600, bytes({1, 2, 3, 4})), 0);
}

TEST_F(SyncManagerTest, ThreeBuffersNeverLockAndHandOverTheNewest) {
  enable(2, kArea, 4, 0x24);
  EXPECT_EQ(sync_manager_status(2), 0x30) << "no buffer written yet";
  EXPECT_TRUE(take(2).empty());
  for (unsigned i = 1; i <= 10; ++i) EXPECT_EQ(write(kArea, bytes({i, i, i, i})), 1);
  EXPECT_EQ(take(2), bytes({10, 10, 10, 10}));
  EXPECT_FALSE(unit().fresh(2));
  EXPECT_TRUE(take(2).empty()) << "nothing new";
  EXPECT_EQ(unit().write_count(2), 10U);
}

TEST_F(SyncManagerTest, ThreeBuffersInputsCanBeReadAgain) {
  enable(3, kArea, 2, 0x20);
  publish(3, bytes({1, 2}));
  EXPECT_EQ(sync_manager_status(3), 0x01);
  EXPECT_EQ(read(kArea, 2).data, bytes({1, 2}));
  EXPECT_EQ(sync_manager_status(3), 0x02);
  EXPECT_EQ(read(kArea, 2).data, bytes({1, 2}));
  publish(3, bytes({3, 4}));
  EXPECT_EQ(sync_manager_status(3), 0x11) << "second buffer";
  EXPECT_EQ(read(kArea, 2).data, bytes({3, 4}));
}

TEST_F(SyncManagerTest, OpenReadBufferIsNotOverwritten) {
  enable(3, kArea, 4, 0x20);
  publish(3, bytes({1, 1, 1, 1}));
  EXPECT_EQ(read(kArea, 2).data, bytes({1, 1}));
  for (unsigned i = 2; i < 9; ++i) EXPECT_TRUE(publish(3, bytes({i, i, i, i})));
  EXPECT_EQ(read(kArea + 2, 2).data, bytes({1, 1})) << "the rest of the same buffer";
  EXPECT_EQ(read(kArea, 4).data, bytes({8, 8, 8, 8}));
}

TEST_F(SyncManagerTest, HalfWrittenOutputsAreNotHandedOver) {
  enable(2, kArea, 4, 0x24);
  write(kArea, bytes({1, 1, 1, 1}));
  write(kArea, bytes({2, 2, 2}));
  EXPECT_EQ(take(2), bytes({1, 1, 1, 1}));
  write(kArea + 3, bytes({2}));
  EXPECT_EQ(take(2), bytes({2, 2, 2, 2}));
}

TEST_F(SyncManagerTest, OneByteIsFirstAndLast) {
  enable(0, kArea, 1, 0x26);
  EXPECT_EQ(write(kArea, bytes({7})), 1);
  EXPECT_EQ(write(kArea, bytes({8})), 0);
  EXPECT_EQ(take(0), bytes({7}));
}

TEST_F(SyncManagerTest, AccessAcrossSeveralChannelsAndPlainRam) {
  enable(0, kArea, 4, 0x26);
  enable(1, kArea + 8, 4, 0x26);
  const std::vector<std::byte> data = bytes({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13});
  EXPECT_EQ(write(kArea - 1, data), 1);
  EXPECT_EQ(take(0), bytes({1, 2, 3, 4}));
  EXPECT_EQ(take(1), bytes({9, 10, 11, 12}));
  EXPECT_EQ(read(kArea - 1, 1).data, bytes({0}));
  EXPECT_EQ(read(kArea + 4, 4).data, bytes({5, 6, 7, 8}));
  EXPECT_EQ(read(kArea + 12, 1).data, bytes({13}));
  // One of them is full: the others still accept their part, and the access counts once.
  write(kArea, bytes({1, 1, 1, 1}));
  EXPECT_EQ(write(kArea - 1, data), 1);
  EXPECT_EQ(take(0), bytes({1, 1, 1, 1}));
  EXPECT_EQ(take(1), bytes({9, 10, 11, 12}));
}

TEST_F(SyncManagerTest, OfOverlappingChannelsTheLowerNumberOwnsTheBytes) {
  enable(1, kArea, 4, 0x26);
  enable(0, kArea + 2, 4, 0x26);
  EXPECT_EQ(write(kArea, bytes({1, 2, 3, 4, 5, 6})), 1);
  EXPECT_EQ(take(0), bytes({3, 4, 5, 6}));
  EXPECT_TRUE(take(1).empty()) << "its last byte was never reached";
}

TEST_F(SyncManagerTest, SettingsAreLockedWhileEnabled) {
  enable(0, kArea, 4, 0x26);
  EXPECT_EQ(write(0x0800, bytes({0x00, 0x10, 0x08, 0x00, 0x22})), 0);
  EXPECT_EQ(read(0x0800, 5).data, bytes({0x00, 0x14, 0x04, 0x00, 0x26}));
  EXPECT_EQ(write(0x0800, std::vector<std::byte>(8)), 1) << "the activate byte can be written";
  EXPECT_EQ(read(0x0800, 5).data, bytes({0x00, 0x14, 0x04, 0x00, 0x26}));
  EXPECT_EQ(write(0x0800, std::vector<std::byte>(5)), 1);
  EXPECT_EQ(read(0x0800, 5).data, bytes({0, 0, 0, 0, 0}));
}

TEST_F(SyncManagerTest, DisabledChannelIsPlainMemory) {
  enable(1, kArea, 4, 0x22);
  publish(1, bytes({1, 2, 3, 4}));
  write(0x080E, bytes({0}));
  EXPECT_EQ(read(kArea + 2, 2).data, bytes({3, 4}));
  EXPECT_EQ(write(kArea, bytes({9})), 1);
  EXPECT_EQ(read(kArea, 1).data, bytes({9}));
}

TEST_F(SyncManagerTest, EnablingAgainForgetsTheBuffers) {
  enable(0, kArea, 4, 0x26);
  write(kArea, bytes({1, 2, 3, 4}));
  write(0x0806, bytes({0}));
  EXPECT_EQ(sync_manager_status(0), 0);
  write(0x0806, bytes({1}));
  EXPECT_TRUE(take(0).empty());
  EXPECT_EQ(write(kArea, bytes({5, 6, 7, 8})), 1);
  EXPECT_EQ(take(0), bytes({5, 6, 7, 8}));
}

TEST_F(SyncManagerTest, DeactivatedByTheApplicationLocksTheArea) {
  enable(2, kArea, 4, 0x24);
  write(kArea, bytes({1, 2, 3, 4}));
  unit().set_deactivated(2, true);
  EXPECT_EQ(read(0x0817, 1).data, bytes({1}));
  EXPECT_EQ(write(kArea, bytes({1, 2, 3, 4})), 0);
  EXPECT_FALSE(unit().fresh(2));
  unit().set_deactivated(2, false);
  EXPECT_EQ(write(kArea, bytes({1, 2, 3, 4})), 1);
}

TEST_F(SyncManagerTest, BuffersBeyondTheMemoryAreNotUsable) {
  const std::uint16_t end = 0x1000 + 8 * 1024;
  enable(2, end - 11, 4, 0x24);  // 3 x 4 bytes do not fit
  EXPECT_EQ(write(end - 11, bytes({1, 2, 3, 4})), 0);
  enable(0, end - 4, 4, 0x26);
  EXPECT_EQ(write(end - 4, bytes({1, 2, 3, 4})), 1);
  enable(1, 0xFFF0, 0xFFFF, 0x22);
  EXPECT_FALSE(publish(1, bytes({1})));
  EXPECT_EQ(read(0xFFF0, 4).working_counter, 0);
}

TEST_F(SyncManagerTest, EventsFollowTheStatusWhenEnabled) {
  const auto al_event = [this] { return get(reg::kAlEventRequest); };
  enable(2, kArea, 2, 0x24);  // PDI interrupt
  write(kArea, bytes({1, 2}));
  EXPECT_EQ(al_event() & 0x0400, 0x0400U);
  take(2);
  EXPECT_EQ(al_event() & 0x0400, 0U);

  write(reg::kEcatEventMask, 0x0FF0);
  enable(3, 0x1500, 2, 0x10);  // ECAT interrupt
  publish(3, bytes({1, 2}));
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0x0080);
  read(0x1500, 2);
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0);

  enable(1, 0x1600, 2, 0x02);  // no interrupt at all
  publish(1, bytes({1, 2}));
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0);
  EXPECT_EQ(al_event() & 0x0200, 0U);
}

TEST_F(SyncManagerTest, ActivationRaisesTheAlEvent) {
  esc().events().set_al(al_event::kSyncManagerChanged, false);
  set_sync_manager(4, {0x1900, 4, 0x24, 0, 0, 0});
  EXPECT_FALSE(esc().events().al_pending(al_event::kSyncManagerChanged));
  write(0x0826, bytes({1}));
  EXPECT_TRUE(esc().events().al_pending(al_event::kSyncManagerChanged));
}

TEST_F(SyncManagerTest, OnlyCompleteWritesTriggerTheWatchdog) {
  enable(2, kArea, 4, 0x64);
  EXPECT_EQ(esc().watchdog().expiry(), WatchdogUnit::kNever);
  write(kArea, bytes({1, 2, 3}));
  EXPECT_EQ(esc().watchdog().expiry(), WatchdogUnit::kNever);
  write(kArea + 3, bytes({4}));
  EXPECT_EQ(esc().watchdog().expiry(), now() + 100ms);
  EXPECT_EQ(get(reg::kWatchdogStatusProcessData), 1);
}

TEST_F(SyncManagerTest, ChannelInRegistersIsDirectAccess) {
  // A digital output terminal: one byte at 0x0F00, no buffers, but the watchdog.
  enable(0, 0x0F00, 1, 0x44);
  EXPECT_EQ(write(0x0F00, bytes({0x0A})), 1);
  EXPECT_EQ(read(0x0F00, 1).data, bytes({0x0A}));
  EXPECT_EQ(esc().watchdog().expiry(), now() + 100ms);
  EXPECT_EQ(take(0), bytes({0x0A}));
  EXPECT_TRUE(take(0).empty());
}

TEST_F(SyncManagerTest, RepeatRequestIsPendingUntilAcknowledged) {
  enable(1, kArea, 4, 0x22);
  EXPECT_FALSE(unit().repeat_requested(1));
  write(0x080E, bytes({3}));
  EXPECT_TRUE(unit().repeat_requested(1));
  unit().acknowledge_repeat(1);
  EXPECT_FALSE(unit().repeat_requested(1));
  EXPECT_EQ(read(0x080F, 1).data, bytes({2}));
  write(0x080E, bytes({1}));
  EXPECT_TRUE(unit().repeat_requested(1));
  unit().acknowledge_repeat(1);
  EXPECT_EQ(read(0x080F, 1).data, bytes({0}));
}

}  // namespace
}  // namespace driveline::slaves::test
