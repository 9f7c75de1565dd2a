#include "driveline/rt/shared_region.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "shared_support.hpp"
#include "support/must.hpp"

namespace driveline::rt {
namespace {

using test::broadcast_of_records;
using test::create;
using test::open;
using test::Peer;
using test::Record;
using test::ring_of_records;
using testing::HasSubstr;

constexpr int kAllSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

/// A descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_{number} {}
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number_; }  // NOLINT(google-explicit-constructor): stands for the number

 private:
  int number_;
};

/// A copy of the memory of `region` with word `at` changed to `value`, with `bytes` in all (0: same size) and `seals`.
int forged(const SharedRegion& region, std::size_t at, std::uint64_t value, std::size_t bytes = 0,
           int seals = kAllSeals) {
  const int descriptor = ::memfd_create("forged", MFD_ALLOW_SEALING);
  std::vector<std::uint64_t> words{region.words().begin(), region.words().end()};
  words.at(at) = value;
  EXPECT_EQ(::write(descriptor, words.data(), words.size() * 8), static_cast<ssize_t>(words.size() * 8));
  if (bytes != 0) {
    EXPECT_EQ(::ftruncate(descriptor, static_cast<off_t>(bytes)), 0);
  }
  EXPECT_EQ(::fcntl(descriptor, F_ADD_SEALS, seals), 0);
  return descriptor;
}

/// The error that opening `descriptor` must return.
template <typename Fact>
Fact refusal(int descriptor, const SharedLayout& wanted, const std::string& sentence) {
  const auto region = SharedRegion::open(descriptor, wanted);
  if (region) {
    throw std::runtime_error("the region was opened");
  }
  EXPECT_EQ(describe(region.error()), "shared region: " + sentence);
  return std::get<Fact>(region.error());
}

TEST(SharedRegionTest, IsOpenedAsItWasMade) {
  const SharedRegion made = create(ring_of_records(100));
  EXPECT_EQ(made.layout().capacity, 128u);
  const SharedRegion opened = open(made.descriptor(), ring_of_records());
  EXPECT_EQ(opened.layout(), made.layout());
  EXPECT_EQ(opened.descriptor(), -1);
  EXPECT_NE(opened.words().data(), made.words().data());
  EXPECT_EQ(opened.words().size(), made.words().size());
  EXPECT_TRUE(SharedRegion::open(made.descriptor(), ring_of_records(128)));
}

