#include "driveline/rt/shared_broadcast.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <thread>
#include <vector>

#include "shared_support.hpp"

namespace driveline::rt {
namespace {

using shared_detail::kHeadWord;
using shared_detail::kRecordsWord;
using test::broadcast_of_records;
using test::create;
using test::is_intact;
using test::open;
using test::Record;
using test::record_of;
using Taken = std::vector<std::uint64_t>;

constexpr std::size_t kSlotWords = 1 + (sizeof(Record) + 7) / 8;

Taken take(SharedBroadcastReader<Record>& reader, std::size_t most = 100) {
  std::vector<Record> records(most);
  records.resize(reader.take(records));
  Taken result;
  for (const Record& record : records) {
    EXPECT_TRUE(is_intact(record));
    result.push_back(record.number);
  }
  return result;
}

TEST(SharedBroadcast, EveryReaderGetsEveryRecord) {
  const SharedRegion made = create(broadcast_of_records(4));
  const SharedRegion opened = open(made.descriptor(), broadcast_of_records());
  SharedBroadcastWriter<Record> writer{made};
  SharedBroadcastReader<Record> here{made};
  SharedBroadcastReader<Record> there{opened};
  for (std::uint64_t i = 0; i < 3; ++i) {
    writer.push(record_of(i));
  }
  EXPECT_EQ(take(here), (Taken{0, 1, 2}));
  EXPECT_EQ(take(there, 2), (Taken{0, 1}));
  EXPECT_EQ(take(there), (Taken{2}));
  EXPECT_TRUE(take(there).empty());
  EXPECT_EQ(here.lost() + there.lost(), 0u);
}

TEST(SharedBroadcast, SlowReaderLosesTheOldestAndCountsThem) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  for (std::uint64_t i = 0; i < 11; ++i) {
    writer.push(record_of(i));
  }
  EXPECT_EQ(take(reader), (Taken{7, 8, 9, 10}));
  EXPECT_EQ(reader.lost(), 7u);
}

TEST(SharedBroadcast, NewReaderBeginsWithWhatComesNext) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastWriter<Record> writer{region};
  writer.push(record_of(1));
  SharedBroadcastReader<Record> reader{region};
  EXPECT_TRUE(take(reader).empty());
  writer.push(record_of(2));
  EXPECT_EQ(take(reader), (Taken{2}));
  EXPECT_EQ(reader.lost(), 0u);
}

TEST(SharedBroadcast, LatestIsTheNewestWhetherTakenOrNot) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  Record record;
  EXPECT_FALSE(reader.latest(record));
  for (std::uint64_t i = 0; i < 10; ++i) {
    writer.push(record_of(i));
    ASSERT_TRUE(reader.latest(record));
    EXPECT_EQ(record.number, i);
    EXPECT_TRUE(is_intact(record));
  }
  EXPECT_EQ(take(reader).size(), 4u);
  ASSERT_TRUE(reader.latest(record));
  EXPECT_EQ(record.number, 9u);
}

TEST(SharedBroadcast, NewWriterInTheSameProcessGoesOn) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastReader<Record> reader{region};
  SharedBroadcastWriter<Record>{region}.push(record_of(1));
  SharedBroadcastWriter<Record>{region}.push(record_of(2));
  EXPECT_EQ(take(reader), (Taken{1, 2}));
}

TEST(SharedBroadcast, CountersPassTheirEnd) {
  const SharedRegion region = create(broadcast_of_records(4));
  region.words()[kHeadWord] = ~std::uint64_t{0} - 5;
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  for (std::uint64_t i = 0; i < 5; ++i) {
    writer.push(record_of(3 * i));
    writer.push(record_of(3 * i + 1));
    writer.push(record_of(3 * i + 2));
    ASSERT_EQ(take(reader), (Taken{3 * i, 3 * i + 1, 3 * i + 2}));
  }
  EXPECT_EQ(reader.lost(), 0u);
}

TEST(SharedBroadcast, RecordThatIsBeingOverwrittenIsLostAndNotTorn) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  for (std::uint64_t i = 0; i < 4; ++i) {
    writer.push(record_of(i));
  }
  // The first action of the writer in the next round: half of record 4 is in the slot of record 0.
  region.words()[kRecordsWord] = 0;
  region.words()[kRecordsWord + 1] = 4;
  EXPECT_EQ(take(reader), (Taken{1, 2, 3}));
  EXPECT_EQ(reader.lost(), 1u);
}

