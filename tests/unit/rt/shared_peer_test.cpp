// Another process at the other end of a shared region that is killed in the middle of a record, stopped, replaced, or
// writes garbage.
#include <gtest/gtest.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <span>

#include "shared_support.hpp"

namespace driveline::rt {
namespace {

using shared_detail::kHeadWord;
using shared_detail::kRecordsWord;
using shared_detail::kTailWord;
using shared_detail::slot_words;
using test::broadcast_of_records;
using test::create;
using test::is_intact;
using test::open;
using test::Peer;
using test::Record;
using test::record_of;
using test::ring_of_records;

constexpr int kLives = 60;  // how often a peer is killed at a random point
constexpr std::uint64_t kPerLife = 300;

/// Takes the next record, as soon as it comes.
template <typename T>
void wait_for(SharedRingReader<T>& reader, T& record) {
  while (!reader.try_pop(record)) {
    ::sched_yield();
  }
}

/// Pushes records with increasing numbers from `first` on, until it is killed.
int write_without_end(int descriptor, std::uint64_t first) {
  const SharedRegion region = open(descriptor, ring_of_records());
  SharedRingWriter<Record> writer{region};
  for (std::uint64_t number = first;;) {
    number += writer.try_push(record_of(number)) ? 1 : 0;
  }
}

TEST(SharedPeer, WritersThatAreKilledLeaveWholeRecordsBehind) {
  const SharedRegion region = create(ring_of_records(16));
  SharedRingReader<Record> reader{region};
  std::uint64_t next = 0;
  std::array<Record, 8> records{};
  for (int life = 0; life < kLives; ++life) {
    Peer peer{[&] { return write_without_end(region.descriptor(), next); }};
    // First come the remaining records of the previous life.
    for (std::uint64_t received = 0; received < kPerLife;) {
      const std::size_t count = reader.pop(records);
      for (const Record& record : std::span{records}.first(count)) {
        ASSERT_TRUE(is_intact(record));
        ASSERT_EQ(record.number, next++);
      }
      received += count;
    }
    peer.end();
    while (const std::size_t count = reader.pop(records)) {
      for (const Record& record : std::span{records}.first(count)) {
        ASSERT_TRUE(is_intact(record));
        ASSERT_EQ(record.number, next++);
      }
    }
  }
  EXPECT_EQ(reader.breaches(), 0u);
}

TEST(SharedPeer, HalfARecordOfAKilledWriterIsNeverSeen) {
  const SharedRegion region = create(ring_of_records(4));
  SharedRingReader<Record> reader{region};
  Peer first{[&] {
    const SharedRegion opened = open(region.descriptor(), ring_of_records());
    SharedRingWriter<Record>{opened}.try_push(record_of(1));
    const std::size_t slot = kRecordsWord + slot_words(SharedForm::kRing, sizeof(Record));
    for (std::size_t i = 0; i < 7; ++i) {
      opened.words()[slot + i] = 0xBAD;
    }
    ::raise(SIGKILL);
    return 0;
  }};
  EXPECT_EQ(first.wait_for_end(), -SIGKILL);
  Peer second{[&] {
    const SharedRegion opened = open(region.descriptor(), ring_of_records());
    return SharedRingWriter<Record>{opened}.try_push(record_of(2)) ? 0 : 1;
  }};
  EXPECT_EQ(second.wait_for_end(), 0);
  std::array<Record, 4> records{};
  ASSERT_EQ(reader.pop(records), 2u);
  EXPECT_TRUE(is_intact(records[0]));
  EXPECT_TRUE(is_intact(records[1]));
  EXPECT_EQ(records[1].number, 2u);
}

TEST(SharedPeer, ReadersThatAreKilledLoseNothingThatWasNotTaken) {
  const SharedRegion region = create(ring_of_records(16));
  const SharedRegion answers = create(ring_of_records(1024));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> taken{answers};
  const auto forward = [&] {
    const SharedRegion from = open(region.descriptor(), ring_of_records());
    const SharedRegion to = open(answers.descriptor(), ring_of_records());
    SharedRingReader<Record> reader{from};
    SharedRingWriter<Record> told{to};
    for (Record record;;) {
      while (reader.try_pop(record)) {
        told.try_push(record);
      }
    }
    return 0;
  };
  std::uint64_t pushed = 0;
  std::uint64_t next = 0;
  for (int life = 0; life < kLives; ++life) {
    Peer peer{forward};
    const std::uint64_t until = next + kPerLife / 4;
    while (next < until) {
      pushed += writer.try_push(record_of(pushed)) ? 1 : 0;
      Record record;
      while (taken.try_pop(record)) {
        ASSERT_TRUE(is_intact(record));
        // If it was killed between taking a record and confirming it, it has taken one more than it reported, or
        // reported one that is taken again.
        ASSERT_LE(record.number, next + 1);
        ASSERT_GE(record.number + 1, next);
        next = record.number + 1;
      }
    }
    peer.end();
  }
  EXPECT_EQ(writer.breaches(), 0u);
}

TEST(SharedPeer, StoppedReaderCostsRecordsAndNoTime) {
  const SharedRegion region = create(ring_of_records(16));
  const SharedRegion answers = create(ring_of_records(1024));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> taken{answers};
  Peer peer{[&] {
    const SharedRegion from = open(region.descriptor(), ring_of_records());
    const SharedRegion to = open(answers.descriptor(), ring_of_records());
    SharedRingReader<Record> reader{from};
    SharedRingWriter<Record> told{to};
    for (Record record;;) {
      if (reader.try_pop(record)) {
        told.try_push(record);
      }
    }
    return 0;
  }};
  Record record;
  ASSERT_TRUE(writer.try_push(record_of(0)));
  wait_for(taken, record);
  peer.stop();
  std::uint64_t accepted = 0;
  for (std::uint64_t i = 1; i <= 100'000; ++i) {
    accepted += writer.try_push(record_of(i)) ? 1 : 0;
  }
  // It was stopped before or after it released record 0.
  EXPECT_TRUE(accepted == 15 || accepted == 16) << accepted;
  EXPECT_EQ(writer.dropped(), 100'000 - accepted);
  peer.go_on();
  for (std::uint64_t i = 1; i <= accepted; ++i) {
    wait_for(taken, record);
    EXPECT_EQ(record.number, i);
  }
}

TEST(SharedPeer, StoppedWriterLeavesAnEmptyRing) {
  const SharedRegion region = create(ring_of_records(16));
  SharedRingReader<Record> reader{region};
  Peer peer{[&] { return write_without_end(region.descriptor(), 0); }};
  Record record;
  wait_for(reader, record);
  peer.stop();
  std::uint64_t rest = 0;
  for (int i = 0; i < 100'000; ++i) {
    rest += reader.try_pop(record) ? 1 : 0;
  }
  EXPECT_LE(rest, 16u);
  const std::uint64_t last = record.number;
  peer.go_on();
  wait_for(reader, record);
  EXPECT_EQ(record.number, last + 1);
  EXPECT_TRUE(is_intact(record));
}

/// Writes garbage anywhere in a ring, mainly into header and indexes, until it is killed.
int write_garbage(int descriptor) {
  const SharedRegion region = open(descriptor, ring_of_records());
  std::uint64_t state = 0x9E37'79B9'7F4A'7C15;
  for (std::uint64_t turn = 0;; ++turn) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    const std::span<std::uint64_t> words = region.words();
    // Large and small numbers: impossible indexes, and plausible ones.
    const std::uint64_t value = turn % 2 == 0 ? state : state % 64;
    std::atomic_ref{words[state % words.size()]}.store(value, std::memory_order_relaxed);
    std::atomic_ref{words[turn % 3 == 0 ? kHeadWord : kTailWord]}.store(value, std::memory_order_relaxed);
  }
}

TEST(SharedPeer, GarbageFromAPeerNeitherStopsNorDeceivesTheOwner) {
  constexpr std::uint64_t kOperations = 1'000'000;
  const SharedRegion in = create(ring_of_records(16));
  const SharedRegion out = create(ring_of_records(16));
  SharedRingReader<Record> reader{in};
  SharedRingWriter<Record> writer{out};
  Peer spoiling_in{[&] { return write_garbage(in.descriptor()); }};
  Peer spoiling_out{[&] { return write_garbage(out.descriptor()); }};
  std::array<Record, 8> records{};
  std::uint64_t accepted = 0;
  std::uint64_t pushed = 0;
  // At least until the peers have disturbed both ends often enough.
  for (std::uint64_t i = 0; i < kOperations || reader.breaches() < 100 || writer.breaches() < 100; ++i) {
    const std::size_t count = reader.pop(records);
    ASSERT_LE(count, records.size());
    for (const Record& record : std::span{records}.first(count)) {
      // The checked copy is private: checking again gives the same answer.
      const bool first_answer = is_intact(record);
      ASSERT_EQ(is_intact(record), first_answer);
      accepted += first_answer ? 1 : 0;
    }
    pushed += writer.try_push(record_of(i)) ? 1 : 0;
    ASSERT_EQ(pushed + writer.dropped(), i + 1);
  }
  EXPECT_EQ(accepted, 0u);  // nothing of what is written there is a record
  spoiling_in.end();
  spoiling_out.end();
  // The owner's copies are intact: layout, size and mapping are as they were.
  EXPECT_EQ(in.layout(), ring_of_records(16));
  // A destroyed region cannot be opened unnoticed, because its header is destroyed, too.
  EXPECT_FALSE(SharedRegion::open(in.descriptor(), ring_of_records()));
}

TEST(SharedPeer, RingHealsWhenAnHonestPeerTakesTheDishonestOnesPlace) {
  const SharedRegion in = create(ring_of_records(16));
  SharedRingReader<Record> reader{in};
  Peer spoiling{[&] {
    const SharedRegion region = open(in.descriptor(), ring_of_records());
    for (std::uint64_t value = 1;; value = value * 6364136223846793005U + 1442695040888963407U) {
      for (std::size_t i = kHeadWord; i < region.words().size(); ++i) {
        std::atomic_ref{region.words()[i]}.store(value, std::memory_order_relaxed);
      }
    }
    return 0;
  }};
  std::array<Record, 8> records{};
  while (reader.breaches() < 10) {
    reader.pop(records);
  }
  spoiling.end();
  while (reader.pop(records) > 0) {
  }
  Peer honest{[&] { return write_without_end(in.descriptor(), 1000); }};
  // The new writer may find a plausible index, but not the previous records.
  Record record;
  do {
    wait_for(reader, record);
  } while (!is_intact(record));
  EXPECT_EQ(record.number, 1000u);
  for (std::uint64_t i = 1; i < 100; ++i) {
    wait_for(reader, record);
    ASSERT_EQ(record.number, 1000 + i);
    ASSERT_TRUE(is_intact(record));
  }
}

TEST(SharedPeer, BroadcastOfAKilledWriterIsReadToItsEnd) {
  std::array<Record, 8> records{};
  for (int life = 0; life < kLives; ++life) {
    // Created here and written by the child, which has inherited the writable mapping.
    const SharedRegion region = create(broadcast_of_records(16));
    SharedBroadcastReader<Record> reader{region};
    Peer peer{[&] {
      SharedBroadcastWriter<Record> writer{region};
      for (std::uint64_t number = 0;; ++number) {
        writer.push(record_of(number));
      }
      return 0;
    }};
    std::uint64_t next = 0;
    for (std::uint64_t received = 0; received < kPerLife;) {
      const std::size_t count = reader.take(records);
      for (const Record& record : std::span{records}.first(count)) {
        ASSERT_TRUE(is_intact(record));
        ASSERT_GE(record.number, next);
        next = record.number + 1;
      }
      received += count;
    }
    peer.end();
    while (reader.take(records) > 0) {
    }
    EXPECT_EQ(reader.take(records), 0u);
    Record record;
    // The newest record is available, unless the writer died while overwriting the only copy, which is impossible with
    // 16 slots.
    ASSERT_TRUE(reader.latest(record));
    EXPECT_TRUE(is_intact(record));
  }
}

TEST(SharedPeer, BroadcastReaderThatWasKilledIsReplacedByANewOne) {
  const SharedRegion region = create(broadcast_of_records(1024));
  const SharedRegion answers = create(ring_of_records(1024));
  SharedBroadcastWriter<Record> writer{region};
  SharedRingReader<Record> told{answers};
  const auto forward = [&] {
    const SharedRegion from = open(region.descriptor(), broadcast_of_records());
    const SharedRegion to = open(answers.descriptor(), ring_of_records());
    SharedBroadcastReader<Record> reader{from};
    SharedRingWriter<Record> tell{to};
    for (std::array<Record, 8> records{};;) {
      for (const Record& record : std::span{records}.first(reader.take(records))) {
        tell.try_push(record);
      }
    }
    return 0;
  };
  std::uint64_t number = 0;
  for (int life = 0; life < kLives; ++life) {
    Peer peer{forward};
    const std::uint64_t first_of_this_life = number;
    Record record;
    // Records published without a reader are lost; wait for the first record that this reader sees.
    do {
      writer.push(record_of(number++));
      if (!told.try_pop(record)) {
        record.number = 0;
      }
    } while (record.number < first_of_this_life || record.number == 0);
    ASSERT_TRUE(is_intact(record));
    peer.end();
    while (told.try_pop(record)) {
      ASSERT_TRUE(is_intact(record));
    }
  }
}

TEST(SharedPeer, StoppedBroadcastReaderLosesWhatItDidNotSee) {
  const SharedRegion region = create(broadcast_of_records(16));
  SharedBroadcastWriter<Record> writer{region};
  const SharedRegion answers = create(shared_ring<std::uint64_t>(1, 1, 16));
  SharedRingReader<std::uint64_t> told{answers};
  Peer peer{[&] {
    const SharedRegion from = open(region.descriptor(), broadcast_of_records());
    const SharedRegion to = open(answers.descriptor(), shared_ring<std::uint64_t>(1, 1));
    SharedBroadcastReader<Record> reader{from};
    SharedRingWriter<std::uint64_t> tell{to};
    tell.try_push(0);
    Record record;
    std::uint64_t seen = 0;
    while (record.number != 100'000) {
      if (reader.take({&record, 1}) == 1) {
        if (!is_intact(record)) return 1;
        ++seen;
      }
    }
    return seen + reader.lost() == 100'000 && reader.lost() >= 100'000 - 16 - 1 ? 0 : 2;
  }};
  std::uint64_t ready = 0;
  wait_for(told, ready);
  peer.stop();
  for (std::uint64_t i = 1; i <= 100'000; ++i) {
    writer.push(record_of(i));
  }
  peer.go_on();
  EXPECT_EQ(peer.wait_for_end(), 0);
}

}  // namespace
}  // namespace driveline::rt
