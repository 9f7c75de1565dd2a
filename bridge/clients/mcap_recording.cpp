#include <algorithm>
#include <limits>
#include <map>

#include "mcap_format.hpp"
#include "mcap_ros2.hpp"
#include "recording.hpp"
#include "recording_file.hpp"

namespace driveline::bridge::clients {
namespace mcap {

namespace {

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    auto value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xEDB8'8320U : 0U);
    table[i] = value;
  }
  return table;
}

}  // namespace

void Crc::add(std::span<const std::uint8_t> bytes) noexcept {
  static constexpr auto kTable = make_crc_table();
  for (const auto byte : bytes) state_ = kTable[(state_ ^ byte) & 0xFF] ^ (state_ >> 8);
}

}  // namespace mcap

namespace {

using mcap::Opcode;
using mcap::Writer;

constexpr std::size_t kChunkSize = 1U << 18;  // approximate number of bytes of records per chunk
constexpr std::string_view kLibrary = "driveline";
constexpr std::uint64_t kChunkIndexSize = 73;         // size of the record without the message indices
constexpr std::uint64_t kMessageIndexEntrySize = 10;  // size per message index in the chunk index

using Times = std::pair<std::uint64_t, std::uint64_t>;  // log time of a message, and offset in its chunk

/// Summary of a chunk.
struct ChunkEntry {
  std::uint64_t first_ns;
  std::uint64_t last_ns;
  std::uint64_t at;
  std::uint64_t length;
  std::uint64_t size;                              ///< size of its records
  std::map<std::uint16_t, std::uint64_t> indices;  ///< file offset of the message index per channel
  std::uint64_t indices_length;
};

class McapRecording final : public Recording {
 public:
  McapRecording(RecordingFile file, std::vector<const Topic*> chosen)
      : file_(std::move(file)), topics_(std::move(chosen)), written_(topics_.size()), waiting_(topics_.size()) {}

  Outcome<void> begin() {
    Writer head;
    head.bytes(mcap::kMagic);
    const auto header = head.begin(Opcode::kHeader);
    head.string(mcap::kRos2Profile);
    head.string(kLibrary);
    head.end(header);
    add_schemas(head);
    add_channels(head);
    add_metadata(head);
    constexpr std::uint64_t kOffsetOfChunkIndices = 26;  // size in the summary, once there are any
    end_size_ = end_of_file().size() + kOffsetOfChunkIndices;
    return add_piece(head);
  }

  Outcome<void> take_place() override { return file_.take_place(); }

  Outcome<void> add(const Sample& sample) override {
    const auto found = std::find(topics_.begin(), topics_.end(), sample.topic);
    const auto number = static_cast<std::size_t>(found - topics_.begin());
    const auto logged = static_cast<std::uint64_t>(sample.received_ns);
    const auto channel = id_of(number);
    indices_[channel].emplace_back(logged, chunk_.size());
    const auto message = chunk_.begin(Opcode::kMessage);
    chunk_.number(channel);
    chunk_.number(static_cast<std::uint32_t>(written_[number] + waiting_[number]));
    chunk_.number(logged);
    chunk_.number(static_cast<std::uint64_t>(sample.published_ns));
    chunk_.bytes(sample.bytes);
    chunk_.end(message);
    ++waiting_[number];
    chunk_first_ns_ = std::min(chunk_first_ns_, logged);
    chunk_last_ns_ = std::max(chunk_last_ns_, logged);
    return chunk_.size() < kChunkSize ? Outcome<void>{} : flush();
  }

  Outcome<void> flush() override {
    if (chunk_.size() == 0) return {};
    Writer piece;
    auto entry = add_chunk(piece);
    // The entry of this chunk lengthens the summary.
    const std::uint64_t longer = kChunkIndexSize + kMessageIndexEntrySize * entry.indices.size();
    end_size_ += longer;
    chunks_.push_back(std::move(entry));
    if (auto done = add_piece(piece); !done) {
      chunks_.pop_back();
      end_size_ -= longer;
      return done;
    }
    for (std::size_t i = 0; i < topics_.size(); ++i) written_[i] += std::exchange(waiting_[i], 0);
    first_ns_ = std::min(first_ns_, chunk_first_ns_);
    last_ns_ = std::max(last_ns_, chunk_last_ns_);
    begin_chunk();
    return {};
  }