TEST(SharedRegionTest, DescriptorDoesNotOutliveExec) {
  const SharedRegion made = create(ring_of_records(4));
  EXPECT_EQ(::fcntl(made.descriptor(), F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
}

TEST(SharedRegionTest, OutlivesTheDescriptorAndTheMaker) {
  auto made = std::make_unique<SharedRegion>(create(ring_of_records(4)));
  SharedRingWriter<Record> writer{*made};
  ASSERT_TRUE(writer.try_push(test::record_of(7)));
  const SharedRegion opened = open(made->descriptor(), ring_of_records());
  const int descriptor = made->descriptor();
  made.reset();
  EXPECT_EQ(::fcntl(descriptor, F_GETFD), -1);
  Record record;
  EXPECT_TRUE(SharedRingReader<Record>{opened}.try_pop(record));
  EXPECT_EQ(record.number, 7u);
}

TEST(SharedRegionTest, MovesWithoutMovingTheMemory) {
  SharedRegion first = create(ring_of_records(4));
  const int descriptor = first.descriptor();
  const auto words = first.words();
  SharedRegion second = create(ring_of_records(8));
  second = std::move(first);
  EXPECT_EQ(second.descriptor(), descriptor);
  EXPECT_EQ(second.words().data(), words.data());
  EXPECT_EQ(second.layout().capacity, 4u);
  const SharedRegion third{std::move(second)};
  EXPECT_EQ(third.words().data(), words.data());
  EXPECT_EQ(third.words()[0], kSharedMagic);
}

TEST(SharedRegionTest, NoPageOfItIsMissingWhenItIsThere) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pagemap{std::fopen("/proc/self/pagemap", "rb"), std::fclose};
  if (!pagemap) {
    GTEST_SKIP() << "no /proc/self/pagemap";
  }
  const SharedRegion ring = create(ring_of_records(1000));
  const SharedRegion opened_ring = open(ring.descriptor(), ring_of_records());
  const SharedRegion broadcast = create(broadcast_of_records(1000));
  const SharedRegion opened_broadcast = open(broadcast.descriptor(), broadcast_of_records());
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  for (const SharedRegion* region : {&ring, &opened_ring, &broadcast, &opened_broadcast}) {
    ASSERT_GT(region->words().size_bytes(), 30 * page);
    const auto first = reinterpret_cast<std::uintptr_t>(region->words().data()) / page;
    for (std::uint64_t i = 0; i < region->words().size_bytes() / page; ++i) {
      std::uint64_t entry = 0;
      ASSERT_EQ(std::fseek(pagemap.get(), static_cast<long>((first + i) * sizeof(entry)), SEEK_SET), 0);
      ASSERT_EQ(std::fread(&entry, sizeof(entry), 1, pagemap.get()), 1u);
      EXPECT_EQ(entry >> 63, 1u) << "page " << i;  // present
    }
  }
}

TEST(SharedRegionTest, NobodyCanChangeItsSize) {
  const SharedRegion made = create(ring_of_records(64));
  const auto bytes = static_cast<off_t>(made.words().size_bytes());
  Peer peer{[&] {
    const Descriptor again{::open(("/proc/self/fd/" + std::to_string(made.descriptor())).c_str(), O_RDWR)};
    const auto is_refused = [](int result) { return result == -1 && errno == EPERM; };
    if (!is_refused(::ftruncate(again, 0))) return 1;
    if (!is_refused(::ftruncate(again, bytes - 4096))) return 2;
    if (!is_refused(::ftruncate(again, bytes + 4096))) return 3;
    if (!is_refused(::fallocate(again, 0, bytes, 4096))) return 4;
    if (!is_refused(::fcntl(again, F_ADD_SEALS, F_SEAL_WRITE))) return 5;
    return 0;
  }};
  EXPECT_EQ(peer.wait_for_end(), 0);
}

TEST(SharedRegionTest, NobodyElseCanWriteIntoABroadcast) {
  const SharedRegion made = create(broadcast_of_records(64));
  Peer peer{[&] {
    const Descriptor again{::open(("/proc/self/fd/" + std::to_string(made.descriptor())).c_str(), O_RDWR)};
    if (again < 0) return 1;
    if (::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, again, 0) != MAP_FAILED || errno != EPERM) return 2;
    if (::pwrite(again, "x", 1, 0) != -1 || errno != EPERM) return 3;
    if (::fallocate(again, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096) != -1 || errno != EPERM) return 4;
    const SharedRegion opened = open(again, broadcast_of_records());
    if (::mprotect(opened.words().data(), 4096, PROT_READ | PROT_WRITE) != -1 || errno != EACCES) return 5;
    return 0;
  }};
  EXPECT_EQ(peer.wait_for_end(), 0);
}

/// Whether all pages of the region are allocated and mapped in this process.
bool is_resident(const SharedRegion& region) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pagemap{std::fopen("/proc/self/pagemap", "rb"), std::fclose};
  const auto first = reinterpret_cast<std::uintptr_t>(region.words().data()) / page;
  std::vector<std::uint64_t> entries(region.words().size_bytes() / page);
  if (std::fseek(pagemap.get(), static_cast<long>(first * sizeof(std::uint64_t)), SEEK_SET) != 0) return false;
  if (std::fread(entries.data(), sizeof(std::uint64_t), entries.size(), pagemap.get()) != entries.size()) return false;
  return std::all_of(entries.begin(), entries.end(), [](std::uint64_t entry) { return entry >> 63 == 1; });
}

