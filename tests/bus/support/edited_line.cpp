#include "edited_line.hpp"

#include "driveline/esi/sii.hpp"

namespace driveline::bus_test {

void EditedDevice::mailbox_request(std::span<const std::byte> mailbox) {
  if (hears) hears(mailbox);
  std::vector<std::byte> received(mailbox.begin(), mailbox.end());
  if (changes_request) changes_request(received);
  if (swallows && swallows(received)) return;
  inner_->mailbox_request(received);
}

std::size_t EditedDevice::mailbox_reply(std::span<std::byte> out) {
  if (!says_first.empty()) {
    const auto mail = std::move(says_first.front());
    says_first.erase(says_first.begin());
    std::copy(mail.begin(), mail.end(), out.begin());
    return mail.size();
  }
  const auto length = inner_->mailbox_reply(out);
  return length > 0 && changes_answer ? changes_answer(out, length) : length;
}

EditedLine::EditedLine(std::size_t drives, const Edit& edit, const Options& options,
                       std::optional<slaves::Wiring> wiring)
    : clock(milliseconds{1}) {
  std::vector<std::unique_ptr<slaves::Slave>> made;
  for (std::size_t i = 0; i < drives; ++i) {
    slaves::msd::MsdParameters parameters;
    parameters.serial_number = static_cast<std::uint32_t>(1000 + i);
    auto drive = std::make_unique<slaves::msd::MsdDrive>(parameters);
    auto profile = drive->profile();
    if (edit) edit(i, profile);
    auto device = std::make_unique<EditedDevice>(std::move(drive), std::move(profile));
    devices_.push_back(device.get());
    made.push_back(std::make_unique<slaves::Slave>(std::move(device), options ? options(i) : slaves::SlaveOptions{}));
  }
  line_ = std::make_unique<slaves::SimulatedLine>(clock, std::move(made), slaves::LineOptions{}, std::move(wiring));
}

void set_alias(slaves::DeviceProfile& profile, std::uint16_t alias) {
  auto image = esi::decode_sii(profile.sii_image).value();
  image.config.station_alias = alias;
  image.checksum = esi::sii_checksum(image.config.bytes());
  profile.sii_image = esi::encode_sii(image);
}

}  // namespace driveline::bus_test
