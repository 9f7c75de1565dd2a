#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "client.hpp"
#include "recording.hpp"
#include "recording_file.hpp"
#include "text.hpp"

namespace driveline::bridge::clients {
namespace {

constexpr std::size_t kPieceSize = 1U << 16;  // approximate number of bytes of rows per write

class CsvRecording final : public Recording {
 public:
  CsvRecording(RecordingFile file, const Topic& topic) : file_(std::move(file)), topic_(topic) {}

  Outcome<void> begin() {
    add_text(fmt::format("received_ns,published_ns,{}\n", fmt::join(table_columns(topic_), ",")));
    return flush();
  }

  Outcome<void> take_place() override { return file_.take_place(); }

  Outcome<void> add(const Sample& sample) override {
    const auto value = decode(*topic_.structure, sample.bytes);
    if (!value) {
      omitted_.add(topic_.name, describe(value.error()));
      return {};
    }
    add_text(table_rows(topic_, *value, fmt::format("{},{},", sample.received_ns, sample.published_ns)));
    ++waiting_;
    return rows_.size() < kPieceSize ? Outcome<void>{} : flush();
  }

  Outcome<void> flush() override {
    if (auto done = file_.add(rows_, 0); !done) return done;
    rows_.clear();
    written_[0] += std::exchange(waiting_, 0);
    return {};
  }

  Outcome<void> finish() override {
    auto flushed = flush();
    auto done = file_.finish({});
    return flushed ? done : flushed;
  }

  void remove() noexcept override { file_.remove(); }
  const std::vector<std::uint64_t>& written() const noexcept override { return written_; }
  std::uint64_t size() const noexcept override { return file_.size(); }

 private:
  void add_text(const std::string& text) { rows_.insert(rows_.end(), text.begin(), text.end()); }

  RecordingFile file_;
  const Topic& topic_;
  std::vector<std::uint8_t> rows_;
  std::uint64_t waiting_ = 0;
  OmittedSamples omitted_{"record"};
  std::vector<std::uint64_t> written_ = {0};
};

}  // namespace

Outcome<std::unique_ptr<Recording>> create_csv(const std::string& name, bool force, const Topic& topic) {
  auto file = RecordingFile::create(name, force);
  if (!file) return tl::unexpected(file.error());
  auto recording = std::make_unique<CsvRecording>(std::move(*file), topic);
  if (auto done = recording->begin(); !done) {
    recording->remove();
    return tl::unexpected(done.error());
  }
  return recording;
}

Outcome<std::unique_ptr<Recording>> create_recording(const std::string& name, bool force,
                                                     const std::vector<const Topic*>& chosen) {
  if (name.ends_with(".mcap")) return create_mcap(name, force, chosen);
  if (!name.ends_with(".csv")) return misused(fmt::format("{}: a name that ends in .mcap or .csv is expected", name));
  if (chosen.size() != 1) {
    return misused(fmt::format("{}: a CSV table holds one topic, e.g. --topic axis_telemetry; .mcap holds all", name));
  }
  return create_csv(name, force, *chosen.front());
}

}  // namespace driveline::bridge::clients
