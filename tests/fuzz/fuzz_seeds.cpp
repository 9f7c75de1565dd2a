#include "fuzz_seeds.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>

#include "driveline/esi/esi_file.hpp"
#include "driveline/wire/frame.hpp"
#include "pcapng_reader.hpp"

namespace driveline::fuzz {
namespace {

constexpr std::size_t kFramesPerInput = 100;
constexpr std::size_t kMaxInputs = 10;
constexpr std::uint16_t kMailboxOut = 0x1800;  ///< mailbox of the recorded drive
constexpr const char* kCaptures[] = {"soem-sdinfo-akd.pcapng", "twincat-akd-nc-mode.pcapng"};

void append(Bytes& input, std::span<const std::byte> piece) {
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(piece.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), piece.begin(), piece.end());
}

/// The packets of a capture sent by a master: in replies the first slave has set bit 1 of the source address.
std::vector<Bytes> requests(const char* name) {
  std::vector<Bytes> list;
  const auto file = replay::find_capture(name);
  if (!file) return list;
  auto packets = replay::read_pcapng(*file);
  if (!packets) {
    std::fprintf(stderr, "%s: %s\n", name, packets.error().c_str());
    std::abort();
  }
  for (auto& packet : *packets) {
    if (packet.bytes.size() > 6 && (packet.bytes[6] & std::byte{2}) == std::byte{0}) list.push_back(packet.bytes);
  }
  return list;
}

/// The commands and addresses of a frame, without data and index.
std::string shape_of(const Bytes& frame) {
  std::string shape;
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto view = cursor->next();
    if (!view) break;
    const auto& header = view->header;
    shape += std::to_string(static_cast<unsigned>(header.command)) + " " + std::to_string(header.address.adp()) + " " +
             std::to_string(header.address.ado()) + " " + std::to_string(header.length) + ",";
  }
  return shape;
}

}  // namespace

std::string example_devices() {
  std::ifstream stream(DRIVELINE_EXAMPLES_DIR "/terminals.xml", std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

esi::DeviceDescription example_device(const std::string& name) {
  const auto file = esi::read_esi(example_devices(), "terminals.xml");
  if (!file) {
    std::fprintf(stderr, "%s\n", esi::to_text(file.error()).c_str());
    std::abort();
  }
  const auto device = file->choose({name, {}, {}});
  if (!device) {
    std::fprintf(stderr, "%s\n", describe(device.error()).c_str());
    std::abort();
  }
  return **device;
}

std::vector<Bytes> recorded_images() {
  std::vector<Bytes> images;
  for (const char* name : {"akd.hex", "ek1100.hex", "el2004-eeprom-dump.bin"}) {
    const auto file = replay::find_capture(name);
    if (file) images.push_back(replay::read_file(*file).value_or(Bytes{}));
  }
  return images;
}

std::vector<Bytes> recorded_frames() {
  std::vector<Bytes> inputs;
  std::set<std::string> seen;
  std::size_t frames = 0;
  for (const char* name : kCaptures) {
    for (const auto& frame : requests(name)) {
      if (!seen.insert(shape_of(frame)).second) continue;
      if (frames % kFramesPerInput == 0) {
        if (inputs.size() == kMaxInputs) return inputs;
        inputs.emplace_back();
      }
      append(inputs.back(), frame);
      ++frames;
    }
  }
  return inputs;
}

std::vector<Bytes> recorded_mailboxes() {
  std::vector<Bytes> inputs;
  for (const char* name : kCaptures) {
    Bytes input;
    for (const auto& frame : requests(name)) {
      auto cursor = wire::DatagramCursor::open(frame);
      while (cursor && !cursor->done()) {
        const auto view = cursor->next();
        if (!view) break;
        if (view->header.command != wire::Command::kFpwr || view->header.address.ado() != kMailboxOut) continue;
        // The mailbox is padded to its end, which would only dilute the input.
        const std::size_t used = view->data.size() < 2 ? 0 : 6U + bytes::load_le<std::uint16_t>(view->data);
        append(input, view->data.first(std::min(used, view->data.size())));
      }
    }
    if (!input.empty()) inputs.push_back(std::move(input));
  }
  return inputs;
}

}  // namespace driveline::fuzz
