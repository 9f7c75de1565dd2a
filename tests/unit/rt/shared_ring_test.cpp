#include "driveline/rt/shared_ring.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "shared_support.hpp"

namespace driveline::rt {
namespace {

using shared_detail::kHeadWord;
using shared_detail::kTailWord;
using test::create;
using test::is_intact;
using test::open;
using test::Record;
using test::record_of;
using test::ring_of_records;

std::vector<std::uint64_t> numbers(SharedRingReader<Record>& reader, std::size_t most = 100) {
  std::vector<Record> records(most);
  records.resize(reader.pop(records));
  std::vector<std::uint64_t> result;
  for (const Record& record : records) {
    EXPECT_TRUE(is_intact(record));
    result.push_back(record.number);
  }
  return result;
}

using Numbers = std::vector<std::uint64_t>;

TEST(SharedRing, GivesBackInOrderThroughTwoMappings) {
  const SharedRegion made = create(ring_of_records(4));
  const SharedRegion opened = open(made.descriptor(), ring_of_records());
  SharedRingReader<Record> reader{made};
  SharedRingWriter<Record> writer{opened};
  for (std::uint64_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(writer.try_push(record_of(i)));
  }
  EXPECT_EQ(numbers(reader, 2), (Numbers{0, 1}));
  EXPECT_EQ(numbers(reader), (Numbers{2}));
  Record untouched{.number = 77};
  EXPECT_FALSE(reader.try_pop(untouched));
  EXPECT_EQ(untouched.number, 77u);
  EXPECT_EQ(reader.pop({}), 0u);
}

TEST(SharedRing, FullRingDropsTheNewestAndCounts) {
  const SharedRegion region = create(ring_of_records(4));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  for (std::uint64_t i = 0; i < 10; ++i) {
    EXPECT_EQ(writer.try_push(record_of(i)), i < 4);
  }
  EXPECT_EQ(writer.dropped(), 6u);
  EXPECT_EQ(numbers(reader, 1), (Numbers{0}));
  EXPECT_TRUE(writer.try_push(record_of(42)));
  EXPECT_EQ(numbers(reader), (Numbers{1, 2, 3, 42}));
  EXPECT_EQ(writer.dropped(), 6u);
  EXPECT_EQ(writer.breaches() + reader.breaches(), 0u);
}

TEST(SharedRing, NewReaderGoesOnWithWhatWasNotGivenBack) {
  const SharedRegion region = create(ring_of_records(8));
  SharedRingWriter<Record> writer{region};
  for (std::uint64_t i = 0; i < 6; ++i) {
    writer.try_push(record_of(i));
  }
  {
    SharedRingReader<Record> first{region};
    EXPECT_EQ(numbers(first, 2), (Numbers{0, 1}));
  }
  SharedRingReader<Record> second{region};
  EXPECT_EQ(numbers(second), (Numbers{2, 3, 4, 5}));
}

TEST(SharedRing, NewWriterGoesOnBehindTheOldOne) {
  const SharedRegion region = create(ring_of_records(8));
  SharedRingReader<Record> reader{region};
  SharedRingWriter<Record>{region}.try_push(record_of(1));
  SharedRingWriter<Record>{region}.try_push(record_of(2));
  EXPECT_EQ(numbers(reader), (Numbers{1, 2}));
}

TEST(SharedRing, CountersPassTheirEnd) {
  const SharedRegion region = create(ring_of_records(4));
  region.words()[kHeadWord] = ~std::uint64_t{0} - 5;
  region.words()[kTailWord] = ~std::uint64_t{0} - 5;
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  std::uint64_t next = 0;
  for (std::uint64_t i = 0; i < 20; ++i) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(writer.try_push(record_of(next++)));
    }
    ASSERT_EQ(numbers(reader), (Numbers{next - 3, next - 2, next - 1}));
  }
  for (std::uint64_t i = 0; i < 6; ++i) {
    EXPECT_EQ(writer.try_push(record_of(i)), i < 4);
  }
  EXPECT_LT(region.words()[kHeadWord], 100u);
  EXPECT_EQ(writer.breaches() + reader.breaches(), 0u);
}

