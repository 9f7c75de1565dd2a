#include "driveline/ecat_master/foe/foe_client.hpp"

#include <fmt/format.h>

#include <utility>

namespace driveline::ecat_master {

std::string describe(const FileFailure& failure) {
  const auto sentence = describe(failure.error);
  return failure.slave_text.empty() ? sentence : fmt::format("{}: {}", sentence, failure.slave_text);
}

FileResult<std::vector<std::byte>> result_of(const FileTransfer& transfer) {
  if (const auto& result = transfer.result(); !result) {
    return tl::unexpected(FileFailure{result.error(), transfer.slave_text()});
  }
  return *transfer.result();
}

std::shared_ptr<FileTransfer> FoeClient::start_read(const FileName& file, const FileSettings& settings) {
  auto transfer = std::make_shared<FileTransfer>(file, settings);
  engine_.submit(position_, transfer);
  return transfer;
}

std::shared_ptr<FileTransfer> FoeClient::start_write(const FileName& file, std::vector<std::byte> content,
                                                     const FileSettings& settings) {
  auto transfer = std::make_shared<FileTransfer>(file, std::move(content), settings);
  engine_.submit(position_, transfer);
  return transfer;
}

FileResult<std::vector<std::byte>> FoeClient::read(const FileName& file, const FileSettings& settings) {
  const auto transfer = start_read(file, settings);
  engine_.wait(*transfer);
  return result_of(*transfer);
}

FileResult<void> FoeClient::write(const FileName& file, std::vector<std::byte> content, const FileSettings& settings) {
  const auto transfer = start_write(file, std::move(content), settings);
  engine_.wait(*transfer);
  auto done = result_of(*transfer);
  if (!done) return tl::unexpected(std::move(done.error()));
  return {};
}

}  // namespace driveline::ecat_master