TEST(SharedRegionTest, AWriterCannotReturnPagesOnceItIsClosed) {
  auto created = must(SharedRegion::create("driveline-test", ring_of_records(1000), SharedSealing::kSizeOnly));
  auto& made = *created;
  const auto bytes = static_cast<off_t>(made.words().size_bytes());
  EXPECT_FALSE(SharedRegion::open(made.descriptor(), ring_of_records())) << "nobody takes it for complete";
  auto opened = SharedMapping::open(made.descriptor(), ring_of_records(), SharedSealing::kSizeOnly);
  ASSERT_TRUE(std::holds_alternative<SharedMapping>(opened));
  auto& peer = std::get<SharedMapping>(opened);
  const auto punch = [&] {
    return ::fallocate(made.descriptor(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, bytes);
  };
  ASSERT_EQ(punch(), 0);
  EXPECT_FALSE(is_resident(made));
  ASSERT_EQ(failure_text(made.close_to_writers()), "");
  EXPECT_TRUE(is_resident(made)) << "the pages are back before the cycle accesses them";
  EXPECT_EQ(punch(), -1);
  EXPECT_EQ(errno, EPERM);
  EXPECT_EQ(::madvise(peer.words().data(), peer.words().size_bytes(), MADV_REMOVE), -1);
  EXPECT_EQ(errno, EPERM);
  EXPECT_TRUE(is_resident(made));
  SharedRingWriter<Record> writer{peer};
  SharedRingReader<Record> reader{made};
  Record record;
  EXPECT_TRUE(writer.try_push(test::record_of(7)));
  EXPECT_TRUE(reader.try_pop(record) && record.number == 7) << "its mapping still writes";
}

TEST(SharedRegionTest, APeerThatSealsTheRegionItselfIsNoticed) {
  auto made = must(SharedRegion::create("driveline-test", ring_of_records(4), SharedSealing::kSizeOnly));
  ASSERT_EQ(::fcntl(made->descriptor(), F_ADD_SEALS, F_SEAL_SEAL), 0);
  EXPECT_EQ(failure_text(made->close_to_writers()), "shared region: fcntl(F_ADD_SEALS): Operation not permitted");
}

TEST(SharedRegionTest, RefusesWhatIsNoSharedMemory) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::tmpfile(), std::fclose};
  refusal<SharedNotMemory>(::fileno(file.get()), ring_of_records(),
                           "the descriptor is not one of shared memory (memfd)");
  const auto error = refusal<SharedCallFailed>(-1, ring_of_records(), "fcntl(F_GET_SEALS): Bad file descriptor");
  EXPECT_EQ(error.error_number, EBADF);
}

TEST(SharedRegionTest, RefusesWhatIsNotSealed) {
  const SharedRegion made = create(ring_of_records(4));
  const Descriptor open_ended{forged(made, 0, kSharedMagic, 0, 0)};
  const auto error =
      refusal<SharedNotSealed>(open_ended, ring_of_records(), "not sealed against further seals, shrinking, growing");
  EXPECT_EQ(error.required, static_cast<unsigned>(kAllSeals));
  EXPECT_EQ(error.present, 0u);
  for (const int seal : {F_SEAL_SHRINK, F_SEAL_GROW, F_SEAL_SEAL}) {
    const Descriptor partly{forged(made, 0, kSharedMagic, 0, kAllSeals & ~seal)};
    const auto region = SharedRegion::open(partly, ring_of_records());
    ASSERT_FALSE(region);
    EXPECT_EQ(std::get<SharedNotSealed>(region.error()).present, static_cast<unsigned>(kAllSeals & ~seal));
  }
}

TEST(SharedRegionTest, RefusesABroadcastThatReadersCanWriteTo) {
  const SharedRegion made = create(broadcast_of_records(4));
  const Descriptor copy{forged(made, 0, kSharedMagic)};
  refusal<SharedNotSealed>(copy, broadcast_of_records(), "not sealed against further writing by others");
}

TEST(SharedRegionTest, RefusesAnotherMagic) {
  const SharedRegion made = create(ring_of_records(4));
  const Descriptor copy{forged(made, 0, 0xABCDEF)};
  const auto error = refusal<SharedWrongMagic>(
      copy, ring_of_records(), "begins with 0xABCDEF and not as a region of driveline (0x6D68736E6C767264)");
  EXPECT_EQ(error.found, 0xABCDEFu);
}

TEST(SharedRegionTest, RefusesAnotherVersionOfTheLayout) {
  const SharedRegion made = create(ring_of_records(4));
  const Descriptor copy{forged(made, 1, made.words()[1] + 6)};
  const auto error = refusal<SharedWrongVersion>(copy, ring_of_records(), "laid out in version 7 instead of 1");
  EXPECT_EQ(error.found, kSharedLayoutVersion + 6);
}

TEST(SharedRegionTest, RefusesAnotherSizeThanTheHeaderTells) {
  const SharedRegion made = create(ring_of_records(64));
  const auto bytes = made.words().size_bytes();
  for (const auto found : {bytes - 4096, bytes + 4096}) {
    const Descriptor copy{forged(made, 0, kSharedMagic, found)};
    const auto error = refusal<SharedWrongSize>(
        copy, ring_of_records(),
        "size of " + std::to_string(found) + " instead of " + std::to_string(bytes) + " bytes");
    EXPECT_EQ(error.expected_bytes, bytes);
    EXPECT_EQ(error.found_bytes, found);
  }
  const Descriptor stump{forged(made, 0, kSharedMagic, 383)};
  refusal<SharedWrongSize>(stump, ring_of_records(), "size of 383 instead of 384 bytes");
  const Descriptor empty{::memfd_create("empty", MFD_ALLOW_SEALING)};
  ASSERT_EQ(::fcntl(empty, F_ADD_SEALS, kAllSeals), 0);
  refusal<SharedWrongSize>(empty, ring_of_records(), "size of 0 instead of 384 bytes");
}

