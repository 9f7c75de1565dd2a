#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "driveline/wire/eoe_frames.hpp"
#include "support/must.hpp"

namespace driveline::wire::test {
namespace {

using Mail = std::vector<std::byte>;

Mail numbered(std::size_t size) {
  Mail frame(size);
  for (std::size_t i = 0; i < size; ++i) frame[i] = static_cast<std::byte>(i * 7 + i / 256);
  return frame;
}

std::vector<Mail> cut(EoeFragmenter& fragmenter, std::span<const std::byte> frame, std::size_t room) {
  EXPECT_TRUE(fragmenter.begin(frame));
  std::vector<Mail> mails;
  Mail mail(room);
  while (const auto length = fragmenter.next(mail))
    mails.emplace_back(mail.begin(), mail.begin() + std::ptrdiff_t(length));
  EXPECT_TRUE(fragmenter.done());
  return mails;
}

std::optional<Mail> take(EoeAssembler& assembler, const Mail& mail) {
  const auto header = EoeHeader::decode(mail);
  const auto frame = assembler.take(*header, std::span<const std::byte>(mail).subspan(EoeHeader::kSize));
  if (!frame) return std::nullopt;
  return Mail(frame->begin(), frame->end());
}

/// A fragment written by hand.
Mail fragment(unsigned number, unsigned blocks, unsigned frame, std::size_t bytes, bool last, bool stamped = false) {
  Mail mail(EoeHeader::kSize + bytes);
  const auto value = number | (blocks << 6) | (frame << 12);
  mail[1] = static_cast<std::byte>((last ? 1 : 0) | (stamped ? 2 : 0));
  mail[2] = static_cast<std::byte>(value & 0xFFU);
  mail[3] = static_cast<std::byte>(value >> 8);
  return mail;
}

TEST(EoeFrames, EveryLengthSurvivesEveryMailbox) {
  for (const std::size_t room : {36U, 42U, 122U, 250U, 506U, 1018U, 1480U}) {
    EoeFragmenter fragmenter;
    EoeAssembler assembler;
    for (std::size_t size = kMinEoeFrame; size <= kMaxEoeFrame; ++size) {
      const auto frame = numbered(size);
      std::optional<Mail> whole;
      for (const auto& mail : cut(fragmenter, frame, room)) {
        ASSERT_FALSE(whole) << "complete before the last fragment";
        whole = take(assembler, mail);
      }
      ASSERT_EQ(whole, frame) << size << " bytes in mailboxes of " << room;
    }
    EXPECT_EQ(assembler.seen().frames, kMaxEoeFrame - kMinEoeFrame + 1);
    EXPECT_EQ(assembler.seen().malformed + assembler.seen().lost + assembler.seen().stray, 0U);
  }
}

/// 1514 bytes in mailboxes of 128: 48 blocks; 96 bytes in every fragment, the last one 74.
TEST(EoeFrames, SizesAndOffsetsAreInBlocksOf32Bytes) {
  EoeFragmenter fragmenter;
  const auto mails = cut(fragmenter, numbered(1514), 122);
  ASSERT_EQ(mails.size(), 16U);
  EXPECT_EQ(mails[0].size(), 4U + 96U);
  EXPECT_EQ(mails[15].size(), 4U + 74U);
  const auto place = [&](std::size_t i) { return EoeFragment::from_value(EoeHeader::decode(mails[i])->value); };
  EXPECT_EQ(place(0), (EoeFragment{0, 48, 1}));
  EXPECT_EQ(place(1), (EoeFragment{1, 3, 1}));
  EXPECT_EQ(place(15), (EoeFragment{15, 45, 1}));
  EXPECT_FALSE(EoeHeader::decode(mails[14])->last_fragment);
  EXPECT_TRUE(EoeHeader::decode(mails[15])->last_fragment);
}

TEST(EoeFrames, FramesAreCountedInFourBits) {
  EoeFragmenter fragmenter;
  const auto frame = numbered(60);
  for (unsigned i = 1; i <= 40; ++i) {
    const auto mails = cut(fragmenter, frame, 122);
    EXPECT_EQ(EoeFragment::from_value(EoeHeader::decode(mails[0])->value).frame, i % 16);
  }
}

TEST(EoeFrames, WhatCannotTravelIsRefused) {
  EoeFragmenter fragmenter;
  EXPECT_FALSE(fragmenter.begin(numbered(kMinEoeFrame - 1)));
  EXPECT_FALSE(fragmenter.begin(numbered(kMaxEoeFrame + 1)));
  EXPECT_TRUE(fragmenter.done());
  const auto frame = numbered(100);
  ASSERT_TRUE(fragmenter.begin(frame));
  Mail mail(EoeHeader::kSize + 31);
  EXPECT_EQ(fragmenter.next(mail), 0U);
  fragmenter.abandon();
  EXPECT_TRUE(fragmenter.done());
}

TEST(EoeFrames, ALostFragmentCostsItsFrameAlone) {
  EoeFragmenter fragmenter;
  EoeAssembler assembler;
  const auto frame = numbered(500);
  auto mails = cut(fragmenter, frame, 122);
  mails.erase(mails.begin() + 2);
  for (const auto& mail : mails) EXPECT_EQ(take(assembler, mail), std::nullopt);
  EXPECT_EQ(assembler.seen().lost, 1U);
  EXPECT_EQ(assembler.seen().stray, 1U);
  std::optional<Mail> whole;
  for (const auto& mail : cut(fragmenter, frame, 122)) whole = take(assembler, mail);
  EXPECT_EQ(whole, frame);
}

TEST(EoeFrames, AFrameThatBeginsEndsTheOneBefore) {
  EoeFragmenter fragmenter;
  EoeAssembler assembler;
  const auto frame = numbered(200);
  auto first = cut(fragmenter, frame, 122);
  EXPECT_EQ(take(assembler, first[0]), std::nullopt);
  std::optional<Mail> whole;
  for (const auto& mail : cut(fragmenter, frame, 122)) whole = take(assembler, mail);
  EXPECT_EQ(whole, frame);
  EXPECT_EQ(assembler.seen().lost, 1U);
}

/// A fragment of each of two frames of a sender was lost, so that the numbers continue without a gap.
TEST(EoeFrames, AFragmentOfAnotherFrameEndsThisOne) {
  EoeAssembler assembler;
  EXPECT_EQ(take(assembler, fragment(0, 3, 1, 32, false)), std::nullopt);
  EXPECT_EQ(take(assembler, fragment(1, 1, 2, 60, true)), std::nullopt);
  EXPECT_EQ(assembler.seen().lost, 1U);
  EXPECT_EQ(assembler.seen().frames, 0U);
}

TEST(EoeFrames, ATimeStampIsNoPartOfTheFrame) {
  EoeAssembler assembler;
  const auto whole = must(take(assembler, fragment(0, 2, 5, 60 + 4, true, true)));
  EXPECT_EQ(whole->size(), 60U);
  EXPECT_EQ(take(assembler, fragment(0, 1, 6, 3, true, true)), std::nullopt);
  EXPECT_EQ(assembler.seen().malformed, 1U);
}

TEST(EoeFrames, ContradictionsAreMalformed) {
  const std::vector<std::vector<Mail>> cases = {
      {fragment(0, 0, 1, 32, false)},                               // no size
      {fragment(0, 63, 1, 32, false)},                              // more than any frame can have
      {fragment(0, 2, 1, 96, true)},                                // longer than announced
      {fragment(0, 3, 1, 64, true)},                                // shorter than announced
      {fragment(0, 3, 1, 40, false)},                               // not in whole blocks
      {fragment(0, 3, 1, 0, false)},                                // empty
      {fragment(0, 4, 1, 64, false), fragment(1, 1, 1, 64, true)},  // overlapping
      {fragment(0, 4, 1, 32, false), fragment(1, 2, 1, 64, true)},  // with a gap
      {fragment(0, 1, 1, kMinEoeFrame - 1, true)},                  // no Ethernet frame
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    EoeAssembler assembler;
    for (const auto& mail : cases[i]) EXPECT_EQ(take(assembler, mail), std::nullopt) << i;
    EXPECT_EQ(assembler.seen().malformed, 1U) << i;
    EXPECT_EQ(assembler.seen().frames, 0U) << i;
    EXPECT_TRUE(take(assembler, fragment(0, 2, 2, 64, true))) << i;
  }
}

TEST(EoeFrames, AnythingMayArrive) {
  std::mt19937 random(11);
  EoeAssembler assembler;
  for (int i = 0; i < 200000; ++i) {
    const auto draw = [&random](unsigned limit) { return static_cast<unsigned>(random() % limit); };
    const auto mail = fragment(draw(4), draw(50), draw(2), draw(200), draw(3) == 0, draw(5) == 0);
    if (const auto whole = take(assembler, mail)) {
      ASSERT_GE(whole->size(), kMinEoeFrame);
      ASSERT_LE(whole->size(), kMaxEoeFrame);
    }
  }
  const auto& seen = assembler.seen();
  EXPECT_EQ(seen.fragments, 200000U);
  EXPECT_GT(seen.frames, 100U);
  EXPECT_GT(seen.lost, 100U);
  EXPECT_GT(seen.malformed, 100U);
}

/// If parameters are missing, some devices write the others without gaps.
TEST(EoeFrames, IpParametersMayBeDense) {
  const std::array<std::byte, 12> dense = {std::byte{6}, std::byte{0},   std::byte{0},   std::byte{0},
                                           std::byte{5}, std::byte{38},  std::byte{168}, std::byte{192},
                                           std::byte{0}, std::byte{255}, std::byte{255}, std::byte{255}};
  ASSERT_FALSE(EoeIpParameters::decode(dense));
  EXPECT_EQ(EoeIpParameters::dense_size(dense), dense.size());
  const auto parameters = must(EoeIpParameters::decode_dense(dense));
  EXPECT_EQ(parameters->ip, (IpV4Address{192, 168, 38, 5}));
  EXPECT_EQ(parameters->subnet_mask, (IpV4Address{255, 255, 255, 0}));
  EXPECT_FALSE(parameters->mac);
  EXPECT_FALSE(EoeIpParameters::decode_dense(std::span(dense).first(11)));
  EXPECT_FALSE(EoeIpParameters::decode_dense(std::span(dense).first(3)));
}

TEST(EoeFrames, EveryResultHasAText) {
  for (const unsigned code : {0x0000U, 0x0001U, 0x0002U, 0x0201U, 0x0202U, 0x0401U}) {
    EXPECT_NE(to_text(static_cast<EoeResult>(code)), "unknown EoE result") << code;
  }
  EXPECT_EQ(to_text(static_cast<EoeResult>(0x0203)), "unknown EoE result");
}

}  // namespace
}  // namespace driveline::wire::test
