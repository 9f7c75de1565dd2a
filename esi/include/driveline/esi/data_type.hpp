#pragma once

#include <cstdint>

/// Data types and object codes of an object dictionary, numbered as in CiA 301 and ETG.1000.6.
namespace driveline::esi {

/// CANopen / CoE data types, numbered by their index in the data type area (ETG.1000.6 Table 64).
enum class DataType : std::uint16_t {
  kBoolean = 0x0001,
  kInteger8 = 0x0002,
  kInteger16 = 0x0003,
  kInteger32 = 0x0004,
  kUnsigned8 = 0x0005,
  kUnsigned16 = 0x0006,
  kUnsigned32 = 0x0007,
  kReal32 = 0x0008,
  kVisibleString = 0x0009,
  kOctetString = 0x000A,
  kReal64 = 0x0011,
  kInteger64 = 0x0015,
  kUnsigned64 = 0x001B,
  kBit1 = 0x0030,
  kBit2 = 0x0031,
  kBit3 = 0x0032,
  kBit4 = 0x0033,
  kBit5 = 0x0034,
  kBit6 = 0x0035,
  kBit7 = 0x0036,
  kBit8 = 0x0037,
};

/// Object code (ETG.1000.6 Table 65).
enum class ObjectCode : std::uint8_t { kVariable = 7, kArray = 8, kRecord = 9 };

}  // namespace driveline::esi