TEST(SharedBroadcast, LatestGivesUpAfterAFewAttempts) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  writer.push(record_of(0));
  region.words()[kRecordsWord] = 0;
  Record record;
  EXPECT_FALSE(reader.latest(record));
  // The number of another record, a round before or after, is as wrong as none.
  region.words()[kRecordsWord] = 5;
  EXPECT_FALSE(reader.latest(record));
  writer.push(record_of(1));
  ASSERT_TRUE(reader.latest(record));
  EXPECT_EQ(record.number, 1u);
}

TEST(SharedBroadcast, SlotsDoNotOverlap) {
  const SharedRegion region = create(broadcast_of_records(4));
  SharedBroadcastWriter<Record> writer{region};
  for (std::uint64_t i = 0; i < 4; ++i) {
    writer.push(record_of(100 + i));
  }
  for (std::uint64_t i = 0; i < 4; ++i) {
    EXPECT_EQ(region.words()[kRecordsWord + i * kSlotWords], i + 1);
    EXPECT_EQ(region.words()[kRecordsWord + i * kSlotWords + 1], 100 + i);
  }
}

TEST(SharedBroadcast, ReadersBesideAWriterNeverSeeATornOrOlderRecord) {
  constexpr std::uint64_t kRecords = 100'000;
  const SharedRegion region = create(broadcast_of_records(8));
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  SharedBroadcastReader<Record> onlooker{region};
  std::atomic<bool> finished{false};
  std::uint64_t received = 0;
  std::uint64_t wrong = 0;
  std::thread taking{[&] {
    std::array<Record, 3> batch{};
    std::uint64_t next = 0;
    for (bool last_look = false;; last_look = finished.load()) {
      const std::size_t taken = reader.take(batch);
      for (const Record& record : std::span{batch}.first(taken)) {
        wrong += is_intact(record) && record.number >= next ? 0 : 1;
        next = record.number + 1;
      }
      received += taken;
      if (taken == 0 && last_look) {
        return;
      }
    }
  }};
  std::uint64_t wrong_latest = 0;
  std::thread looking{[&] {
    std::uint64_t newest = 0;
    while (!finished.load()) {
      Record record;
      if (onlooker.latest(record)) {
        wrong_latest += is_intact(record) && record.number >= newest ? 0 : 1;
        newest = record.number;
      }
    }
  }};
  for (std::uint64_t i = 0; i < kRecords; ++i) {
    writer.push(record_of(i));
  }
  finished = true;
  taking.join();
  looking.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(wrong_latest, 0u);
  EXPECT_EQ(received + reader.lost(), kRecords);
}

// The model: all published records, of which the last `capacity` are still available.
RC_GTEST_PROP(SharedBroadcastProperty, GivesWhatIsStillThereAndCountsTheRest, ()) {
  const auto capacity = std::uint64_t{1} << *rc::gen::inRange(0, 6);
  const SharedRegion region = create(broadcast_of_records(capacity));
  SharedBroadcastWriter<Record> writer{region};
  SharedBroadcastReader<Record> reader{region};
  std::uint64_t published = 0;
  std::uint64_t next = 0;
  std::uint64_t lost = 0;
  const auto steps = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 30));
  for (const int step : steps) {
    if (step < 20) {
      writer.push(record_of(published++));
    } else {
      if (published - next > capacity) {
        lost += published - capacity - next;
        next = published - capacity;
      }
      const auto most = static_cast<std::uint64_t>(step - 20);
      const Taken taken = take(reader, most);
      RC_ASSERT(taken.size() == std::min(most, published - next));
      for (const std::uint64_t number : taken) {
        RC_ASSERT(number == next++);
      }
      RC_ASSERT(reader.lost() == lost);
    }
  }
  Record record;
  RC_ASSERT(reader.latest(record) == (published > 0));
  RC_ASSERT(published == 0 || record.number == published - 1);
}

}  // namespace
}  // namespace driveline::rt