TEST(SharedRing, ReaderGivesUpWhatNoWriterCanHaveWritten) {
  const SharedRegion region = create(ring_of_records(4));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  writer.try_push(record_of(1));
  for (const std::uint64_t nonsense : {std::uint64_t{5}, ~std::uint64_t{0}, std::uint64_t{1} << 63}) {
    const std::uint64_t before = reader.breaches();
    region.words()[kHeadWord] = nonsense;
    EXPECT_TRUE(numbers(reader).empty());
    EXPECT_EQ(reader.breaches(), before + 1);
    // The writer restores its own index; after another read both agree again. That read may return anything.
    writer.try_push(record_of(2));
    std::array<Record, 4> anything{};
    reader.pop(anything);
    writer.try_push(record_of(3));
    EXPECT_EQ(numbers(reader), (Numbers{3}));
  }
}

TEST(SharedRing, WriterTakesNonsenseOfTheReaderForAFullRing) {
  const SharedRegion region = create(ring_of_records(4));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  writer.try_push(record_of(1));
  for (const std::uint64_t nonsense : {std::uint64_t{2}, ~std::uint64_t{0} - 3, std::uint64_t{1} << 63}) {
    const std::uint64_t before = writer.breaches();
    region.words()[kTailWord] = nonsense;
    EXPECT_FALSE(writer.try_push(record_of(2)));
    EXPECT_EQ(writer.breaches(), before + 1);
  }
  EXPECT_EQ(writer.dropped(), 3u);
  // The reader restores its own index.
  EXPECT_EQ(numbers(reader), (Numbers{1}));
  EXPECT_TRUE(writer.try_push(record_of(5)));
  EXPECT_EQ(numbers(reader), (Numbers{5}));
}

TEST(SharedRing, SpoiltIndexOfOnesOwnIsPutBack) {
  const SharedRegion region = create(ring_of_records(4));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  writer.try_push(record_of(1));
  region.words()[kHeadWord] = 1000;
  region.words()[kTailWord] = 2000;
  EXPECT_FALSE(writer.try_push(record_of(2)));
  EXPECT_EQ(region.words()[kHeadWord], 1u);
  EXPECT_EQ(numbers(reader), (Numbers{1}));
  EXPECT_EQ(region.words()[kTailWord], 1u);
  region.words()[kTailWord] = 2000;
  EXPECT_TRUE(numbers(reader).empty());
  EXPECT_EQ(region.words()[kTailWord], 1u);
}

TEST(SharedRing, NewHandlesDoNotBelieveNonsenseEither) {
  const SharedRegion region = create(ring_of_records(4));
  region.words()[kHeadWord] = 1000;
  SharedRingWriter<Record> writer{region};
  EXPECT_EQ(region.words()[kHeadWord], 0u);
  region.words()[kTailWord] = 1000;
  SharedRingReader<Record> reader{region};
  EXPECT_EQ(region.words()[kTailWord], 0u);
  EXPECT_TRUE(writer.try_push(record_of(1)));
  EXPECT_EQ(numbers(reader), (Numbers{1}));
}

TEST(SharedRing, ValueInHandDoesNotChangeWithTheMemory) {
  const SharedRegion region = create(ring_of_records(4));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  writer.try_push(record_of(1));
  Record record;
  ASSERT_TRUE(reader.try_pop(record));
  for (std::size_t i = shared_detail::kRecordsWord; i < region.words().size(); ++i) {
    region.words()[i] = 0xDEAD;
  }
  EXPECT_TRUE(is_intact(record));
}

