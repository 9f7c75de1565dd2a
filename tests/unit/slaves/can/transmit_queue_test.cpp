#include "driveline/slaves/can/transmit_queue.hpp"

#include <gtest/gtest.h>

#include "support/bytes.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;

// C4: by priority; equal ones in the order in which they came.
TEST(TransmitQueue, C4IsInTheOrderOfArbitration) {
  TransmitQueue queue(8);
  ASSERT_TRUE(queue.push(Frame::of(0x583, hex("01"))));
  ASSERT_TRUE(queue.push(Frame::of(0x185, hex("02"))));
  ASSERT_TRUE(queue.push(Frame::of(0x185, hex("03"))));
  ASSERT_TRUE(queue.push(Frame::of(0x080, hex("04"))));
  std::vector<Frame> order;
  for (; queue.front() != nullptr; queue.pop()) order.push_back(*queue.front());
  EXPECT_EQ(order, (std::vector{Frame::of(0x080, hex("04")), Frame::of(0x185, hex("02")), Frame::of(0x185, hex("03")),
                                Frame::of(0x583, hex("01"))}));
}

TEST(TransmitQueue, WhatFindsNoRoomIsDroppedAndCounted) {
  TransmitQueue queue(2);
  EXPECT_TRUE(queue.push(Frame::of(0x100, {})));
  EXPECT_TRUE(queue.push(Frame::of(0x101, {})));
  EXPECT_FALSE(queue.push(Frame::of(0x001, {})));
  EXPECT_EQ(queue.size(), 2U);
  EXPECT_EQ(queue.dropped(), 1U);
  EXPECT_FALSE(queue.push({{0x800, false}, canopen::FrameKind::kData, 0, {}}));
  EXPECT_EQ(queue.dropped(), 2U);
}

TEST(TransmitQueue, APutBackFrameIsBeforeEqualOnesAndBehindBetterOnes) {
  TransmitQueue queue(3);
  ASSERT_TRUE(queue.push(Frame::of(0x185, hex("01"))));
  const Frame taken = *queue.front();
  queue.pop();
  ASSERT_TRUE(queue.push(Frame::of(0x185, hex("02"))));
  ASSERT_TRUE(queue.push(Frame::of(0x080, {})));
  ASSERT_TRUE(queue.push(Frame::of(0x586, {})));
  queue.put_back(taken);  // has room even now
  EXPECT_EQ(queue.front()->identifier.value, 0x080U);
  queue.pop();
  EXPECT_EQ(*queue.front(), taken);
}

}  // namespace
}  // namespace driveline::slaves::can
