#include "driveline/slaves/mailbox/foe_server.hpp"

#include <gmock/gmock.h>

namespace driveline::slaves {
namespace {

using testing::ElementsAre;
using Bytes = std::vector<unsigned>;

/// A file "F" behind mailboxes with room for four bytes of data. Requests and answers are plain numbers from ETG.1000.6
/// 5.8, independent of the encoder under test.
class FoeRig : private FileStore {
 public:
  static constexpr std::size_t kRoom = 10;
  Bytes ask(const Bytes& request, wire::AlState in = wire::AlState::kPreOp) {
    std::vector<std::byte> data;
    for (const auto value : request) data.push_back(static_cast<std::byte>(value));
    std::vector<std::byte> out(kRoom, std::byte{0xEE});
    const auto length = server.request({data, kRoom, in}, out);
    if (!length) return {0xFFFF, static_cast<unsigned>(length.error())};
    EXPECT_LE(*length, kRoom);
    Bytes answer;
    for (std::size_t i = 0; i < *length; ++i) answer.push_back(std::to_integer<unsigned>(out[i]));
    return answer;
  }

  FoeServer server{*this};
  std::string content = "123456789";
  std::size_t limit = 100;
  int busy_times = 0;
  int written = 0;
  std::uint32_t password = 0;
  wire::AlState asked_in = wire::AlState::kNone;

