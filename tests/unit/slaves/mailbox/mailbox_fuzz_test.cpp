#include <random>

#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

/// Whatever the master writes, the reply is a mailbox message with a correct length and a protocol of the device.
void expect_sound(const Bytes& reply) {
  if (reply.empty()) return;
  ASSERT_GE(reply.size(), 6U);
  ASSERT_EQ(reply.size(), 6 + reply[0] + 256 * reply[1]);
  const unsigned type = reply[5] & 0x0F;
  ASSERT_TRUE(type == 0 || type == 3) << type;
  ASSERT_NE(reply[5] >> 4, 0U);
}

class MailboxFuzz : public testing::TestWithParam<unsigned> {};

TEST_P(MailboxFuzz, RandomMailboxes) {
  std::mt19937 random(GetParam());
  const std::size_t size = std::array{36U, 48U, 64U, 512U}[GetParam() % 4];
  MailboxRig rig(size);
  std::uniform_int_distribution<unsigned> byte(0, 255);
  for (int i = 0; i < 5000; ++i) {
    Bytes mailbox(byte(random) % size);
    for (auto& b : mailbox) b = byte(random);
    if (mailbox.size() > 8 && byte(random) < 200) {  // mostly almost correct CoE
      mailbox[0] = static_cast<unsigned>(mailbox.size() - 6);
      mailbox[1] = 0;
      mailbox[5] = (mailbox[5] & 0x70) | 0x03;
      mailbox[6] = 0;
      mailbox[7] = byte(random) < 200 ? 0x20 : 0x80;
    }
    rig.write(mailbox);
    for (unsigned n = 0; n < byte(random) % 4; ++n) expect_sound(rig.read());
  }
}

TEST_P(MailboxFuzz, RandomSdoConversations) {
  std::mt19937 random(GetParam() + 1000);
  MailboxRig rig(std::array{36U, 48U, 64U, 512U}[GetParam() % 4]);
  const auto pick = [&](auto list) { return *(list.begin() + random() % list.size()); };
  for (int i = 0; i < 5000; ++i) {
    const unsigned command = pick(std::initializer_list<unsigned>{
        0x40, 0x60, 0x70, 0x00, 0x10, 0x01, 0x11, 0x21, 0x20, 0x2F, 0x2B, 0x27, 0x23, 0x22, 0x80, 0x50, 0x31, 0xE0});
    const unsigned index = pick(std::initializer_list<unsigned>{0x2000, 0x2001, 0x2002, 0x2003, 0x2003, 0x2003, 0x2004,
                                                                0x2008, 0x6091, 0x9999});
    Bytes request = {command, index & 0xFF, index >> 8, random() % 4 == 0 ? 1U : 0U};
    const unsigned size = pick(std::initializer_list<unsigned>{0, 1, 3, 4, 20, 99, 100, 101, 0xFFFF});
    request.insert(request.end(), {size & 0xFF, size >> 8, 0, 0});
    request.resize(8 + random() % 20, 'x');
    const Bytes answer = rig.sdo(request);
    if (answer.empty()) {
      ASSERT_EQ(command, 0x80U);
      continue;
    }
    ASSERT_GE(answer.size(), 8U);
    ASSERT_LE(rig.dictionary.text(rig.dictionary.table().find(0x2003, 0)->slot).size(), 100U);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, MailboxFuzz, testing::Range(0U, 8U));

}  // namespace
}  // namespace driveline::slaves
