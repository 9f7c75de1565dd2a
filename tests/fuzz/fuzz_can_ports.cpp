// What adapters, servers and tunnels send to the ports of a program. Input: a byte that chooses the protocol, then its
// bytes.

#include <cstdlib>
#include <string_view>

#include "driveline/canopen_port/slcan_reader.hpp"
#include "driveline/canopen_port/socketcand_reader.hpp"
#include "driveline/canopen_wire/cannelloni.hpp"
#include "driveline/canopen_wire/cannelloni_tcp.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

using canopen::Frame;
using canopen::FrameKind;

/// A frame that has come is possible on a bus, or an error frame.
void check(const Frame& frame) {
  if (!frame.valid() && frame != Frame{{}, FrameKind::kError, 0, {}}) std::abort();
}

/// Whether `text` gives a frame with identifier 123h last.
template <typename Reader>
bool ends_with_frame(Reader& reader, std::string_view text) {
  auto event = Reader::Event::kNone;
  for (const char c : text) {
    event = reader.take(c);
    if (event == Reader::Event::kFrame) check(reader.frame());
  }
  return event == Reader::Event::kFrame && reader.frame().identifier.value == 0x123;
}

/// Whatever has come, the next line or element is read.
template <typename Reader>
void read_text(std::span<const std::byte> input, std::string_view next) {
  Reader reader;
  for (const std::byte byte : input) {
    if (reader.take(static_cast<char>(byte)) == Reader::Event::kFrame) check(reader.frame());
  }
  if (reader.malformed() > input.size() || !ends_with_frame(reader, next)) std::abort();
}

void read_stream(std::span<const std::byte> input) {
  using Event = canopen::cannelloni::StreamReader::Event;
  canopen::cannelloni::StreamReader reader;
  bool broken = false;
  for (const std::byte byte : input) {
    const Event event = reader.take(byte);
    if (event == Event::kFrame) check(reader.frame());
    if (broken && event != Event::kBroken) std::abort();
    broken = event == Event::kBroken;
  }
}

void read_packet(std::span<const std::byte> input) {
  canopen::cannelloni::Reader reader(input);
  std::size_t count = 0;
  while (const auto frame = reader.next()) {
    check(*frame);
    if (++count > input.size() / 5) std::abort();
  }
}

Bytes seed(unsigned protocol, std::string_view text) {
  Bytes bytes{static_cast<std::byte>(protocol)};
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  switch (std::to_integer<unsigned>(input[0]) % 4) {
    case 0:
      return read_text<canopen::SlcanReader>(rest, "\rt1230\r");
    case 1:
      return read_text<canopen::SocketcandReader>(rest, "< frame 123 1.0 >");
    case 2:
      return read_stream(rest);
    default:
      return read_packet(rest);
  }
}

std::vector<Bytes> seeds() {
  using std::string_view_literals::operator""sv;
  return {seed(0, "\rz\rt10021133\rT1AAAAAAA201F1A05F\r\aF04\rV1013\rr70A4\r"),
          seed(1, "< hi >< ok >< frame 123 23.424242 11 22 >< rtr 123 1.0 4 >< error 20000040 1.0 >< error no bus >"),
          seed(2, "\0\0\x01\x23\x02\x11\x22\xC0\0\x01\0\x02\0\0\x01\x23\x82\0\xAA\xBB"sv),
          seed(3, "\x02\0\0\0\x02\0\0\x01\x23\x02\x11\x22\xC0\0\x01\0\x02"sv)};
}

}  // namespace driveline::fuzz
