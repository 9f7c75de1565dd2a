#include "recorded.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include "mcap_format.hpp"
#include "mcap_ros2.hpp"

namespace driveline::bridge::clients {
namespace {

using mcap::Opcode;

/// A file mapped into memory during the lifetime of this object.
class MappedFile {
 public:
  static Outcome<MappedFile> open(const std::string& name) {
    const int file = ::open(name.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status = {};
    if (file < 0 || ::fstat(file, &status) != 0) {
      const int error = errno;
      if (file >= 0) ::close(file);
      return misused(fmt::format("{}: cannot be read: {}", name, std::strerror(error)));
    }
    const auto size = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0));
    void* const memory = size == 0 ? MAP_FAILED : ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
    ::close(file);
    if (memory == MAP_FAILED) return misused(fmt::format("{}: is not an MCAP file", name));
    return MappedFile(memory, size);
  }
  MappedFile(MappedFile&& other) noexcept
      : memory_(std::exchange(other.memory_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile() {
    if (memory_ != nullptr) ::munmap(memory_, size_);
  }

  [[nodiscard]] Bytes bytes() const noexcept { return {static_cast<const std::uint8_t*>(memory_), size_}; }

 private:
  MappedFile(void* memory, std::size_t size) : memory_(memory), size_(size) {}
  void* memory_;
  std::size_t size_;
};

/// Reads fields from the front of a record; returns nothing once the record was too short.
class Fields {
 public:
  explicit Fields(Bytes bytes) : rest_(bytes) {}

  std::uint64_t number(std::size_t size) {
    std::uint64_t value = 0;
    const auto part = bytes(size);
    for (auto i = part.size(); i-- > 0;) value = value << 8 | part[i];
    return value;
  }
  std::string_view string() {
    const auto part = bytes(number(4));
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }
  Bytes bytes(std::uint64_t size) {
    if (size > rest_.size()) good_ = false;
    const auto part = rest_.first(good_ ? static_cast<std::size_t>(size) : 0);
    rest_ = rest_.subspan(part.size());
    return part;
  }
  [[nodiscard]] Bytes rest() const noexcept { return rest_; }
  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  Bytes rest_;
  bool good_ = true;
};

class RecordingReader {
 public:
  explicit RecordingReader(const std::function<void(const Recorded&)>& take) : take_(take) {}

  /// Reads consecutive records. Failure: a sentence without the name of the file.
  Outcome<void> records(Bytes bytes) {
    while (!ended_) {
      Fields head(bytes);
      const auto opcode = static_cast<Opcode>(head.number(1));
      const auto content = head.bytes(head.number(8));
      if (!head.good()) return {};  // truncated here, or the end
      bytes = head.rest();
      if (auto done = record(opcode, Fields(content)); !done) return done;
    }
    return {};
  }

 private:
  Outcome<void> record(Opcode opcode, Fields fields) {
    if (opcode == Opcode::kSchema) {
      const auto number = fields.number(2);
      fields.string();
      fields.string();
      schemas_[number] = fields.string();
    } else if (opcode == Opcode::kChannel) {
      return channel(fields);
    } else if (opcode == Opcode::kMessage) {
      const auto found = channels_.find(fields.number(2));
      fields.number(4);
      const auto logged = fields.number(8);
      fields.number(8);
      if (fields.good() && found != channels_.end()) {
        take_({found->second, fields.rest(), static_cast<std::int64_t>(logged)});
      }
    } else if (opcode == Opcode::kChunk) {
      fields.bytes(8 + 8 + 8 + 4);  // times, size, checksum
      if (!fields.string().empty()) return failed("is compressed, which is not supported");
      if (std::exchange(in_chunk_, true)) return failed("has a chunk within a chunk");
      auto done = records(fields.bytes(fields.number(8)));
      in_chunk_ = false;
      return done;
    } else if (opcode == Opcode::kDataEnd) {
      ended_ = true;
    }
    return {};
  }

  Outcome<void> channel(Fields& fields) {
    const auto number = fields.number(2);
    const auto schema = fields.number(2);
    const auto* const topic = mcap::find_recorded(fields.string());
    if (topic == nullptr) return {};  // topic of another program
    if (schemas_[schema] != topic->text) {
      return failed(fmt::format("{} was recorded from a line of another version", topic->name));
    }
    channels_[number] = topic;
    return {};
  }

  const std::function<void(const Recorded&)>& take_;
  std::map<std::uint64_t, std::string_view> schemas_;
  std::map<std::uint64_t, const Topic*> channels_;
  bool ended_ = false;
  bool in_chunk_ = false;
};

}  // namespace

Outcome<void> read_recording(const std::string& name, const std::function<void(const Recorded&)>& take) {
  const auto file = MappedFile::open(name);
  if (!file) return tl::unexpected(file.error());
  const auto bytes = file->bytes();
  const auto& magic = mcap::kMagic;
  if (bytes.size() < magic.size() || !std::equal(magic.begin(), magic.end(), bytes.begin())) {
    return misused(fmt::format("{}: is not an MCAP file", name));
  }
  auto read = RecordingReader(take).records(bytes.subspan(magic.size()));
  if (!read) return failed(fmt::format("{}: {}", name, read.error().text));
  return {};
}

}  // namespace driveline::bridge::clients