  Outcome<void> finish() override {
    auto flushed = flush();
    auto done = file_.finish(end_of_file());
    return flushed ? done : flushed;
  }

  void remove() noexcept override { file_.remove(); }
  const std::vector<std::uint64_t>& written() const noexcept override { return written_; }
  std::uint64_t size() const noexcept override { return file_.size(); }

 private:
  // 0 means no schema
  static std::uint16_t id_of(std::size_t number) { return static_cast<std::uint16_t>(number + 1); }

  void begin_chunk() {
    chunk_.clear();
    indices_.clear();
    chunk_first_ns_ = std::numeric_limits<std::uint64_t>::max();
    chunk_last_ns_ = 0;
  }

  /// Appends a piece and reserves space for the summary after it. The size of the summary is tracked, because building
  /// the summary for every chunk would take longer with each chunk.
  Outcome<void> add_piece(const Writer& piece) {
    if (auto done = file_.add(piece.content(), end_size_); !done) return done;
    data_crc_.add(piece.content());
    return {};
  }

  void add_schemas(Writer& to) const {
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      const auto schema = to.begin(Opcode::kSchema);
      to.number(id_of(i));
      to.string(topics_[i]->schema);
      to.string("ros2msg");
      to.string(topics_[i]->text);
      to.end(schema);
    }
  }

