// Electronic data sheets. What is read must be writable, and the written file must stay the same when it is read again.
// A device that is simulated from it must answer its master.

#include <cstdlib>
#include <string>

#include "driveline/esi/eds_file.hpp"
#include "driveline/slaves/canopen/eds_device.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "fuzz_target.hpp"
#include "support/scripted_node.hpp"

namespace driveline::fuzz {
namespace {

Bytes bytes_of(std::string_view text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

/// Starts the device with its default PDOs, and sends it what each of them may get.
void check_device(const esi::EdsFile& file) {
  using namespace std::chrono_literals;
  using canopen::Frame;
  auto model = slaves::cia301::EdsModel::create(file);
  if (!model) {
    if (describe(model.error()).empty()) std::abort();
    return;
  }
  slaves::can::Bus bus;
  slaves::can::ScriptedNode master;
  slaves::cia301::EdsDevice device(*model, {.node_id = 3});
  bus.attach(master);
  bus.attach(device.device());
  bus.advance(5ms);
  const auto frame = [](std::uint32_t identifier, std::string_view payload) {
    return Frame::of(identifier, bytes_test::hex(payload));
  };
  master.send_at(6ms, frame(0x000, "01 03"));
  for (const std::uint32_t identifier : {0x203U, 0x303U, 0x403U, 0x503U, 0x080U}) {
    master.send_at(7ms, frame(identifier, "FF 80 01 7F 55 AA 00 FF"));
  }
  master.send_at(20ms, frame(0x603, "40 18 10 01 00 00 00 00"));
  bus.advance(60ms);
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  std::string text;
  for (const auto byte : input) text += static_cast<char>(byte);
  const auto file = esi::read_eds(text, "input.eds");
  if (!file) {
    if (file.error().problem.empty() || file.error().line == 0) std::abort();
    return;
  }
  check_device(*file);
  const auto written = esi::write_eds(*file, "output.eds");
  const auto again = esi::read_eds(written, "output.eds");
  if (!again || !again->notes.empty() || esi::write_eds(*again, "output.eds") != written) std::abort();
}

std::vector<Bytes> seeds() {
  auto device = slaves::msd::device_description();
  if (device.objects.size() > 12) device.objects.resize(12);
  constexpr std::string_view kVendors =
      "; tool\r\n[DeviceInfo]\r\nVendorNumber=0x28\r\nProductName=p\xE4\r\nBaudRate_125=1\r\nLSS_Supported=1\r\n"
      "[DeviceComissioning]\r\nNodeID=17\r\nBaudrate=500\r\nNodeName=n\r\n"
      "[OptionalObjects]\r\nSupportedObjects=4\r\n1=0x1003\r\n2=0x1014\r\n3=0x1A00\r\n4=0x6064\r\n"
      "[1003]\r\nParameterName=e\r\nObjectType=8\r\nDataType=7\r\nAccessType=ro\r\nCompactSubObj=3\r\n"
      "[1003Name]\r\n2=Older one\r\n[1003sub3]\r\nDataType=7\r\nAccessType=rw\r\nParameterValue=7\r\n"
      "[1014]\r\nDataType=7\r\nAccessType=rw\r\nDefaultValue=$NODEID+0x80\r\nParameterValue=010+$NodeID\r\n"
      "[1A00]\r\nObjectType=9\r\nSubNumber=2\r\n[1A00sub0]\r\nDataType=5\r\nAccessType=rw\r\nDefaultValue=1\r\n"
      "[1A00sub1]\r\nDataType=7\r\nAccessType=rw\r\nDefaultValue=0x60640020\r\n"
      "[6064]\r\nDataType=4\r\nAccessType=rwr\r\nLowLimit=-1000\r\nDefaultValue=-2\r\nPDOMapping=1\r\n"
      "[ManufacturerObjects]\r\n1=0x2003\r\n2=0x2100\r\n[2003]\r\nDataType=9\r\nDefaultValue=x = 1; y\r\n"
      "[2100]\r\nDataType=8\r\nAccessType=rww\r\nDefaultValue=1.5e3\r\nPDOMapping=1\r\n";
  return {bytes_of(esi::write_eds(device, "msd.eds")), bytes_of(kVendors)};
}

}  // namespace driveline::fuzz
