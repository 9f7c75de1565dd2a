// Memory of what is on a CAN bus, and a bus with as many nodes as it can have.
#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/canopen_sample.hpp"
#include "support/scripted_node.hpp"

namespace driveline::bus_test {
namespace {

using canopen::Frame;
using slaves::msd::MsdCanDrive;
using namespace std::chrono_literals;

constexpr std::size_t kKibibyte = 1024;
/// Nodes that the transceivers of one segment can drive.
constexpr std::size_t kMostNodes = 110;

std::size_t heap_bytes() {
  const auto heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

/// Heap and size of an object on a bus, its controller included, averaged over many.
template <typename Make>
std::size_t bytes_each(Make make) {
  constexpr std::size_t kMany = 50;
  slaves::can::Bus bus;
  const auto keeps_shared_tables = make(bus, std::uint8_t{1});
  std::vector<decltype(make(bus, std::uint8_t{1}))> many;
  many.reserve(kMany);
  const auto before = heap_bytes();
  for (std::size_t i = 0; i < kMany; ++i) many.push_back(make(bus, static_cast<std::uint8_t>(i + 2)));
  return (heap_bytes() - before) / kMany;
}

/// All objects of the communication profile and some of an application, without one of 2000 bytes.
const slaves::DictionaryTable& node_table() {
  static const slaves::cia301::SampleRows kSample;
  static const auto kRows = [] {
    std::vector<slaves::EntryRow> rows(kSample.rows().begin(), kSample.rows().end());
    std::erase_if(rows, [](const slaves::EntryRow& row) { return row.index == 0x2008; });
    return rows;
  }();
  static const slaves::DictionaryTable kTable({std::span<const slaves::EntryRow>(kRows)}, 0);
  return kTable;
}

/// The rows that CANopen adds to a drive.
const slaves::DictionaryTable& front_end_table() {
  static const auto kRows = [] {
    auto rows = slaves::msd::can_rows(slaves::msd::Variant::kMsd);
    for (auto& row : rows) row.slot = slaves::slot::kOwn;  // those of the drive are not there
    return rows;
  }();
  static const slaves::DictionaryTable kTable({std::span<const slaves::EntryRow>(kRows)}, 0);
  return kTable;
}

/// A device with a dictionary and nothing behind it.
class BareNode : public slaves::cia301::Application {
 public:
  BareNode(std::uint8_t node, const slaves::DictionaryTable& table, bool stores)
      : node_(node), dictionary_(table), device_(dictionary_, *this, {.stores = stores}) {}

  [[nodiscard]] slaves::SdoResult<void> accept(const slaves::EntryRow& /*row*/, std::uint64_t /*raw*/) override {
    return {};
  }
  void written(const slaves::EntryRow& /*row*/) override {}
  [[nodiscard]] bool power_stage_on() const noexcept override { return false; }
  [[nodiscard]] std::uint8_t node_id(slaves::cia301::Reset /*reset*/) override { return node_; }
  [[nodiscard]] slaves::cia301::Device& device() noexcept { return device_; }

 private:
  std::uint8_t node_;
  slaves::ObjectDictionary dictionary_;
  slaves::cia301::Device device_;
};

/// Bytes of a node with this dictionary.
std::size_t node_bytes(const slaves::DictionaryTable& table, bool stores) {
  return bytes_each([&](slaves::can::Bus& bus, std::uint8_t node) {
    auto one = std::make_unique<BareNode>(node, table, stores);
    bus.attach(one->device());
    return one;
  });
}

// What the MSD has on a bus beside its drive, which stores the values.
TEST(CanMemory, ANodeWithoutItsDriveTakesAtMost8KiB) {
  if (heap_bytes() == 0) GTEST_SKIP() << "a sanitizer's heap, which mallinfo2 knows nothing of";
  const auto each = node_bytes(front_end_table(), false);
  RecordProperty("bytes", std::to_string(each));
  EXPECT_LE(each, 8 * kKibibyte);
  EXPECT_GT(each, sizeof(BareNode)) << "this is not what is meant to be counted";
}

// With values and stored values of its own application.
TEST(CanMemory, ADeviceWithAllServicesTakesAtMost10KiB) {
  if (heap_bytes() == 0) GTEST_SKIP() << "a sanitizer's heap, which mallinfo2 knows nothing of";
  const auto each = node_bytes(node_table(), true);
  RecordProperty("bytes", std::to_string(each));
  EXPECT_LE(each, 10 * kKibibyte);
}

TEST(CanMemory, AnMsdOnABusTakesAtMost30KiB) {
  if (heap_bytes() == 0) GTEST_SKIP() << "a sanitizer's heap, which mallinfo2 knows nothing of";
  const auto each = bytes_each([](slaves::can::Bus& bus, std::uint8_t node) {
    auto one = std::make_unique<MsdCanDrive>(slaves::msd::MsdParameters{},
                                             slaves::msd::CanConnection{slaves::msd::DipSwitch{node}, {}, 500us});
    bus.attach(one->device());
    return one;
  });
  RecordProperty("bytes", std::to_string(each));
  EXPECT_LE(each, 30 * kKibibyte);
  EXPECT_GT(each, sizeof(MsdCanDrive)) << "this is not what is meant to be counted";
}

/// Boot-up messages of all at once, in the order of their identifiers; then each is asked, and all are started.
TEST(CanLine, OneHundredAndTenDrivesOnOneBus) {
  slaves::can::Bus bus;
  slaves::can::ScriptedNode master;
  bus.attach(master);
  std::vector<std::unique_ptr<MsdCanDrive>> drives;
  for (std::size_t i = kMostNodes; i > 0; --i) {
    const slaves::msd::DipSwitch address{static_cast<std::uint8_t>(i)};
    drives.push_back(
        std::make_unique<MsdCanDrive>(slaves::msd::MsdParameters{}, slaves::msd::CanConnection{address, {}, 500us}));
    bus.attach(drives.back()->device());
  }
  bus.advance(40ms);
  ASSERT_EQ(master.received.size(), kMostNodes);
  for (std::size_t i = 0; i < kMostNodes; ++i) {
    EXPECT_EQ(master.received[i].frame.identifier.value, 0x701 + i);
  }
  master.received.clear();
  for (std::uint32_t node = 1; node <= kMostNodes; ++node) {
    master.send_at(bus.now(), Frame::of(0x600 + node, bytes_test::hex("40 00 10 00 00 00 00 00")));
    bus.advance(bus.now() + 1ms);
  }
  ASSERT_EQ(master.received.size(), kMostNodes);
  for (const auto& seen : master.received) EXPECT_EQ(seen.frame.length, 8);
  master.send_at(bus.now(), canopen::NmtRequest{canopen::NmtCommand::kStart, 0}.frame());
  bus.advance(bus.now() + 3ms);
  for (const auto& drive : drives) EXPECT_EQ(drive->device().state(), canopen::NmtState::kOperational);
  EXPECT_EQ(bus.statistics().error_frames, 0U);
}

}  // namespace
}  // namespace driveline::bus_test