 private:
  FileAnswer<void> check(const FileRequest& request) {
    password = request.password;
    asked_in = request.state;
    if (request.name == "F") return {};
    return tl::unexpected(FileRefusal{wire::FoeError::kNotFound, "none"});
  }
  FileAnswer<std::vector<std::byte>> read_file(const FileRequest& request) override {
    return check(request).map([this] {
      const auto bytes = std::as_bytes(std::span(content));
      return std::vector<std::byte>(bytes.begin(), bytes.end());
    });
  }
  FileAnswer<std::size_t> open_file(const FileRequest& request) override {
    return check(request).map([this] { return limit; });
  }
  FileAnswer<void> write_file(const FileRequest&, std::span<const std::byte> bytes) override {
    ++written;
    content.clear();
    for (const auto byte : bytes) content += static_cast<char>(byte);
    return {};
  }
  std::optional<wire::FoeBusy> busy() const noexcept override {
    if (busy_times == 0) return std::nullopt;
    return wire::FoeBusy{static_cast<std::uint16_t>(10 - busy_times), 10};
  }
};

const Bytes kRead = {1, 0, 0x78, 0x56, 0x34, 0x12, 'F'};
const Bytes kWrite = {2, 0, 0, 0, 0, 0, 'F'};

TEST(FoeServer, SendsAFileInPackets) {
  FoeRig rig;
  EXPECT_THAT(rig.ask(kRead), ElementsAre(3, 0, 1, 0, 0, 0, '1', '2', '3', '4'));
  EXPECT_EQ(rig.password, 0x12345678U);
  EXPECT_THAT(rig.ask({4, 0, 1, 0, 0, 0}), ElementsAre(3, 0, 2, 0, 0, 0, '5', '6', '7', '8'));
  EXPECT_THAT(rig.ask({4, 0, 2, 0, 0, 0}), ElementsAre(3, 0, 3, 0, 0, 0, '9'));
  EXPECT_THAT(rig.ask({4, 0, 3, 0, 0, 0}), ElementsAre()) << "over";
}

TEST(FoeServer, TakesAFileInPackets) {
  FoeRig rig;
  EXPECT_THAT(rig.ask(kWrite, wire::AlState::kOp), ElementsAre(4, 0, 0, 0, 0, 0));
  EXPECT_EQ(rig.asked_in, wire::AlState::kOp);
  EXPECT_THAT(rig.ask({3, 0, 1, 0, 0, 0, 'a', 'b', 'c', 'd'}), ElementsAre(4, 0, 1, 0, 0, 0));
  EXPECT_EQ(rig.content, "123456789") << "whole or not at all";
  EXPECT_THAT(rig.ask({3, 0, 2, 0, 0, 0}), ElementsAre(4, 0, 2, 0, 0, 0)) << "an empty packet ends it";
  EXPECT_EQ(rig.content, "abcd");
}

TEST(FoeServer, PassesOverTheZeroBehindAName) {
  FoeRig rig;
  EXPECT_THAT(rig.ask({2, 0, 0, 0, 0, 0, 'F', 0}), ElementsAre(4, 0, 0, 0, 0, 0));
}

TEST(FoeServer, IsBusyUntilTheFileIsKeptAndKeepsItOnce) {
  FoeRig rig;
  rig.busy_times = 2;
  EXPECT_THAT(rig.ask(kWrite), ElementsAre(4, 0, 0, 0, 0, 0));
  EXPECT_THAT(rig.ask({3, 0, 1, 0, 0, 0, 'a'}), ElementsAre(6, 0, 8, 0, 10, 0));
  rig.busy_times = 1;
  EXPECT_THAT(rig.ask({3, 0, 1, 0, 0, 0, 'a'}), ElementsAre(6, 0, 9, 0, 10, 0));
  rig.busy_times = 0;
  EXPECT_THAT(rig.ask({3, 0, 1, 0, 0, 0, 'a'}), ElementsAre(4, 0, 1, 0, 0, 0));
  EXPECT_EQ(rig.written, 1);
}

TEST(FoeServer, RefusesWithTheCodesOfTheStandard) {
  FoeRig rig;
  EXPECT_THAT(rig.ask({1, 0, 0, 0, 0, 0, 'G'}), ElementsAre(5, 0, 0x01, 0x80, 0, 0, 'n', 'o', 'n', 'e'));
  EXPECT_THAT(rig.ask({2, 0, 0, 0, 0, 0, 'G'}), ElementsAre(5, 0, 0x01, 0x80, 0, 0, 'n', 'o', 'n', 'e'));
  // An unexpected packet, in each direction.
  EXPECT_THAT(rig.ask(kWrite), ElementsAre(4, 0, 0, 0, 0, 0));
  EXPECT_THAT(rig.ask({3, 0, 2, 0, 0, 0, 'a'}), ElementsAre(5, 0, 0x05, 0x80, 0, 0));
  EXPECT_THAT(rig.ask(kRead), testing::SizeIs(10));
  EXPECT_THAT(rig.ask({4, 0, 1, 0, 1, 0}), ElementsAre(5, 0, 0x05, 0x80, 0, 0)) << "all 32 bits of the number";
  // More than the file may contain; a text is cut to the mailbox.
  rig.limit = 4;
  EXPECT_THAT(rig.ask(kWrite), ElementsAre(4, 0, 0, 0, 0, 0));
  EXPECT_THAT(rig.ask({3, 0, 1, 0, 0, 0, 'a', 'b', 'c', 'd'}), ElementsAre(4, 0, 1, 0, 0, 0));
  EXPECT_THAT(rig.ask({3, 0, 2, 0, 0, 0, 'e'}), ElementsAre(5, 0, 0x03, 0x80, 0, 0, 'a', 't', ' ', 'm'));
  EXPECT_THAT(rig.ask({3, 0, 3, 0, 0, 0}), testing::SizeIs(10)) << "nothing is being written any more";
  EXPECT_EQ(rig.written, 0);
  EXPECT_THAT(rig.ask({7, 0, 0, 0, 0, 0})[2], 0x04U) << "no such operation";
}

TEST(FoeServer, AnErrorOrAStopEndsATransfer) {
  FoeRig rig;
  EXPECT_THAT(rig.ask(kWrite), testing::SizeIs(6));
  EXPECT_THAT(rig.ask({5, 0, 0x00, 0x80, 0, 0}), ElementsAre());
  EXPECT_EQ(rig.ask({3, 0, 1, 0, 0, 0, 'a'})[0], 5U);
  EXPECT_THAT(rig.ask(kWrite), testing::SizeIs(6));
  rig.server.stop();
  EXPECT_EQ(rig.ask({3, 0, 1, 0, 0, 0, 'a'})[0], 5U);
  EXPECT_EQ(rig.content, "123456789");
}

TEST(FoeServer, AHeaderThatIsCutIsAMailboxError) {
  FoeRig rig;
  EXPECT_THAT(rig.ask({1, 0, 0, 0, 0}), ElementsAre(0xFFFF, 6)) << "too short";
}

}  // namespace
}  // namespace driveline::slaves