TEST(SharedRing, RecordsOfAnySizeKeepTheirBytes) {
  const auto check = [](auto example) {
    using T = decltype(example);
    const SharedRegion region = create(shared_ring<T>(1, 1, 3));
    SharedRingWriter<T> writer{region};
    SharedRingReader<T> reader{region};
    for (std::uint8_t round = 0; round < 10; ++round) {
      for (std::uint8_t i = 0; i < 3; ++i) {
        example.fill(static_cast<std::uint8_t>(round * 16 + i));
        ASSERT_TRUE(writer.try_push(example));
      }
      std::array<T, 4> values{};
      ASSERT_EQ(reader.pop(values), 3u);
      for (std::uint8_t i = 0; i < 3; ++i) {
        example.fill(static_cast<std::uint8_t>(round * 16 + i));
        ASSERT_EQ(values[i], example);
      }
    }
  };
  check(std::array<std::uint8_t, 1>{});
  check(std::array<std::uint8_t, 7>{});
  check(std::array<std::uint8_t, 8>{});
  check(std::array<std::uint8_t, 9>{});
  check(std::array<std::uint8_t, 1000>{});
}

TEST(SharedRing, TwoThreadsLoseNothingButWhatIsCounted) {
  constexpr std::uint64_t kRecords = 100'000;
  const SharedRegion region = create(ring_of_records(16));
  SharedRingWriter<Record> writer{region};
  SharedRingReader<Record> reader{region};
  std::atomic<bool> finished{false};
  std::uint64_t received = 0;
  std::uint64_t torn = 0;
  std::uint64_t disordered = 0;
  std::thread consumer{[&] {
    std::array<Record, 7> batch{};
    std::uint64_t next = 0;
    for (bool last_look = false;; last_look = finished.load()) {
      const std::size_t taken = reader.pop(batch);
      for (const Record& record : std::span{batch}.first(taken)) {
        torn += is_intact(record) ? 0 : 1;
        disordered += record.number < next ? 1 : 0;
        next = record.number + 1;
      }
      received += taken;
      if (taken == 0 && last_look) {
        return;
      }
    }
  }};
  for (std::uint64_t i = 0; i < kRecords; ++i) {
    writer.try_push(record_of(i));
  }
  finished = true;
  consumer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(disordered, 0u);
  EXPECT_EQ(received + writer.dropped(), kRecords);
  EXPECT_EQ(writer.breaches() + reader.breaches(), 0u);
}

// The model of a ring is a queue of limited length. Readers and writers are replaced at any time, and the counters
// start at any value.
RC_GTEST_PROP(SharedRingProperty, IsAQueueOfLimitedLength, ()) {
  const auto capacity = std::uint64_t{1} << *rc::gen::inRange(0, 6);
  const auto start = *rc::gen::arbitrary<std::uint64_t>() - *rc::gen::inRange<std::uint64_t>(0, 50);
  const SharedRegion region = create(ring_of_records(capacity));
  region.words()[kHeadWord] = start;
  region.words()[kTailWord] = start;
  auto writer = std::make_unique<SharedRingWriter<Record>>(region);
  auto reader = std::make_unique<SharedRingReader<Record>>(region);
  std::deque<std::uint64_t> model;
  std::uint64_t next = 0;
  std::uint64_t dropped = 0;
  const auto steps = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 20));
  for (const int step : steps) {
    if (step < 10) {
      RC_ASSERT(writer->try_push(record_of(next)) == (model.size() < capacity));
      if (model.size() < capacity) {
        model.push_back(next);
      } else {
        ++dropped;
      }
      RC_ASSERT(writer->dropped() == dropped);
      ++next;
    } else if (step < 18) {
      std::vector<Record> records(static_cast<std::size_t>(step - 10));
      const std::size_t expected = std::min(records.size(), model.size());
      RC_ASSERT(reader->pop(records) == expected);
      for (std::size_t i = 0; i < expected; ++i) {
        RC_ASSERT(is_intact(records[i]));
        RC_ASSERT(records[i].number == model.front());
        model.pop_front();
      }
    } else if (step == 18) {
      writer = std::make_unique<SharedRingWriter<Record>>(region);
      dropped = 0;
    } else {
      reader = std::make_unique<SharedRingReader<Record>>(region);
    }
  }
  RC_ASSERT(writer->breaches() == 0);
  RC_ASSERT(reader->breaches() == 0);
}

}  // namespace
}  // namespace driveline::rt