  void add_channels(Writer& to) const {
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      const auto channel = to.begin(Opcode::kChannel);
      to.number(id_of(i));
      to.number(id_of(i));
      to.string(mcap::recorded_name(*topics_[i]));
      to.string("cdr");
      add_entry(to, mcap::kOfferedQosKey, mcap::offered_qos_profiles(*topics_[i]));
      to.end(channel);
    }
  }

  /// Writes a map with one entry, preceded by its length.
  static void add_entry(Writer& to, std::string_view key, std::string_view value) {
    constexpr std::size_t kLengths = 2 * sizeof(std::uint32_t);
    to.number(static_cast<std::uint32_t>(kLengths + key.size() + value.size()));
    to.string(key);
    to.string(value);
  }

  /// The record by which players of ROS 2 know how to read the metadata of the channels. `to` is the start of the file.
  void add_metadata(Writer& to) {
    metadata_at_ = to.size();
    const auto metadata = to.begin(Opcode::kMetadata);
    to.string(mcap::kRos2Metadata);
    add_entry(to, mcap::kRos2DistroKey, mcap::kRos2Distro);
    to.end(metadata);
    metadata_length_ = to.size() - metadata_at_;
  }

  void add_metadata_index(Writer& to) const {
    const auto index = to.begin(Opcode::kMetadataIndex);
    to.number(std::uint64_t{metadata_at_});
    to.number(std::uint64_t{metadata_length_});
    to.string(mcap::kRos2Metadata);
    to.end(index);
  }

  /// Writes the chunk and its message indices.
  ChunkEntry add_chunk(Writer& to) const {
    ChunkEntry entry{chunk_first_ns_, chunk_last_ns_, file_.size(), 0, chunk_.size(), {}, 0};
    mcap::Crc crc;
    crc.add(chunk_.content());
    const auto chunk = to.begin(Opcode::kChunk);
    to.number(entry.first_ns);
    to.number(entry.last_ns);
    to.number(entry.size);
    to.number(crc.value());
    to.string("");  // not compressed
    to.number(entry.size);
    to.bytes(chunk_.content());
    to.end(chunk);
    entry.length = to.size();
    for (const auto& [channel, times] : indices_) {
      entry.indices[channel] = entry.at + to.size();
      const auto index = to.begin(Opcode::kMessageIndex);
      to.number(channel);
      to.number(static_cast<std::uint32_t>(times.size() * 16));
      for (const auto& [time, offset] : times) {
        to.number(time);
        to.number(offset);
      }
      to.end(index);
    }
    entry.indices_length = to.size() - entry.length;
    return entry;
  }

  void add_chunk_index(Writer& to, const ChunkEntry& entry) const {
    const auto index = to.begin(Opcode::kChunkIndex);
    to.number(entry.first_ns);
    to.number(entry.last_ns);
    to.number(entry.at);
    to.number(entry.length);
    to.number(static_cast<std::uint32_t>(entry.indices.size() * 10));
    for (const auto& [channel, at] : entry.indices) {
      to.number(channel);
      to.number(at);
    }
    to.number(entry.indices_length);
    to.string("");
    to.number(entry.size);
    to.number(entry.size);
    to.end(index);
  }

  void add_statistics(Writer& to) const {
    std::uint64_t messages = 0;
    for (const auto count : written_) messages += count;
    const auto statistics = to.begin(Opcode::kStatistics);
    to.number(messages);
    to.number(static_cast<std::uint16_t>(topics_.size()));
    to.number(static_cast<std::uint32_t>(topics_.size()));
    to.number(std::uint32_t{0});  // attachments
    to.number(std::uint32_t{1});  // metadata
    to.number(static_cast<std::uint32_t>(chunks_.size()));
    to.number(messages == 0 ? 0 : first_ns_);
    to.number(last_ns_);
    to.number(static_cast<std::uint32_t>(topics_.size() * 10));
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      to.number(id_of(i));
      to.number(written_[i]);
    }
    to.end(statistics);
  }

  /// Everything after the last chunk: end of the data, summary, footer.
  std::vector<std::uint8_t> end_of_file() const {
    Writer end;
    const auto data_end = end.begin(Opcode::kDataEnd);
    end.number(data_crc_.value());
    end.end(data_end);
    const auto summary_at = end.size();
    std::vector<std::array<std::uint64_t, 3>> groups;  // opcode, start, length
    const auto group = [&](Opcode opcode, auto add_records) {
      const auto begin = end.size();
      add_records();
      if (end.size() > begin)
        groups.push_back({static_cast<std::uint64_t>(opcode), file_.size() + begin, end.size() - begin});
    };
    group(Opcode::kSchema, [&] { add_schemas(end); });
    group(Opcode::kChannel, [&] { add_channels(end); });
    group(Opcode::kStatistics, [&] { add_statistics(end); });
    group(Opcode::kMetadataIndex, [&] { add_metadata_index(end); });
    group(Opcode::kChunkIndex, [&] {
      for (const auto& entry : chunks_) add_chunk_index(end, entry);
    });
    const auto offsets_at = end.size();
    for (const auto& [opcode, begin, length] : groups) {
      const auto offset = end.begin(Opcode::kSummaryOffset);
      end.number(static_cast<std::uint8_t>(opcode));
      end.number(begin);
      end.number(length);
      end.end(offset);
    }
    const auto footer = end.begin(Opcode::kFooter);
    end.number(std::uint64_t{file_.size() + summary_at});
    end.number(std::uint64_t{file_.size() + offsets_at});
    end.number(std::uint32_t{0});
    end.end(footer);
    // CRC of the summary and of the footer up to this field.
    const auto crc_at = end.size() - sizeof(std::uint32_t);
    mcap::Crc crc;
    crc.add(std::span(end.content()).subspan(summary_at, crc_at - summary_at));
    end.put(crc_at, crc.value());
    end.bytes(mcap::kMagic);
    return end.content();
  }

  RecordingFile file_;
  std::vector<const Topic*> topics_;
  std::vector<std::uint64_t> written_;  ///< number of samples per topic
  std::vector<std::uint64_t> waiting_;  ///< number of samples per topic in the unfinished chunk
  std::size_t metadata_at_ = 0;         ///< offset of the metadata record in the file
  std::size_t metadata_length_ = 0;
  mcap::Crc data_crc_;
  std::vector<ChunkEntry> chunks_;
  std::uint64_t end_size_ = 0;  // size of the end of the file if it ended now
  std::uint64_t first_ns_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t last_ns_ = 0;
  Writer chunk_;
  std::map<std::uint16_t, std::vector<Times>> indices_;  ///< message times of the unfinished chunk, per channel
  std::uint64_t chunk_first_ns_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t chunk_last_ns_ = 0;
};

}  // namespace

Outcome<std::unique_ptr<Recording>> create_mcap(const std::string& name, bool force,
                                                const std::vector<const Topic*>& chosen) {
  auto file = RecordingFile::create(name, force);
  if (!file) return tl::unexpected(file.error());
  auto recording = std::make_unique<McapRecording>(std::move(*file), chosen);
  if (auto done = recording->begin(); !done) {
    recording->remove();
    return tl::unexpected(done.error());
  }
  return recording;
}

}  // namespace driveline::bridge::clients
