#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <tl/expected.hpp>

#include "driveline/sdo/sdo_abort.hpp"

/// What programs do on a CANopen bus: SDO transfers, NMT commands, the search for nodes, and watching their states.
namespace driveline::canopen {

/// An entry of a node's object dictionary.
struct SdoObject {
  std::uint16_t index = 0;    ///< index of the object
  std::uint8_t subindex = 0;  ///< sub-index of the entry
  constexpr bool operator==(const SdoObject&) const = default;
};

/// Why a request to a bus or to a node failed.
enum class ClientErrorKind : std::uint8_t {
  kDown,        ///< the adapter, its connection or the bus is gone
  kBusy,        ///< the adapter took no frame for `waited`
  kNotCarried,  ///< the adapter cannot carry the frame
  kNoAnswer,    ///< the node did not answer for `waited`
  kAborted,     ///< the node ended the transfer with `code`
  kBadAnswer,   ///< the node broke the protocol, and the transfer was ended with `code`
  kStopped,     ///< the program is to end
};

/// A request that failed, with its facts. `describe()` makes the sentence.
struct ClientError {
  ClientErrorKind kind = ClientErrorKind::kDown;      ///< what happened
  std::uint8_t node = 0;                              ///< node-ID; 0: the request was to no single node
  SdoObject object{};                                 ///< kNoAnswer of an SDO, kAborted, kBadAnswer; index 0: no SDO
  sdo::SdoAbort code = sdo::SdoAbort::kGeneralError;  ///< kAborted, kBadAnswer
  std::chrono::nanoseconds waited{0};                 ///< kBusy, kNoAnswer
  std::uint32_t expected = 0;                         ///< kBadAnswer: bytes that were expected; 0: not about sizes
  std::uint32_t received = 0;                         ///< kBadAnswer: bytes that came or were announced
  std::uint32_t ignored = 0;                          ///< answers of the node that belong to no request of this client
  constexpr bool operator==(const ClientError&) const = default;
};

/// A value or a ClientError.
template <typename T>
using ClientResult = tl::expected<T, ClientError>;

/// Returns one sentence. Not for use in a cycle.
[[nodiscard]] std::string describe(const ClientError& error);

}  // namespace driveline::canopen