TEST(SharedRegionTest, RefusesACapacityThatCannotBe) {
  const SharedRegion made = create(ring_of_records(64));
  for (const std::uint64_t capacity :
       {std::uint64_t{0}, std::uint64_t{63}, ~std::uint64_t{0}, std::uint64_t{1} << 63}) {
    const Descriptor copy{forged(made, 4, capacity)};
    const auto error = refusal<SharedBadCapacity>(copy, ring_of_records(),
                                                  "cannot hold " + std::to_string(capacity) + " records of 128 bytes");
    EXPECT_EQ(error.capacity, capacity);
  }
  // A power of two, but larger than the region.
  const Descriptor larger{forged(made, 4, 128)};
  const auto region = SharedRegion::open(larger, ring_of_records());
  ASSERT_FALSE(region);
  EXPECT_EQ(std::get<SharedWrongSize>(region.error()).found_bytes, made.words().size_bytes());
}

TEST(SharedRegionTest, RefusesOtherContentAndSaysWhichPartOfIt) {
  const SharedRegion made = create(ring_of_records(64));
  SharedLayout wanted = ring_of_records();
  wanted.content = 0xABC;
  const auto error = refusal<SharedOtherContent>(made.descriptor(), wanted, "content 0xC0FFEE instead of 0xABC");
  EXPECT_EQ(error.found, made.layout());
  EXPECT_EQ(error.expected.content, 0xABCu);
  wanted = ring_of_records();
  wanted.content_version = 4;
  refusal<SharedOtherContent>(made.descriptor(), wanted, "version of the content 3 instead of 4");
  wanted = ring_of_records();
  wanted.record_bytes = 136;
  refusal<SharedOtherContent>(made.descriptor(), wanted, "bytes of a record 128 instead of 136");
  refusal<SharedOtherContent>(made.descriptor(), ring_of_records(32), "capacity 64 instead of 32");
  const SharedRegion broadcast = create(broadcast_of_records(64));
  const Descriptor copy{forged(broadcast, 0, kSharedMagic)};
  refusal<SharedOtherContent>(copy, ring_of_records(), "form broadcast instead of ring");
  const Descriptor neither{forged(broadcast, 1, std::uint64_t{9} << 32 | 1)};
  refusal<SharedOtherContent>(neither, ring_of_records(), "form 0x9 instead of ring");
}

TEST(SharedRegionTest, IsNotMadeWithoutRoomOrTooLarge) {
  const auto refused = [](SharedLayout layout) {
    const auto region = SharedRegion::create("driveline-test", layout);
    return region ? "made" : describe(region.error());
  };
  EXPECT_EQ(refused(ring_of_records(0)), "shared region: cannot hold 0 records of 128 bytes");
  EXPECT_EQ(refused(ring_of_records(kMaxSharedBytes / 64)), "shared region: cannot hold 16777216 records of 128 bytes");
  EXPECT_EQ(refused(ring_of_records(~std::uint64_t{0})),
            "shared region: cannot hold 18446744073709551615 records of 128 bytes");
  EXPECT_EQ(refused({.record_bytes = 0, .capacity = 1}), "shared region: cannot hold 1 records of 0 bytes");
  EXPECT_THAT(refused({.record_bytes = ~std::uint32_t{0}, .capacity = 4}), HasSubstr("cannot hold 4 records"));
}

TEST(SharedRegionTest, NameThatTheSystemRefusesIsAnError) {
  const auto region = SharedRegion::create(std::string(300, 'x'), ring_of_records(4));
  ASSERT_FALSE(region);
  EXPECT_EQ(describe(region.error()), "shared region: memfd_create: Invalid argument");
}

TEST(SharedRegionTest, HandlesOfAnotherFormOrSizeAreRefused) {
  const SharedRegion ring = create(ring_of_records(4));
  const SharedRegion broadcast = create(broadcast_of_records(4));
  EXPECT_THROW(SharedBroadcastReader<Record>{ring}, std::invalid_argument);
  EXPECT_THROW(SharedRingReader<Record>{broadcast}, std::invalid_argument);
  EXPECT_THROW(SharedRingWriter<std::uint64_t>{ring}, std::invalid_argument);
  EXPECT_THROW(SharedBroadcastWriter<std::uint64_t>{broadcast}, std::invalid_argument);
  const SharedRegion opened = open(broadcast.descriptor(), broadcast_of_records());
  EXPECT_THROW(SharedBroadcastWriter<Record>{opened}, std::invalid_argument);
}

}  // namespace
}  // namespace driveline::rt
